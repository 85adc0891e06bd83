"""experiment_odds.csv: how probable it is that a trial shows what a recording of the paper does."""

import numpy as np
import pandas as pd

from beltrepro.model import units
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.experiment import trials
from beltrepro.stats.shares import share

TABLE = Table(
    title="How probable it is, by noise, that a trial shows what a recording of the paper shows.",
    uses=("trials", "trials_short"),
    columns={
        "dataset": "of the trials: trials or trials_short",
        "speed_m_s": "speed of the belt of the recording (m/s)",
        "recorded_s": "length of a trial after the transient (s)",
        "noise": "of the trials; empty for those at all noises",
        "runs": "trials",
        "r_recorded": "r that the paper prints of the recording",
        "r": "median r of the trials",
        "r_lower": "r of the trials, 2.5 %",
        "r_upper": "r of the trials, 97.5 %",
        "r_least": "smallest r of a trial",
        "lasting_share": "mean share of the time in small amplitudes that last",
        "lasting_longest_s": "longest small amplitude in any trial (s)",
        "all_slip_longest_s": "longest time in any trial in which no block sticks (s)",
        "below": "share of the trials with r at or below the recorded one",
        "below_lower": "lower end of its interval (Clopper and Pearson, 95 %)",
        "below_upper": "upper end",
        "alternates": "share of the trials with both regimes, each for 15.3 s or more",
        "alternates_lower": "lower end of its interval",
        "alternates_upper": "upper end",
        "shows": "share of the trials that show both regimes for as long as the recording does",
        "shows_lower": "lower end of its interval",
        "shows_upper": "upper end",
        "agrees": "share of those that show them and whose r is within 10 % of the recorded one",
        "agrees_lower": "lower end of its interval",
        "agrees_upper": "upper end",
        "both": "share of the trials with r at or below the recorded one that show the regimes too",
        "both_lower": "lower end of its interval",
        "both_upper": "upper end",
    },
)


def derive(data) -> pd.DataFrame:
    """A row for each dataset, recording and noise, and one for all noises together."""
    rows = []
    for name in TABLE.uses:
        arrays, attributes = data[name].arrays, data[name].attributes
        length = units.to_si(attributes["duration"] - attributes["transient"], "time")
        for observation in trials.EXPERIMENT:
            here = trials.at_speed(observation, arrays)
            for noise in (*np.unique(arrays["noise"][here]), np.nan):
                chosen = here if np.isnan(noise) else here & (arrays["noise"] == noise)
                own = {key: values[chosen] for key, values in arrays.items()}
                place = {"dataset": name, "speed_m_s": observation.speed_m_s}
                place |= {"recorded_s": length, "noise": noise}
                rows.append(place | _row(observation, own))
    return pd.DataFrame(rows, columns=list(TABLE.columns))


def _row(observation, own) -> dict:
    """What the trials of one recording at one noise say together."""
    disorder = own["disorder_parameter"]
    below = disorder <= observation.disorder_parameter
    shown = trials.shows(observation, own)
    found = {
        "below": below,
        "alternates": trials.alternates(own),
        "shows": shown,
        "agrees": trials.agrees(observation, own),
        "both": below & shown,
    }
    lower, median, upper = np.quantile(disorder, [0.025, 0.5, 0.975])
    row = {
        "runs": disorder.size,
        "r_recorded": observation.disorder_parameter,
        "r": median,
        "r_lower": lower,
        "r_upper": upper,
        "r_least": disorder.min(),
        "lasting_share": own["lasting_share"].mean(),
        "lasting_longest_s": units.to_si(own["lasting_longest"].max(), "time"),
        "all_slip_longest_s": units.to_si(own["all_slip_longest"].max(), "time"),
    }
    for name, having in found.items():
        row[name], row[f"{name}_lower"], row[f"{name}_upper"] = share(having.sum(), having.size)
    return row
