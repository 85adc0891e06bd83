"""The datasets of a preset, made from config.yaml.

`make_plan` is the one entrance. It checks the configuration against the schema and then what a
schema cannot say, and raises InputError with one line that names key, value and what is allowed.
"""

import functools
import itertools
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from beltrepro.replication.plan import checking, grids
from beltrepro.replication.plan.checking import complain
from beltrepro.replication.plan.films import PlannedFilm, planned_films
from beltrepro.replication.plan.kinds import KINDS, SETTINGS, Kind, Setting
from beltrepro.replication.plan.points import Point, plain
from beltrepro.replication.plan.quantities import LAW, QUANTITIES, REQUIRED, Quantity, cast
from beltrepro.replication.plan.schema import config_schema

TIME_STEP = 0.001  # of the paper; work counts its steps
OWN = ("kind", "like", "own_method")  # keys of a dataset that are no quantity and no setting
Given = dict[str, tuple[Any, str]]
"""What config.yaml gives, by key: the value and where it stands."""


@dataclass(frozen=True)
class PlannedDataset:
    """A dataset before it is simulated."""

    name: str  # unique over all kinds
    kind: Kind  # what is recorded
    points: tuple[Point, ...]  # in the order in which the file has them
    settings: dict = field(hash=False)  # what the kind is told besides points
    points_per_job: int  # largest number of points of a batch

    @functools.cached_property
    def batches(self) -> tuple[tuple[Point, ...], ...]:
        """The points cut into jobs, in their order; all of a batch have one method, and all or
        none of them noise."""
        cut = []
        for _, alike in itertools.groupby(
            self.points, lambda point: (point.method, point.noise > 0)
        ):
            points = tuple(alike)
            starts = range(0, len(points), self.points_per_job)
            cut += [points[start : start + self.points_per_job] for start in starts]
        return tuple(cut)

    def values(self) -> dict[str, list]:
        """Distinct values of each quantity, rising."""
        table = {}
        for name in QUANTITIES:
            known = {getattr(point, name) for point in self.points}
            table[name] = sorted(known, key=lambda value: (value is not None, value))
        return table

    def described(self) -> dict:
        """The whole as plain values."""
        return {"kind": self.kind.name} | self.settings | self.values()

    def work(self, points: Iterable[Point]) -> float:
        """Blocks times model time of some points, with a weight for short steps of verlet."""
        usual = TIME_STEP
        weights = (
            point.n_blocks * (usual / point.time_step if point.method == "verlet" else 1.0)
            for point in points
        )
        return self.settings["duration"] * sum(weights)


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
    # films of datasets by name, in the order of the configuration
    films: dict[str, PlannedFilm] = field(hash=False)

    def settings(self) -> dict:
        """The plan as plain values, by which claims and report are made."""
        return {
            "preset": self.preset,
            "run": self.run,
            "seed": self.seed,
            "model": self.model,
            "defaults": self.defaults,
            "datasets": {name: each.described() for name, each in self.datasets.items()},
            "films": {
                name: {"of": each.dataset} | each.told() for name, each in self.films.items()
            },
        }

    def told(self, name: str) -> dict:
        """Plain values that say what the file of a dataset holds."""
        dataset = self.datasets[name]
        return self._told(dataset, {"count": len(dataset.points)} | dataset.values())

    def told_batch(self, name: str, number: int) -> dict:
        """Plain values that the job of one batch needs, and its file keeps."""
        dataset = self.datasets[name]
        return self._told(dataset, plain(dataset.batches[number]))

    def _told(self, dataset: PlannedDataset, points: dict) -> dict:
        return {
            "dataset": dataset.name,
            "kind": dataset.kind.name,
            "preset": self.preset,
            "run": self.run,
            "settings": dataset.settings,
            "points": points,
        }


def make_plan(config: dict) -> Plan:
    """The plan of the preset that `config` names."""
    config = checking.normalised(config)
    _check_names(config)
    chosen = config["preset"]
    run = config.get("run", chosen)
    return {name: _preset_plan(config, name, run) for name in config["presets"]}[chosen]


# --- from config to plan --------------------------------------------------------------------------


def _check_names(config: dict) -> None:
    """Refuse what the schema does not allow, an unknown preset, and a run that would overwrite."""
    if found := checking.fault(config, config_schema()):
        raise found
    chosen, presets = config["preset"], config["presets"]
    if chosen not in presets:
        raise complain(f"preset = {chosen!r}: allowed are {', '.join(presets)}", chosen, presets)
    run = config.get("run", chosen)
    if run != chosen and run in presets:
        raise complain(
            f"run = {run!r}: is the name of another preset, whose results it would overwrite"
        )


def _preset_plan(config: dict, preset: str, run: str) -> Plan:
    sections = [("", config), *_bases(config, preset)]
    defaults: Given = {
        name: (value, f"model.{name}") for name, value in config.get("model", {}).items()
    }
    for where, section in sections:
        defaults |= _given(section.get("defaults", {}), f"{where}defaults")
    entries: dict[str, Given] = {}
    for where, section in sections:
        for name, entry in section.get("datasets", {}).items():
            place = f"{where}datasets.{name}"
            entries[name] = entries.get(name, {}) | _given(entry, place)
    entries = {name: _with_model(name, entries, preset) for name in entries}
    datasets = {
        name: _dataset(name, entry, defaults, config, preset) for name, entry in entries.items()
    }
    return Plan(
        preset=preset,
        run=run,
        seed=config["seed"],
        model={each.name: _value(defaults, each) for each in LAW},
        defaults={
            name: _value(defaults, each)
            for name, each in (QUANTITIES | SETTINGS).items()
            if _value(defaults, each) is not REQUIRED
        },
        datasets=datasets,
        films=planned_films(config, datasets, preset),
    )


def _value(given: Given, each: Quantity | Setting) -> Any:
    """What is given for a quantity or setting, or else its default."""
    return given[each.name][0] if each.name in given else each.default


def _bases(config: dict, preset: str) -> list[tuple[str, dict]]:
    """The preset and those that it is based on, the most basic one first."""
    presets = config["presets"]
    chain: list[str] = []
    name = preset
    while name is not None:
        if name in chain:
            raise complain(f"presets.{preset}.based_on: {' is based on '.join([*chain, name])}")
        chain.append(name)
        base = presets[name].get("based_on")
        if base is not None and base not in presets:
            text = f"presets.{name}.based_on = {base!r}: allowed are {', '.join(presets)}"
            raise complain(text, base, presets)
        name = base
    return [(f"presets.{name}.", presets[name]) for name in reversed(chain)]


def _with_model(name: str, entries: dict[str, Given], preset: str, asked: tuple = ()) -> Given:
    """A dataset with what it takes from the one that it is like."""
    entry = entries[name]
    if "like" not in entry:
        return entry
    model, where = entry["like"]
    if model not in entries:
        raise complain(f"{where} = {model!r}: preset {preset} has no such dataset", model, entries)
    if model in (name, *asked):
        raise complain(f"{where} = {model!r}: a dataset cannot be like itself")
    return _with_model(model, entries, preset, (name, *asked)) | entry


def _given(section: dict, where: str) -> Given:
    return {key: (value, f"{where}.{key}") for key, value in section.items()}


def _dataset(name: str, entry: Given, defaults: Given, config: dict, preset: str) -> PlannedDataset:
    place = f"datasets.{name} of preset {preset}"
    if "kind" not in entry:
        raise complain(f"{place} has no kind: allowed are {', '.join(KINDS)}")
    kind = KINDS[entry["kind"][0]]
    _check_settings(entry, kind)
    found = defaults | entry

    def value(each):
        given, where = found.get(each.name, (each.default, place))
        if given is REQUIRED:
            raise complain(f"{place} has no {each.name}")
        return given, where

    axes = {each.name: value(each) for each in QUANTITIES.values()}
    if "method" in config and not entry.get("own_method", (False,))[0]:
        axes["method"] = config["method"], "method"
    axes["seed"] = found.get("seed", ({"offset": 0}, "seed"))
    settings = {each.name: cast(each.schema, value(each)[0]) for each in kind.settings}
    points = grids.points(axes, config["seed"], complain)
    if found_wrong := kind.first_complaint(settings, points):
        key, text = found_wrong
        where = found.get(key, (None, f"{place}: {key}"))[1]
        raise complain(f"{where} {text}" if where.endswith(key) else f"{where}: {key} {text}")
    per_job = found.get("points_per_job", (len(points), place))[0]
    return PlannedDataset(name, kind, points, settings, per_job)


def _check_settings(entry: Given, kind: Kind) -> None:
    """Refuse a setting that belongs to another kind."""
    known = [*OWN, "points_per_job", *QUANTITIES, *(each.name for each in kind.settings)]
    for key, (_, where) in entry.items():
        if key not in known:
            own = ", ".join(each.name for each in kind.settings)
            raise complain(
                f"{where}: a dataset of kind {kind.name} has no such setting, only {own}"
            )
