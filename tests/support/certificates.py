"""Periodic orbits that close with 40 digits, and their multipliers.

Each record of tests/data/periodic_orbits.json says how its orbit was `found` in double precision;
Newton's method in the arithmetic of exact.py then closed it. What follows it again needs neither.
"""

import json
from operator import itemgetter
from pathlib import Path

from mpmath import mp

from exact import ONE, Deviations, ExactChain, fixed, real

DATA = Path(__file__).parents[1] / "data" / "periodic_orbits.json"
DIGITS = 50  # after the point, of the numbers in the file


def chain_of(record):
    """The start of an orbit of the file, in exact arithmetic."""
    names = ("belt_velocity", "displacements", "relative_velocities", "directions")
    return ExactChain.of(*(record[name] for name in names))


def once_around(record, *, tangent=False):
    """Follow an orbit for its period: the chain, by how much it misses its start, tangent map.

    In the coordinates of docs/chaos.md; the map (D, D) is None if not asked for.
    """
    chain = chain_of(record)
    begin, free = _numbers(chain), _free(chain)
    if tangent:
        chain.deviations = Deviations([_unit(len(chain.y), *place) for place in free])
    chain.advance(until=fixed(record["period_time"]))
    end = _numbers(chain)
    apart = [real(end[what][i] - begin[what][i]) for what, i in free]
    if not tangent:
        return chain, apart, None
    columns = chain.deviations.columns()
    return chain, apart, mp.matrix([[real(each[what][i]) for each in columns] for what, i in free])


def _numbers(chain):
    return chain.y, chain.v


def _free(chain):
    """The coordinates, as (0 for a displacement or 1 for a velocity, block)."""
    blocks = range(1, len(chain.y))
    return [(0, i) for i in blocks] + [(1, i) for i in blocks if chain.direction[i]]


def _unit(count, what, block):
    deviation = [0] * count, [0] * count
    deviation[what][block] = ONE
    return deviation


def flow(chain):
    """Rates of change (D,) of the coordinates of a chain."""
    rates = chain.flow()
    return [real(rates[what][i]) for what, i in _free(chain)]


def multipliers(matrix, rates):
    """Eigenvalues of a tangent map of a period but the trivial one, largest modulus first.

    Modulo the flow, which is mapped to itself: the coordinate in which it is fastest is dropped,
    after as much of the flow is subtracted from each column as makes it zero there.
    """
    fastest = max(range(len(rates)), key=lambda i: abs(rates[i]))
    kept = [i for i in range(len(rates)) if i != fastest]
    if not kept:
        return []
    rest = [
        [matrix[i, j] - rates[i] * matrix[fastest, j] / rates[fastest] for j in kept] for i in kept
    ]
    across = mp.matrix(rest)
    return sorted(mp.eig(across, right=False), key=lambda mu: -abs(mu))


def largest_modulus(record):
    return max((abs(complex(float(re), float(im))) for re, im in record["multipliers"]), default=0)


def table():
    """The orbits of the file as a table for docs/chaos.md."""
    lines = [
        "| N | u | period | slips | largest multiplier besides 1 | misses itself by |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    row = "| {n_blocks} | {belt_velocity:g} | {:.6f} | {period_events} | {:.2g} | {:.0e} |"
    order = itemgetter("n_blocks", "belt_velocity", "period_events")
    for record in sorted(records_of_file(), key=order):
        sizes = float(record["period_time"]), largest_modulus(record), float(record["residual"])
        lines.append(row.format(*sizes, **record))
    return "\n".join(lines)


def records_of_file():
    return json.loads(DATA.read_text())
