"""Reading of the ledger, the files in `ledger/`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from types import MappingProxyType
from typing import Any

from beltrepro import packaged

SECTIONS = (
    "model",
    "experiment",
    "without_noise",
    "transition_without_noise",
    "avalanches",
    "motion",
    "transients",
    "transition_with_noise",
    "intermittency",
    "noise_of_experiment",
    "motion_of_sizes",
    "system_size",
    "noise_and_size",
    "integrators",
)
KINDS = ("number", "shape", "construction")


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
    reason: str = ""

    @property
    def testable(self) -> bool:
        """Whether there is anything that a simulation can be compared with."""
        return bool(self.criterion.get("allowed"))

    @property
    def finding(self) -> bool:
        """Whether it could come out otherwise: not true because the model is built so."""
        return self.kind != "construction"


@cache
def load_ledger() -> Mapping[str, Claim]:
    """All claims by id, section by section; read once."""
    claims = {}
    for section in SECTIONS:
        for entry in packaged.read_yaml("beltrepro.claims", f"ledger/{section}.yaml"):
            needs = tuple(entry.pop("needs"))
            claims[entry["id"]] = Claim(**entry, section=section, needs=needs)
    return MappingProxyType(claims)
