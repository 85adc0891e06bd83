"""Which picture shows why a claim came out as it did."""

from beltrepro.replication.report.findings import Result

# Claims that another picture than the figure of their number shows best.
SHOWN_BY = {
    "scheme-order": "agreement_trajectories",
    "u15-aperiodic": "survival",
    "permanent-chaos": "motion_map",
    "no-permanent-chaos": "motion_map",
    "bifurcation-sigma0": "motion_map",
    "transient-lifetime": "survival",
    "u7-transient-chaos": "survival",
    "small-n-regular": "motion_map",
    "chaos-from-n5": "motion_map",
    "complexity-at-n5": "motion_map",
    "experiment-022": "experiment_noise",
    "r-experiment": "experiment_noise",
    "intermittency-experiment": "experiment_noise",
    "sigma-experiment": "experiment_noise",
    "u-critical": "critical_velocity",
    "uc-of-sigma": "critical_velocity",
    "uc-sigma22": "critical_velocity",
    "transition-width": "critical_velocity",
    "sharpest-at-n5": "critical_velocity",
    "soc-cutoff": "avalanches",
    "method-independence": "agreement_disorder",
}


def diagnostic(result: Result, pictures: list[dict]) -> dict | None:
    """The picture that shows a claim best."""
    by_name = {each["name"]: each for each in pictures}
    if SHOWN_BY.get(result.id) in by_name:
        return by_name[SHOWN_BY[result.id]]
    for each in pictures:
        if each["number"] and each["number"] == str(result.claim.figure):
            return each
    used = set(result.dataset.split(", "))
    shared = [(len(used & set(each["uses"])), -len(each["uses"])) for each in pictures]
    best = max(range(len(pictures)), key=shared.__getitem__, default=None)
    return pictures[best] if best is not None and shared[best][0] else None
