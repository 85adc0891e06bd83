"""Temporary."""

import numpy as np

from beltrepro import simulation as old
from beltrepro.model import section_position as rule


def _groups(chains, names, told):
    keys = [tuple(told[name][i] for name in names) for i in range(len(chains))]
    for key in dict.fromkeys(keys):
        yield dict(zip(names, key)), np.array([i for i, k in enumerate(keys) if k == key])


def _fill(table, part, rows, count):
    for name, values in part.items():
        if name not in table:
            table[name] = np.empty((count, *values.shape[1:]), dtype=values.dtype)
        table[name][rows] = values


def scan(chains, *, section_position=None, replicate, progress, tolerance, **told):
    table = {}
    per = {n: told.pop(n) for n in ("method", "time_step", "seed", "initial_spread")}
    for how, rows in _groups(chains, list(per), per):
        mine = [chains[i] for i in rows]
        part = old.measure_points(
            mine, **how, **told, replicates=[replicate[i] for i in rows], progress=progress,
            section_position=[rule(c) for c in mine],
        )
        _fill(table, part, rows, len(chains))
    return table


def escapes(chains, *, replicate, progress, tolerance, **told):
    table = {}
    per = {n: told.pop(n) for n in ("method", "time_step", "seed", "initial_spread")}
    per["chain"] = chains
    for how, rows in _groups(chains, list(per), per):
        assert [replicate[i] for i in rows] == list(range(len(rows)))
        part = old.escape_ensemble(
            how.pop("chain"), n_members=len(rows), **how, **told, progress=progress)
        part.pop("member")
        _fill(table, part, rows, len(chains))
    return table


def catalogue(chains, *, replicate, progress, tolerance, **told):
    parts = {"slips": [], "avalanches": [], "section": []}
    per = {n: told.pop(n) for n in ("method", "time_step", "seed", "initial_spread")}
    per["chain"] = chains
    for how, rows in _groups(chains, list(per), per):
        assert [replicate[i] for i in rows] == list(range(len(rows)))
        assert list(rows) == list(range(rows[0], rows[0] + len(rows)))
        part = old.record_catalogue(
            how.pop("chain"), n_chains=len(rows), **how, **told, progress=progress)
        for name, table in part.items():
            table["chain"] += rows[0]
            table.dtype.names = ("point", *table.dtype.names[1:])
            parts[name].append(table)
    return {name: np.concatenate(tables) for name, tables in parts.items()}


def simulate(chains, *, replicate, seed, initial_spread, progress, **told):
    starts = [old._perturbed(*each) for each in zip(chains, seed, replicate, initial_spread)]
    runs = [None] * len(chains)
    per = {n: told.pop(n) for n in ("method", "time_step", "tolerance")} | {"seed": seed, "replicate": replicate}
    for how, rows in _groups(chains, list(per), per):
        found = old.simulate([chains[i] for i in rows], **how, **told,
            initial_positions=[starts[i] for i in rows], progress=progress)
        for i, run in zip(rows, found):
            runs[i] = run
    return runs
