"""The datasets and films of a preset, made from config.yaml.

`make_plan` is the one entrance. It raises InputError with one line that names key, value and what
is allowed, also for what no type can refuse.
"""

import functools
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from beltrepro.base.checks import shown, spaced
from beltrepro.base.errors import InputError
from beltrepro.base.names import hint
from beltrepro.model.units import TIME_S
from beltrepro.replication.camera.scene import Camera, camera_settings
from beltrepro.replication.plan.config import (
    MOST_POINTS,
    SOURCE,
    Settings,
    checked,
    is_by_size,
    refuse,
)
from beltrepro.replication.plan.filming import FILM, NEEDED, TRACK, PlannedFilm
from beltrepro.replication.plan.kinds import KINDS, SETTINGS, Kind
from beltrepro.replication.plan.points import DEFAULTS, LAW, QUANTITIES, REQUIRED, Point, plain

_FRAME_TOLERANCE = 1e-3  # of the time between frames, as in `camera.film`
_DEFAULTS = DEFAULTS | {name: Settings.model_fields[name].default for name in SETTINGS}


class Entry(NamedTuple):
    """A value of config.yaml, and where it stands there."""

    value: Any
    where: str


Entries = dict[str, Entry]


@dataclass(frozen=True)
class PlannedDataset:
    """A dataset before it is simulated."""

    name: str  # unique over all kinds
    kind: Kind  # what is recorded
    points: tuple[Point, ...]  # in the order in which the file has them
    settings: dict = field(hash=False)  # what the kind is told besides points
    points_per_job: int  # largest number of points of a batch

    @functools.cached_property
    def batches(self) -> dict[str, tuple[Point, ...]]:
        """The points of each job by its name, in their order; all of a batch have one method, and
        all or none of them noise."""
        cut = []
        for _, alike in itertools.groupby(self.points, lambda one: (one.method, one.noise > 0)):
            points = tuple(alike)
            starts = range(0, len(points), self.points_per_job)
            cut += [points[start : start + self.points_per_job] for start in starts]
        return {f"{number:04d}": points for number, points in enumerate(cut)}

    def values(self) -> dict[str, list]:
        """Distinct values of each quantity, rising."""
        columns = zip(QUANTITIES, zip(*self.points, strict=True), strict=True)
        return {name: sorted(set(values)) for name, values in columns}

    def described(self) -> dict:
        """The whole as plain values."""
        return {"kind": self.kind.name} | self.settings | self.values()


@dataclass(frozen=True)
class Plan:
    """Everything that one preset computes."""

    preset: str  # names of the preset and of the folder of its results
    run: str
    seed: int  # that of the configuration
    # constants of the law, and settings, of datasets that give no own
    model: dict[str, float] = field(hash=False)
    defaults: dict = field(hash=False)
    # by name, in the order of the configuration
    datasets: dict[str, PlannedDataset] = field(hash=False)
    films: dict[str, PlannedFilm] = field(hash=False)

    def settings(self) -> dict:
        """The plan as plain values, by which claims and report are made."""
        return {
            "preset": self.preset,
            "run": self.run,
            "seed": self.seed,
            "model": self.model,
            "defaults": self.defaults,
            "datasets": {name: dataset.described() for name, dataset in self.datasets.items()},
            "films": {
                name: {"of": film.dataset} | film.spec() for name, film in self.films.items()
            },
        }

    def dataset_spec(self, name: str) -> dict:
        """Plain values that say what the file of a dataset holds."""
        dataset = self.datasets[name]
        return self._spec(dataset, {"count": len(dataset.points)} | dataset.values())

    def batch_spec(self, name: str, batch: str) -> dict:
        """Plain values that a job needs, and its file keeps."""
        dataset = self.datasets[name]
        return self._spec(dataset, plain(dataset.batches[batch]))

    def _spec(self, dataset: PlannedDataset, points: dict) -> dict:
        return {
            "dataset": dataset.name,
            "kind": dataset.kind.name,
            "preset": self.preset,
            "run": self.run,
            "settings": dataset.settings,
            "points": points,
        }


def make_plan(config: dict) -> Plan:
    """The plan of the preset that `config` names; of the others only the form is checked."""
    config = checked(config)
    preset, presets = config["preset"], config["presets"]
    if preset not in presets:
        refuse(f"preset = {shown(preset)}: allowed are {', '.join(presets)}", preset, presets)
    run = config.get("run", preset)
    if run != preset and run in presets:
        refuse(f"run = {run!r}: is the name of another preset, whose results it would overwrite")
    return _preset_plan(config, preset, run)


# --- layers of the configuration ------------------------------------------------------------------


def _preset_plan(config: dict, preset: str, run: str) -> Plan:
    defaults = _entries(config.get("model", {}), "model")
    entries: dict[str, Entries] = {}
    for where, section in [("", config), *_bases(config, preset)]:
        if thin := section.get("thin"):
            defaults = _thinned(defaults, thin)
            entries = {name: _thinned(keys, thin) for name, keys in entries.items()}
        defaults |= _entries(section.get("defaults", {}), f"{where}defaults")
        for name, keys in section.get("datasets", {}).items():
            place = f"{where}datasets.{name}"
            entries[name] = entries.get(name, {}) | _entries(keys, place)
    entries = {name: _with_model(name, entries, preset) for name in entries}
    datasets = {
        name: _dataset(name, keys, defaults, config, preset) for name, keys in entries.items()
    }
    usual = _DEFAULTS | {name: defaults[name].value for name in _DEFAULTS if name in defaults}
    return Plan(
        preset=preset,
        run=run,
        seed=config["seed"],
        model={name: usual[name] for name in LAW},
        defaults={name: value for name, value in usual.items() if value != REQUIRED},
        datasets=datasets,
        films=_films(config, datasets, preset),
    )


def _entries(section: dict, where: str) -> Entries:
    return {key: Entry(value, f"{where}.{key}") for key, value in section.items()}


def _bases(config: dict, preset: str) -> list[tuple[str, dict]]:
    """The preset and those that it is based on, the most basic one first."""
    presets = config["presets"]
    chain: list[str] = []
    name = preset
    while name is not None:
        if name in chain:
            refuse(f"presets.{preset}.based_on: {' is based on '.join([*chain, name])}")
        chain.append(name)
        base = presets[name].get("based_on")
        if base is not None and base not in presets:
            text = f"presets.{name}.based_on = {shown(base)}: allowed are {', '.join(presets)}"
            refuse(text, base, presets)
        name = base
    return [(f"presets.{name}.", presets[name]) for name in reversed(chain)]


def _with_model(name: str, entries: dict[str, Entries], preset: str, asked: tuple = ()) -> Entries:
    """A dataset with what it takes from the one that it is like."""
    entry = entries[name]
    if "like" not in entry:
        return entry
    model, where = entry["like"]
    if model not in entries:
        refuse(f"{where} = {shown(model)}: preset {preset} has no such dataset", model, entries)
    if model in (name, *asked):
        refuse(f"{where} = {shown(model)}: a dataset cannot be like itself")
    return _with_model(model, entries, preset, (name, *asked)) | entry


def _dataset(
    name: str, keys: Entries, defaults: Entries, config: dict, preset: str
) -> PlannedDataset:
    place = f"datasets.{name} of preset {preset}"
    if "kind" not in keys:
        refuse(f"{place} has no kind: allowed are {', '.join(KINDS)}")
    kind = KINDS[keys["kind"].value]
    if foreign := next((key for key in keys if key in SETTINGS.keys() - {*kind.settings}), None):
        text = f"a dataset of kind {kind.name} has no such setting, only {', '.join(kind.settings)}"
        refuse(f"{keys[foreign].where}: {text}")
    entries = defaults | keys
    for key in (*QUANTITIES, *kind.settings):
        if key not in entries and _DEFAULTS[key] == REQUIRED:
            refuse(f"{place} has no {key}")
        entries.setdefault(key, Entry(_DEFAULTS[key], place))
    if "method" in config and not ("own_method" in keys and keys["own_method"].value):
        entries["method"] = Entry(config["method"], "method")
    if "seed" not in defaults | keys:
        entries["seed"] = Entry({"offset": 0}, "seed")
    settings = {key: entries[key].value for key in kind.settings}
    points = _points(entries, config["seed"])
    also = entries.get("also", Entry(None, place))
    if also.value:
        points += _points(entries | _entries(also.value, also.where), config["seed"])
        if len(set(points)) < len(points):
            refuse(f"{also.where}: gives points that the dataset has without it")
    if complaint := kind.complaint(settings, points):
        key, text = complaint
        where = (defaults | keys).get(key, Entry(None, f"{place}: {key}")).where
        refuse(f"{where} {text}" if where.endswith(key) else f"{where}: {key} {text}")
    per_job = entries.get("points_per_job", Entry(len(points), place)).value
    return PlannedDataset(name, kind, points, settings, per_job)


# --- from axes to points --------------------------------------------------------------------------


def _points(axes: Entries, seed: int) -> tuple[Point, ...]:
    """Every combination of the axes, in the order of the quantities."""
    sizes = [int(size) for size in grid_values(*axes["n_blocks"])]
    _check_tables(axes, sizes)
    table: list[Point] = []
    for n_blocks in sizes:
        grids = [
            (n_blocks,) if name == "n_blocks" else _values_at(name, n_blocks, axes[name], seed)
            for name in QUANTITIES
        ]
        count = len(table) + math.prod(map(len, grids))
        if count > MOST_POINTS:
            longest = max(zip(map(len, grids), QUANTITIES, strict=True))[1]
            refuse(
                f"{axes[longest].where}: with the other axes it makes {count:.3g} points, "
                f"at most {MOST_POINTS} allowed"
            )
        table += map(_with_one_method, map(Point._make, itertools.product(*grids)))
    return tuple(table)


def grid_values(grid: object, where: str) -> tuple:
    """Values of a grid, rising."""
    if isinstance(grid, list):
        return tuple(sorted(grid))
    return spaced(f"{SOURCE}: {where}", **grid) if isinstance(grid, dict) else (grid,)


def _values_at(name: str, n_blocks: int, axis: Entry, seed: int) -> tuple:
    """Values of one quantity for chains of one size."""
    match axis.value[str(n_blocks)] if is_by_size(axis.value) else axis.value:
        case {"count": count}:
            return tuple(range(count))
        case {"offset": offset}:
            return (seed + offset,)
        case {"without_noise": without_noise, "with_noise": with_noise}:
            return ((without_noise, with_noise),)
        case grid:
            values = grid_values(grid, axis.where)
    return tuple(map(int, values)) if name in ("seed", "replicate") else values


def _with_one_method(point: Point) -> Point:
    """The point with the one of two methods that its noise asks for."""
    is_one = isinstance(point.method, str)
    return point if is_one else point._replace(method=point.method[point.noise > 0])


def _check_tables(axes: Entries, sizes: list[int]) -> None:
    """A table N -> grid has an entry for each number of blocks and no other."""
    for grid, where in axes.values():
        given = set(map(int, grid)) if is_by_size(grid) else set(sizes)
        if missing := set(sizes) - given:
            refuse(f"{where} has no entry for n_blocks = {min(missing)}")
        if extra := given - set(sizes):
            refuse(f"{where} has an entry for n_blocks = {min(extra)}, which the dataset lacks")


# --- thinner presets ------------------------------------------------------------------------------


def _thinned(entries: Entries, thin: dict) -> Entries:
    """What a dataset is given, in a preset that has less of all."""
    return {key: Entry(_less(key, *entry, thin), entry.where) for key, entry in entries.items()}


def _less(key: str, value: Any, where: str, thin: dict) -> Any:
    """Fewer values of a grid, a part of the replicates, or a shorter time."""
    if key == "also" and value:
        return {axis: _less(axis, grid, where, thin) for axis, grid in value.items()}
    if key in SETTINGS:
        return min(value, thin[key]) if key in thin else value
    is_grid = isinstance(value, list | dict)
    if not is_grid or key not in QUANTITIES or key in ("n_blocks", "method", "seed"):
        return value
    if is_by_size(value):
        return {size: _less(key, grid, where, thin) for size, grid in value.items()}
    if key != "replicate":
        values = grid_values(value, where)
        return list(values[:: math.ceil(len(values) / thin.get("values", len(values)))])
    is_count = isinstance(value, dict) and "count" in value
    replicates = range(value["count"]) if is_count else grid_values(value, where)
    kept = max(2, math.ceil(len(replicates) / thin.get("replicates", 1)))
    return list(replicates[:kept])


# --- films ----------------------------------------------------------------------------------------


def _films(config: dict, datasets: Mapping, preset: str) -> dict[str, PlannedFilm]:
    for name in datasets:
        if name.endswith((FILM, TRACK)):
            refuse(f"datasets.{name}: only films have names that end in {FILM} or {TRACK}")
    camera = {name: setting.default for name, setting in camera_settings().items()}
    for name in config.get("camera", {}):
        if name not in camera:
            allowed = f": allowed are {', '.join(camera)}"
            refuse(f"unknown key {shown(name)} in camera{hint(name, camera) or allowed}")
    camera |= config.get("camera", {}) | {"seed": config["seed"]}
    try:
        rate = Camera(**camera).frames_per_second
    except InputError as error:
        refuse(f"camera.{error}")
    films = {}
    for name, keys in config.get("films", {}).items():
        _check_filmed(name, keys["of"], datasets, rate, preset)
        films[name] = PlannedFilm(name, keys["of"], camera)
    return films


def _check_filmed(name: str, of: str, datasets: Mapping, rate: float, preset: str) -> None:
    """Refuse what is no series of one point, or is not sampled at the instants of the frames."""
    where = f"films.{name}.of = {shown(of)}"
    if of not in datasets:
        refuse(f"{where}: preset {preset} has no such dataset", of, datasets)
    dataset = datasets[of]
    if dataset.kind.name != "series" or len(dataset.points) != 1:
        refuse(f"{where}: must be a series of one point")
    missing = [name for name in NEEDED if name not in dataset.settings["samples"]]
    if missing:
        refuse(f"{where}: its samples lack {', '.join(missing)}")
    interval, needed = dataset.settings["sample_interval"], 1 / rate / TIME_S
    if abs(interval / needed - 1) > _FRAME_TOLERANCE:
        text = f"its sample_interval is {interval:g}, {rate:g} frames a second need {needed:.7g}"
        refuse(f"{where}: {text}")
