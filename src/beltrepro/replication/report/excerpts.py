"""What the figures of a run draw, small enough to be published, and figures drawn from that.

Of each dataset that is its excerpt: arrays that figures draw as they are, and those to which large
ones are reduced. Tables and tracks of films are published whole.
"""

import importlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.base import store
from beltrepro.base.errors import InputError
from beltrepro.base.names import one_of
from beltrepro.base.store import Dataset
from beltrepro.replication.drawing import style
from beltrepro.replication.drawing.panels import EXCERPT, Excerpt
from beltrepro.replication.plan import io, registry
from beltrepro.replication.plan.kinds import FILM, KINDS, TRACK
from beltrepro.replication.plan.points import QUANTITIES

FOLDER = "drawn"  # of the excerpts, in that of a published run
PUBLISHED, REDRAWN = Path("docs/results/paper"), Path("build/figures")
# Arrays that are drawn as they are, but quantities of one value, which are attributes.
WHOLE = {
    "n_blocks", "belt_velocity", "noise", "friction_ratio", "initial_spread", "time_step",
    "replicate", "disorder_parameter", "final_disorder", "laminar_count", "laminar_fraction",
    "last_stick_time", "largest_exponent", "section_position", "section_bins",
    "section_histogram", "lifetime", "escaped", "settled", "state", "period_events",
    "start_energy", "attractor", "attractors", "branches",
}  # fmt: skip


class _Published(dict):
    """Arrays by name, of which only those of `WHOLE` are there."""

    def __missing__(self, name: str) -> Any:
        raise InputError(f"{name!r} is not published; figures of a run (`make`) have all arrays")


def excerpts(results: Path) -> dict[str, Excerpt]:
    """Excerpts of the datasets behind the figures of a run, which are drawn for that."""
    made: dict[str, Excerpt] = {}
    for name in _drawn(results):
        data, _ = io.load(dict(_files(name, results, "datasets")))
        for used, dataset in data.items():
            if isinstance(dataset, Dataset):
                arrays, about = dataset.arrays, dataset.attributes
                drawn = made[used].drawn if used in made else {}
                data[used] = Excerpt(arrays, about, drawn)
                whole = {array: arrays[array] for array in arrays.keys() & WHOLE - _alike(about)}
                made[used] = Excerpt(whole, about, drawn)
        _draw(name, data)
    return made


def write(made: dict[str, Excerpt], folder: Path) -> None:
    """Write excerpts beside what else is published of a run; array B to which A reduces is A/B."""
    for name, one in made.items():
        words = KINDS[one.attributes["kind"]].arrays
        about = {array: words[array].attributes() for array in one.arrays}
        arrays = dict(one.arrays)
        for place, reduced in one.drawn.items():
            arrays |= {f"{place}/{array}": values for array, values in reduced.items()}
        attributes = one.attributes | {"kind": EXCERPT}
        store.write(folder / FOLDER / f"{name}.h5", arrays, attributes, about)


def redraw(*names: str, folder: Path = PUBLISHED, target: Path = REDRAWN) -> None:
    """Draw figures, or all, from what is published of a run."""
    if not (folder / FOLDER).is_dir():
        made_by = f"`make publish RUN={folder.name}` writes it, from a finished run"
        raise InputError(f"{folder / FOLDER}: no such folder; {made_by}")
    for name in names:
        one_of("figure", name, registry.figures())
    for name in names or _drawn(folder):
        data, sources = io.load(dict(_files(name, folder, FOLDER)))
        data |= {used: _excerpt(one) for used, one in data.items() if isinstance(one, Dataset)}
        data |= {used: None for used in registry.figures()[name].uses if used.endswith(FILM)}
        files = (target / f"{name}.{ending}" for ending in ("png", "pdf"))
        style.save(_draw(name, data), *files, sources)


def _drawn(folder: Path) -> list[str]:
    """Names of the figures of a run."""
    return [name for name in registry.figures() if (folder / f"figures/{name}.png").exists()]


def _files(name: str, folder: Path, datasets: str) -> Iterator[tuple[str, str]]:
    """What a figure is drawn from, by name; no film where datasets are excerpts."""
    for used in registry.figures()[name].uses:
        if used in registry.tables():
            yield used, str(folder / f"tables/{used}.csv")
        elif used.endswith(TRACK):
            yield used, str(folder / f"experiment/{used.removesuffix(TRACK)}.csv")
        elif not used.endswith(FILM):
            yield used, str(folder / f"{datasets}/{used}.h5")
        elif datasets != FOLDER:
            yield used, str(folder / f"experiment/{used.removesuffix(FILM)}.mp4")


def _draw(name: str, data: dict[str, Any]) -> Any:
    return getattr(importlib.import_module(registry.figures()[name].module), name)(data)


def _alike(attributes: dict[str, Any]) -> set[str]:
    """Quantities that have one value in a dataset."""
    return QUANTITIES.keys() & attributes


def _excerpt(dataset: Dataset) -> Excerpt:
    """An excerpt as it was written."""
    about = dataset.attributes
    count = json.loads(about["config"])["points"]["count"]
    alike = {name: np.full(count, about[name]) for name in _alike(about)}
    one = Excerpt(_Published(alike), about)
    for name, values in dataset.arrays.items():
        place, _, array = name.rpartition("/")
        (one.drawn.setdefault(place, {}) if place else one.arrays)[array] = values
    return one


if __name__ == "__main__":
    try:
        redraw(*sys.argv[1:])
    except InputError as error:
        sys.exit(f"error: {error}")
    print(REDRAWN)
