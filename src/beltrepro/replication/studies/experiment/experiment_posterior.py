"""experiment_posterior.csv: noise, friction ratio and belt speed that agree with the recordings."""

from typing import Any

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.experiment import inference, trials
from beltrepro.stats.errors import NotEnoughDataError

TABLE = Table(
    title="Which noise, friction ratio and factor on the belt speed agree with both recordings.",
    uses=("trials_free",),
    columns={
        "free": "which parameters are not known; the others have their printed values",
        "tolerance": "largest distance of ln r at which a trial agrees",
        "combinations": "combinations of levels of the free parameters, equally probable before",
        "runs": "trials of each recording in a combination",
        "agreed_022": "trials that agree with the recording at 0.22 m/s",
        "agreed_028": "trials that agree with the recording at 0.28 m/s",
        "evidence": "probability, before, that trials agree with both recordings",
        "held_out": "the same under the posterior, by trials that did not make it",
        "sigma_1_to_2": "posterior of a noise from 1 to 2",
        "sigma_1_to_2_before": "the same before the trials",
        "best_noise": "most probable noise, whatever the others; empty if under 20 trials agree",
        "noise_levels": "credible set of the noise, 90 %",
        "noise_coverage": "share of made-up experiments whose true noise lies in the set",
        "noise_uniform_p": "p-value of the test that posteriors of them are uniform",
        "best_friction_ratio": "as of the noise",
        "friction_ratio_levels": "as of the noise",
        "friction_ratio_coverage": "as of the noise",
        "friction_ratio_uniform_p": "as of the noise",
        "best_speed_factor": "as of the noise",
        "speed_factor_levels": "as of the noise",
        "speed_factor_coverage": "as of the noise",
        "speed_factor_uniform_p": "as of the noise",
        "made_up": "made-up experiments",
        "unanswered": "further ones with which no trial agreed",
        "r_022": "r at 0.22 m/s under the posterior, median",
        "r_022_lower": "5 %",
        "r_022_upper": "95 %",
        "r_028": "r at 0.28 m/s under the posterior, median",
        "r_028_lower": "5 %",
        "r_028_upper": "95 %",
    },
)

TOLERANCES = (trials.TOLERANCE, trials.TOLERANCE / 2, 2 * trials.TOLERANCE)
PRINTED = {"friction_ratio": trials.FRICTION_RATIO, "speed_factor": 1.0}
FREE = (("noise",), ("noise", "friction_ratio"), ("noise", "speed_factor"), ("noise", *PRINTED))


def derive(data) -> pd.DataFrame:
    """A row for each choice of free parameters and each tolerance."""
    simulated = trials.on_grid(data["trials_free"].arrays)
    rows = []
    for free in FREE:
        own = _fixed(simulated, free)
        rows += [_row(own, free, tolerance) for tolerance in TOLERANCES]
    return pd.DataFrame(rows, columns=list(TABLE.columns))


def _fixed(simulated, free):
    for name, value in PRINTED.items():
        if name not in free:
            simulated = simulated.fixed(name, value)
    return simulated


def _row(simulated, free, tolerance) -> dict:
    agreed = inference.agreement(simulated, trials.RECORDED, tolerance)
    row: dict[str, Any] = {
        "free": ", ".join(free),
        "tolerance": tolerance,
        "combinations": agreed[0, ..., 0].size,
        "runs": simulated.runs,
        "agreed_022": int(agreed[0].sum()),
        "agreed_028": int(agreed[1].sum()),
        "evidence": 0.0,
    }
    try:
        found = inference.posterior(simulated, trials.RECORDED, tolerance)
    except NotEnoughDataError:
        return row
    row |= {"evidence": found.evidence}
    row |= {"held_out": inference.held_out(simulated, trials.RECORDED, tolerance)}
    if min(found.agreed) < trials.MINIMUM_AGREED:
        return row  # sets of so few trials would promise too much
    row |= _noise(found)
    for name in free:
        row |= _levels(found, name)
    if tolerance == trials.TOLERANCE:
        row |= _calibration(simulated, free, tolerance)
    return row | _predicted(found, simulated)


def _noise(found) -> dict:
    """Posterior of the noise that the paper assigns to the experiment."""
    inside = trials.assigned(found.levels["noise"])
    posterior = found.marginal("noise")[inside].sum()
    return {"sigma_1_to_2": posterior, "sigma_1_to_2_before": inside.mean()}


def _levels(found, name) -> dict:
    """The most probable level, and the levels of the credible set."""
    levels, chosen = found.levels[name], found.credible(name)
    return {
        f"best_{name}": levels[np.argmax(found.marginal(name))],
        f"{name}_levels": "; ".join(f"{level:.3g}" for level in levels[chosen]),
    }


def _calibration(simulated, free, tolerance) -> dict:
    """How posteriors do on trials with known parameters."""
    try:
        done = inference.calibrate(simulated, tolerance, shown=trials.RECORDED.shown)
    except NotEnoughDataError:
        return {}
    row: dict[str, float] = {"made_up": done.experiments, "unanswered": done.unanswered}
    for name in free:
        row[f"{name}_coverage"] = done.coverage[name].value
        row[f"{name}_uniform_p"] = done.uniform_p[name]
    return row


def _predicted(found, simulated) -> dict:
    """r of both recordings under the posterior."""
    row: dict[str, float] = {}
    for name, values in zip(("r_022", "r_028"), np.exp(simulated.summary), strict=True):
        lower, median, upper = inference.predicted(found, values, (0.05, 0.5, 0.95))
        row |= {name: median, f"{name}_lower": lower, f"{name}_upper": upper}
    return row
