"""Made-up evidence for claim functions."""

from types import SimpleNamespace

import numpy as np

from beltrepro.replication.studies.every_claim import REGISTRY
from beltrepro.replication.verdicts.evidence import Cut, Evidence
from beltrepro.replication.verdicts.ledger import load_ledger
from beltrepro.stats import states
from beltrepro.stats.transitions import Transition

LEDGER = load_ledger()
LAW = {
    "static_friction": 71.4,
    "friction_ratio": 0.45,
    "rest_length": 50.0,
    "linear_limit": 20.0,
    "compression_rate": 0.2,
    "extension_rate": 0.01,
}
LABELS = {
    "c": states.CHAOTIC,
    "p": states.PERIODIC,
    "q": states.QUASI_PERIODIC,
    "s": states.CONTINUOUS,
    "i": states.INTERMITTENT,
    "t": states.TRANSIENT,
    "u": states.UNDECIDED,
}


def cut(belt_velocity=(), *, labels=None, fall=None, rise=None, transient=2e5, **arrays):
    """A row or column with these points; states, one letter each, and transitions as given."""
    u = np.array(belt_velocity, dtype=float)
    names = {"disorder": "disorder_parameter", "velocities": "section_velocity"}
    points = {"belt_velocity": u, "noise": np.zeros(u.size), "disorder_parameter": np.ones(u.size)}
    points |= {names.get(name, name): np.array(values) for name, values in arrays.items()}
    made = Cut(points, transient, 4e5)
    if labels is not None:
        made.__dict__["states"] = np.array([LABELS[letter] for letter in labels])
    made.__dict__["transition"] = fall
    made.__dict__["noise_transition"] = rise
    return made


class Stub(Evidence):
    """Evidence of made-up rows by (N, sigma), columns by (N, u), tables and datasets by name."""

    laminar_time = 200.0

    def __init__(self, name, *, datasets=None, rows=None, columns=None, tables=None, phases=None):
        super().__init__(datasets or {}, {"model": LAW})
        self.start(LEDGER[name])
        self.rows, self.columns, self.tables, self.phases = rows, columns, tables, phases

    def row(self, n_blocks, noise, *, scan=None, settled=True):
        return self.rows[(n_blocks, noise) if scan is None else (scan, noise)]

    def column(self, scan, n_blocks, belt_velocity, *, settled=True):
        return self.columns[n_blocks, float(belt_velocity)]

    def table(self, scan, *, settled=True):
        return self.tables[scan]

    def laminar_phases(self, name, *, shortest=0.0):
        return self.phases[name]


def measured(name, reading=None, **given):
    """Measurement of a claim from made-up evidence."""
    found = REGISTRY[name](Stub(name, **given))
    return found if reading is None else found[reading]()


def passed(measurement):
    """Which checks pass, as 1 and 0 in their order."""
    return [int(check) for check in measurement.checks.values()]


def transition(lower, upper, critical=None, *, error=0.5, high=0.12, low=0.02, n=10, found=True):
    critical = (lower + upper) / 2 if critical is None else critical
    return Transition(lower, upper, critical, high, low, found, error, 0.003, 0.004, n)


def data(arrays=None, **attributes):
    return SimpleNamespace(arrays=arrays or {}, attributes=attributes)
