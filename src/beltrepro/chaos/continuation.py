"""Periodic orbits followed along a constant of the chain: where they end, and how."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.chaos import periodic_orbits, words
from beltrepro.chaos.periodic_orbits import MOMENTS, PeriodicOrbit
from beltrepro.chaos.vectors import part
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.model.energy import fast_unit
from beltrepro.model.parameters import LIMITS
from beltrepro.simulation.groups import Report, check_progress
from beltrepro.simulation.setup import check_tolerance
from beltrepro.simulation.tables import Tabled, one_panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

QUANTITIES = tuple(
    field.name for field in fields(ChainParameters) if field.name not in ("n_blocks", "noise")
)
_LOCATED = 1e-8  # share of its value to which a quantity is known where something happens
_STEPS = 50  # at least, across the range
_GROWTH = 1.5  # of the step where two orbits in turn have closed
_PREDICTED = 0.1  # share of a step over which the change of the orbit is looked at
_CLOSED = 1e-10  # residual; a fold seems to lie further on by about that
_NEAR = 0.2, 1e-3  # by which a period may miss its prediction: shares of its change, and of itself
_MULTIPLE = 1e-6  # share of the period to which its parts agree if it is several periods
_HALVES = 0.05  # the same just before an orbit becomes twice one of half the period
_BEYOND = 8  # times the last step: where a motion beyond an end shows what has changed
_FOLD = 0.2  # a multiplier so near to 1 becomes 1 at the end; it does as a square root

EDGE, FOLD, DOUBLING, TORUS = "edge", "fold", "period doubling", "torus"
GRAZING, NO_STICK, CONTACT, LOST = "grazing", "stick of no length", "contact", "lost"


class SpecialPoint(NamedTuple):
    """Where something happens to an orbit."""

    parameter: float
    kind: str
    block: int  # that it happens to, from 1; 0: no single one
    text: str


def _of_orbits(name: str, meaning: str) -> property:
    return property(
        lambda branch: np.array([getattr(orbit, name) for orbit in branch.orbits]), doc=meaning
    )


@dataclass(frozen=True, eq=False, repr=False)
class OrbitBranch(Tabled):
    """A periodic orbit along a constant of the chain: a branch of P orbits.

    An end is a `SpecialPoint`, with `parameter`, `kind`, `block` (from 1; 0 if it is no single one)
    and a sentence, `text`. Kinds are the "edge" of the range; "grazing", where a slipping block
    comes to touch the velocity of the belt, or the pull on a stuck one the static friction, or no
    longer reaches it; "stick of no length"; "fold", "period doubling" and "torus", where a
    multiplier becomes 1 or -1, or a complex pair leaves the unit circle; "contact" of two blocks,
    or of one with the wall; and "lost", where Newton's method fails for another reason.

    Attributes
    ----------
    quantity : str
        The constant of the chain that changes.
    orbits : tuple of PeriodicOrbit
        P of them, in order of the quantity.
    word : str
        Events of the first orbit: the block, and "-" if it starts to slip backwards over the belt,
        "+" forwards, "|" if it sticks.
    lower_end, upper_end : SpecialPoint
        The ends, at one of the orbits. What happens lies beyond it by less than 1e-8 of the value.
    passed : tuple of SpecialPoint
        What happens on the way, in order of the quantity.
    """

    quantity: str
    orbits: tuple[PeriodicOrbit, ...]
    word: str
    lower_end: SpecialPoint
    upper_end: SpecialPoint
    passed: tuple[SpecialPoint, ...]

    period_time = _of_orbits("period_time", "Periods (P,), model time.")
    multipliers = _of_orbits("multipliers", "Multipliers (P, 2N), largest modulus first.")
    largest_multiplier = _of_orbits("largest_multiplier", "The largest (P,) but the trivial one.")
    disorder_parameter = _of_orbits("disorder_parameter", "r (Eq. 4) of each orbit (P,).")
    mean_length = _of_orbits("mean_length", "<x_N> (P,) of each orbit.")

    @property
    def parameter(self) -> np.ndarray:
        """Values (P,) of the quantity."""
        return np.array([getattr(orbit.parameters, self.quantity) for orbit in self.orbits])

    @property
    def lower(self) -> float:
        """Value of the quantity at which the branch begins."""
        return self.lower_end.parameter

    @property
    def upper(self) -> float:
        """Value of the quantity at which it ends."""
        return self.upper_end.parameter

    @property
    def stable(self) -> np.ndarray:
        """Whether each orbit (P,) attracts."""
        return np.abs(self.largest_multiplier) < 1

    def _columns(self) -> dict[str, Any]:
        events = [orbit.period_events for orbit in self.orbits]
        columns = {self.quantity: self.parameter, "period_time": self.period_time}
        columns |= {"period_events": events, "largest_multiplier": abs(self.largest_multiplier)}
        return columns | {name: self[name] for name in ("stable", *MOMENTS)}

    @one_panel
    def plot(
        self, path: str | Path | None = None, *, ax: Any = None, y: str = MOMENTS[0], **look: Any
    ) -> Axes:
        """Draw a number of the orbits along the branch, dashed where they do not attract.

        Parameters
        ----------
        y : str
            disorder_parameter, mean_length, period_time, period_events or largest_multiplier.
        """
        from beltrepro.simulation import plots

        columns = self._columns()
        del columns[self.quantity], columns["stable"]
        return plots.branch(ax, self, y, columns, look)

    def __repr__(self) -> str:
        ends = f"{self.lower:.9g} ({self.lower_end.kind}) to "
        ends += f"{self.upper:.9g} ({self.upper_end.kind})"
        slips = self.orbits[0].period_events
        return f"OrbitBranch({slips} slips, {self.quantity} {ends}, {len(self.orbits)} orbits)"


@names.checked
def orbit_branch(
    orbit: PeriodicOrbit,
    quantity: str = "belt_velocity",
    *,
    lower: float,
    upper: float,
    step: float | None = None,
    unstable: bool = False,
    tolerance: float | None = None,
    progress: Report | None = None,
) -> OrbitBranch:
    """Follow a periodic orbit along a constant of the chain, down and up, to its ends.

    Each step predicts the next orbit from the way in which this one changes, and closes it by
    Newton's method. Where that fails the step is halved, until the ends are known to 1e-8 of the
    value. An orbit is one with the last if each block slips as often, in the same directions and
    order. Which of two blocks is first may change; that is smooth.

    Parameters
    ----------
    orbit : PeriodicOrbit
        Where to begin.
    quantity : str
        "belt_velocity" or another constant of `ChainParameters`, except n_blocks and noise.
    lower, upper : float
        The range to look at; the value of the orbit lies in it.
    step : float or None
        Largest step; a fiftieth of the range if not given.
    unstable : bool
        Whether to go on where the orbit gains or loses stability: such points are in `passed` then.
        A fold is always an end.
    tolerance : float or None
        Truncation of the series, as in `simulate`.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    OrbitBranch
        The orbits, their ends, and what happens on the way.

    Raises
    ------
    InputError
        A value is not allowed, or the orbit is several periods of another one.
    """
    if not isinstance(orbit, PeriodicOrbit):
        raise InputError(f"orbit = {checks.shown(orbit)}: a PeriodicOrbit is needed")
    quantity = names.one_of("quantity", quantity, QUANTITIES)
    value, limits = getattr(orbit.parameters, quantity), LIMITS[quantity]
    lower, upper = checks.within("lower", lower, **limits), checks.within("upper", upper, **limits)
    if isinstance(value, tuple):
        raise InputError(f"quantity = {quantity!r}: differs among the blocks, one number is needed")
    if not lower <= value <= upper or lower == upper:
        raise InputError(
            f"lower = {lower:g}, upper = {upper:g}: must have the {quantity} of the orbit, "
            f"{value:g}, between them"
        )
    step = (upper - lower) / _STEPS if step is None else checks.positive("step", step)
    if not isinstance(unstable, bool | np.bool_):
        raise InputError(f"unstable = {checks.shown(unstable)}: must be True or False")
    check_progress(progress)
    course = _Course(quantity, step, bool(unstable), check_tolerance("tolerance", tolerance))
    begin = course.point(orbit)
    if words.repeats(begin.word, orbit.period_time, _MULTIPLE) > 1:
        raise InputError(f"orbit = {orbit!r}: is several periods of a shorter one")
    report = part(progress, 0, 1)
    below, passed_below, lower_end = course.walk(begin, lower)
    report((value - lower) / (upper - lower))
    above, passed_above, upper_end = course.walk(begin, upper)
    report(1.0)
    return OrbitBranch(
        quantity,
        tuple(point.orbit for point in [*below[:0:-1], *above]),
        " ".join(map(str, begin.word)),
        lower_end,
        upper_end,
        (*passed_below[::-1], *passed_above),
    )


class _Point(NamedTuple):
    """An orbit of a branch, with its word."""

    value: float  # of the quantity
    orbit: PeriodicOrbit
    word: words.Word

    @property
    def outside(self) -> int:
        """How many multipliers lie outside the unit circle."""
        return int(np.sum(np.abs(self.orbit.multipliers) > 1))

    def changed(self, other: _Point) -> bool:
        """Whether something happens between this orbit and another one of its branch."""
        return self.outside != other.outside or words.sticks(self.word) != words.sticks(other.word)


class _Course(NamedTuple):
    """How an orbit is followed."""

    quantity: str
    step: float  # the largest
    unstable: bool
    tolerance: float | None

    def follow(self, state: ChainState, duration: float) -> tuple[ChainState, words.Word]:
        """The state after some time, and what happens on the way."""
        after, events = periodic_orbits.follow(state, duration, self.tolerance)
        return after, words.symbols(events)

    def point(self, orbit: PeriodicOrbit) -> _Point:
        """An orbit with its word."""
        _, word = self.follow(orbit.state, orbit.period_time)
        return _Point(getattr(orbit.parameters, self.quantity), orbit, word)

    def walk(
        self, begin: _Point, edge: float
    ) -> tuple[list[_Point], list[SpecialPoint], SpecialPoint]:
        """Follow an orbit to the edge: its points, what happens on the way, and the end."""
        points, step, failed = [begin], self.step, False
        passed: list[SpecialPoint] = []
        while (value := (here := points[-1]).value) != edge:
            finest = _LOCATED * max(abs(value), abs(edge))
            left = edge - value
            ahead = edge if abs(left) <= step + finest else value + np.sign(left) * step
            new = self.next(here, ahead)
            if new is None:
                if step > finest:
                    step, failed = max(abs(ahead - value) / 2, finest), True
                    continue
                # the time of its state may shrink to nothing, where events come in another order
                new = self.next(self.turned(here), ahead)
                if new is None:
                    return points, passed, self.end(here, ahead)
            step, failed = step if failed else min(_GROWTH * step, self.step), False
            if here.changed(new):
                before, new = self.located(here, new, finest)
                special = _happens(before, new)
                points += [before] if before is not here else []
                if before.outside != new.outside and not self.unstable:
                    return points, passed, special
                passed.append(special)
            points.append(new)
        return points, passed, SpecialPoint(edge, EDGE, 0, "the edge of the range")

    def turned(self, here: _Point) -> _Point:
        """The same orbit from a time of its period in which fewer blocks are stuck, if any is."""
        try:
            return self.point(periodic_orbits.turned(here.orbit, self.tolerance))
        except InputError:
            return here

    def next(self, here: _Point, value: float) -> _Point | None:
        """The orbit of a branch at another value of the quantity, if it is there."""
        try:
            start, period_time = self.predicted(here, value)
            orbit = periodic_orbits.close_orbit(start, period_time, self.tolerance)
            point = self.point(orbit)
        except (InputError, ModelStateError):  # it does not close, or blocks would meet
            return None
        before = here.orbit.period_time
        allowed = max(_NEAR[0] * abs(period_time - before), _NEAR[1] * before)
        belongs = (
            orbit.residual < _CLOSED
            and abs(orbit.period_time - period_time) < allowed
            and words.slips_alike(here.word, point.word)
            and words.repeats(point.word, orbit.period_time, _MULTIPLE) == 1
        )
        return point if belongs else None

    def predicted(self, here: _Point, value: float) -> tuple[ChainState, float]:
        """A state and the period of the orbit at another value, to first order."""
        orbit = here.orbit

        def under(value: float) -> ChainState:
            changes: dict[str, Any] = {self.quantity: value}
            return orbit.state.under(replace(orbit.parameters, **changes))

        begin = under(value)
        # what is apart after a period, a small part of the way back or ahead, says how the orbit
        # must change; near an end its word may be another there
        for share in (-_PREDICTED, _PREDICTED):
            try:
                nearby = under(here.value + share * (value - here.value))
            except InputError:  # no chain has such a value: the branch begins at a limit
                continue
            after, word = self.follow(nearby, orbit.period_time)
            if words.kinds(word) == words.kinds(here.word):
                before, after = map(periodic_orbits.coordinates, (nearby, after))
                flow = periodic_orbits.flow(orbit.state)
                change, longer = periodic_orbits.closing(
                    orbit.monodromy, flow, (after - before) / share
                )
                return periodic_orbits.shifted(begin, change), orbit.period_time + longer
        return begin, orbit.period_time

    def located(self, here: _Point, there: _Point, finest: float) -> tuple[_Point, _Point]:
        """Two orbits of a branch at most `finest` apart, between which something happens first."""
        while abs(there.value - here.value) > finest:
            middle = self.next(here, (here.value + there.value) / 2)
            if middle is None:
                break
            here, there = (here, middle) if here.changed(middle) else (middle, there)
        return here, there

    def end(self, here: _Point, ahead: float) -> SpecialPoint:
        """Why an orbit does not go on a little ahead."""
        value, orbit = here.value, here.orbit
        try:
            start, period_time = self.predicted(here, value + _BEYOND * (ahead - value))
            _, beyond = self.follow(start, period_time)
        except ModelStateError:
            return SpecialPoint(value, CONTACT, 0, "blocks meet, or a block and the wall")
        unit = fast_unit(orbit.parameters)
        if difference := words.first_difference(here.word, beyond, unit):
            return _grazing(value, difference)
        size = float(np.abs(np.delete(orbit.multipliers, orbit.trivial) - 1).min())
        if size > _FOLD:
            return SpecialPoint(value, LOST, 0, "Newton's method finds no orbit beyond")
        if words.repeats(here.word, orbit.period_time, _HALVES) > 1:
            text = "the orbit becomes twice one of half the period"
            return SpecialPoint(value, DOUBLING, 0, text)
        return SpecialPoint(value, FOLD, 0, "a multiplier becomes 1: the orbit meets another one")


def _happens(here: _Point, there: _Point) -> SpecialPoint:
    """What happens between two orbits side by side on a branch."""
    value = here.value
    before, after = words.sticks(here.word), words.sticks(there.word)
    block = next((block for block in before if before[block] != after[block]), 0)
    if block:
        goes = "shrinks to nothing" if after[block] < before[block] else "appears"
        sizes = [abs(point.orbit.largest_multiplier) for point in (here, there)]
        text = f"a stick of block {block} between two slips {goes}; the largest multiplier goes "
        return SpecialPoint(value, NO_STICK, block, text + "from {:.3g} to {:.3g}".format(*sizes))
    others = np.delete(there.orbit.multipliers, there.orbit.trivial)
    crossing = others[np.argmin(np.abs(np.abs(others) - 1))]
    if abs(crossing.imag) > 1e-6:
        pair = f"{crossing.real:.3g} +- {abs(crossing.imag):.3g}i"
        return SpecialPoint(value, TORUS, 0, f"multipliers {pair} of modulus 1")
    kind = FOLD if crossing.real > 0 else DOUBLING
    return SpecialPoint(value, kind, 0, f"a multiplier is {np.sign(crossing.real):.0f}")


def _grazing(value: float, difference: words.Difference) -> SpecialPoint:
    """An end at which an event appears or disappears."""
    block, kind = difference.symbol.block, difference.symbol.kind
    if difference.at_once:
        text = f"a stick of block {block} between two slips has no length"
        return SpecialPoint(value, NO_STICK, block, text)
    if kind == "|":
        what, does, limit = f"block {block}", "slips", "the velocity of the belt"
    else:
        what, does, limit = f"the pull on block {block}", "is stuck", "the static friction"
    touches = f", which {does}, touches" if difference.appears else " no longer reaches"
    return SpecialPoint(value, GRAZING, block, f"{what}{touches} {limit}")
