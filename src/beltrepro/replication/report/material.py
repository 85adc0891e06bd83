"""What a run left for the report: files by name, and those that several sections read."""

import base64
import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from beltrepro.base.store import Dataset
from beltrepro.replication.plan import files, registry
from beltrepro.replication.report import findings
from beltrepro.replication.report.findings import Results
from beltrepro.replication.report.findings.pictures import seen
from beltrepro.replication.report.findings.presets import Comparison, compare
from beltrepro.replication.report.findings.reliability import length


@dataclass(frozen=True)
class Material:
    """Files of a run, by the names under which the workflow hands them to the report."""

    preset: str
    settings: dict
    files: dict[str, list[Path]]
    benchmarks: Path
    expected: Mapping[str, dict] = field(default_factory=dict)

    def has(self, names) -> bool:
        """Whether there is at least one file of each name, or a dataset of that name."""
        return all(self._found(name) for name in names)

    def file(self, name: str) -> Path:
        """The one file of this name, or that of the dataset of this name."""
        (path,) = self._found(name)
        return path

    def _found(self, name: str) -> list[Path]:
        datasets = self.files.get("datasets", [])
        return self.files.get(name) or [path for path in datasets if path.stem == name]

    @functools.cached_property
    def claims(self) -> Results:
        """The claims of the run by id."""
        return findings.read(self.file("claims"), self.file("estimates"))

    @functools.cached_property
    def comparison(self) -> Comparison | None:
        """Verdicts of this run beside those of others, None if there are none."""
        others = {path.parent.name: path for path in self.files.get("compared", [])}
        return compare(self.claims, others)

    @functools.cached_property
    def datasets(self) -> list[dict]:
        """What was simulated: one dict of plain values per dataset."""
        return [_describe(self._read(path)) for path in self.files.get("datasets", [])]

    def _read(self, path: Path) -> Dataset:
        told = self.expected.get(path.stem)
        return files.read_any(path) if told is None else files.read(path, told)

    @functools.cached_property
    def pictures(self) -> list[dict]:
        """The figures that were drawn, in the order of the registry, with their words and claims.

        Keys: name, number, category, heading, words, alt, image (base64), claims (results), seen
        (sentences), uses.
        """
        images = {path.stem: path for path in self.files.get("figures", [])}
        return [
            _picture(name, entry, images[name], self.claims)
            for name, entry in registry.figures().items()
            if name in images
        ]

    def pictures_of(self, category: str) -> list[dict]:
        """The pictures of one of `registry.CATEGORIES`."""
        return [picture for picture in self.pictures if picture["category"] == category]


def distinct(values) -> list[str]:
    """The different values as text, in order, without empty ones."""
    return list(dict.fromkeys(str(value) for value in values if value not in ("", None)))


# --- figures --------------------------------------------------------------------------------------


def _picture(name: str, entry: registry.Figure, path: Path, claims: Results) -> dict:
    own = [each for each in claims.values() if entry.number == str(each.claim.figure)]
    return {
        "name": name,
        "number": entry.number,
        "category": entry.category,
        "heading": f"Figure {entry.number}. {entry.title}" if entry.number else entry.title,
        "words": entry.words,
        "alt": entry.alt,
        "image": base64.b64encode(path.read_bytes()).decode(),
        "claims": own,
        "seen": seen(own),
        "uses": list(entry.uses),
    }


# --- datasets -------------------------------------------------------------------------------------


def _describe(dataset: Dataset) -> dict:
    attributes, arrays = dataset.attributes, dataset.arrays
    residual = arrays.get("energy_residual")
    libraries = json.loads(attributes.get("library_versions", "{}"))
    count = len(arrays["n_blocks"])
    return {
        "name": attributes["dataset"],
        "kind": attributes["kind"],
        "method": str(attributes["method"]),
        "n_blocks": _span(arrays["n_blocks"]),
        "belt_velocity": _span(arrays["belt_velocity"]),
        "noise": _span(arrays["noise"]),
        "duration": length(attributes["duration"]),
        "transient": length(attributes.get("transient", 0.0)),
        "time_step": _span(arrays["time_step"]),
        "seed": _span(arrays["seed"]),
        "size": ", ".join(filter(None, [f"{count} point{'s' * (count != 1)}", _contents(arrays)])),
        "energy_residual": "" if residual is None else f"{np.nanmax(np.abs(residual)):.1e}",
        "code_version": str(attributes["code_version"]),
        "processor": str(attributes.get("processor", "")),
        "libraries": ", ".join(f"{name} {number}" for name, number in libraries.items()),
    }


def _contents(arrays) -> str:
    tables = ("slips", "avalanches", "section", "time", "events")
    names = {"time": "samples", "section": "section points"}
    return ", ".join(f"{len(arrays[t])} {names.get(t, t)}" for t in tables if t in arrays)


def _span(values) -> str:
    """A grid as short text: its value, its few values, or its ends and number."""
    values = np.unique(values)
    if values.size <= 7:
        return ", ".join(f"{value:g}" for value in values)
    return f"{values[0]:g} to {values[-1]:g} ({values.size})"
