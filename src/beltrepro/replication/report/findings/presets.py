"""Verdicts of several runs side by side."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from beltrepro.replication.report.findings.results import Result, Results


@dataclass(frozen=True)
class Comparison:
    """Verdicts of this run and of others.

    runs : names of the others; verdicts : of each claim that any two runs judge differently, in the
    order of `runs`, empty where a run lacks the claim or judges it by another criterion.
    same, known : for each of the others, claims with the same verdict and claims that both judge.
    """

    runs: tuple[str, ...]
    rows: tuple[tuple[Result, tuple[str, ...]], ...]
    same: tuple[int, ...]
    known: tuple[int, ...]


def compare(results: Results, others: dict[str, Path]) -> Comparison | None:
    """This run beside others."""
    tables = {name: _verdicts(path, results) for name, path in others.items()}
    if not tables:
        return None
    rows = [
        (result, tuple(each.get(key, "") for each in tables.values()))
        for key, result in results.items()
    ]
    return Comparison(
        runs=tuple(tables),
        rows=tuple(row for row in rows if _differ(*row)),
        same=tuple(
            sum(results[key].verdict == verdict for key, verdict in each.items())
            for each in tables.values()
        ),
        known=tuple(map(len, tables.values())),
    )


def _differ(result: Result, verdicts: tuple[str, ...]) -> bool:
    return bool({*verdicts} - {"", result.verdict})


def _verdicts(path: Path, results: Results) -> dict[str, str]:
    """Verdicts of a table of claims, of the claims that it judges as this run does."""
    table = pd.read_csv(path, dtype=str, keep_default_na=False)
    counted = table[table["variant"] == ""]
    return {
        row["id"]: row["verdict"]
        for row in counted.to_dict("records")
        if row["id"] in results and row["criterion"] == results[row["id"]].criterion
    }
