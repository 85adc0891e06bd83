"""The virtual experiment: what its recordings tell, and what is lost on the way."""

import pandas as pd

TITLE = "The virtual experiment"
ANCHOR = "experiment"
NEEDS = ("recordings",)

STAGES = {
    "stage_tracker": "tracker alone: sharp, still, noiseless, lossless",
    "stage_lens": "and the lens: blur, exposure, picture turned",
    "stage_sensor": "and the sensor: noise, uneven and drifting light, lost frames",
}


def gather(material) -> dict:
    """Rows of the recordings and of the stages."""
    table = pd.read_csv(material.file("recordings"))
    rows = table.to_dict("records")
    whole = [row for row in rows if row["film"] == row["dataset"]]
    stages = [row | {"stage": STAGES[row["film"]]} for row in rows if row["film"] in STAGES]
    filmed = next(row for row in whole if row["film"] == stages[0]["dataset"])
    return {
        "recordings": [_recording(row) for row in whole],
        "stages": [_error(row) for row in [*stages, filmed | {"stage": "and the codec: the film"}]],
        "rate": rows[0]["frames_per_second"],
    }


def _recording(row: dict) -> dict:
    return {
        "speed": f"{row['belt_speed']:.2f}",
        "noise": f"{row['noise']:g}",
        "seconds": f"{row['seconds']:.0f}",
        "r": [f"{row[name]:.5f}" for name in ("r_run", "r_sampled", "r_tracked")],
        "mean": [f"{100 * row[name]:.3f}" for name in ("mean_sampled", "mean_tracked")],
        "small": [f"{100 * row[name]:.1f}" for name in ("small_sampled", "small_tracked")],
    }


def _error(row: dict) -> dict:
    pixels = {name: f"{row[name]:.3f}" for name in ("scatter", "offset", "largest", "told")}
    relative = (
        ("scale", row["scale"]),
        ("r", row["r_tracked"] / row["r_sampled"] - 1),
    )
    return {"stage": row["stage"]} | pixels | {name: f"{value:.0e}" for name, value in relative}
