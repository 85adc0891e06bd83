"""The kinds of datasets: for each what it is told besides its points, what records it, and which
arrays that makes.

From here follow what config.yaml may give, what a job is told, how files of batches are joined, and
what every array in a file says of itself. The code behind a dataset is that of its function and of
`batch`.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from beltrepro.base.provenance import PACKAGE
from beltrepro.model.friction import noise_beyond_event
from beltrepro.replication.plan.points import QUANTITIES, UNITS, WORDS, Point, chain

POINT = "point"  # name of the axis along which batches are joined
# ends of the names by which tables, figures and claims ask for a film, and for what is tracked
FILM, TRACK = "_film", "_track"
FILMED = ("positions", "velocities")  # samples without which nothing can be filmed


class Array(NamedTuple):
    """One array of a file."""

    unit: str  # a key of UNITS; empty for a table of records
    # names of its axes. Batches are joined along "point". A table of records has one axis of
    # another name and a field `point`, the row of its run
    dimensions: tuple[str, ...]
    symbol: str
    description: str
    fields: Mapping[str, str]  # of a table of records, the unit of each field

    def attributes(self) -> dict[str, str]:
        """Symbol, unit, dimensions and description, by name, as a file carries them."""
        words = {
            "symbol": self.symbol,
            "unit": UNITS[self.unit] if self.unit else "by field",
            "dimensions": ", ".join(self.dimensions),
            "description": self.description,
        }
        if self.fields:
            units = [f"{name}: {UNITS[unit]}" for name, unit in self.fields.items()]
            words["field_units"] = "; ".join(units)
        return words


class Kind(NamedTuple):
    """What is recorded of the points of a dataset."""

    name: str  # its name in config.yaml
    record: str  # the function that records it, as module:function
    settings: tuple[str, ...]  # what it is told besides points: names in SETTINGS
    follows_tangents: bool = False  # which only the method event has

    @property
    def description(self) -> str:
        """One sentence."""
        return WORDS["kinds"][self.name]["description"]

    @property
    def recorded(self) -> dict[str, Array]:
        """What it records besides a column for each quantity."""
        return {name: _array(row) for name, row in WORDS["kinds"][self.name]["arrays"].items()}

    @property
    def arrays(self) -> dict[str, Array]:
        """All arrays of a file by name: the columns of the points and what is recorded."""
        of_points = {
            name: Array(words.unit, (POINT,), words.symbol, words.description, {})
            for name, words in QUANTITIES.items()
        }
        return of_points | self.recorded

    def complaints(self, settings: dict, points: Sequence[Point]) -> Iterator[str]:
        """Keys with values that fit their types and still cannot be meant, and why not."""
        # one for each chain at any belt velocity, on which this does not depend
        whole = Point._fields.index("belt_velocity")
        alike = {point[:whole]: point for point in points if point.method == "event"}
        for text in filter(None, map(noise_beyond_event, map(chain, alike.values()))):
            yield f"noise {text}"
        for name in ("transient", "settle_time"):
            if settings.get(name, 0) >= (duration := settings["duration"]):
                yield f"{name} = {settings[name]:g}: must be less than duration = {duration:g}"
        if self.follows_tangents and (others := {point.method for point in points} - {"event"}):
            yield f"method = {others.pop()}: only event has a tangent dynamics"
        if self.name == "basins" and any(chain(point).friction_varies for point in points):
            needed = "starts of one energy need friction that does not depend on velocity"
            yield f"viscosity and weakening_velocity: {needed}"
        drawn = self.name == "basins" or any(one.noise or one.initial_spread for one in points)
        if not drawn and len({one._replace(seed=0, replicate=0) for one in points}) < len(points):
            yield "replicate: without noise and initial_spread all replicates are the same run"
        if block := settings.get("section_block"):
            if block > (smallest := min(point.n_blocks for point in points)):
                yield f"section_block = {block}: the chain has {smallest} blocks"
            if settings["section_position"] is None:
                yield "section_position is missing: section_block needs one, for the file to name"
        interval = settings.get("sample_interval", 0)
        if interval and interval > (observed := settings["duration"] - settings["transient"]):
            yield f"sample_interval = {interval:g}: at most duration - transient = {observed:g}"
        for step in {point.time_step for point in points if point.method == "verlet"}:
            if abs(round(interval / step) * step - interval) > 1e-9 * interval:
                needed = f"method verlet needs a multiple of time_step = {step:g}"
                yield f"sample_interval = {interval:g}: {needed}"  # as in simulation/trajectories


def _array(row: str) -> Array:
    """An array as its row in words.yaml describes it."""
    unit, dimensions, symbol, text = map(str.strip, row.split("|", 3))
    fields = {}
    if " " in unit:  # a table of records
        fields, unit = dict(part.split(" ") for part in unit.split(", ")), ""
    return Array(unit, tuple(dimensions.split(", ")), symbol, text, fields)


# They are named, and imported where they run: to plan must not wait for numba.
_RECORDED = (
    ("scan", "simulation.scans:scan",
     "duration transient section_position section_values laminar_time"),
    ("density", "replication.plan.sections:density",
     "duration transient section_position section_from section_bins laminar_time"),
    ("series", "replication.plan.series:series",
     "duration transient sample_interval samples"),
    ("catalogue", "simulation.catalogues:catalogue",
     "duration transient section_block section_position"),
    ("section", "replication.plan.sections:section",
     "duration transient section_block section_position"),
    ("escapes", "simulation.scans:time_to_continuous_slip",
     "duration settle_time laminar_time"),
    ("motion", "chaos.naming:classify", "duration transient noise_clock"),
    ("settling", "chaos.irregular:time_to_orbit", "duration closed"),
    ("trial", "replication.camera.trials:trials",
     "duration transient sample_interval laminar_time"),
    ("basins", "replication.plan.attractors:basin_starts", "duration energies"),
    ("sweep", "replication.plan.attractors:sweeps", "duration transient"),
    ("births", "replication.plan.attractors:births", "duration slips friction_ratios"),
)  # fmt: skip
KINDS = {
    name: Kind(name, f"{PACKAGE}.{record}", tuple(settings.split()), name in ("motion", "basins"))
    for name, record, settings in _RECORDED
}
