"""Numbers on the noise of the experiment: what trials of its length show, and what that implies."""

from contextlib import suppress
from typing import Any

import numpy as np
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.model import units
from beltrepro.replication.plan.registry import Table, tables
from beltrepro.replication.studies.experiment import inference, observations
from beltrepro.replication.studies.experiment.observations import EXPERIMENT, RECORDED, TOLERANCE
from beltrepro.stats import estimates
from beltrepro.stats.estimates import Estimate, share

TABLES = {
    "alternation": Table(uses=("trials_free",)),
    "experiment_odds": Table(uses=("trials", "trials_short")),
    "experiment_posterior": Table(uses=("trials_free",)),
}

QUIET_WITHIN = 0.1  # how well films would tell their share of the time in small amplitudes
TOLERANCES = (TOLERANCE, TOLERANCE / 2, 2 * TOLERANCE)
PRINTED = {"friction_ratio": observations.FRICTION_RATIO, "speed_factor": 1.0}
FREE = (("noise",), ("noise", "friction_ratio"), ("noise", "speed_factor"), ("noise", *PRINTED))

_POINT = ["noise", "friction_ratio", "belt_velocity"]


# --- trials ---------------------------------------------------------------------------------------


def alternation(data) -> pd.DataFrame:
    """A row for each noise, friction ratio and belt velocity."""
    arrays = data["trials_free"].arrays
    names = (*_POINT, "lasting_share", "disorder_parameter")
    runs = pd.DataFrame({name: arrays[name] for name in names})
    runs["alternates"] = observations.alternates(arrays)
    runs["slip_s"] = units.to_si(arrays["all_slip_longest"], "time")
    runs["slips"] = runs["slip_s"] >= EXPERIMENT[0].lasting_s
    grouped = runs.groupby(_POINT)
    table = pd.DataFrame({"runs": grouped.size(), "alternating": grouped["alternates"].sum()})
    shares = [share(*counts).numbers for counts in table[["alternating", "runs"]].to_numpy()]
    table[["share", "share_lower", "share_upper"]] = np.reshape(shares, (-1, 3))
    others = grouped.agg(
        lasting_share=("lasting_share", "mean"),
        all_slip_longest_s=("slip_s", "max"),
        all_slip=("slips", "sum"),
        r=("disorder_parameter", "median"),
    )
    return table.join(others).reset_index()


def experiment_odds(data) -> pd.DataFrame:
    """A row for each dataset, recording and noise, and one for all noises together."""
    rows = []
    for name in TABLES["experiment_odds"].uses:
        arrays, attributes = data[name].arrays, data[name].attributes
        length = units.to_si(attributes["duration"] - attributes["transient"], "time")
        for observation in EXPERIMENT:
            here = observations.at_speed(observation, arrays)
            for noise in (*np.unique(arrays["noise"][here]), np.nan):
                chosen = here if np.isnan(noise) else here & (arrays["noise"] == noise)
                trials = {key: values[chosen] for key, values in arrays.items()}
                place = {"dataset": name, "speed_m_s": observation.speed_m_s}
                place |= {"recorded_s": length, "noise": noise}
                rows.append(place | _odds(observation, trials))
    return pd.DataFrame(rows, columns=list(tables()["experiment_odds"].columns))


def _odds(observation, trials) -> dict:
    """What the trials of one recording at one noise say together."""
    disorder = observations.disorder_along_tape(trials)
    below = disorder <= observation.disorder_parameter
    shown = observations.shows(observation, trials)
    lower, median, upper = np.quantile(disorder, [0.025, 0.5, 0.975])
    row = {
        "runs": disorder.size,
        "r_recorded": observation.disorder_parameter,
        "r": median,
        "r_lower": lower,
        "r_upper": upper,
        "r_least": disorder.min(),
        "lasting_share": trials["lasting_share"].mean(),
        "lasting_longest_s": units.to_si(trials["lasting_longest"].max(), "time"),
        "all_slip_longest_s": units.to_si(trials["all_slip_longest"].max(), "time"),
    }
    for name, having in {
        "below": below,
        "alternates": observations.alternates(trials),
        "shows": shown,
        "agrees": observations.agrees(observation, trials),
        "both": below & shown,
    }.items():
        ends = (name, f"{name}_lower", f"{name}_upper")
        row |= zip(ends, share(having.sum(), having.size).numbers, strict=True)
    return row


# --- posteriors -----------------------------------------------------------------------------------


def experiment_posterior(data) -> pd.DataFrame:
    """A row for each choice of free parameters and each tolerance."""
    simulated = observations.on_grid(data["trials_free"].arrays)
    rows = [
        _posterior_row(fixed_but(simulated, free), free, tolerance)
        for free in FREE
        for tolerance in TOLERANCES
    ]
    return pd.DataFrame(rows, columns=list(tables()["experiment_posterior"].columns))


def fixed_but(simulated: inference.Simulated, free) -> inference.Simulated:
    """The trials with the printed values of all parameters that are not free."""
    for name, value in PRINTED.items():
        if name not in free:
            simulated = simulated.fixed(name, value)
    return simulated


def posterior(simulated: inference.Simulated, tolerance: float = TOLERANCE) -> inference.Posterior:
    """The posterior given both recordings, if enough trials agree with each."""
    answer = inference.posterior(simulated, RECORDED, tolerance)
    fewest = min(answer.agreed)
    require(
        fewest >= observations.MINIMUM_AGREED,
        f"{fewest} trials agree with a recording, {observations.MINIMUM_AGREED} are needed",
    )
    return answer


def assigned_share(levels: np.ndarray, probability: np.ndarray | None = None) -> float:
    """Probability of the noise that the paper assigns to the experiment; without one, beforehand.

    A level stands for the noises half way, in ratio, around it.
    """
    ends = observations.ASSIGNED
    if probability is None:
        probability = np.full(levels.size, 1 / levels.size)
    if levels.size == 1:
        return float(ends[0] <= levels[0] <= ends[1])
    place = np.log(levels)
    middle = (place[1:] + place[:-1]) / 2
    edges = np.concatenate([[2 * place[0] - middle[0]], middle, [2 * place[-1] - middle[-1]]])
    below = np.interp(np.log(ends), edges, np.concatenate([[0.0], np.cumsum(probability)]))
    return float(below[1] - below[0])


def posterior_of_assigned(simulated: inference.Simulated, answer: inference.Posterior) -> Estimate:
    """`assigned_share` with its interval; the trials of each combination are drawn anew."""
    levels, rng = answer.levels["noise"], np.random.default_rng(0)
    resampled = np.full(estimates.RESAMPLES, np.nan)
    for number in range(resampled.size):
        with suppress(NotEnoughDataError):
            drawn = inference.posterior(simulated.drawn_anew(rng), RECORDED, TOLERANCE)
            resampled[number] = assigned_share(levels, drawn.marginal("noise"))
    share_of_all = assigned_share(levels, answer.marginal("noise"))
    return estimates.from_resamples(share_of_all, resampled, min(answer.agreed))


def fitted(answer: inference.Posterior, name: str) -> Estimate:
    """Median of a parameter under the posterior, and the range of 95 % of it."""
    levels, weights = answer.levels[name], answer.marginal(name)
    ends = (0.5, 0.025, 0.975)
    value, low, high = np.quantile(levels, ends, weights=weights, method="inverted_cdf")
    return Estimate(float(value), float(low), float(high), min(answer.agreed))


def _posterior_row(simulated, free, tolerance) -> dict:
    agreed = simulated.agreeing(RECORDED, tolerance)
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
        answer = inference.posterior(simulated, RECORDED, tolerance)
    except NotEnoughDataError:
        return row
    row["evidence"] = answer.evidence
    row["held_out"] = inference.held_out(simulated, RECORDED, tolerance)
    if min(answer.agreed) < observations.MINIMUM_AGREED:
        return row  # sets of so few trials would promise too much
    noises = answer.levels["noise"]
    row["sigma_1_to_2"] = assigned_share(noises, answer.marginal("noise"))
    row["sigma_1_to_2_before"] = assigned_share(noises)
    for name in free:
        levels, marginal = answer.levels[name], answer.marginal(name)
        chosen = inference.credible_set(marginal)
        row[f"best_{name}"] = levels[np.argmax(marginal)]
        row[f"{name}_levels"] = "; ".join(f"{level:.3g}" for level in levels[chosen])
    if tolerance == TOLERANCE:  # how posteriors do on trials with known parameters
        with suppress(NotEnoughDataError):
            done = inference.calibrate(simulated, tolerance)
            row |= {"made_up": done.experiments, "unanswered": done.unanswered}
            for name in free:
                row[f"{name}_coverage"] = done.coverage[name].value
                row[f"{name}_uniform_p"] = done.uniform_p[name]
                row[f"{name}_in_set"] = done.levels[name]
            quiet = inference.calibrate(simulated, tolerance, quiet_within=QUIET_WITHIN)
            row |= {f"{name}_in_set_quiet": quiet.levels[name] for name in free}
    for name, values in zip(("r_022", "r_028"), np.exp(simulated.summary), strict=True):
        lower, median, upper = inference.predicted(answer, values, (0.05, 0.5, 0.95))
        row |= {name: median, f"{name}_lower": lower, f"{name}_upper": upper}
    return row
