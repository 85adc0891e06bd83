"""The ledger with its functions, the law of the model, and the plainest stand-in of a dataset."""

from types import SimpleNamespace

from beltrepro.replication.studies.every_claim import REGISTRY
from beltrepro.replication.verdicts.ledger import load_ledger

__all__ = ["LAW", "LEDGER", "REGISTRY", "data"]

LEDGER = load_ledger()
LAW = {
    "static_friction": 71.4,
    "friction_ratio": 0.45,
    "rest_length": 50.0,
    "linear_limit": 20.0,
    "compression_rate": 0.2,
    "extension_rate": 0.01,
}


def data(arrays=None, **attributes):
    return SimpleNamespace(arrays=arrays or {}, attributes=attributes)
