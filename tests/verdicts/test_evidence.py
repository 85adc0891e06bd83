"""Cuts through scans, which claims read."""

from made_up import cut


def test_a_cut_reads_its_points():
    made = cut([1.0, 5, 9], noise=[0, 1, 2], disorder=[0.1, 0.2, 0.3], velocities=[[1], [2], [3]])
    assert made.between(1, 5).tolist() == [True, True, False]
    assert made.between(1 + 1e-12, 9 - 1e-12).tolist() == [True, True, True]
    assert made.noise.tolist() == [0, 1, 2] and made.disorder.tolist() == [0.1, 0.2, 0.3]
    assert made.velocities.tolist() == [[1], [2], [3]]
