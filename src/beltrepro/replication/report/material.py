"""What a run left for the page and the article: files by name, and what several sections read."""

import base64
import functools
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from beltrepro.base import store
from beltrepro.base.store import Dataset
from beltrepro.replication.plan import registry
from beltrepro.replication.report.claim_results import OtherRun, Results, compared, read_tables
from beltrepro.replication.report.trust import length
from beltrepro.replication.verdicts.ledger import read_yaml


@dataclass(frozen=True)
class Material:
    """Files of a run, by the names under which the workflow hands them over."""

    preset: str
    settings: dict
    files: dict[str, list[Path]]
    benchmarks: Path = Path("none")

    def has(self, names: Iterable[str]) -> bool:
        """Whether there is at least one file of each name, or a dataset of that name."""
        return all(self._files(name) for name in names)

    def file(self, name: str) -> Path:
        """The one file of this name, or that of the dataset of this name."""
        (path,) = self._files(name)
        return path

    def _files(self, name: str) -> list[Path]:
        datasets = self.files.get("datasets", [])
        return self.files.get(name) or [path for path in datasets if path.stem == name]

    @functools.cached_property
    def claims(self) -> Results:
        """The claims of the run by id."""
        return read_tables(self.file("claims"), self.file("estimates"))

    @functools.cached_property
    def others(self) -> list[OtherRun]:
        """Verdicts of other runs."""
        return compared(self.claims, self.files.get("compared", []))

    @functools.cached_property
    def datasets(self) -> list[dict]:
        """What was simulated: one dict of plain values per dataset."""
        return [_describe(store.read(path)) for path in self.files.get("datasets", [])]

    @functools.cached_property
    def images(self) -> dict[str, Path]:
        """Files of the figures by name, in the order of the registry."""
        drawn = {path.stem: path for path in self.files.get("figures", [])}
        return {name: drawn[name] for name in registry.figures() if name in drawn}

    @functools.cached_property
    def pictures(self) -> list[dict]:
        """The figures that were drawn, with their words and claims, as templates show them."""
        return [
            _picture(name, registry.figures()[name], path, self.claims)
            for name, path in self.images.items()
        ]


@functools.cache
def captions() -> dict[str, str]:
    """What the captions of the paper say, in our words, by number of the figure."""
    return read_yaml("beltrepro.replication.report", "captions.yaml")


def distinct(values: Iterable[object]) -> list[str]:
    """The different values as text, in order, without empty ones."""
    return list(dict.fromkeys(str(value) for value in values if value not in ("", None)))


def _picture(name: str, entry: registry.Figure, path: Path, claims: Results) -> dict:
    shown = [result for result in claims.values() if entry.number == str(result.claim.figure)]
    return {
        "name": name,
        "number": entry.number,
        "category": entry.category,
        "heading": f"Figure {entry.number}. {entry.title}" if entry.number else entry.title,
        "words": entry.words,
        "printed": captions().get(entry.number, ""),
        "alt": entry.alt,
        "image": base64.b64encode(path.read_bytes()).decode(),
        "claims": shown,
        "uses": list(entry.uses),
    }


def _describe(dataset: Dataset) -> dict:
    attributes, arrays = dataset.attributes, dataset.arrays
    residual = arrays.get("energy_residual")
    libraries = json.loads(attributes.get("library_versions", "{}"))
    count = len(arrays["n_blocks"])
    grids = ("n_blocks", "belt_velocity", "noise", "time_step", "seed")
    tables = {"slips": "slips", "avalanches": "avalanches", "section": "section points"}
    tables |= {"time": "samples", "events": "events"}
    contents = [f"{len(arrays[key])} {words}" for key, words in tables.items() if key in arrays]
    return {name: _grid(arrays[name]) for name in grids} | {
        "name": attributes["dataset"],
        "kind": attributes["kind"],
        "method": str(attributes["method"]),
        "duration": length(attributes["duration"]),
        "transient": length(attributes.get("transient", 0.0)),
        "size": ", ".join([f"{count} point{'s' * (count != 1)}", *contents]),
        "energy_residual": "" if residual is None else f"{np.nanmax(np.abs(residual)):.1e}",
        "code_version": str(attributes["code_version"]),
        "processor": str(attributes.get("processor", "")),
        "libraries": ", ".join(f"{name} {number}" for name, number in libraries.items()),
    }


def _grid(values: np.ndarray) -> str:
    """A grid as short text: its few values, or its ends and number."""
    values = np.unique(values)
    if values.size <= 7:
        return ", ".join(f"{value:g}" for value in values)
    return f"{values[0]:g} to {values[-1]:g} ({values.size})"
