"""Numbers on the laws of force and friction in sampled runs, and on the order of the scheme."""

from functools import partial

import numpy as np
import scipy

from beltrepro.base.errors import require
from beltrepro.model import ChainParameters, spring
from beltrepro.stats.estimates import Estimate, bootstrap, mean, ratio

STRETCHES = 20  # of a series, which count as independent
_STUCK = 1e-9


def friction_numbers(series, chain: ChainParameters) -> tuple[dict[str, Estimate], int]:
    """Statistics of the friction force on stuck and on slipping blocks, and samples in slip."""
    friction = series.arrays["friction"]
    relative = series.arrays["velocities"] - series.attributes["belt_velocity"]
    external = spring.external_force(series.arrays["positions"], chain)
    stuck = np.abs(relative) <= _STUCK
    inner = stuck[:-1] & stuck[1:]
    balance = np.abs(friction + external)[:-1][inner] / chain.static_friction
    slipping = ~stuck[:-1] & ~stuck[1:] & (np.sign(relative[:-1]) == np.sign(relative[1:]))
    require(slipping.sum() >= 1000 and inner.sum() >= 1000, "too few samples of stick and of slip")
    kinetic, following = np.abs(friction[:-1][slipping]), np.abs(friction[1:][slipping])
    events = series.arrays["events"]
    before = np.abs(events["force"][events["kind"] == "slip"])
    require(before.size >= 2, f"{before.size} slips, not 2")
    target = chain.friction_ratio * chain.static_friction
    spread = chain.friction_ratio * series.attributes["noise"]
    return {
        "stuck: |F_f + F_ex| / F_st0": over_stretches(partial(np.quantile, q=0.99), balance),
        "slip: mean / (f_s F_st0)": over_stretches(np.mean, kinetic / target),
        "slip: spread / (f_s sigma)": over_stretches(np.std, kinetic / spread),
        "slip: correlation of steps": over_stretches(_correlation, kinetic, following),
        "friction in slip / before": ratio(over_stretches(np.mean, kinetic), mean(before)),
    }, kinetic.size


def over_stretches(statistic, *samples: np.ndarray) -> Estimate:
    """Mean of a statistic of some samples side by side over the stretches of a series."""
    parts = zip(*(np.array_split(sample, STRETCHES) for sample in samples), strict=True)
    return mean([statistic(*part) for part in parts])


def _correlation(one, other):
    return np.corrcoef(one, other)[0, 1] if one.std() > 0 else 1.0


# --- order of the scheme --------------------------------------------------------------------------

_ROUNDING = 1e-9  # errors below come from rounding, not from the step


def errors_of_runs(tested, reference, n_blocks, belt_velocity, after_events):
    """Time steps (S,), and errors (R, S) of runs from the same starts as those of the reference."""
    finest = _at(reference, n_blocks, belt_velocity)
    finest &= reference["time_step"] == reference["time_step"].min()
    true_rows = dict(zip(reference["replicate"][finest], np.flatnonzero(finest), strict=True))
    at = _at(tested, n_blocks, belt_velocity)
    require(at.any(), f"no paths with N = {n_blocks}, u = {belt_velocity:g}")
    steps = np.unique(tested["time_step"][at])
    errors = np.full((len(true_rows), steps.size), np.nan)
    for number, (replicate, true_row) in enumerate(true_rows.items()):
        for row in np.flatnonzero(at & (tested["replicate"] == replicate)):
            error = _error_after(after_events, tested, row, reference, true_row)
            errors[number, steps == tested["time_step"][row]] = error
    errors = errors[np.isfinite(errors).all(axis=1)]
    require(len(errors) >= 4, f"{len(errors)} starts with so many events, 4 are needed")
    return steps, errors


def _at(runs, n_blocks, belt_velocity):
    return (runs["n_blocks"] == n_blocks) & np.isclose(runs["belt_velocity"], belt_velocity)


def _error_after(n_events, tested, row, reference, true_row) -> float:
    """Largest distance of any block, at the first sample after so many events of the reference."""
    events = reference["events"]
    instants = np.sort(events["time"][events["point"] == true_row])[n_events - 1 : n_events]
    sample = np.searchsorted(reference["time"], instants, side="right")
    if not sample.size or sample[0] == reference["time"].size:
        return np.nan
    distance = tested["positions"][row, sample[0]] - reference["positions"][true_row, sample[0]]
    return float(np.abs(distance)[: tested["n_blocks"][row]].max())


def root_mean_square(errors: np.ndarray) -> np.ndarray:
    """Over the first axis: the starts. One alone tells little, as the phase of an event counts."""
    return np.sqrt(np.mean(errors**2, axis=0))


def order_of_runs(steps: np.ndarray, errors: np.ndarray) -> Estimate:
    """Order in the step of the root mean square over starts, which are drawn anew."""
    return bootstrap(lambda drawn: _order(steps, root_mean_square(drawn)), [errors])


def _order(steps, errors) -> float:
    """Order q of error = c * step**q, from a straight line through the logarithms."""
    steps, errors = np.asarray(steps), np.asarray(errors)
    above = errors > _ROUNDING
    if above.sum() < 3:
        return np.nan
    return float(scipy.stats.linregress(np.log(steps[above]), np.log(errors[above])).slope)


def order_of_formula(*, in_one_step: bool) -> float:
    """x(t+dt) = 2x(t) - x(t-dt) + a(t) dt^2 for x'' = -x, of which cos t is a solution."""
    steps = 2.0 ** -np.arange(4, 9)
    errors = []
    for step in steps:
        before, now = np.cos(1 - step), np.cos(1.0)
        count = 1 if in_one_step else round(1 / step)
        for _ in range(count):
            before, now = now, 2 * now - before - now * step**2
        error = abs(now - np.cos(1 + count * step))
        errors.append(error / step if in_one_step else error)
    return _order(steps, errors)
