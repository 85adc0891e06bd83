"""What `beltrepro bench` measured, as tables: for the terminal and for the docs."""

from typing import NamedTuple

import numpy as np

from beltrepro.extras.bench.competitors import BASE, LABELS, TIME_STEP

PAPER_DURATION = 2e6  # model time of a run of the paper
# Additions, multiplications and comparisons of the printed formulas, for a slipping block and step:
# deformation 2, branch of the spring 2, F_ex 1, stick and slip rule 4, a 3, x 4, v 7.
OPERATIONS = 23
_MISSING = "n/a"


class Sheet(NamedTuple):
    """One table."""

    title: str
    text: str  # what it says in words
    header: tuple[str, ...]
    rows: list[tuple[str, ...]]


def sheets(result: dict) -> list[Sheet]:
    """The tables of a result of `measuring.measure`."""
    parts = (_conditions, _cases, _shares, _chains, _blocks, _cores, _processes)
    return [sheet for sheet in (part(result) for part in parts) if sheet.rows]


def as_text(result: dict) -> str:
    """All tables for a terminal."""
    return "\n".join(map(_as_text, sheets(result)))


def comparison(rows: list[dict], tree: str) -> str:
    """What `measuring.compare` measured, for a terminal."""
    cells = []
    for row in rows:
        ratios = np.divide(row["here"], row["there"])
        costs = [_cell(np.median(row[side])) for side in ("here", "there")]
        spread = f"{ratios.min():.3f} to {ratios.max():.3f}"
        calls = [f"{1e3 * np.median(row[side]):.1f}" for side in ("call_here", "call_there")]
        cells.append(
            (*_case(row), row["method"], *costs, f"{np.median(ratios):.3f}", spread, *calls)
        )
    header = ("N", "σ", "u", "integrator", "ns here", "ns there", "here / there", "in the rounds")
    header += ("ms of a call here", "there")
    return _as_text(Sheet(f"Cost per chain and unit of time, beside {tree}", "", header, cells))


def _as_text(sheet: Sheet) -> str:
    lines = [sheet.header, *sheet.rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    rows = ("  ".join(map(str.ljust, line, widths)).rstrip() for line in lines)
    return "\n".join([sheet.title, *rows, ""])


def as_markdown(result: dict) -> str:
    """All tables as a page of the documentation."""
    rounds, timing = result["conditions"]["rounds"], result["conditions"]["timing"]
    parts = [
        f"""# Benchmark

Made by `{_command(result["conditions"])}`; do not edit.
All quantities were measured in one interleaved run of {rounds} rounds, each for about {timing:g} s
in a round. The tables show medians over the rounds. A cost is the processor time of one thread, for
one chain and one unit of model time (0.0765 s). All chains had moved for a while before.
"""
    ]
    for sheet in sheets(result):
        parts += [f"## {sheet.title}", "", *([sheet.text, ""] if sheet.text else [])]
        lines = [sheet.header, ["---"] * len(sheet.header), *sheet.rows]
        parts += [*(f"| {' | '.join(cells)} |" for cells in lines), ""]
    return "\n".join(parts)


def _command(conditions):
    flags = f"--rounds {conditions['rounds']}{' --quick' if conditions['quick'] else ''}"
    only = conditions["only"]
    flags += f" --only {only}" if only else ""
    return f"beltrepro bench {flags} --output docs/benchmark.md --force"


def _conditions(result):
    conditions, solver = result["conditions"], result["conditions"]["solve_ivp"]
    walls, compiler = result["wall"], conditions["compiler"]
    costs = [
        values
        for part in ("cases", "chains", "blocks")
        for row in result[part]
        for values in row["ns"].values()
    ]
    spread = np.median([max(values) / min(values) for values in costs])
    rows = [
        ("processor", f"{conditions['processor']}, {conditions['cores']} cores"),
        ("code", f"beltrepro {conditions['code_version']}"),
        ("date", conditions["date"]),
        ("versions", ", ".join(map(" ".join, conditions["versions"].items()))),
        ("C compiler", f"{compiler}; {conditions['compiler_flags']}" if compiler else _MISSING),
        ("solve_ivp", f"{solver['method']}, tolerances {solver['tolerance']:g}"),
        ("time step", f"{TIME_STEP:g} (plain loops and verlet)"),
        ("chains together", f"{conditions['width']} (verlet and event), 1 (all others)"),
        ("peak of one core", f"{np.median(result['peak']) / 1e9:.1f} GFlop/s of multiply-adds"),
        ("clock over processor time", f"{np.median(walls):.2f}, at most {np.max(walls):.2f}"),
        ("largest over smallest cost in the rounds", f"{spread:.2f}"),
    ]
    return Sheet("Conditions", "", ("what", "value"), rows)


def _cases(result):
    names, rows = result["names"], []
    for row in result["cases"]:
        costs = row["ns"]
        gains = {name: np.divide(costs[BASE], costs[name]) for name in costs}
        rows += [
            (*_case(row), "ns per chain and unit of time", *_cells(costs, names)),
            (*_case(row), "s per run of the paper", *_cells(costs, names, PAPER_DURATION / 1e9)),
            (*_case(row), "times faster than the plain loop", *_cells(gains, names)),
        ]
    text = (
        f"A run of the paper lasts {PAPER_DURATION:g} units of time; its seconds are those of one "
        "chain of those advanced together. The ratios are medians of the ratios within a round. "
        "solve_ivp follows one chain without noise from event to event; a step now and then hides "
        "a pair of events, which steps of at most 0.05 would find at 1.3 to 10 times the cost. "
        "Without noise verlet computes many steps at once; the column before it shows the scheme "
        "step by step. The last column is event with a deviation vector for each chain, as "
        "Lyapunov exponents need it."
    )
    return Sheet("Cost", text, ("N", "σ", "u", "quantity", *_labels(names)), rows)


def _case(row):
    return str(row["n_blocks"]), f"{row['noise']:g}", f"{row['belt_velocity']:g}"


def _shares(result):
    names = [name for name in ("numba", "c", "steps") if name in result["names"]]
    peak, rows = np.median(result["peak"]), []

    def share(costs, n_blocks):
        speed = OPERATIONS * n_blocks / TIME_STEP / (np.median(costs) * 1e-9)
        return f"{speed / 1e9:.2f} ({100 * speed / peak:.1f} %)"

    for row in result["cases"]:
        if row["noise"] == 0:
            n_blocks, _, belt_velocity = _case(row)
            shares = {name: share(costs, row["n_blocks"]) for name, costs in row["ns"].items()}
            rows.append((n_blocks, belt_velocity, *(shares.get(name, _MISSING) for name in names)))
    if rows:
        rows.append(("peak", "", *[f"{peak / 1e9:.1f} (100 %)"] * len(names)))
    text = (
        "Speed in GFlop/s without noise, and its share of the measured peak. The printed formulas "
        f"count as {OPERATIONS} operations for each block and step, as if all slipped."
    )
    return Sheet("Share of the peak", text, ("N", "u", *_labels(names)), rows)


def _chains(result):
    names = [name for name in ("verlet", "event") if name in result["names"]]
    rows = [(str(row["chains"]), *_cells(row["ns"], names)) for row in result["chains"]]
    n_blocks, noise, belt_velocity = result["conditions"]["scaling_case"]
    text = (
        f"Cost in ns per chain and unit of time at N = {n_blocks}, σ = {noise:g}, "
        f"u = {belt_velocity:g}, for several numbers of chains advanced together."
    )
    return Sheet("Number of chains", text, ("chains", *_labels(names)), rows)


def _blocks(result):
    names = [name for name in result["names"] if any(name in row["ns"] for row in result["blocks"])]
    rows = [
        (str(row["n_blocks"]), *_cells(row["ns"], names, 1 / row["n_blocks"]))
        for row in result["blocks"]
    ]
    _, noise, belt_velocity = result["conditions"]["scaling_case"]
    text = f"Cost in ns per block and unit of time at σ = {noise:g}, u = {belt_velocity:g}."
    return Sheet("Number of blocks", text, ("N", *_labels(names)), rows)


def _cores(result):
    rows = []
    for name, gains in result["cores"].items():
        wall, processor = gains["wall"], gains["processor"]
        numbers = np.median(wall), max(wall), np.median(processor)
        rows.append((LABELS[name], *(f"{number:.2f}" for number in numbers)))
    text = (
        "Work per time of two processes, divided by that of one process (target 1.9). The clock "
        "counts other programs too, the processor time only how the two slow each other down."
    )
    header = ("integrator", "by the clock", "best round", "by processor time")
    return Sheet("Two processes", text, header, rows)


def _processes(result):
    rows = []
    for name, memory in result["memory"].items():
        megabytes = [f"{memory[when] / 1e6:.0f}" for when in ("start", "end")]
        rows.append((LABELS[name], *megabytes, f"{np.median(result['first_step'][name]):.2f}"))
    n_blocks, width = result["conditions"]["scaling_case"][0], result["conditions"]["width"]
    text = (
        f"Peak memory of a process with {width} chains of {n_blocks} blocks, with all libraries, "
        "after its warm-up and after all rounds; and the time of a new process that does a few "
        "steps, with the compiled kernels in the cache (target: under 3 s)."
    )
    header = ("integrator", "MB at the start", "MB at the end", "s to the first step")
    return Sheet("Memory and start", text, header, rows)


def _labels(names):
    return (LABELS[name] for name in names)


def _cells(values, names, factor=1.0):
    """The median of the values of each competitor, times a factor."""
    return [
        _cell(factor * np.median(values[name])) if name in values else _MISSING for name in names
    ]


def _cell(value):
    """Three digits, without an exponent."""
    digits = 2 - int(np.floor(np.log10(value)))
    return f"{round(value, digits):.{max(digits, 0)}f}"
