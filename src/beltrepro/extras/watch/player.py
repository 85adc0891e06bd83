"""A chain that is being watched, as a value."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from beltrepro.base import checks
from beltrepro.extras.watch.clock import Clock
from beltrepro.extras.watch.record import Record
from beltrepro.model import ChainParameters
from beltrepro.model.spring import chain_deformations, spring_force
from beltrepro.simulation import ChainState, Run, simulate

STRETCH = (
    250.0  # a run that is cut at multiples of it has the bits of the uncut run (docs/states.md)
)


@dataclass(frozen=True, eq=False)
class Player:
    """A chain at the instant that is shown, with its motion up to the next multiple of 250."""

    stretch: Run  # the motion simulated ahead, by the method "event", with a sample at each tick
    row: int  # sample that is shown; -1 for the state in which the stretch begins
    tick: float  # model time between samples, which lie at its multiples
    belt: float  # how far the belt has moved, model length
    record: Record  # what was shown of the last block

    @classmethod
    def begin(cls, state: ChainState, tick: float) -> Player:
        """Show a chain from a state on."""
        shown = Record().extended(np.array([state.time]), state.positions[-1:])
        return cls._from(state, tick, belt=0.0, record=shown)

    @classmethod
    def _from(cls, state: ChainState, tick: float, *, belt: float, record: Record) -> Player:
        stretch = _ahead(state, tick)
        # a run from t = 0 has a sample there, a later one has none at its beginning
        row = 0 if len(stretch.time) and stretch.time[0] == state.time else -1
        return cls(stretch, row, tick, belt, record)

    def advance(self, ticks: int = 1) -> Player:
        """The chain so many ticks later."""
        stretch, row, record = self.stretch, self.row, self.record
        while ticks > 0:
            if row + 1 == len(stretch.time):
                stretch, row = _ahead(stretch.final_state, self.tick), -1
                continue  # a stretch that is shorter than a tick may have no sample
            passed = slice(row + 1, min(row + 1 + ticks, len(stretch.time)))
            record = record.extended(stretch.time[passed], stretch.positions[passed, -1])
            ticks -= passed.stop - passed.start
            row = passed.stop - 1
        later = replace(self, stretch=stretch, row=row, record=record)
        moved = self.parameters.belt_velocity * (later.time - self.time)
        return replace(later, belt=self.belt + moved)

    def under(self, parameters: ChainParameters) -> Player:
        """The chain under other parameters from now on; r and <x_N> begin anew."""
        if parameters == self.parameters:
            return self
        state = self.state.under(parameters)
        return Player._from(state, self.tick, belt=self.belt, record=self.record.anew())

    def anew(self) -> Player:
        """This player with r and <x_N> beginning now."""
        return replace(self, record=self.record.anew())

    @property
    def state(self) -> ChainState:
        """The state that is shown."""
        start = self.stretch.initial_state
        if self.row < 0 or self.time == start.time:
            return start
        return _simulated(start, self.time - start.time, None).final_state

    @property
    def parameters(self) -> ChainParameters:
        """The chain."""
        return self.stretch.parameters

    @property
    def time(self) -> float:
        """The instant that is shown, model time."""
        start = self.stretch.initial_state.time
        return float(self.stretch.time[self.row]) if self.row >= 0 else start

    @property
    def positions(self) -> np.ndarray:
        """Positions (N,) of the blocks, model length."""
        start = self.stretch.initial_state
        return self.stretch.positions[self.row] if self.row >= 0 else start.positions

    @property
    def directions(self) -> np.ndarray:
        """Of the slip (N,) of the blocks over the belt: -1, 1, or 0 while stuck."""
        if self.row < 0:
            return self.stretch.initial_state.directions
        # the velocity of a stuck block is exactly that of the belt
        return np.sign(self.stretch.velocities[self.row] - self.parameters.belt_velocity)

    @property
    def tensions(self) -> np.ndarray:
        """Tension (N,) of the spring before each block, unit of force; positive when stretched."""
        return -spring_force(chain_deformations(self.positions, self.parameters), self.parameters)


def begin(parameters: ChainParameters, clock: Clock, transient: float, seed: int) -> Player:
    """A chain to watch, from undeformed springs (Sec. III)."""
    state = ChainState.at_rest(parameters, seed=seed)
    if checks.not_negative("transient", transient) > 0:
        state = _simulated(state, transient, None).final_state
    return Player.begin(state, clock.tick)


def _ahead(state: ChainState, tick: float) -> Run:
    """The motion from a state to the next multiple of 250."""
    end = STRETCH * (np.floor(state.time / STRETCH) + 1)
    return _simulated(state, float(end - state.time), tick)


def _simulated(state: ChainState, duration: float, sample_interval: float | None) -> Run:
    run = simulate(
        state.parameters,
        duration=duration,
        method="event",
        initial_state=state,
        sample_interval=sample_interval,
    )
    assert isinstance(run, Run)  # as it was one chain
    return run
