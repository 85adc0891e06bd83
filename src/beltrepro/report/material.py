"""What a run left for the report: files by name, and those that several sections read."""

import base64
import functools
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from beltrepro import store
from beltrepro.claims import load_ledger
from beltrepro.claims.criteria import range_in_words
from beltrepro.claims.estimates import Estimate
from beltrepro.figures import registry


@dataclass(frozen=True)
class Material:
    """Files of a run, by the names under which the workflow hands them to the report.

    Parameters
    ----------
    preset : str
        Name of the preset.
    settings : dict
        Its resolved configuration.
    files : dict of str to list of Path
        "claims" and "estimates": the tables of claims; "figures": PNG files; "datasets": HDF5
        files; and any table that a section needs, by its name. A name may lack.
    benchmarks : Path
        Folder of Snakemake's benchmark files; may lack or be empty.
    """

    preset: str
    settings: dict
    files: dict[str, list[Path]]
    benchmarks: Path

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
    def claims(self) -> list[dict]:
        """Rows of claims.csv, one dict per claim, with its further readings under `variants`.

        The rows of estimates.csv of each are under `values`. The fields of the ledger that the
        table lacks are added: open, reading, version, since and changed of its criterion.
        """
        return _read_claims(self.file("claims"), self.file("estimates"))

    @functools.cached_property
    def datasets(self) -> list[dict]:
        """What was simulated: one dict of plain values per dataset."""
        return [_describe(path) for path in self.files.get("datasets", [])]

    @functools.cached_property
    def pictures(self) -> list[dict]:
        """The figures that were drawn, in the order of the registry, with their words and claims.

        Keys: name, number, category, heading, words, alt, image (base64), claims (rows), uses.
        """
        images = {path.stem: path for path in self.files.get("figures", [])}
        return [
            _picture(name, entry, images[name], self.claims)
            for name, entry in registry.entries().items()
            if name in images
        ]

    def pictures_of(self, category: str) -> list[dict]:
        """The pictures of one of `registry.CATEGORIES`."""
        return [picture for picture in self.pictures if picture["category"] == category]


def length(value: float) -> str:
    """A duration as short text: 40000, 2e6."""
    return f"{value:.3g}".replace("e+0", "e").replace("e+", "e") if value >= 1e6 else f"{value:g}"


def distinct(values) -> list[str]:
    """The different values as text, in order, without empty ones."""
    return list(dict.fromkeys(str(value) for value in values if value not in ("", None)))


# --- figures --------------------------------------------------------------------------------------


def _picture(name: str, entry: registry.Entry, path: Path, claims: list[dict]) -> dict:
    return {
        "name": name,
        "number": entry.number,
        "category": entry.category,
        "heading": f"Figure {entry.number}. {entry.title}" if entry.number else entry.title,
        "words": entry.words,
        "alt": entry.alt,
        "image": base64.b64encode(path.read_bytes()).decode(),
        "claims": [row for row in claims if entry.number and row["figure"] == entry.number],
        "uses": list(entry.uses),
    }


# --- claims ---------------------------------------------------------------------------------------


def _read_claims(claims_csv: Path, estimates_csv: Path) -> list[dict]:
    ledger = load_ledger()
    table = pd.read_csv(claims_csv, dtype=str, keep_default_na=False)
    estimates = _read_estimates(estimates_csv)
    claims: list[dict] = []
    for row in table.to_dict("records"):
        row["values"] = estimates.get((row["id"], row["variant"]), [])
        if row["variant"]:
            claims[-1]["variants"].append(row)
            continue
        claim = ledger[row["id"]]
        criterion = {key: claim.criterion.get(key, "") for key in ("version", "since", "changed")}
        own = {"variants": [], "open": claim.open, "reading": claim.reading}
        claims.append(row | own | criterion)
    return claims


def _read_estimates(path: Path) -> dict[tuple[str, str], list[dict]]:
    """Numbers of each claim and reading: name, interval and allowed range in words, verdict."""
    table = pd.read_csv(path, keep_default_na=False, na_values=[""], dtype={"id": str, "name": str})
    table = table.fillna({"variant": "", "name": "", "verdict": ""})
    found: dict[tuple[str, str], list[dict]] = {}
    for row in table.to_dict("records"):
        runs = None if np.isnan(row["runs"]) else int(row["runs"])
        estimate = Estimate(row["value"], row["low"], row["high"], runs)
        allowed = [row["allowed_low"], row["allowed_high"]]
        found.setdefault((row["id"], row["variant"]), []).append(
            {
                "name": row["name"],
                "words": estimate.words,
                "allowed": "" if np.isnan(allowed[0]) else range_in_words(allowed),
                "verdict": row["verdict"],
                "estimate": estimate,
            }
        )
    return found


# --- datasets -------------------------------------------------------------------------------------


def _describe(path: Path) -> dict:
    dataset = store.read(path)
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
