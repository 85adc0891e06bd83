"""A chain that is being watched, as a value: its clock, its motion, and what was shown of it."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from beltrepro.base import checks
from beltrepro.model import ChainParameters
from beltrepro.model.spring import chain_deformations, spring_force
from beltrepro.model.units import TIME_S
from beltrepro.simulation import ChainState, Run, simulate

DOUBLINGS = 4  # of the speed, up or down by keys


@dataclass(frozen=True)
class Clock:
    """How fast a chain is shown: a frame is a whole number of ticks, one at the slowest speed."""

    speed: float = 1.0  # seconds of the chain in a second of the film, without doublings
    frames_per_second: float = 24.0
    doublings: int = 0  # of the speed; negative where it was halved
    paused: bool = False  # whether frames stand still

    def __post_init__(self) -> None:
        checks.within("speed", self.speed, ge=0.05, le=50)
        checks.within("fps", self.frames_per_second, ge=1, le=120)

    @property
    def tick(self) -> float:
        """Model time of a tick."""
        # a power of two: instants on the grid of ticks are also those on the grid of frames
        return self.speed / self.frames_per_second / TIME_S / 2**DOUBLINGS

    @property
    def ticks_of_frame(self) -> int:
        """Ticks from one frame to the next."""
        return 2 ** (DOUBLINGS + self.doublings)

    @property
    def shown_speed(self) -> float:
        """Seconds of the chain in a second, with doublings."""
        return self.speed * 2.0**self.doublings

    def changed(self, doublings: int) -> Clock:
        """Faster or slower, as far as the speed goes."""
        return replace(
            self, doublings=int(np.clip(self.doublings + doublings, -DOUBLINGS, DOUBLINGS))
        )


KEPT = 30.0 / TIME_S  # model time: thirty seconds of the belt


@dataclass(frozen=True, eq=False)
class Record:
    """Recent positions of the last block, and their moments since an instant."""

    since: float  # from when on positions count, model time
    # instants and x_N of the last `KEPT` of model time; of those that count, the disorder parameter
    # up to each instant
    time: np.ndarray
    length: np.ndarray
    disorder: np.ndarray
    count: int  # positions that count, and their moments about the first of them
    total: float = 0.0
    squares: float = 0.0
    origin: float = 0.0

    @classmethod
    def begin(cls, time: np.ndarray, length: np.ndarray) -> Record:
        """A record of which the last position counts, as the first one."""
        at_last = {"since": float(time[-1]), "origin": float(length[-1])}
        return cls(time=time, length=length, disorder=np.zeros(1), count=1, **at_last)

    def extended(self, time: np.ndarray, length: np.ndarray) -> Record:
        """This record with further positions."""
        if not len(time):
            return self
        count = self.count + np.arange(1, len(length) + 1)
        total = self.total + np.cumsum(length - self.origin)
        squares = self.squares + np.cumsum((length - self.origin) ** 2)
        spread = np.sqrt(np.maximum(squares / count - (total / count) ** 2, 0.0))
        disorder = spread / (self.origin + total / count)
        recent = self.time >= time[-1] - KEPT
        return replace(
            self,
            time=np.append(self.time[recent], time),
            length=np.append(self.length[recent], length),
            disorder=np.append(self.disorder, disorder)[-recent.sum() - len(time) :],
            count=int(count[-1]),
            total=float(total[-1]),
            squares=float(squares[-1]),
        )

    def anew(self) -> Record:
        """This record with positions counting from the last one on."""
        return Record.begin(self.time, self.length)

    @property
    def mean_length(self) -> float:
        """<x_N> of the positions that count."""
        return self.origin + self.total / self.count

    @property
    def disorder_parameter(self) -> float:
        """The disorder parameter r of the positions that count (Eq. 4); 0 of the first alone."""
        return float(self.disorder[-1])


# a run that is cut at multiples of it has the bits of the uncut run (docs/states.md)
STRETCH = 250.0


@dataclass(frozen=True, eq=False)
class Player:
    """A chain at the instant that is shown, with its motion up to the next multiple of 250."""

    stretch: Run  # the motion simulated ahead, by the method "event", with a sample at each tick
    row: int  # sample that is shown; -1 for the state in which the stretch begins
    tick: float  # model time between samples, which lie at its multiples
    belt: float  # how far the belt has moved, model length
    record: Record  # what was shown of the last block

    @classmethod
    def begin(cls, state: ChainState, tick: float, before: Run | None = None) -> Player:
        """Show a chain from a state on; of a run before it the way of the last block is kept."""
        time, length = np.array([state.time]), state.positions[-1:]
        if before is not None:
            seen = before.time < state.time
            time = np.append(before.time[seen], time)
            length = np.append(before.positions[seen, -1], length)
        return cls._from(state, tick, 0.0, Record.begin(time, length))

    @classmethod
    def _from(cls, state: ChainState, tick: float, belt: float, record: Record) -> Player:
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
        return Player._from(state, self.tick, self.belt, self.record.anew())

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
    """A chain to watch after a transient from undeformed springs (Sec. III), which r leaves out."""
    state = ChainState.at_rest(parameters, seed=seed)
    if checks.not_negative("transient", transient) == 0:
        return Player.begin(state, clock.tick)
    before = _simulated(state, transient, clock.tick, max(0.0, transient - KEPT))
    return Player.begin(before.final_state, clock.tick, before)


def _ahead(state: ChainState, tick: float) -> Run:
    """The motion from a state to the next multiple of 250."""
    end = STRETCH * (np.floor(state.time / STRETCH) + 1)
    return _simulated(state, float(end - state.time), tick)


def _simulated(
    state: ChainState, duration: float, sample_interval: float | None, sample_start: float = 0.0
) -> Run:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # r of so short a run is asked by nobody
        how: Any = {"initial_state": state, "sample_interval": sample_interval}
        how["sample_start"] = sample_start
        run = simulate(state.parameters, duration=duration, **how)
    assert isinstance(run, Run)  # as it was one chain
    return run
