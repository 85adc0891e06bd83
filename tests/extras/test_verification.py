"""How far numbers of another machine may be from the list; `test_integrity.py` has the files."""

import numpy as np
import pytest

from beltrepro.extras import verification


@pytest.mark.parametrize("share", [-1.2, -0.8, 0.8, 1.2])
@pytest.mark.parametrize(
    ("duration", "bound"),
    [(500.0, 1e-6 * (3.0 + 0.5)), (501.0, 6 * 0.5 * np.sqrt(2 / 8) + 1e-6 * 3.0)],
)
def test_means_agree_up_to_the_bound(duration, bound, share):
    listed, here = [40, -3.0, 0.5], [40, -3.0 + share * bound, 0.7]
    assert verification._apart(here, listed, duration, 8) == (abs(share) > 1)


def test_summaries_are_of_finite_values_and_of_each_field():
    values = np.array([1.0, np.nan, 4.0, np.inf, 4.0])
    assert verification._summaries(values) == {"": [3, 3.0, np.sqrt(2).round(8)]}
    records = np.array([(1, 2.0, "a"), (5, 4.0, "b")], [("n", int), ("x", float), ("s", "U1")])
    assert verification._summaries(records) == {"n": [2, 3.0, 2.0], "x": [2, 3.0, 1.0]}
    assert verification._summaries(np.array([np.nan])) == {"": [0, 0.0, 0.0]}
