"""What the report says of the two integrators: sentences and rows from the tables of a run."""

import numpy as np
import pandas as pd

from beltrepro.replication.studies.integrators import divergence, measure, samples, steps

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
SHOWN = (measure.DISORDER, measure.STILL_STICKING, measure.FINAL_DISORDER)


def describe(tables: dict[str, pd.DataFrame], settings: dict) -> dict:
    """What the template needs: sentences by heading, rows of tables."""
    comparisons, families, partings, convergence = (tables[name] for name in TOLD_BY)
    methods = {role: comparisons[role].iloc[0] for role in ("tested", "reference")}
    base = settings["defaults"]["time_step"]
    sentences = {
        "trajectories": _on_trajectories(partings, convergence, methods, base),
        "disorder": [_on_family(row) for row in _records(families, "disorder")],
        "slips": [_on_family(row) for row in _records(families, "slips")],
        "attractors": [
            *(
                _on_family(row)
                for row in _records(families, "attractors")
                if row["quantity"] != measure.FINAL_DISORDER and np.isclose(row["time_step"], base)
            ),
            *_on_attractors(comparisons, methods, base),
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
                "sentences": sentences[part],
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
    # with one method on both sides the reference is the one with the base step
    ours = partings[(partings["method"] == tested) & np.isclose(partings["time_step"], base)]
    sentences = []
    if len(ours):
        apart = ours[np.isfinite(ours["parting_time"])]
        together = ours[~np.isfinite(ours["parting_time"])]
        parts = [
            f"{_point(row)} at t = {row['parting_time']:g}" for row in apart.to_dict("records")
        ]
        parts = "; ".join(parts) or "at none of the points"
        whole = ", ".join(_point(row) for row in together.to_dict("records")) or "none"
        sentences.append(
            f"From the same states, {tested} at dt = {base:g} and {reference} are more than "
            f"{divergence.PARTED:g} apart (median of {int(ours['members'].min())} runs a point): "
            f"{parts}; not within the run: {whole}. The first {divergence.FIRST_EVENTS} events "
            f"that both have differ by at most {ours['first_shift'].max():.2g} in time (median "
            "over the runs, largest of the points)."
        )
    by_step = convergence[convergence["varied"] == "time_step"]
    early = by_step[by_step["after_events"].between(1, 5) & by_step["order"].notna()]
    for method, rows in early.groupby("method"):
        orders = rows.drop_duplicates(["n_blocks", "belt_velocity", "after_events"])["order"]
        taken = np.sort(rows["time_step"].unique())
        sentences.append(
            f"The error of {method} after 1 to 5 events falls as dt to the power "
            f"{orders.mean():.2f} ± {orders.std(ddof=1) / np.sqrt(orders.size):.2f} (mean and "
            f"standard error over {orders.size} fits, from {orders.min():.2f} to "
            f"{orders.max():.2f}; {taken.size} steps from {taken[0]:g} to {taken[-1]:g})."
        )
    sentences += _on_tolerances(convergence[convergence["varied"] == "tolerance"])
    before = convergence[convergence["after_events"] == 0]
    if len(before):
        sentences.append(f"Before the first event all runs agree to {before['error'].max():.1g}.")
    itself = by_step[(by_step["method"] == reference) & (reference != tested)]
    if len(itself):
        others = ", ".join(f"{step:g}" for step in np.sort(itself["time_step"].unique()))
        sentences.append(
            f"{reference} with time step {others} differs from itself with {base:g} by at most "
            f"{itself['error'].max():.1g} in any of these errors."
        )
    return sentences


def _on_tolerances(convergence) -> list[str]:
    """How fast the error of the integrator that has a tolerance falls with its mean step."""
    sentences = []
    for method, rows in convergence[convergence["order"].notna()].groupby("method"):
        fits = rows.drop_duplicates(["n_blocks", "belt_velocity", "after_events"])
        events, orders = fits["after_events"], fits["order"]
        means = ", ".join(
            f"{at_velocity.mean():.1f} at u = {velocity:g}"
            for velocity, at_velocity in orders.groupby(fits["belt_velocity"])
        )
        sentences.append(
            f"The error of {method} after {events.min()} to {events.max()} events, against its "
            f"runs with the tightest tolerance, falls as its mean step to the power {means} (means "
            f"of {orders.size} fits in all, from {orders.min():.1f} to {orders.max():.1f}, with a "
            f"median standard error of {fits['order_error'].median():.1f}; they share states and "
            f"steps, so they are not independent). Tolerances from {rows['tolerance'].min():g} to "
            f"{rows['tolerance'].max():g} allow mean steps from {rows['step'].min():.2g} to "
            f"{rows['step'].max():.2g}; errors below {divergence.ROUNDING_OF_LONG_STEPS:g} are "
            f"rounding and not fitted. Full steps have order {steps.FORCE_ORDER + 1}, a little "
            "more where they are long, and less after a few short slips, whose ends cut the steps."
        )
    return sentences


def _on_family(row) -> str:
    measured = row["points"] - row[samples.UNKNOWN]
    quantity = ", ".join(filter(None, [row["quantity"], _conditions(row)]))
    if not measured:
        return f"{quantity}: not measured, too few runs or escapes."
    differ = row[samples.DIFFER]
    close = row[samples.CLOSE]
    verdicts = f"agree at {row[samples.AGREE]} of {measured} points"
    if close:
        verdicts += f", {samples.CLOSE} at {close}"
    if differ:
        verdicts += f", differ at {differ}"
    return (
        f"{quantity}: {verdicts} ({row['test']}, {row['runs']} runs a side, smallest corrected "
        f"{_p_is(row['smallest_p'])}){_on_means(row)}."
    )


def _on_means(row) -> str:
    if not row["degrees"]:
        return ""
    return (
        f". All means together: χ² = {row['chi2']:.1f} for {row['degrees']} degrees of freedom, "
        f"{_p_is(row['chi2_p'])}; mean relative difference "
        f"({100 * row['shift']:+.2f} ± {100 * row['shift_error']:.2f}) %"
    )


def _on_attractors(comparisons, methods, base) -> list[str]:
    """Where the distribution of the final r depends on the integrator, for each initial spread."""
    rows = comparisons[
        (comparisons["quantity"] == measure.FINAL_DISORDER)
        & np.isclose(comparisons["time_step"], base)
    ]
    sentences = []
    for spread, at_spread in rows.groupby("initial_spread"):
        runs = int(at_spread["n_tested"].min())
        verdicts = "; ".join(
            f"{verdict} at {_velocities(at_spread[at_spread['verdict'] == verdict])}"
            for verdict in samples.VERDICTS
            if (at_spread["verdict"] == verdict).any()
        )
        sentences.append(
            f"Initial states within {spread:g} (standard deviation of each position): the "
            f"distributions of r at the end of the runs by {methods['tested']} at dt = {base:g} "
            f"and by {methods['reference']} {verdicts} (Kolmogorov-Smirnov, {runs} runs a side; it "
            f"sees cumulative shares that differ by {_visible(runs):.2f}, before the correction)."
        )
    sentences += _on_steps(comparisons)
    sentences.append(_conclusion(rows))
    return sentences


def _on_steps(comparisons) -> list[str]:
    """How often each time step gave what the reference gives, over all u and spreads."""
    rows = comparisons[comparisons["quantity"] == measure.FINAL_DISORDER]
    counted = [
        f"{int((at_step['verdict'] == samples.AGREE).sum())} of {len(at_step)} at dt = {step:g}"
        for step, at_step in rows.groupby("time_step")
    ]
    if len(counted) < 2:
        return []
    return [f"Points whose final r agrees with the reference: {', '.join(counted)}."]


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
    wide = differ[differ["initial_spread"] == rows["initial_spread"].max()]
    where = (
        "also from the most distant states"
        if len(wide)
        else "but not, within the resolution of these samples, from the most distant states"
    )
    return (
        f"So without noise the last sentence of the Appendix, that the numerical method matters "
        f"little, does not hold at {len(differ)} of {len(rows)} points: r at the end depends on "
        f"the integrator, {where}."
    )


def _visible(runs) -> float:
    """Difference of cumulative shares that is significant at LEVEL in two samples of this size."""
    return float(np.sqrt(-np.log(samples.LEVEL / 2) / 2) * np.sqrt(2 / runs))


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


def _records(table, part) -> list[dict]:
    return table[table["part"] == part].to_dict("records")


def _point(row) -> str:
    return f"N = {row['n_blocks']:g}, u = {row['belt_velocity']:g}"


def _velocities(rows) -> str:
    return "u = " + ", ".join(f"{velocity:g}" for velocity in sorted(rows["belt_velocity"]))


def _p_is(value) -> str:
    words = _p(value)
    return f"p {words}" if words.startswith("<") else f"p = {words}"


def _p(value) -> str:
    if not np.isfinite(value):
        return ""
    return "< 1e-12" if value < 1e-12 else f"{value:.2g}"
