"""The ledger: claims of the paper with their criteria, and the functions that measure them."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

from beltrepro.replication.plan import points
from beltrepro.replication.verdicts.criteria import QUESTIONS, Criterion

# The sections of the ledger in the order of the paper, and the study whose claims.yaml has each.
SECTIONS = {
    "model": "laws",
    "experiment": "experiment",
    "without_noise": "transition",
    "transition_without_noise": "transition",
    "avalanches": "avalanches",
    "motion": "chaos",
    "transients": "transition",
    "transition_with_noise": "noise",
    "intermittency": "noise",
    "noise_of_experiment": "experiment",
    "motion_of_sizes": "sizes",
    "system_size": "sizes",
    "noise_and_size": "sizes",
    "integrators": "integrators",
    "fall": "fall",
}
REGISTRY: dict[str, dict[str, Callable]] = {}  # by claim and reading
# What a statement is about. A `construction` is true because the model is built so, `validation`
# tests our own camera, a `recording` is not to be compared: the recordings are not published. An
# `explanation` is not in the paper: it is ours, and has one criterion.
KINDS = ("number", "shape", "recording", "validation", "construction", "explanation")
FINDINGS = ("number", "shape", "recording")
# What of the results had been seen when a criterion was written, the most last.
SEEN = ("nothing", "short runs", "long runs", "the published run")


@dataclass(frozen=True)
class Change:
    """A criterion written or changed: the day, what had been seen by then, and what was changed."""

    date: datetime.date
    seen: str
    what: str


@dataclass(frozen=True)
class Claim:
    """One entry of the ledger; the fields are explained in docs/trust.md."""

    id: str
    section: str
    figure: int | None
    kind: str
    says: str
    statement: str
    replicated: Criterion = field(hash=False)
    robust: Criterion = field(hash=False)
    history: tuple[Change, ...]
    needs: tuple[str, ...] = ()
    paper: Any = field(default=None, hash=False)
    parameters: dict[str, Any] = field(default_factory=dict, hash=False)
    open: str = ""
    starts: str = ""

    @property
    def criteria(self) -> dict[str, Criterion]:
        """The criterion of each question."""
        return {question: getattr(self, question) for question in QUESTIONS}

    @property
    def testable(self) -> bool:
        """Whether there is anything that a simulation can be compared with."""
        return any(not criterion.untestable for criterion in self.criteria.values())

    @property
    def finding(self) -> bool:
        """Whether it is a statement of the paper that could come out otherwise."""
        return self.kind in FINDINGS

    @property
    def seen(self) -> str:
        """The most that had been seen when its criteria were written or changed."""
        return max((change.seen for change in self.history), key=SEEN.index)


def claim(identifier: str, reading: str | dict[str, Any] = "") -> Callable:
    """Register a function `(evidence) -> Measurement` for a claim, or for one of its readings.

    Each criterion names the reading that it judges, or judges the first.

    reading : its name; of several, by name what each gives the function behind `evidence`.
    """

    def register(function: Callable) -> Callable:
        if isinstance(reading, str):
            by_name = {reading: function}
        else:
            by_name = {
                name: lambda evidence, what=what: function(evidence, what)
                for name, what in reading.items()
            }
        readings = REGISTRY.setdefault(identifier, {})
        together = [*readings, *by_name]
        if len(set(together)) < len(together) or ("" in together and len(together) > 1):
            raise ValueError(f"claim {identifier!r} has two functions")
        readings.update(by_name)
        return function

    return register


def read_yaml(room: str, name: str) -> Any:
    """Content of a YAML file that is part of the package."""
    return points.read_yaml(Path(str(resources.files(room).joinpath(name))))


def printed(identifier: str) -> Any:
    """What the paper prints of a claim."""
    return load_ledger()[identifier].paper


@cache
def load_ledger() -> Mapping[str, Claim]:
    """All claims by id, section by section; read once."""
    files = {
        study: read_yaml("beltrepro.replication.studies", f"{study}/claims.yaml")
        for study in set(SECTIONS.values())
    }
    return MappingProxyType(
        {
            entry["id"]: _claim(section, **entry)
            for section, study in SECTIONS.items()
            for entry in files[study][section]
        }
    )


def _claim(section: str, *, replicated: dict, history: list[dict], **entry: Any) -> Claim:
    """An entry as a value; without a criterion for `robust` that of `replicated` is both."""
    robust = entry.pop("robust", replicated)
    return Claim(
        **entry | {"needs": tuple(entry["needs"])},
        section=section,
        replicated=Criterion(**replicated),
        robust=Criterion(**robust),
        history=tuple(Change(**change) for change in history),
    )
