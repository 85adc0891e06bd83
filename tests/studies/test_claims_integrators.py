"""Claim on the numerical method, by made-up points of both integrators with a known answer."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, UNDECIDED
from made_up import grades, measured, scan

U = np.linspace(5, 45, 60)


def both(shift=0.0, *, far=0, scatter=0.02, noise=0.0, seed=1, names=("n5_rows_check", "n5_rows")):
    """Points by each method; ln r of `event` is shifted, and that of `far` points by 0.5 more."""
    rng = np.random.default_rng(seed)
    change = shift + scatter * rng.standard_normal(U.size)
    change[:far] += 0.5 * np.where(np.arange(far) % 2, 1, -1)
    verlet = scan(5, U, 0.1, noise=noise, method="verlet")
    event = scan(5, U, 0.1 * np.exp(change), noise=noise, method="event")
    return dict(zip(names, (verlet, event), strict=True))


def pair(**options):
    """Points with noise and, in other datasets, without."""
    quiet = both(names=("n5_replicates_check", "n5_replicates"), seed=2, **options.pop("quiet", {}))
    return both(noise=1.0, **options) | quiet


def named(verdicts, which="with"):
    return verdicts[f"mean shift, {which} noise"], verdicts[f"points that differ, {which} noise"]


@pytest.mark.parametrize(
    ("options", "verdicts"),
    [
        ({}, (HOLDS, HOLDS)),
        ({"shift": 0.06}, (FAILS, HOLDS)),
        ({"shift": -0.06}, (FAILS, HOLDS)),
        ({"shift": 0.03}, (UNDECIDED, HOLDS)),
        ({"scatter": 0.2}, (UNDECIDED, FAILS)),  # a large error decides nothing
        ({"far": 4}, (UNDECIDED, HOLDS)),
        ({"far": 15}, (UNDECIDED, UNDECIDED)),
        ({"far": 30}, (UNDECIDED, FAILS)),
    ],
)
def test_both_methods_agree(options, verdicts):
    made = grades("method-independence", **pair(**options))
    assert named(made) == verdicts and named(made, "without") == (HOLDS, HOLDS)
    made = grades("method-independence", **pair(quiet=options))
    assert named(made) == (HOLDS, HOLDS)
    assert named(made, "without")[1] == verdicts[1]


def test_the_ratio_is_of_means_over_runs_and_each_point_counts_once():
    event = scan(5, U, np.tile([0.08, 0.12], 60), replicates=2, noise=1.0)
    verlet = scan(5, U, 0.1, replicates=2, noise=1.0, method="verlet")
    made = pair() | {"pairs_r_event": event, "pairs_r_verlet": verlet}
    estimate = measured("method-independence", **made).judged["mean shift, with noise"]
    assert estimate.value == pytest.approx(0) and estimate.runs == 60  # not the pair that follows


def test_which_dataset_is_of_which_method_is_read_off_its_points():
    """At sigma = 0 the check is by `event`, elsewhere the scan."""
    turned = both(0.06, names=("size_rows", "size_rows_check"))
    made = measured("method-independence", **both(noise=1.0), **turned)
    assert made.judged["mean shift, without noise"].value == pytest.approx(0.06, abs=0.01)
    assert made.also["largest shift, without noise"].value > 0.06


def test_transients_are_left_out():
    made = pair()
    for name in ("n5_rows", "n5_rows_check"):
        made[name].attributes["transient"] = 4999.0
    with pytest.raises(NotEnoughDataError, match="0 points with noise by both integrators, 8"):
        measured("method-independence", **made)
    del made["n5_replicates"]
    made["n5_rows"].attributes["transient"] = made["n5_rows_check"].attributes["transient"] = 5000.0
    with pytest.raises(NotEnoughDataError, match="0 points without noise by both"):
        measured("method-independence", **made)
