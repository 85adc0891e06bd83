"""The datasets and films of a preset, made from config.yaml.

`make_plan` is the one entrance. It raises InputError with one line that names key, value and what
is allowed, also for what no type can refuse.
"""

import functools
import itertools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from beltrepro.base.checks import shown
from beltrepro.base.errors import InputError
from beltrepro.base.names import one_of
from beltrepro.model.units import TIME_S
from beltrepro.replication.camera.scene import Camera, camera_settings
from beltrepro.replication.plan.config import (
    MOST_POINTS,
    SOURCE,
    UNSET,
    Settings,
    checked,
    is_by_size,
    meant_by,
    refuse,
)
from beltrepro.replication.plan.kinds import FILMED, KINDS, Kind
from beltrepro.replication.plan.points import (
    DEFAULTS,
    LAW,
    QUANTITIES,
    SETTINGS,
    Point,
    plain,
)

_FRAME_TOLERANCE = 1e-3  # of the time between frames, as in `camera.film`
_DEFAULTS = {
    **{name: (value,) for name, value in DEFAULTS.items()},
    "seed": {"offset": 0},
    **{
        name: about.default
        for name, about in Settings.model_fields.items()
        if about.default is not UNSET
    },
}


class Entry(NamedTuple):
    """A value of config.yaml, and where it stands there."""

    value: Any
    where: str


Entries = dict[str, Entry]


@dataclass(frozen=True)
class PlannedDataset:
    """A dataset before it is simulated."""

    kind: Kind  # what is recorded
    points: tuple[Point, ...]  # in the order in which the file has them
    settings: dict  # what the kind is told besides points
    points_per_job: int  # largest number of points of a batch

    @functools.cached_property
    def batches(self) -> dict[str, tuple[Point, ...]]:
        """The points of each job by its name, in their order; all of a batch have one method, and
        all or none of them noise."""
        cut: list[tuple[Point, ...]] = []
        for _, alike in itertools.groupby(self.points, lambda one: (one.method, one.noise > 0)):
            points = tuple(alike)
            starts = range(0, len(points), self.points_per_job)
            cut += [points[start : start + self.points_per_job] for start in starts]
        return {f"{number:04d}": points for number, points in enumerate(cut)}

    def values(self) -> dict[str, list]:
        """Distinct values of each quantity, rising."""
        columns = zip(QUANTITIES, zip(*self.points, strict=True), strict=True)
        return {name: sorted(set(values)) for name, values in columns}


@dataclass(frozen=True)
class Plan:
    """Everything that one preset computes."""

    preset: str  # names of the preset and of the folder of its results
    run: str
    defaults: dict  # quantities and settings of datasets that give no own
    datasets: dict[str, PlannedDataset]  # by name, in the order of the configuration
    films: dict[str, dict]  # by name of the dataset, what the job needs

    def settings(self) -> dict:
        """The plan as plain values, by which claims and report are made."""
        return {
            "model": {name: self.defaults[name] for name in LAW},
            "defaults": {name: self.defaults[name] for name in ("time_step", "laminar_time")},
            "datasets": {
                name: {"kind": dataset.kind.name} | dataset.settings | dataset.values()
                for name, dataset in self.datasets.items()
            },
        }

    def spec(self, name: str, batch: str = "") -> dict:
        """Plain values that say what the file of a dataset, or of one of its batches, holds.

        A job needs no more than those of its batch.
        """
        dataset = self.datasets[name]
        whole = {"count": len(dataset.points)} | dataset.values()
        return {
            "dataset": name,
            "kind": dataset.kind.name,
            "preset": self.preset,
            "run": self.run,
            "settings": dataset.settings,
            "points": plain(dataset.batches[batch]) if batch else whole,
        }


def make_plan(config: dict) -> Plan:
    """The plan of the preset that `config` names; of the others only the form is checked."""
    config = checked(config)
    presets = config["presets"]
    preset = one_of(f"{SOURCE}: preset", config["preset"], presets)
    run = config.get("run", preset)
    if run != preset and run in presets:
        refuse(f"run = {run!r}: is the name of another preset, whose results it would overwrite")
    defaults: Entries = {}
    given: dict[str, Entries] = {}  # by dataset
    for where, layer in _layers(config, preset):
        if thin := layer.get("thin"):
            defaults = _thinned(defaults, thin)
            given = {name: _thinned(entries, thin) for name, entries in given.items()}
        defaults |= _entries(layer.get("defaults", {}), f"{where}defaults")
        for name, keys in layer.get("datasets", {}).items():
            given[name] = given.get(name, {}) | _entries(keys, f"{where}datasets.{name}")
    datasets = {
        name: _dataset(name, _with_like(name, given, preset), defaults, config, preset)
        for name in given
    }
    usual = _DEFAULTS | {name: entry.value for name, entry in defaults.items()}
    for name, value in usual.items():
        if isinstance(value, tuple) and len(value) == 1:
            usual[name] = value[0]
    return Plan(preset, run, usual, datasets, _films(config, datasets, preset))


# --- layers of the configuration ------------------------------------------------------------------


def _layers(config: dict, preset: str) -> list[tuple[str, dict]]:
    """The top level, the presets that the preset is based on, the most basic one first, and it."""
    presets, chain = config["presets"], [preset]
    while base := presets[chain[-1]].get("based_on"):
        one_of(f"{SOURCE}: presets.{chain[-1]}.based_on", base, presets)
        if base in chain:
            refuse(f"presets.{preset}.based_on: {' is based on '.join([*chain, base])}")
        chain.append(base)
    return [("", config), *((f"presets.{name}.", presets[name]) for name in reversed(chain))]


def _entries(section: dict, where: str) -> Entries:
    return {key: Entry(value, f"{where}.{key}") for key, value in section.items()}


def _with_like(name: str, given: dict[str, Entries], preset: str) -> Entries:
    """A dataset with what it takes from the one that it is like."""
    entries, names = given[name], [name]
    while "like" in given[names[-1]]:
        model, where = given[names[-1]]["like"]
        if model not in given:
            refuse(f"{where} = {shown(model)}: preset {preset} has no such dataset", model, given)
        if model in names:
            refuse(f"{where} = {shown(model)}: a dataset cannot be like itself")
        names.append(model)
        entries = given[model] | entries
    return entries


def _dataset(
    name: str, given: Entries, defaults: Entries, config: dict, preset: str
) -> PlannedDataset:
    """A dataset of what is given for it and for all."""
    place = f"datasets.{name} of preset {preset}"
    kind_given = given.get("kind", Entry(None, f"{place}: kind"))
    kind = KINDS[one_of(f"{SOURCE}: {kind_given.where}", kind_given.value, KINDS)]
    for key in given.keys() & SETTINGS.keys() - {*kind.settings}:
        text = f"a dataset of kind {kind.name} has no such setting, only {', '.join(kind.settings)}"
        refuse(f"{given[key].where}: {text}")
    unset = {key: Entry(value, f"{place}: {key}") for key, value in _DEFAULTS.items()}
    entries = unset | defaults | given
    for key in (*QUANTITIES, *kind.settings):
        if key not in entries:
            refuse(f"{place} has no {key}")
    if "method" in config and not ("own_method" in given and given["own_method"].value):
        entries["method"] = Entry((config["method"],), "method")
    points = _points(entries, config["seed"])
    if "also" in given and (axes := given["also"].value):
        points += _points(entries | _entries(axes, given["also"].where), config["seed"])
        if len(set(points)) < len(points):
            refuse(f"{given['also'].where}: gives points that the dataset has without it")
    settings = {key: entries[key].value for key in kind.settings}
    for key, text in kind.complaints(settings, points):
        refuse(f"{entries[key].where} {text}")
    per_job = entries.get("points_per_job", Entry(len(points), place)).value
    return PlannedDataset(kind, points, settings, per_job)


# --- from axes to points --------------------------------------------------------------------------


def _points(axes: Entries, seed: int) -> tuple[Point, ...]:
    """Every combination of the axes, in the order of the quantities."""
    points: list[Point] = []
    for n_blocks in axes["n_blocks"].value:
        alike = axes | {"n_blocks": Entry((n_blocks,), axes["n_blocks"].where)}
        grids = [_values_at(n_blocks, alike[name], seed) for name in QUANTITIES]
        count = len(points) + math.prod(map(len, grids))
        if count > MOST_POINTS:
            longest = max(zip(map(len, grids), QUANTITIES, strict=True))[1]
            text = f"with the other axes it makes {count:.3g} points, at most {MOST_POINTS} allowed"
            refuse(f"{axes[longest].where}: {text}")
        for point in map(Point._make, itertools.product(*grids)):
            by_noise = isinstance(point.method, tuple)
            points.append(
                point._replace(method=point.method[point.noise > 0]) if by_noise else point
            )
    return tuple(points)


def _values_at(n_blocks: int, axis: Entry, seed: int) -> tuple:
    """Values of one quantity for chains of one size."""
    grid = axis.value
    if is_by_size(grid):
        if n_blocks not in grid:
            refuse(f"{axis.where} has no entry for n_blocks = {n_blocks}")
        grid = grid[n_blocks]
    match grid:
        case {"offset": offset}:
            return (seed + offset,)
        case {"without_noise": without_noise, "with_noise": with_noise}:
            return ((without_noise, with_noise),)
    return grid


# --- thinner presets ------------------------------------------------------------------------------


def _thinned(entries: Entries, thin: dict) -> Entries:
    """What a dataset is given, in a preset that has less of all."""
    return {key: Entry(_less(key, value, thin), where) for key, (value, where) in entries.items()}


def _less(key: str, value: Any, thin: dict) -> Any:
    """Fewer values of a grid, a part of the replicates, or a shorter time."""
    if key in SETTINGS:
        return min(value, thin[key]) if key in thin else value
    if key == "also" and value:
        return {axis: _less(axis, grid, thin) for axis, grid in value.items()}
    if is_by_size(value):
        return {size: _less(key, grid, thin) for size, grid in value.items()}
    if key not in QUANTITIES or key in ("n_blocks", "method", "seed"):
        return value
    if key == "replicate":
        return value[: max(2, math.ceil(len(value) / thin.get("replicates", 1)))]
    return value[:: math.ceil(len(value) / thin.get("values", len(value)))]


# --- films ----------------------------------------------------------------------------------------


def _films(config: dict, datasets: dict[str, PlannedDataset], preset: str) -> dict[str, dict]:
    """What the job of each film needs."""
    settings, given = camera_settings(), config.get("camera", {})
    for name in given.keys() - settings.keys():
        refuse(f"unknown key {shown(name)} in camera{meant_by(name, settings)}")
    camera = {name: setting.default for name, setting in settings.items()}
    camera |= given | {"seed": config["seed"]}
    try:
        rate = Camera(**camera).frames_per_second
    except InputError as error:
        refuse(f"camera.{error}")
    for name in config.get("films", []):
        if name not in datasets:
            refuse(f"films: {name}: preset {preset} has no such dataset", name, datasets)
        filmed, dataset = datasets[name].settings, datasets[name]
        is_single = dataset.kind.name == "series" and len(dataset.points) == 1
        if not (is_single and set(FILMED) <= set(filmed["samples"])):
            refuse(
                f"films: {name}: must be a series of one point that samples {' and '.join(FILMED)}"
            )
        interval, needed = filmed["sample_interval"], 1 / rate / TIME_S
        if abs(interval / needed - 1) > _FRAME_TOLERANCE:
            text = (
                f"its sample_interval is {interval:g}, {rate:g} frames a second need {needed:.7g}"
            )
            refuse(f"films: {name}: {text}")
    return {name: {"film": name, "camera": camera} for name in config.get("films", [])}
