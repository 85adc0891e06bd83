"""Runs that are added at some points draw no number of several points there."""

import contextlib

import numpy as np
import pytest

import made_up
from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from made_up import few_resamples  # noqa: F401

CLAIMS = (
    "bifurcation-sigma0", "windows-vanish", "intermittency", "intermittency-region",
    "n10-intermittency", "r-experiment", "r-windows",
)  # fmt: skip


def scans():
    """Runs of which half are periodic up to u = 15, of five and of ten blocks, and a map."""
    falls = {0.0: 17, 0.5: 17, 1.0: 17, 2.2: 19, 5.0: 24}
    share = {"windows": {0.0: 0.5}, "laminar": lambda u, noise: 0.01 * u}
    five = made_up.replicates(falls, noises=tuple(falls), **share)
    ten = made_up.replicates(30, noises=(0.0, 1.0), velocities=np.arange(25.0, 39), **share)
    ten = Dataset(ten.arrays | {"n_blocks": 10 + 0 * ten.arrays["n_blocks"]}, ten.attributes)
    names = ("n5_replicates", "n5_replicates_check", "n5_replicates_wide")
    made = dict.fromkeys(names, five) | {"size_replicates": ten}
    table = made_up.replicates(20, noises=np.arange(0.0, 9), replicates=1, **share)
    return made, {"n5_map": table}


def with_more(scan):
    """The scan with 16 more runs at every third velocity, all periodic and of large r."""
    arrays, count = scan.arrays, len(scan.arrays["noise"])
    velocities = np.unique(arrays["belt_velocity"])[1::3]
    added = np.flatnonzero(np.isin(arrays["belt_velocity"], velocities))
    rows = np.r_[np.arange(count), added, added]
    more = {name: values[rows] for name, values in arrays.items()}
    more["replicate"] = more["replicate"] + np.repeat([0, 8, 16], [count, len(added), len(added)])
    more["disorder_parameter"][count:] = 0.5
    more["laminar_count"][count:] = 99
    more["section_velocity"][count:] = -20.0
    return Dataset(more, scan.attributes)


def _measured(functions):
    """The first reading that these scans are enough for."""
    for function in functions.values():
        with contextlib.suppress(NotEnoughDataError):
            return function()
    pytest.fail("no reading can be measured")


@pytest.mark.parametrize("claim", CLAIMS)
def test_numbers_of_several_points_take_as_many_runs_at_each(claim):
    runs, others = scans()
    readings = [
        made_up.readings(claim, data | others)
        for data in (runs, {name: with_more(scan) for name, scan in runs.items()})
    ]
    first, second = (_measured(functions).judged for functions in readings)
    at_one = {"intermittency": {"alternating"}, "r-experiment": {"r_022"}}
    for number, estimate in first.items():
        if not number.startswith(tuple(at_one.get(claim, ["none"]))):
            assert second[number] == estimate, number
