"""The typed plan made from config.yaml: datasets with their lengths and grids.

`make_plan` is the one entrance. It checks the configuration against the schema and then what a
schema cannot say, and raises InputError with one line that names key, value and what is allowed.
"""

import difflib
import itertools
import json
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from pathlib import Path

import jsonschema
import yaml

from beltrepro.errors import InputError

SOURCE = "config.yaml"
LISTED = "listed"
KINDS = ("scans", "series", "catalogues", "ensembles")
ROLES = ("tested", "reference")  # of an integrator in the comparison
PARTS = ("trajectories", "disorder", "slips", "attractors")  # of the comparison
GRID_DIGITS = 10  # values of a grid are rounded so that 35 steps of 0.2 and 14 of 0.5 are both 7.0
LONGEST_GRID = 100_000

Point = tuple[int, float, float]
"""One point of a scan: n_blocks, belt_velocity, noise."""


@dataclass(frozen=True)
class Method:
    """Integrator of a dataset; it may differ between points without and with noise."""

    without_noise: str
    with_noise: str

    def at(self, noise: float) -> str:
        """Integrator for a point with this noise."""
        return self.with_noise if noise > 0 else self.without_noise

    def __str__(self):
        if self.with_noise == self.without_noise:
            return self.with_noise
        return f"{self.without_noise} (sigma = 0), {self.with_noise} (sigma > 0)"


@dataclass(frozen=True)
class Block:
    """Points of a scan that one job advances together, all with the same integrator."""

    method: str
    points: tuple[Point, ...]


@dataclass(frozen=True)
class Scan:
    """Points (N, u, sigma), sorted by N, then sigma, then u, with their common lengths."""

    name: str
    method: Method
    duration: float
    transient: float
    points_per_job: int
    points: tuple[Point, ...]

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The points cut into jobs, in their order."""
        blocks = []
        for method, run in itertools.groupby(self.points, lambda point: self.method.at(point[2])):
            points = tuple(run)
            starts = range(0, len(points), self.points_per_job)
            blocks += [Block(method, points[at : at + self.points_per_job]) for at in starts]
        return tuple(blocks)

    def settings(self) -> dict:
        """Plain values that describe the whole scan."""
        return {
            "method": str(self.method),
            "duration": self.duration,
            "transient": self.transient,
            "n_blocks": sorted({point[0] for point in self.points}),
            "belt_velocity": sorted({point[1] for point in self.points}),
            "noise": sorted({point[2] for point in self.points}),
        }

    def block_settings(self, number: int) -> dict:
        """Plain values that one job needs."""
        block = self.blocks[number]
        return {
            "method": block.method,
            "duration": self.duration,
            "transient": self.transient,
            "points": [list(point) for point in block.points],
        }


@dataclass(frozen=True)
class Series:
    """One sampled trajectory."""

    name: str
    method: str
    n_blocks: int
    belt_velocity: float
    noise: float
    duration: float
    transient: float
    sample_interval: float

    def settings(self) -> dict:
        """Plain values that the job needs."""
        return _without_name(self)


@dataclass(frozen=True)
class Catalogue:
    """Slips, avalanches and section points of several chains with the same parameters."""

    name: str
    method: str
    n_blocks: int
    belt_velocity: float
    noise: float
    duration: float
    transient: float
    section_block: int
    section_position: float
    n_chains: int

    def settings(self) -> dict:
        """Plain values that the job needs."""
        return _without_name(self)


@dataclass(frozen=True)
class Ensemble:
    """Many slightly different initial states at each of several belt velocities."""

    name: str
    method: str
    n_blocks: int
    belt_velocities: tuple[float, ...]
    noise: float
    duration: float
    n_members: int
    initial_spread: float
    settle_time: float

    def settings(self) -> dict:
        """Plain values that describe the whole ensemble."""
        return _without_name(self) | {"belt_velocities": list(self.belt_velocities)}

    def member_settings(self, number: int) -> dict:
        """Plain values that the job of one belt velocity needs."""
        settings = _without_name(self)
        del settings["belt_velocities"]
        return settings | {"belt_velocity": self.belt_velocities[number]}


@dataclass(frozen=True)
class Agreement:
    """Runs by two integrators for their comparison.

    methods : integrator of each of ROLES. parts : lengths and grids of each of PARTS, with grids as
    lists and with `time_steps` by role.
    """

    methods: dict[str, str] = field(hash=False)
    parts: dict[str, dict] = field(hash=False)
    seed: int

    def settings(self) -> dict:
        """Plain values."""
        return {"methods": self.methods, **self.parts}

    def run_settings(self, part: str, role: str) -> dict:
        """Plain values that the job with the runs of one part by one integrator needs.

        Tests between the two need independent samples, so the reference has another seed; but
        trajectories begin in the same states.
        """
        other = role == "reference" and part != "trajectories"
        settings = {name: value for name, value in self.parts[part].items() if name != "time_steps"}
        return settings | {
            "method": self.methods[role],
            "time_steps": self.parts[part]["time_steps"][role],
            "seed": self.seed + other,
        }


@dataclass(frozen=True)
class Numerics:
    """Numerical choices common to all presets; see the schema for each."""

    time_step: float
    laminar_time: float
    section_values: int
    section_rule: str
    section_position: dict[int, float] = field(hash=False)

    def settings(self) -> dict:
        """Plain values."""
        return {each.name: getattr(self, each.name) for each in fields(self)}


@dataclass(frozen=True)
class Plan:
    """Everything that one preset computes. Mappings are by name, in the order of the config."""

    preset: str
    seed: int
    model: dict[str, float] = field(hash=False)
    numerics: Numerics
    scans: dict[str, Scan] = field(hash=False)
    series: dict[str, Series] = field(hash=False)
    catalogues: dict[str, Catalogue] = field(hash=False)
    ensembles: dict[str, Ensemble] = field(hash=False)
    agreement: Agreement

    @property
    def constants(self) -> dict:
        """What every simulation is told besides its own settings."""
        return {"seed": self.seed, "time_step": self.numerics.time_step, "model": dict(self.model)}

    def settings(self) -> dict:
        """The plan as plain values, by which claims and report are made."""
        datasets = {
            kind: {name: each.settings() for name, each in getattr(self, kind).items()}
            for kind in KINDS
        }
        return {
            "preset": self.preset,
            "seed": self.seed,
            "model": dict(self.model),
            "numerics": self.numerics.settings(),
            **datasets,
            "agreement": self.agreement.settings(),
        }


def load(path) -> dict:
    """Read a YAML file. Raises InputError when it is missing, is not YAML or is not a mapping."""
    try:
        content = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except yaml.YAMLError as error:
        raise InputError(f"{path}: not YAML: {' '.join(str(error).split())}") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: must be a mapping of keys to values")
    return content


def make_plan(config: dict, schema: dict) -> Plan:
    """The plan of the preset that `config` names.

    config : content of config.yaml, with what the command line changed.
    schema : content of workflow/schemas/config.schema.yaml.

    Raises InputError for the first thing that is wrong, anywhere in the config: every preset is
    checked, not only the one asked for.
    """
    config = _normalised(config)
    _validate(config, schema)
    chosen = config["preset"]
    if chosen not in config["presets"]:
        known = list(config["presets"])
        raise _error(f"preset = {chosen!r}: allowed are {', '.join(known)}", chosen, known)
    return {preset: _preset_plan(config, preset) for preset in config["presets"]}[chosen]


# --- from config to plan --------------------------------------------------------------------------


def _preset_plan(config: dict, preset: str) -> Plan:
    section = config["presets"][preset]
    where = f"presets.{preset}"
    _check_lengths(section, where)
    sections = config["numerics"]["section_position"]
    by_size = {int(n_blocks): position for n_blocks, position in sections.items()}
    methods = {kind: _methods(config, kind, section[kind], where) for kind in KINDS}
    plan = Plan(
        preset=preset,
        seed=config["seed"],
        model=config["model"],
        numerics=Numerics(**config["numerics"] | {"section_position": by_size}),
        scans={
            name: _scan(name, entry, section, methods["scans"][name], f"{where}.scans.{name}")
            for name, entry in section["scans"].items()
        },
        series={
            name: _single(Series, name, entry, methods["series"][name], f"{where}.series.{name}")
            for name, entry in section["series"].items()
        },
        catalogues={
            name: _catalogue(name, entry, methods["catalogues"][name], f"{where}.catalogues.{name}")
            for name, entry in section["catalogues"].items()
        },
        ensembles={
            name: _ensemble(name, entry, methods["ensembles"][name], f"{where}.ensembles.{name}")
            for name, entry in section["ensembles"].items()
        },
        agreement=_agreement(config, section["agreement"], f"{where}.agreement"),
    )
    _check_sections(plan)
    return plan


def _scan(name: str, entry: dict, preset: dict, method: Method, where: str) -> Scan:
    lengths = {key: entry.get(key, preset[key]) for key in ("duration", "transient")}
    _check_lengths(lengths, where)
    velocities = entry["belt_velocity"]
    numbers = _values(entry["n_blocks"], f"{where}.n_blocks")
    by_size = isinstance(velocities, dict) and "start" not in velocities
    points = []
    for n_blocks in map(int, numbers):
        place = f"{where}.belt_velocity"
        if by_size and str(n_blocks) not in velocities:
            raise _error(f"{place} has no entry for n_blocks = {n_blocks}")
        at_size = velocities[str(n_blocks)] if by_size else velocities
        points += [
            (n_blocks, belt_velocity, noise)
            for noise in _values(entry["noise"], f"{where}.noise")
            for belt_velocity in _values(at_size, place)
        ]
    if by_size and (extra := set(velocities) - {str(int(number)) for number in numbers}):
        raise _error(f"{place} has an entry for n_blocks = {min(extra)}, which the scan lacks")
    return Scan(
        name=name,
        method=method,
        **lengths,
        points_per_job=int(entry.get("points_per_job", preset["points_per_job"])),
        points=tuple(sorted(points, key=lambda point: (point[0], point[2], point[1]))),
    )


def _single(kind: type, name: str, entry: dict, method: Method, where: str):
    _check_lengths(entry, where)
    return kind(name=name, method=method.at(entry["noise"]), **entry)


def _catalogue(name: str, entry: dict, method: Method, where: str) -> Catalogue:
    _check_section_block(entry["section_block"], entry["n_blocks"], where)
    return _single(Catalogue, name, entry, method, where)


def _ensemble(name: str, entry: dict, method: Method, where: str) -> Ensemble:
    _check_settle_time(entry, where)
    rest = {key: value for key, value in entry.items() if key != "belt_velocity"}
    velocities = _values(entry["belt_velocity"], f"{where}.belt_velocity")
    return Ensemble(name=name, method=method.at(entry["noise"]), belt_velocities=velocities, **rest)


def _agreement(config: dict, section: dict, where: str) -> Agreement:
    base = config["numerics"]["time_step"]
    parts = {}
    for name in PARTS:
        part = dict(section[name])
        place = f"{where}.{name}"
        for key in ("n_blocks", "belt_velocity", "noise", "initial_spread"):
            if key in part:
                part[key] = list(_values(part[key], f"{place}.{key}"))
        part["n_blocks"] = list(map(int, part["n_blocks"]))
        steps = part.setdefault("time_steps", {role: [base] for role in ROLES})
        for role in ROLES:
            if base not in steps[role]:
                raise _error(f"{place}.time_steps.{role} lacks numerics.time_step = {base:g}")
        if "transient" in part:
            _check_lengths(part, place)
        if "settle_time" in part:
            _check_settle_time(part, place)
        if "section_block" in part:
            _check_section_block(part["section_block"], min(part["n_blocks"]), place)
        parts[name] = part
    return Agreement(methods=config["agreement"], parts=parts, seed=config["seed"])


def _methods(config: dict, kind: str, datasets: dict, where: str) -> dict[str, Method]:
    """Method of each dataset of one kind; every dataset must be listed and no other."""
    listed, single = config["methods"][kind], config["method"]
    for name in listed:
        if name not in datasets:
            text = f"methods.{kind}.{name}: {where}.{kind} has no dataset {name!r}"
            raise _error(text, name, list(datasets))
    for name in datasets:
        if name not in listed:
            text = f"{where}.{kind}.{name} has no entry in methods.{kind}"
            raise _error(text, name, list(listed))
    chosen = listed if single == LISTED else dict.fromkeys(listed, single)
    return {
        name: Method(**entry) if isinstance(entry, dict) else Method(entry, entry)
        for name, entry in chosen.items()
    }


def _values(grid, where: str) -> tuple[float, ...]:
    """Values of a number, a list or a {start, stop, step}, ascending."""
    if isinstance(grid, list):
        return tuple(sorted(map(float, grid)))
    if not isinstance(grid, dict):
        return (float(grid),)
    start, stop, step = (grid[key] for key in ("start", "stop", "step"))
    if stop < start:
        raise _error(f"{where}.stop = {stop:g}: must not be less than start = {start:g}")
    count = math.floor((stop - start) / step + 1e-9) + 1
    if count > LONGEST_GRID:
        raise _error(
            f"{where}.step = {step:g}: gives {count} values, at most {LONGEST_GRID} allowed"
        )
    return tuple(round(float(start + index * step), GRID_DIGITS) for index in range(count))


def _without_name(dataset) -> dict:
    return {each.name: getattr(dataset, each.name) for each in fields(dataset)[1:]}


# --- what a schema cannot say ---------------------------------------------------------------------


def _check_lengths(section: dict, where: str) -> None:
    if section["transient"] >= section["duration"]:
        raise _error(
            f"{where}.transient = {section['transient']:g}: "
            f"must be less than duration = {section['duration']:g}"
        )


def _check_settle_time(section: dict, where: str) -> None:
    if section["settle_time"] >= section["duration"]:
        raise _error(
            f"{where}.settle_time = {section['settle_time']:g}: "
            f"must be less than duration = {section['duration']:g}"
        )


def _check_section_block(block: int, n_blocks: int, where: str) -> None:
    if block > n_blocks:
        raise _error(f"{where}.section_block = {block}: the chain has {n_blocks} blocks")


def _check_sections(plan: Plan) -> None:
    known = plan.numerics.section_position
    users = {
        f"scans.{scan.name}": {point[0] for point in scan.points} for scan in plan.scans.values()
    }
    users["agreement.disorder"] = set(plan.agreement.parts["disorder"]["n_blocks"])
    for user, sizes in users.items():
        for n_blocks in sorted(sizes - set(known)):
            raise _error(
                f"numerics.section_position has no entry for n_blocks = {n_blocks}, "
                f"which presets.{plan.preset}.{user} uses"
            )


# --- the schema, in words -------------------------------------------------------------------------


def _normalised(node):
    """The config with text keys only, and with numbers that were read as text turned into numbers.

    YAML reads 2e6 as text, and Snakemake every number inside `--config 'presets={...}'`.
    """
    if isinstance(node, dict):
        return {str(key): _normalised(value) for key, value in node.items()}
    if isinstance(node, list | tuple):
        return [_normalised(value) for value in node]
    if isinstance(node, str) and re.fullmatch(r"[+-]?\d+", node):
        return int(node)
    if isinstance(node, str) and re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", node):
        return float(node)
    if isinstance(node, float) and not math.isfinite(node):
        raise _error(f"{node} is not allowed as a value: a finite number is needed")
    return node


def _validate(config: dict, schema: dict) -> None:
    errors = jsonschema.Draft202012Validator(schema).iter_errors(config)
    # A misspelt key is also a missing one: speak of the cause.
    first = min(errors, key=lambda error: error.validator != "additionalProperties", default=None)
    if first is not None:
        raise _explained(first)


def _explained(error: jsonschema.ValidationError) -> InputError:
    where = _dotted(error.absolute_path)
    allowed = error.validator_value
    value = error.instance
    match error.validator:
        case "additionalProperties":
            known = list(error.schema.get("properties", {}))
            patterns = error.schema.get("patternProperties", {})
            unknown = next(key for key in value if not _is_known(key, known, patterns))
            place = f" in {where}" if where else ""
            return _error(f"unknown key {unknown!r}{place}", unknown, known)
        case "required":
            missing = next(key for key in allowed if key not in value)
            return _error(f"{'.'.join(filter(None, [where, missing]))} is missing")
        case "enum":
            text = f"{where} = {value!r}: allowed are {', '.join(allowed)}"
            return _error(text, str(value), allowed)
        case "type":
            return _error(f"{where} = {_shown(value)}: must be {_TYPES.get(allowed, allowed)}")
        case "minimum" | "maximum" | "exclusiveMinimum" | "exclusiveMaximum":
            return _error(f"{where} = {value!r}: must be {_LIMITS[error.validator]} {allowed:g}")
        case "minItems" | "minProperties" | "minLength":
            return _error(f"{where} is empty: at least one entry is needed")
        case "uniqueItems":
            return _error(f"{where} = {_shown(value)}: the same value occurs twice")
    return _error(f"{where}: {error.message}")


_TYPES = {
    "object": "a mapping of keys to values",
    "array": "a list",
    "string": "text",
    "number": "a number",
    "integer": "a whole number",
}
_LIMITS = {
    "minimum": "at least",
    "maximum": "at most",
    "exclusiveMinimum": "greater than",
    "exclusiveMaximum": "less than",
}


def _is_known(key: str, names: list[str], patterns: dict) -> bool:
    return key in names or any(re.search(pattern, key) for pattern in patterns)


def _dotted(path: Iterator) -> str:
    """Path to a value as in `presets.smoke.scans.n5_map.noise[2]`."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return "".join(parts).removeprefix(".")


def _shown(value) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _error(text: str, found: str = "", known: list[str] | None = None) -> InputError:
    """One line about the config; with the nearest known name when `found` looks like a slip."""
    nearest = difflib.get_close_matches(found, known or [], n=1, cutoff=0.6)
    hint = f"; did you mean {nearest[0]!r}?" if nearest else ""
    return InputError(f"{SOURCE}: {text}{hint}")
