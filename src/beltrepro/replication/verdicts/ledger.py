"""The ledger: claims of the paper with their criteria, and the functions that measure them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import Any

import yaml

SECTIONS = {
    "model": "laws/claims",
    "experiment": "experiment/claims",
    "without_noise": "transition/claims_motion",
    "transition_without_noise": "transition/claims",
    "avalanches": "avalanches/claims",
    "motion": "chaos/claims",
    "transients": "transition/claims_transients",
    "transition_with_noise": "noise/claims",
    "intermittency": "noise/claims_intermittency",
    "noise_of_experiment": "experiment/claims_noise",
    "motion_of_sizes": "sizes/claims_motion",
    "system_size": "sizes/claims",
    "noise_and_size": "sizes/claims_noise",
    "integrators": "integrators/claims",
}
REGISTRY: dict[str, Callable] = {}
# PyYAML's own reader takes ten times as long; it is the one where libyaml is not to be had.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
KINDS = ("number", "shape", "construction")
# What a reading can change that the paper leaves to the one who computes.
CHANGES = ("integrator", "time step", "initial state", "transient", "length", "number of runs")


@dataclass(frozen=True)
class Claim:
    """One entry of the ledger; the fields are explained in README.md beside this file."""

    id: str
    section: str
    figure: int | None
    kind: str
    statement: str
    criterion: dict[str, Any] = field(hash=False)
    needs: tuple[str, ...] = ()
    paper: Any = field(default=None, hash=False)
    parameters: dict[str, Any] = field(default_factory=dict, hash=False)
    open: str = ""
    reading: str = ""
    changes: dict[str, str] = field(default_factory=dict, hash=False)
    reason: str = ""

    @property
    def testable(self) -> bool:
        """Whether there is anything that a simulation can be compared with."""
        return bool(self.criterion.get("allowed"))

    @property
    def finding(self) -> bool:
        """Whether it could come out otherwise: not true because the model is built so."""
        return self.kind != "construction"


def claim(identifier: str) -> Callable:
    """Register a function `(evidence) -> Measurement`, or one that returns readings, for a claim.

    Readings of an open point are a dict of functions `() -> Measurement` by name; the first is the
    one that counts, the others are variants.
    """

    def register(function: Callable) -> Callable:
        if identifier in REGISTRY:
            raise ValueError(f"claim {identifier!r} has two functions")
        REGISTRY[identifier] = function
        return function

    return register


def read_yaml(room: str, name: str) -> Any:
    """Content of a YAML file that is part of the package."""
    text = resources.files(room).joinpath(name).read_text(encoding="utf-8")
    return yaml.load(text, Loader=_LOADER)


def printed(identifier: str) -> Any:
    """What the paper prints of a claim."""
    return load_ledger()[identifier].paper


@cache
def load_ledger() -> Mapping[str, Claim]:
    """All claims by id, section by section; read once."""
    claims = {}
    for section, place in SECTIONS.items():
        for entry in read_yaml("beltrepro.replication.studies", f"{place}.yaml"):
            needs = tuple(entry.pop("needs"))
            claims[entry["id"]] = Claim(**entry, section=section, needs=needs)
    return MappingProxyType(claims)
