"""Reading of `ledger.yaml`."""

from dataclasses import dataclass, field
from importlib import resources

import yaml

CRITERIA = (
    "exact",
    "absolute",
    "relative",
    "interval",
    "ordering",
    "topological",
    "qualitative",
    "none",
)


@dataclass(frozen=True)
class Claim:
    """One entry of the ledger; the fields are explained at the top of `ledger.yaml`."""

    id: str
    section: str
    figure: int | None
    kind: str
    statement: str
    criterion: dict = field(hash=False)
    needs: tuple[str, ...] = ()
    paper: object = field(default=None, hash=False)
    parameters: dict = field(default_factory=dict, hash=False)
    open: str = ""
    reading: str = ""
    reason: str = ""
    experiment: dict = field(default_factory=dict, hash=False)

    @property
    def testable(self) -> bool:
        """Whether there is anything that a simulation can be compared with."""
        return self.criterion["type"] != "none"


def load_ledger() -> dict[str, Claim]:
    """All claims by id, in the order of the ledger."""
    text = resources.files("beltrepro.claims").joinpath("ledger.yaml").read_text(encoding="utf-8")
    claims = [Claim(**entry | {"needs": tuple(entry["needs"])}) for entry in yaml.safe_load(text)]
    return {claim.id: claim for claim in claims}
