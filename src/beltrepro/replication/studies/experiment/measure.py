"""Numbers on the noise of the experiment: what trials of its length show."""

import numpy as np
import pandas as pd

from beltrepro.model import units
from beltrepro.replication.plan.registry import Table, tables
from beltrepro.replication.studies.experiment import observations
from beltrepro.replication.studies.experiment.observations import EXPERIMENT
from beltrepro.stats.estimates import share

TABLES = {
    "alternation": Table(uses=("trials_free",)),
    "experiment_odds": Table(uses=("trials", "trials_short")),
}

_POINT = ["noise", "friction_ratio", "belt_velocity"]


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
