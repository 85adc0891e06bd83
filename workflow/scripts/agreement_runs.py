"""Simulate the runs of one part of the comparison of integrators, by one of them."""

import itertools
from typing import TYPE_CHECKING

import numpy as np

from beltrepro import ChainParameters, provenance, scripting, store
from beltrepro.analysis.steps import mean_step
from beltrepro.simulation import TOLERANCES, catalogue, escapes, scan, simulate

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

EVENT = np.dtype([("run", "i4"), ("time", "f8"), ("block", "i4"), ("kind", "U5")])
KINDS = {
    "trajectories": "series",
    "disorder": "scan",
    "slips": "catalogue",
    "attractors": "ensemble",
}


def agreement_runs(part: str, settings: dict, preset: str, output, progress=None) -> None:
    """Simulate and write one part.

    part : "trajectories", "disorder", "slips" or "attractors". settings : its lengths, grids,
    time_steps, tolerances and n_runs, method, seed, constants; what to record.
    progress : called with the fraction done; a bar or log lines if not given.
    """
    simulate_part = {
        "trajectories": trajectories,
        "disorder": disorder,
        "slips": slips,
        "attractors": attractors,
    }[part]
    label = f"{part} by {settings['method']}"
    arrays = simulate_part(settings, progress or scripting.Progress(label))
    attributes = provenance.attributes(KINDS[part], preset, settings)
    if len(settings["time_steps"]) > 1:
        attributes["time_step"] = ", ".join(f"{step:g}" for step in settings["time_steps"])
    if settings["method"] in TOLERANCES:
        attributes["tolerance"] = TOLERANCES[settings["method"]]
    store.write(output, arrays, attributes)


def trajectories(settings: dict, progress) -> dict:
    """Samples and events of every chain from n_runs states, with every time step and tolerance.

    The time steps are taken with the integrator's own tolerance, the other tolerances, if it has
    any, with the time step of the project.
    """
    chains = _chains(settings)
    starts = [_start(chain, member, settings) for chain, member in _repeated(chains, settings)]
    runs, accuracies = [], _accuracies(settings)
    for index, (time_step, tolerance) in enumerate(accuracies):
        runs += simulate(
            [chain for chain, _ in _repeated(chains, settings)],
            duration=settings["duration"],
            method=settings["method"],
            seed=settings["seed"],
            initial_positions=starts,
            sample_interval=settings["sample_interval"],
            time_step=time_step,
            tolerance=tolerance,
            progress=_share(progress, index, len(accuracies)),
        )
    members = list(range(settings["n_runs"])) * (len(chains) * len(accuracies))
    steps, tolerances = np.repeat(np.array(accuracies, dtype=float), len(starts), axis=0).T
    positions = np.full((len(runs), runs[0].time.size, max(settings["n_blocks"])), np.nan)
    events = []
    for row, run in enumerate(runs):
        positions[row, :, : run.parameters.n_blocks] = run.positions
        records = np.empty(run.events.size, EVENT)
        records["run"] = row
        for name in EVENT.names[1:]:
            records[name] = run.events[name]
        events.append(records)
    return _columns([run.parameters for run in runs]) | {
        "member": np.array(members),
        "time_step": steps,
        "tolerance": tolerances,
        "step": np.array([_mean_step(*run) for run in zip(runs, steps, strict=True)]),
        "time": runs[0].time,
        "positions": positions,
        "events": np.concatenate(events),
    }


def _accuracies(settings) -> list[tuple]:
    """Pairs of time step and tolerance, None for an integrator that has no tolerance."""
    own = TOLERANCES.get(settings["method"])
    pairs = [(time_step, own) for time_step in settings["time_steps"]]
    others = [] if own is None else [value for value in settings["tolerances"] if value != own]
    return pairs + [(settings["time_step"], tolerance) for tolerance in others]


def _mean_step(run, time_step):
    if run.tolerance is None:
        return time_step
    return mean_step(run.positions, run.velocities, run.parameters, run.tolerance)


def disorder(settings: dict, progress) -> dict:
    """What a scan records, for n_runs replicates of every chain."""
    chains, replicates = zip(*_repeated(_chains(settings), settings), strict=True)
    sections = settings["section_position"]
    return scan(
        chains,
        duration=settings["duration"],
        transient=settings["transient"],
        method=settings["method"],
        time_step=settings["time_step"],
        seed=settings["seed"],
        replicate=replicates,
        section_position=[sections[chain.n_blocks] for chain in chains],
        section_values=settings["section_values"],
        laminar_time=settings["laminar_time"],
        progress=progress,
    )


def slips(settings: dict, progress) -> dict:
    """Slips and section points of n_runs of every chain; `point` in them is the row of the run."""
    chains = _chains(settings)
    parts = {"slips": [], "section": []}
    for index, chain in enumerate(chains):
        recorded = catalogue(
            [chain] * settings["n_runs"],
            duration=settings["duration"],
            transient=settings["transient"],
            method=settings["method"],
            time_step=settings["time_step"],
            seed=settings["seed"],
            section_block=settings["section_block"],
            section_position=settings["section_position"],
            replicate=range(settings["n_runs"]),
            initial_spread=settings["initial_spread"][0],
            progress=_share(progress, index, len(chains)),
        )
        for name, tables in parts.items():
            recorded[name]["point"] += index * settings["n_runs"]
            tables.append(recorded[name])
    rows = _columns([chain for chain, _ in _repeated(chains, settings)])
    return rows | {name: np.concatenate(tables) for name, tables in parts.items()}


def attractors(settings: dict, progress) -> dict:
    """Where n_runs of every chain end, for every initial spread and time step."""
    cases = list(
        itertools.product(_chains(settings), settings["initial_spread"], settings["time_steps"])
    )
    tables = []
    for index, (chain, spread, time_step) in enumerate(cases):
        table = escapes(
            [chain] * settings["n_runs"],
            replicate=range(settings["n_runs"]),
            duration=settings["duration"],
            settle_time=settings["settle_time"],
            laminar_time=settings["laminar_time"],
            method=settings["method"],
            time_step=time_step,
            seed=settings["seed"],
            initial_spread=spread,
            progress=_share(progress, index, len(cases)),
        )
        runs = settings["n_runs"]
        alike = {"initial_spread": np.full(runs, spread), "time_step": np.full(runs, time_step)}
        tables.append(table | _columns([chain] * runs) | alike)
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def _chains(settings) -> list[ChainParameters]:
    grids = (settings["n_blocks"], settings["belt_velocity"], settings.get("noise", [0.0]))
    return [ChainParameters(*point, **settings["model"]) for point in itertools.product(*grids)]


def _repeated(chains, settings):
    return itertools.product(chains, range(settings["n_runs"]))


def _columns(chains) -> dict:
    names = ("n_blocks", "belt_velocity", "noise")
    return {name: np.array([getattr(chain, name) for chain in chains]) for name in names}


def _start(chain, member, settings):
    """Initial positions of a member, the same for every method and time step; 0 is the declared."""
    stream = np.random.default_rng([settings["seed"], chain.n_blocks, member])
    spread = settings["initial_spread"][0] if member else 0.0
    return chain.rest_positions + spread * stream.standard_normal(chain.n_blocks)


def _share(progress, index, count):
    """Progress of one of several equal pieces of work."""
    return lambda fraction: progress((index + fraction) / count)


def main(job):
    scripting.use_threads(job.threads)
    agreement_runs(job.wildcards.part, job.params.settings, job.params.preset, job.output[0])


if __name__ == "__main__":
    scripting.run(main, snakemake)
