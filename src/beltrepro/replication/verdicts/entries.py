"""Reading of the ledger, the files in `ledger/`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from types import MappingProxyType
from typing import Any

from beltrepro.replication.verdicts import packaged

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
KINDS = ("number", "shape", "construction")
# What a reading can change that the paper leaves to the one who computes.
CHANGES = (
    "integrator",
    "time step",
    "initial state",
    "transient",
    "length",
    "number of runs",
)


@dataclass(frozen=True)
class Claim:
    """One entry of the ledger; the fields are explained in `ledger/README.md`."""

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


def printed(claim: str) -> Any:
    """What the paper prints of a claim."""
    return load_ledger()[claim].paper


@cache
def load_ledger() -> Mapping[str, Claim]:
    """All claims by id, section by section; read once."""
    claims = {}
    for section, place in SECTIONS.items():
        for entry in packaged.read_yaml("beltrepro.replication.studies", f"{place}.yaml"):
            needs = tuple(entry.pop("needs"))
            claims[entry["id"]] = Claim(**entry, section=section, needs=needs)
    return MappingProxyType(claims)
