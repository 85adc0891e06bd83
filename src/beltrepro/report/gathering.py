"""What the report says, gathered from the files of a run as plain values for the template."""

import csv
import json
from importlib import resources
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from beltrepro import store
from beltrepro.claims import load_ledger
from beltrepro.claims.criteria import NOT_TESTABLE, VERDICTS

PAPER_DURATION = 2e6
PAPER_TRANSIENT = 1e6

# Folders or names of benchmark files, and what the jobs behind them do.
RULES = {
    "blocks": "simulate blocks of scans",
    "scans": "join scans",
    "series": "simulate series",
    "catalogues": "simulate catalogues",
    "ensembles": "simulate and join ensembles",
    "agreement": "compare the integrators",
    "figures": "draw figures",
    "claims": "measure claims",
    "report": "write the report",
}


def read_content() -> dict:
    """The words of the report, from `content.yaml`."""
    text = resources.files("beltrepro.report").joinpath("content.yaml").read_text(encoding="utf-8")
    return yaml.safe_load(text)


def read_claims(claims_csv: Path) -> list[dict]:
    """Rows of claims.csv, one dict per claim, with its further readings under `variants`.

    The fields of the ledger that the table lacks (open, reading, kind) are added.
    """
    ledger = load_ledger()
    table = pd.read_csv(claims_csv, dtype=str, keep_default_na=False)
    claims = []
    for row in table.to_dict("records"):
        row["values"] = _values(row)
        if row["variant"]:
            claims[-1]["variants"].append(row)
            continue
        claim = ledger[row["id"]]
        claims.append(
            row | {"variants": [], "open": claim.open, "reading": claim.reading, "kind": claim.kind}
        )
    return claims


def count_verdicts(claims: list[dict]) -> dict:
    """Number of claims with each verdict, how many there are, and how many can be tested."""
    counts = {verdict: sum(row["verdict"] == verdict for row in claims) for verdict in VERDICTS}
    return {
        "by_verdict": counts,
        "total": len(claims),
        "testable": len(claims) - counts[NOT_TESTABLE],
    }


def read_datasets(paths: list[Path]) -> list[dict]:
    """What was simulated: one dict of plain values per dataset."""
    return [_describe(Path(path)) for path in paths]


def environment(datasets: list[dict]) -> dict[str, str]:
    """Code, libraries and machines that made the datasets; several values where they differ."""
    keys = ("code_version", "processor", "libraries", "seed", "time_step")
    return {key: "; ".join(_distinct(each[key] for each in datasets)) for key in keys}


def read_benchmarks(folder: Path) -> list[dict]:
    """Jobs, time and memory per kind of rule, from the benchmark files of Snakemake."""
    groups = {}
    for path in sorted(Path(folder).rglob("*.tsv")):
        relative = path.relative_to(folder)
        group = relative.parts[0] if len(relative.parts) > 1 else path.stem
        with path.open(newline="", encoding="utf-8") as file:
            for run in csv.DictReader(file, delimiter="\t"):
                groups.setdefault(group, []).append(
                    (_number(run.get("s")), _number(run.get("max_rss")))
                )
    order = [*RULES, *sorted(groups.keys() - RULES.keys())]
    rows = []
    for group in (name for name in order if name in groups):
        seconds, memory = np.array(groups[group]).T
        rows.append(
            {
                "rule": RULES.get(group, group),
                "jobs": len(seconds),
                "seconds": float(np.nansum(seconds)),
                "longest": float(np.nanmax(seconds, initial=0.0)),
                "memory_mb": float(np.nanmax(memory, initial=0.0)),
            }
        )
    return rows


def deviations(content: dict, datasets: list[dict]) -> list[dict]:
    """Differences from the paper: in lengths and methods of this run, and the general ones."""
    rows = []
    scans = [each for each in datasets if each["kind"] == "scan"]
    for lengths in _distinct(f"{each['duration']}, {each['transient']}" for each in scans):
        if lengths != f"{_length(PAPER_DURATION)}, {_length(PAPER_TRANSIENT)}":
            names = [s["name"] for s in scans if f"{s['duration']}, {s['transient']}" == lengths]
            duration, transient = lengths.split(", ")
            rows.append(
                {
                    "what": "Length of the runs",
                    "paper": f"t = {_length(PAPER_DURATION)}, of which {_length(PAPER_TRANSIENT)} "
                    "discarded",
                    "ours": f"t = {duration}, of which {transient} discarded",
                    "where": ", ".join(names),
                    "why": "this preset trades length for time; the preset named paper does not",
                }
            )
    other = [each["name"] for each in datasets if "event" in each["method"]]
    if other:
        rows.append(
            {
                "what": "Integrator",
                "paper": "Verlet scheme, step 0.001, stick and slip at the ends of steps",
                "ours": "high order between events, instants of stick and slip located",
                "where": ", ".join(other),
                "why": "faster; see the section on the two integrators",
            }
        )
    return rows + content["deviations"]


def ambiguities(content: dict, claims: list[dict], settings: dict) -> list[dict]:
    """Open points: of the model, with the reading taken; of claims, with what each reading gave."""
    rows = []
    for entry in content["ambiguities"]:
        reading = entry.get("reading") or settings["numerics"][entry["reading_from"]]
        rows.append({"where": "model", "open": entry["open"], "reading": reading, "effects": []})
    for claim in claims:
        if claim["open"]:
            effects = [
                {"reading": row["variant"], "values": row["values"], "verdict": row["verdict"]}
                for row in claim["variants"]
            ]
            rows.append(
                {
                    "where": claim["id"],
                    "open": claim["open"],
                    "reading": claim["reading"],
                    "effects": effects,
                }
            )
    return rows


def _describe(path: Path) -> dict:
    dataset = store.read(path)
    attributes, arrays = dataset.attributes, dataset.arrays
    config = json.loads(attributes.get("config", "{}"))
    residual = arrays.get("energy_residual", attributes.get("energy_residual"))
    lengths = {len(array) for array in arrays.values() if array.ndim}
    libraries = json.loads(attributes.get("library_versions", "{}"))
    chains = {"scan": "points", "ensemble": "members"}.get(attributes["kind"])
    return {
        "name": f"{path.parent.name}/{path.stem}",
        "kind": attributes["kind"],
        "method": str(attributes["method"]),
        "n_blocks": _span(config.get("n_blocks", attributes.get("n_blocks"))),
        "belt_velocity": _span(
            config.get("belt_velocity", config.get("belt_velocities"))
            or attributes.get("belt_velocity")
        ),
        "noise": _span(config.get("noise", attributes.get("noise"))),
        "duration": _length(attributes["duration"]),
        "transient": _length(attributes["transient"]),
        "time_step": f"{attributes['time_step']:g}",
        "seed": str(attributes["seed"]),
        "size": f"{max(lengths, default=0)} {chains}" if chains else _contents(arrays),
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
    if values is None:
        return ""
    values = np.unique(np.atleast_1d(values))
    if values.size <= 7:
        return ", ".join(f"{value:g}" for value in values)
    return f"{values[0]:g} to {values[-1]:g} ({values.size})"


def _length(value) -> str:
    return f"{value:.3g}".replace("e+0", "e").replace("e+", "e") if value >= 1e6 else f"{value:g}"


def _values(row) -> list[dict]:
    """Named values of a cell "name: value; ..." with their uncertainties beside them."""
    errors = dict(_parts(row["uncertainty"]))
    return [
        {"name": name, "value": value, "error": errors.get(name, "")}
        for name, value in _parts(row["measured"])
    ]


def _parts(cell: str) -> list[tuple[str, str]]:
    parts = [part.rpartition(": ") for part in cell.split("; ") if part]
    return [(name, value) for name, _, value in parts]


def _number(text) -> float:
    try:
        return float(text)
    except (TypeError, ValueError):
        return np.nan


def _distinct(values) -> list[str]:
    return list(dict.fromkeys(str(value) for value in values if value not in ("", None)))
