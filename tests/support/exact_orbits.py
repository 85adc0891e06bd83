"""Periodic orbits and their grazings with 40 digits, from orbits in double precision."""

from copy import deepcopy

from mpmath import mp, mpf

from beltrepro.chaos.periodic_orbits import flow
from exact import ExactChain, fixed, real

CLOSED = mpf(10) ** -40
_STEPS = 12  # of Newton's method: ten digits each at the velocity of the matrix, five beside it


class ExactOrbit:
    """An orbit closed with 40 digits at a belt velocity near that of one in double precision.

    The derivative of Newton's method is the matrix in double precision.
    """

    def __init__(self, orbit, belt_velocity):
        self.belt_velocity, state = belt_velocity, orbit.state
        self.directions = [int(way) for way in state.directions]
        self.displacements = [mpf(float(place)) for place in state.displacements]
        self.velocities = [mpf(float(speed)) for speed in state.relative_velocities]
        self.period_time = mpf(orbit.period_time)
        rows = self._rows(orbit)
        with mp.workdps(55):
            for _ in range(_STEPS):
                self.residual, change = self._newton(rows)
                if self.residual < CLOSED:
                    return
                self._move(change)
        raise AssertionError(f"no orbit closes at {belt_velocity}: {self.residual}")

    def start(self):
        """The chain at the start of the period."""
        return ExactChain.of(
            self.belt_velocity, self.displacements, self.velocities, self.directions
        )

    def _rows(self, orbit):
        matrix, rates = orbit.monodromy, flow(orbit.state)
        rows = mp.matrix(len(rates) + 1)
        for i, row in enumerate(matrix):
            for j, value in enumerate(row):
                rows[i, j] = mpf(float(value)) - (i == j)
            rows[i, len(rates)] = rows[len(rates), i] = mpf(float(rates[i]))
        return rows

    def _newton(self, rows):
        begin, end = self.start(), self.start()
        end.advance(until=fixed(self.period_time))
        moved = [after - before for after, before in zip(end.y, begin.y, strict=True)]
        faster = [after - before for after, before in zip(end.v, begin.v, strict=True)]
        slipping = [i for i, way in enumerate(begin.direction) if way]
        apart = [real(units) for units in [*moved[1:], *(faster[i] for i in slipping)]]
        change = mp.lu_solve(rows, mp.matrix([*(-value for value in apart), 0]))
        return max(map(abs, apart)), list(change)

    def _move(self, change):
        blocks = range(len(self.displacements))
        for i in blocks:
            self.displacements[i] += change[i]
        slipping = (i for i in blocks if self.directions[i])
        for i, faster in zip(slipping, change[len(blocks) : -1], strict=True):
            self.velocities[i] += faster
        self.period_time += change[-1]

    def softest_stick(self, block):
        """Square of the least acceleration with which a block sticks: 0 if it only just does."""
        chain, accelerations = self.start(), []
        while chain.time < fixed(self.period_time):
            before = deepcopy(chain)
            chain.advance(n_events=len(chain.events) + 1)
            time, where, kind = chain.events[-1]
            if (where, kind) == (block, "stick"):
                before.advance(until=time - (1 << 40))  # 1e-46 before it sticks
                accelerations.append(real(before.flow()[1][block]))
        return min(accelerations) ** 2
