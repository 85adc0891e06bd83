"""What the report says of the two integrators, from the tables of a run."""

import numpy as np
import pandas as pd

from beltrepro.replication.studies.integrators import divergence, measure, samples

PARTS = {
    "trajectories": "Trajectories without noise",
    "disorder": "With noise",
    "slips": "Slips and section points",
    "attractors": "Attractors and lifetimes without noise",
}
DATASETS = {
    "trajectories": "pairs_paths_verlet",
    "disorder": "pairs_r_verlet",
    "slips": "pairs_slips_verlet",
    "attractors": "pairs_states_verlet",
}
"""Dataset of the tested integrator in each part, whose lengths the other one shares."""
TOLD_BY = ("agreement", "families", "partings", "convergence")
STEPS = {"time_step": "dt", "tolerance": "its mean step"}
SHOWN = (measure.DISORDER, measure.STILL_STICKING, measure.FINAL_DISORDER)


def describe(tables: dict[str, pd.DataFrame], settings: dict) -> dict:
    """What the template needs: rows of tables, and sentences on what no row can tell."""
    comparisons, families, partings, convergence = (tables[name] for name in TOLD_BY)
    methods = {role: comparisons[role].iloc[0] for role in ("tested", "reference")}
    base = settings["defaults"]["time_step"]
    final = comparisons["quantity"] == measure.FINAL_DISORDER
    sentences = {
        "trajectories": _on_trajectories(partings, convergence, methods, base),
        "attractors": [
            _conclusion(comparisons[final & np.isclose(comparisons["time_step"], base)])
        ],
    }
    shown = comparisons[comparisons["quantity"].isin(SHOWN)]
    return {
        "methods": methods,
        "level": samples.LEVEL,
        "parts": [
            {
                "title": title,
                "lengths": _lengths(settings["datasets"][DATASETS[part]]),
                "sentences": sentences.get(part, []),
            }
            for part, title in PARTS.items()
        ],
        "families": [_family(row) for row in families.to_dict("records")],
        "partings": [_parting(row) for row in partings.to_dict("records")],
        "comparisons": [_comparison(row) for row in shown.to_dict("records")],
    }


# --- sentences ------------------------------------------------------------------------------------


def _on_trajectories(partings, convergence, methods, base) -> list[str]:
    tested, reference = methods["tested"], methods["reference"]
    sentences = []
    # with one method on both sides the reference is the one with the base step
    ours = partings[(partings["method"] == tested) & np.isclose(partings["time_step"], base)]
    if len(ours):
        times = ours["parting_time"]
        sentences.append(
            f"From the same states, {tested} at dt = {base:g} and {reference} are more than "
            f"{divergence.PARTED:g} apart within the run at {np.isfinite(times).sum()} of "
            f"{len(ours)} points, from t = {times.min():g} on (median of "
            f"{int(ours['members'].min())} runs a point)."
        )
    # before the first event there is only rounding, and after many of them the errors are large
    early = convergence[convergence["order"].notna() & (convergence["after_events"] > 0)]
    short = (early["varied"] == "tolerance") | (early["after_events"] <= 5)
    for (varied, method), fits in early[short].groupby(["varied", "method"]):
        for velocity, at_velocity in fits.groupby("belt_velocity"):
            orders = at_velocity.drop_duplicates(["n_blocks", "after_events"])["order"]
            events = at_velocity["after_events"]
            sentences.append(
                f"At u = {velocity:g} the error of {method} after {events.min()} to "
                f"{events.max()} events falls as {STEPS[varied]} to the power "
                f"{orders.mean():.2f} ({orders.min():.2f} to {orders.max():.2f} in {orders.size} "
                "fits)."
            )
    return sentences


def _conclusion(rows) -> str:
    """The last sentence of the Appendix, judged for motion without noise."""
    if rows.empty:
        return "Whether the numerical method matters without noise is not measured."
    differ = rows[rows["verdict"] == samples.DIFFER]
    if differ.empty:
        return (
            "So no point without noise shows a significant difference of 1 % or more: in "
            "samples of this size nothing speaks against the last sentence of the Appendix, that "
            "the numerical method matters little."
        )
    wide = (differ["initial_spread"] == rows["initial_spread"].max()).any()
    where = (
        "also from the most distant states"
        if wide
        else "but not, within the resolution of these samples, from the most distant states"
    )
    return (
        f"So without noise the last sentence of the Appendix, that the numerical method matters "
        f"little, does not hold at {len(differ)} of {len(rows)} points: r at the end depends on "
        f"the integrator, {where}."
    )


# --- rows -----------------------------------------------------------------------------------------


def _family(row) -> dict:
    share = (
        f"{100 * row['shift']:+.2f} ± {100 * row['shift_error']:.2f} %"
        if np.isfinite(row["shift"])
        else ""
    )
    return {
        "part": PARTS[row["part"]],
        "quantity": row["quantity"],
        "conditions": _conditions(row),
        "runs": row["runs"],
        "verdicts": [(name, int(row[name])) for name in samples.VERDICTS if row[name]],
        "test": row["test"],
        "smallest_p": _p(row["smallest_p"]),
        "chi2": f"{row['chi2']:.1f} ({row['degrees']})" if row["degrees"] else "",
        "chi2_p": _p(row["chi2_p"]),
        "uniform_p": _p(row["uniform_p"]),
        "shift": share,
    }


def _parting(row) -> dict:
    apart = row["parting_time"]
    return row | {"parting_time": f"{apart:g}" if np.isfinite(apart) else "not"}


def _comparison(row) -> dict:
    return {
        "quantity": row["quantity"],
        "n_blocks": row["n_blocks"],
        "belt_velocity": f"{row['belt_velocity']:g}",
        "noise": f"{row['noise']:g}",
        "conditions": _conditions(row),
        "runs": f"{row['n_tested']}, {row['n_reference']}",
        "tested": f"{row['mean_tested']:.4g} ± {row['error_tested']:.1g}",
        "reference": f"{row['mean_reference']:.4g} ± {row['error_reference']:.1g}",
        "z": f"{row['z']:+.1f}" if np.isfinite(row["z"]) else "",
        "p": _p(row["p"]),
        "corrected_p": _p(row["corrected_p"]),
        "distance": f"{100 * row['distance']:.1f} %" if np.isfinite(row["distance"]) else "",
        "verdict": row["verdict"],
    }


def _conditions(row) -> str:
    words = []
    if np.isfinite(row["time_step"]):
        words.append(f"dt = {row['time_step']:g}")
    if np.isfinite(row["initial_spread"]):
        words.append(f"initial spread {row['initial_spread']:g}")
    return ", ".join(words)


def _lengths(part) -> str:
    words = [f"t = {part['duration']:g}"]
    if part.get("transient"):
        words.append(f"of which {part['transient']:g} discarded")
    if "settle_time" in part:
        words.append(f"the last {part['settle_time']:g} for the state reached")
    runs = len(part["replicate"])
    return ", ".join([*words, f"{runs} runs at each point by each integrator"])


def _p(value) -> str:
    if not np.isfinite(value):
        return ""
    return "< 1e-12" if value < 1e-12 else f"{value:.2g}"
