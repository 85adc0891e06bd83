"""Periodic orbits that close with 40 digits, and their multipliers.

`python tests/support/certificates.py` completes each record of tests/data/periodic_orbits.json that
has no more than how it is `found`: in double precision, then closed in the arithmetic of exact.py.
A slow test follows them again.
"""

import json
from operator import itemgetter
from pathlib import Path

from mpmath import mp, mpf

from beltrepro import ChainParameters, periodic_orbit
from exact import ONE, Deviations, ExactChain, fixed, real

DATA = Path(__file__).parents[1] / "data" / "periodic_orbits.json"
DIGITS = 50  # after the point, of the numbers in the file
CLOSED = mpf(10) ** -35
STEPS = 12
NEAR = mpf(10) ** -20  # Newton's method brings ten digits and more: the next state closes


def chain_of(record):
    """The start of an orbit of the file, in exact arithmetic."""
    names = ("belt_velocity", "displacements", "relative_velocities", "directions")
    return ExactChain.of(*(record[name] for name in names))


def once_around(record, *, tangent=False):
    """Follow an orbit of the file for its period.

    Returns
    -------
    chain : ExactChain after it.
    apart : (D,) by which the state misses its start, in the coordinates of docs/chaos.md.
    matrix : (D, D) the tangent map over the period, if asked for.
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


def certify(orbit):
    """A record of an orbit, closed by Newton's method, with the derivative in double precision."""
    state = orbit.state
    record = {
        "n_blocks": orbit.parameters.n_blocks,
        "belt_velocity": orbit.parameters.belt_velocity,
        "period_events": orbit.period_events,
        "period_time": mp.nstr(mpf(orbit.period_time), DIGITS),
        "displacements": _texts(state.displacements),
        "relative_velocities": _texts(state.relative_velocities),
        "directions": state.directions.astype(int).tolist(),
    }
    rates = mp.matrix(flow(chain_of(record)))
    size = len(rates)
    rows = mp.zeros(size + 1)
    rows[:size, :size] = mp.matrix(orbit.monodromy.tolist()) - mp.eye(size)
    rows[:size, size] = rates
    rows[size, :size] = rates.T
    missed, matrix = mp.inf, None
    for _ in range(STEPS):
        chain, apart, matrix = once_around(record, tangent=missed < NEAR)
        missed = max(map(abs, apart))
        if missed > CLOSED:
            change = mp.lu_solve(rows, mp.matrix([*(-a for a in apart), 0]))
            record |= _shifted(record, list(change))
        elif matrix is not None:
            break
    assert missed < CLOSED, f"{orbit} misses itself by {mp.nstr(missed, 3)}"
    found = multipliers(matrix, flow(chain_of(record)))
    return record | {
        "residual": mp.nstr(missed, 3),
        "n_events": len(chain.events),
        "multipliers": [[mp.nstr(mu.real, 20), mp.nstr(mu.imag, 20)] for mu in found],
        "erased": state.directions.tolist().count(0.0),
    }


def _texts(values):
    return [mp.nstr(mpf(value), DIGITS) for value in values.tolist()]


def _shifted(record, change):
    """The numbers of a record, with other coordinates and another period."""
    names = ("displacements", "relative_velocities")
    moved = {name: list(record[name]) for name in names}
    for (what, block), by in zip(_free(chain_of(record)), change, strict=False):
        texts = moved[names[what]]
        texts[block - 1] = _text(mpf(texts[block - 1]) + by)
    return moved | {"period_time": _text(mpf(record["period_time"]) + change[-1])}


def _text(value):
    """To DIGITS after the point."""
    return mp.nstr(value, DIGITS + max(0, int(mp.log10(abs(value))) + 1) if value else DIGITS)


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


def write_certificates():
    """Complete the records of the file, and print the table."""
    records = records_of_file()
    for record in records:
        case = record["found"]
        if "residual" in record:
            continue
        chain = ChainParameters(case["n_blocks"], case["belt_velocity"])
        settings = {name: case[name] for name in ("duration", "transient", "replicate")}
        orbit = periodic_orbit(chain, **settings)
        with mp.workdps(DIGITS + 10):
            record |= certify(orbit)
    DATA.write_text(json.dumps(records, indent=1) + "\n")
    print(table())


if __name__ == "__main__":
    write_certificates()
