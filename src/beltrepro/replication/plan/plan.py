"""The datasets and films of a preset, made from config.yaml.

`make_plan` is the one entrance. It raises InputError with one line that names key, value and what
is allowed, also for what no type can refuse.
"""

import functools
import itertools
import math
from dataclasses import dataclass, replace
from typing import Any

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
    FURTHER,
    LAW,
    QUANTITIES,
    SETTINGS,
    Point,
    has_column,
)

FIRST_BATCH = "0000"
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


@dataclass(frozen=True)
class PlannedDataset:
    """A dataset before it is simulated."""

    kind: Kind  # what is recorded
    points: tuple[Point, ...]  # in the order in which the file has them
    settings: dict  # what the kind is told besides points
    points_per_job: int  # largest number of points of a batch

    @functools.cached_property
    def batches(self) -> dict[str, tuple[Point, ...]]:
        """The points of each job by its name, in their order."""
        starts = range(0, len(self.points), self.points_per_job)
        return {
            f"{number:04d}": self.points[start : start + self.points_per_job]
            for number, start in enumerate(starts)
        }

    def values(self) -> dict[str, list]:
        """Distinct values of each quantity, rising."""
        columns = zip(QUANTITIES, zip(*self.points, strict=True), strict=True)
        return {name: sorted(set(values)) for name, values in columns if has_column(name, values)}


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
            "model": {
                name: self.defaults[name]
                for name in LAW
                if name not in FURTHER or self.defaults[name] != DEFAULTS[name]
            },
            "defaults": {name: self.defaults[name] for name in ("time_step", "laminar_time")},
            "datasets": {
                name: {"kind": dataset.kind.name} | dataset.settings | dataset.values()
                for name, dataset in self.datasets.items()
            },
        }

    def spec(self, name: str, batch: str = "") -> dict:
        """Plain values that say what the file of a dataset, or of one of its batches, holds."""
        dataset = self.datasets[name]
        if batch:
            dataset = replace(dataset, points=dataset.batches[batch])
        return {
            "dataset": name,
            "kind": dataset.kind.name,
            "preset": self.preset,
            "run": self.run,
            "settings": dataset.settings,
            "points": {"count": len(dataset.points)} | dataset.values(),
        }


def make_plan(config: dict) -> Plan:
    """The plan of the preset that `config` names; of the others only the form is checked."""
    config = checked(config)
    presets = config["presets"]
    preset = one_of(f"{SOURCE}: preset", config["preset"], presets)
    run = config.get("run", preset)
    if run != preset and run in presets:
        refuse(f"run = {run!r}: is the name of another preset, whose results it would overwrite")
    defaults: dict = {}
    given: dict[str, dict] = {}  # by dataset
    bases = _chain(preset, presets, "based_on", "presets")
    for layer in (config, *(presets[name] for name in reversed(bases))):
        # first: what the layer itself gives stays as it is
        if thin := layer.get("thin"):
            defaults = _thinned(defaults, thin)
            given = {name: _thinned(keys, thin) for name, keys in given.items()}
        defaults |= layer.get("defaults", {})
        for name, keys in layer.get("datasets", {}).items():
            given[name] = given.get(name, {}) | keys
    usual = _DEFAULTS | defaults
    datasets = {}
    place = f"preset {preset}: datasets"
    for name in given:
        merged: dict = {}
        for model in reversed(_chain(name, given, "like", place)):
            merged |= given[model]
        if "kind" not in merged:  # a new dataset, or the slip of a preset that changes one
            refuse(f"{place}.{name} has no kind", name, given.keys() - {name})
        if "method" in config and not merged.get("own_method"):
            merged["method"] = (config["method"],)
        datasets[name] = _dataset(merged, usual | merged, config["seed"], f"{place}.{name}")
    return Plan(preset, run, _plain(usual), datasets, _films(config, datasets, preset))


def _plain(values: dict) -> dict:
    """Grids of one value as that value."""
    return {
        name: value[0] if isinstance(value, tuple) and len(value) == 1 else value
        for name, value in values.items()
    }


def _chain(name: str, entries: dict[str, dict], key: str, place: str) -> list[str]:
    """The entry of this name, and those on which it rests by a key that names another."""
    names = [name]
    while key in entries[names[-1]]:
        base = entries[names[-1]][key]
        where = f"{place}.{names[-1]}.{key} = {shown(base)}"
        if base not in entries:
            refuse(f"{where}: there is none{meant_by(base, entries)}")
        if base in names:
            refuse(f"{where}: rests on itself")
        names.append(base)
    return names


def _dataset(given: dict, keys: dict, seed: int, place: str) -> PlannedDataset:
    """A dataset by what is given for it, and by that with what is usual."""
    kind = KINDS[one_of(f"{SOURCE}: {place}.kind", given["kind"], KINDS)]
    for key in given.keys() & SETTINGS.keys() - {*kind.settings}:
        text = f"a dataset of kind {kind.name} has no such setting, only {', '.join(kind.settings)}"
        refuse(f"{place}.{key}: {text}")
    for key in (*QUANTITIES, *kind.settings):
        if key not in keys:
            refuse(f"{place} has no {key}")
    points = _points(keys, seed, place)
    if also := keys.get("also"):
        points += _points(keys | also, seed, f"{place}.also")
        if len(set(points)) < len(points):
            refuse(f"{place}.also: gives points that the dataset has without it")
    settings = {key: keys[key] for key in kind.settings}
    for text in kind.complaints(settings, points):
        refuse(f"{place}.{text}")
    return PlannedDataset(kind, points, settings, keys.get("points_per_job", len(points)))


def _points(axes: dict, seed: int, place: str) -> tuple[Point, ...]:
    """Every combination of the axes, in the order of the quantities."""
    points: list[Point] = []
    names = "without_noise", "with_noise"
    for n_blocks in axes["n_blocks"]:
        grids = {}
        for name, grid in [*axes.items(), ("n_blocks", (n_blocks,))]:
            if is_by_size(grid) and n_blocks not in grid:
                refuse(f"{place}.{name} has no entry for n_blocks = {n_blocks}")
            grids[name] = grid[n_blocks] if is_by_size(grid) else grid
        if isinstance(grids["seed"], dict):
            grids["seed"] = (seed + grids["seed"]["offset"],)
        by_noise = grids["method"] if isinstance(grids["method"], dict) else {}
        if by_noise:
            grids["method"] = ("",)  # told when the noise is known
        columns = [grids[name] for name in QUANTITIES]
        # before they are made: a slip of the pen in a grid could fill the memory
        count = len(points) + math.prod(map(len, columns))
        if count > MOST_POINTS:
            longest = max(zip(map(len, columns), QUANTITIES, strict=True))[1]
            text = f"with the other axes it makes {count:.3g} points, at most {MOST_POINTS} allowed"
            refuse(f"{place}.{longest}: {text}")
        made = map(Point._make, itertools.product(*columns))
        if by_noise:
            made = (one._replace(method=by_noise[names[one.noise > 0]]) for one in made)
        points += made
    return tuple(points)


def _thinned(keys: dict, thin: dict) -> dict:
    """What a dataset is given, in a preset that has less of all."""
    return {key: _less(key, value, thin) for key, value in keys.items()}


def _less(key: str, value: Any, thin: dict) -> Any:
    """Fewer values of a grid, a part of the replicates, or a shorter time."""
    if key in SETTINGS:
        return min(value, thin[key]) if key in thin else value
    if key == "also" and value:
        return _thinned(value, thin)
    if is_by_size(value):
        return {size: _less(key, grid, thin) for size, grid in value.items()}
    if key not in QUANTITIES or key in ("n_blocks", "method", "seed"):
        return value
    if key == "replicate":  # two at least: one run has no interval
        return value[: max(2, math.ceil(len(value) / thin.get("replicates", 1)))]
    return value[:: math.ceil(len(value) / thin.get("values", len(value)))]


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
    films = config.get("films", [])
    for name in films:
        if name not in datasets:
            refuse(f"films: {name}: preset {preset} has no such dataset", name, datasets)
        dataset = datasets[name]
        is_single = dataset.kind.name == "series" and len(dataset.points) == 1
        if not (is_single and set(FILMED) <= set(dataset.settings["samples"])):
            needed = f"must be a series of one point that samples {' and '.join(FILMED)}"
            refuse(f"films: {name}: {needed}")
        interval, frame = dataset.settings["sample_interval"], 1 / rate / TIME_S
        if abs(interval / frame - 1) > _FRAME_TOLERANCE:
            needed = f"{rate:g} frames a second need {frame:.7g}"
            refuse(f"films: {name}: its sample_interval is {interval:g}, {needed}")
    return {name: {"film": name, "camera": camera} for name in films}
