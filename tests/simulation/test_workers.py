"""Several cores: no bit depends on them, the first error and Ctrl-C end all."""

import threading

import numpy as np
import pytest

from beltrepro import (
    ChainParameters,
    Grid,
    catalogue,
    classify,
    lyapunov_spectrum,
    scan,
    time_to_continuous_slip,
    time_to_orbit,
)
from beltrepro.base.errors import ModelStateError

GRID = Grid([2, 3], np.linspace(5.0, 25.0, 9), [0.0, 1.0], replicates=2)
SHORT = {"duration": 60.0, "transient": 20.0, "initial_spread": 1.0}


def threads() -> int:
    return sum(thread.name.startswith("beltrepro") for thread in threading.enumerate())


functions = pytest.mark.parametrize(
    ("called", "settings"),
    [
        (scan, SHORT),
        (catalogue, SHORT),
        (lyapunov_spectrum, SHORT),
        (classify, SHORT),
        (time_to_continuous_slip, {"duration": 60.0}),
        (time_to_orbit, {"duration": 1500.0}),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)


@functions
@pytest.mark.filterwarnings("ignore")
def test_no_bit_depends_on_the_cores(called, settings):
    alone, together = (called(GRID, workers=workers, **settings) for workers in (1, 3))
    assert list(alone) == list(together)
    for name, values in alone.items():
        assert values.tobytes() == together[name].tobytes(), name


@pytest.mark.parametrize("workers", [1, 2])
def test_progress_rises_to_one_and_is_told_by_the_thread_that_calls(workers):
    told = []

    def progress(fraction):
        assert threading.current_thread() is threading.main_thread()
        told.append(fraction)

    scan(GRID, progress=progress, workers=workers, **SHORT, method="verlet")
    assert told == sorted(set(told)) and told[-1] == 1.0


def test_ctrl_c_ends_all_soon():
    def interrupted(fraction):
        assert threads() > 0
        raise KeyboardInterrupt

    chains = ChainParameters(5, 10.0, 1.0)
    with pytest.raises(KeyboardInterrupt):
        scan(chains, replicate=range(64), duration=1e7, progress=interrupted, workers=2)
    assert threads() == 0


def test_the_first_error_ends_all():
    good, bad = (
        ChainParameters(5, 10.0, 1.0),
        ChainParameters(10, 200.0),
    )  # larger groups begin first
    with pytest.raises(ModelStateError, match="N=10, u=200"):
        scan([good] * 40 + [bad] * 40, replicate=range(80), duration=1e7, workers=2)
    assert threads() == 0
