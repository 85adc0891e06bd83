"""Lyapunov exponents of chains, from the exact tangent dynamics (docs/exponents.md)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError, warn
from beltrepro.chaos import vectors
from beltrepro.chaos.naming import RESTS, warn_of_rests
from beltrepro.chaos.vectors import REST, end_errors, grow, slopes, standard_errors
from beltrepro.model import ChainParameters
from beltrepro.observe.slips import MostStuck
from beltrepro.simulation.gathering import gathered
from beltrepro.simulation.groups import Group, Report, integrator_of, observe
from beltrepro.simulation.loading import warn_of_loading
from beltrepro.simulation.results import Results
from beltrepro.simulation.setup import Chains, check_lengths, setup_of, with_setup
from beltrepro.simulation.tables import OF_RUNS, Tabled, one_panel
from beltrepro.stats.motion import resolution

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ACROSS = OF_RUNS + "across"
# Errors of a difference that runs of one motion do not reach, nor the halves of one run.
_APART, _HALVES_APART = 6, 4
_LEAST_HALF = 16  # intervals, of which the error is known well enough
_ALIGNED = 0.2  # last share of the transient, in which the vectors turn to their directions


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectrum(Tabled):
    """Lyapunov exponents of a chain, per unit of model time.

    Attributes
    ----------
    parameters : ChainParameters
        The chain.
    exponents, standard_error : array (K,)
        Means over the runs, largest first, minus infinity for directions that a stick erases; and
        their errors by the scatter of the runs, or of the parts of a single one, 0 where erased.
    runs : array (R, K)
        Of each run: the slope of the logarithm of the growth, by least squares.
    growth : array (R, T, K)
        Rates of growth of the vectors in T intervals after the transient: finite-time exponents.
    interval : float
        Length of these intervals, model time.
    most_stuck : array (R,)
        Most blocks that were stuck at once after the transient.
    noise_clock : str
        By which noise is the same for two chains, see `lyapunov_spectrum`.
    nontrivial_exponent, nontrivial_error : float
        The largest exponent besides that of a shift of time, mean over the runs, and its error.
    """

    parameters: ChainParameters
    exponents: np.ndarray
    standard_error: np.ndarray
    runs: np.ndarray
    growth: np.ndarray
    interval: float
    most_stuck: np.ndarray
    noise_clock: str = REST
    nontrivial_exponent: float = np.nan
    nontrivial_error: float = np.nan

    def _columns(self) -> dict[str, np.ndarray]:
        return {"exponent": self.exponents, "standard_error": self.standard_error}

    @property
    def erased(self) -> int:
        """Number of exponents of the K that are minus infinity."""
        return int(np.isneginf(self.exponents).sum())

    @property
    def trivial(self) -> int | None:
        """Index of the exponent that belongs to a shift of time, and is zero.

        The one nearest to zero, if its error and e^5 in the time of observation explain how far it
        is; else None, as it is not among the K. None too with noise that is not shifted in time
        with the chain, which takes a rest of the whole chain and that clock.
        """
        finite = np.isfinite(self.exponents)
        rests = np.all(self.most_stuck == self.parameters.n_blocks)
        shifted = rests and self.noise_clock == REST
        if (self.parameters.noise > 0 and not shifted) or not finite.any():
            return None
        first = int(np.argmin(np.abs(self.exponents[finite])))
        time = self.growth.shape[1] * self.interval
        # the error of a short run is not known
        least = resolution(np.nan_to_num(self.standard_error[first]), time)
        return first if abs(self.exponents[first]) <= least else None

    @one_panel
    def plot(self, path: str | Path | None = None, *, ax: Any = None, **look: Any) -> Axes:
        """Draw the exponents in their order, with errors; at the foot those of minus infinity."""
        from beltrepro.simulation import plots

        return plots.exponents(ax, self, look)

    def __repr__(self) -> str:
        first = ", ".join(
            f"{value:.3g} ± {error:.1g}"
            for value, error in zip(self.exponents[:3], self.standard_error[:3], strict=True)
        )
        more = ", ..." if len(self.exponents) > 3 else ""
        return f"LyapunovSpectrum({self.parameters.describe()}: {first}{more})"


@with_setup
def lyapunov_spectrum(
    chains: Chains,
    *,
    duration: float,
    transient: float = 0.0,
    n_exponents: int | None = None,
    noise_clock: str = REST,
    on_error: str = "raise",
    store: str | Path | None = None,
    progress: Report | None = None,
    **setup: Any,
) -> LyapunovSpectrum | Results:
    """Lyapunov exponents: of one chain from its runs, or of each of several chains.

    Vectors follow the linearised motion through slips, sticks and reversals, and are made
    orthonormal every 20 time units (Benettin et al. 1980), oftener in chains that are lighter,
    stiffer or more viscous; their logarithmic growth is counted after the transient. With noise
    they are those of the motion under one realisation of it.

    The largest exponent besides the trivial one, of a shift of time, is measured by one more vector
    w, from which the flow f = dz/dt is taken after each interval: w' = M w - f (f.M w) / (f.f),
    with the tangent map M. As M maps the flow to the flow, deviations that count up to multiples of
    f have a tangent dynamics of their own, with all exponents but that zero. So none has to be told
    from zero to be left out. With noise by the clock "rest", f has the shift of the noise too: a
    zero is left out if the chain rests now and then, and nothing if it never does. By the clock
    "laboratory", and in steady slip, no exponent is trivial, and the largest of all is given.

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        One chain, of which several runs (`replicate=range(8), initial_spread=1`) tell the errors
        best; or P chains, which may differ in everything. Only "event" has a tangent dynamics.
    duration, transient : float
        Model time of each run, and of its first part, which is not counted. The vectors turn to
        their directions in the last fifth of that.
    n_exponents : int or None
        K, how many exponents, the largest; all 2N of the longest chain if not given.
    noise_clock : str
        When noise is the same for two chains: "rest", at the same time since the last rest of the
        whole chain, as in `event`; or "laboratory", at the same time.
    on_error, store : str, str or Path
        As in `scan`; of one chain those runs are left out that fail.
    progress, **setup : callable, keywords of `Setup`
        As in `simulate`.

    Returns
    -------
    LyapunovSpectrum or Results
        Of one chain its spectrum; of several the same by name, each from its one run: exponents and
        standard_error (P, K), NaN for those that a shorter chain lacks, nontrivial_exponent and
        nontrivial_error (P,), most_stuck (P,), the number of directions that sticks erase, growth
        (P, T, K) and interval (). NaN too of a run without any slip or stick in which not all slip.

    Raises
    ------
    InputError, ModelStateError
        A value is not allowed, the runs of one chain would not all differ, or a state left the
        range of the model.
    """
    duration, transient = check_lengths(duration, transient)
    made = setup_of(chains, setup)
    vectors.check_method(made.cases, noise_clock)
    most = 2 * max(case.parameters.n_blocks for case in made.cases)
    count = most if n_exponents is None else checks.whole_number("n_exponents", n_exponents)
    if not 1 <= count <= most:
        raise InputError(f"n_exponents = {checks.shown(count)}: allowed are 1 to 2N = {most}")
    one_chain = isinstance(made.chains, ChainParameters)
    if one_chain and len({case.identity for case in made.cases}) < len(made.cases):
        raise InputError(
            "replicate: some runs would be the same; each needs another one, and without noise an "
            "initial_spread too"
        )
    settings: dict = {"duration": duration, "transient": transient, "noise_clock": noise_clock}
    measure = partial(_growth, count=count, **settings)
    settings["n_exponents"] = "all" if n_exponents is None else count
    spectra = gathered("exponents", made, measure, progress, on_error, store, **settings)
    rests = spectra.of_runs[RESTS]
    warn_of_rests(made.cases, rests, transient)
    warn_of_loading(made.cases, np.where(rests, np.nan, np.inf), duration, transient)
    interval = (duration - transient) / spectra["growth"].shape[1]
    if not one_chain:
        spectra["interval"] = np.array(interval)
        return spectra
    well = spectra["error"] == "" if "error" in spectra else slice(None)
    names = "growth", "standard_error", "exponents", "most_stuck"
    growth, errors, runs, stuck = (spectra[name][well] for name in names)
    across, error = spectra.of_runs[_ACROSS][well], spectra["nontrivial_error"][well, None]
    parts = *_mean_of_runs(growth, errors), runs, growth, interval, stuck, noise_clock
    _warn_of_several_motions(across, error[:, 0])
    nontrivial = (mean.item() for mean in _mean_of_runs(across, error))
    return LyapunovSpectrum(made.cases[0].parameters, *parts, *nontrivial)


def _warn_of_several_motions(growth: np.ndarray, errors: np.ndarray) -> None:
    """Say where nontrivial exponents of R runs, or of the halves of one, differ beyond chance.

    growth : rates (R, T, 1) of growth; errors (R,) of their slopes.
    """
    parts, apart = "runs differ", _APART
    if len(growth) == 1:
        if (half := growth.shape[1] // 2) < _LEAST_HALF:
            return
        growth = growth[0, : 2 * half].reshape(2, half, 1)
        parts, apart = "halves of the run differ", _HALVES_APART
        errors = standard_errors(growth)[:, 0]
    exponents = slopes(growth)[:, 0]
    ends = [np.argmin(exponents), np.argmax(exponents)]
    if np.isfinite(exponents[ends]).all() and np.ptp(exponents) > apart * np.hypot(*errors[ends]):
        low, high = (f"{exponents[end]:.3g} ± {errors[end]:.1g}" for end in ends)
        warn(
            f"{parts} by more than their errors: nontrivial exponents from {low} to {high}; the "
            "means may be those of several motions together (`lyapunov_spectrum` of a Grid gives "
            "those of each run)"
        )


def _mean_of_runs(growth: np.ndarray, errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean exponents (K,) of R runs and their errors; `errors` (R, K) are those of each run."""
    runs = slopes(growth)
    erased = np.isneginf(runs).any(axis=0)  # by one run is enough
    finite, error = np.where(erased, 0.0, runs), errors[0]
    if len(runs) > 1:
        scatter = finite.std(axis=0, ddof=1) / np.sqrt(len(runs))
        error = np.hypot(scatter, end_errors(growth).mean(axis=0))
    return np.where(erased, -np.inf, finite.mean(axis=0)), np.where(erased, 0.0, error)


def _growth(
    group: Group, *, duration: float, transient: float, noise_clock: str, count: int
) -> dict[str, np.ndarray]:
    members, report = group.cases, group.report
    size = min(count, 2 * group.chain.n_blocks)
    before = integrator_of(members, sampling=vectors.NO_SAMPLES)
    alone = (1 - _ALIGNED) * transient
    if transient > 0:
        observe(before, alone, [], vectors.part(report, 0, alone / duration))
    how: dict = {"noise_clock": noise_clock, "across": True}
    chains = vectors.with_vectors(before.state(), members[0], size, **how)
    if transient > 0:
        grow(chains, transient - alone, [], lambda done: None, across=True)
    stuck = MostStuck(np.array([np.sum(state.directions == 0) for state in chains.state()]))
    report = vectors.part(report, transient / duration, 1)
    growth = grow(chains, duration - transient, [stuck], report, across=True)
    erased = np.arange(size) >= 2 * chains.n_blocks - stuck.most[:, None]
    erased = np.column_stack([erased, vectors.none_across(chains, stuck.most)])
    growth = np.where(erased[:, None], -np.inf, growth)
    rests = (stuck.events == 0) & (stuck.most > 0)
    growth[rests] = np.nan
    growth, across = map(np.ascontiguousarray, np.split(growth, [size], axis=2))
    order = np.argsort(-slopes(growth), axis=1, kind="stable")  # NaN last
    growth = np.take_along_axis(growth, order[:, None], axis=2)
    shared = len(growth), vectors.intervals_in(duration - transient), -1  # by chains of all units
    return {
        "most_stuck": stuck.most,
        "growth": growth.reshape(*shared, size).mean(axis=2),
        "exponents": slopes(growth),
        "standard_error": standard_errors(growth),
        "nontrivial_exponent": slopes(across)[:, 0],
        "nontrivial_error": standard_errors(across)[:, 0],
        _ACROSS: across.reshape(*shared, 1).mean(axis=2),
        RESTS: rests,
    }
