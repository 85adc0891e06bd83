"""Simulate many slightly different initial states at one belt velocity; write when each escaped."""

from typing import TYPE_CHECKING

from beltrepro import ChainParameters, escapes, provenance, scripting, store

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def ensemble_member(settings: dict, preset: str, output, progress=None) -> None:
    """Follow the members of an ensemble.

    settings : n_blocks, belt_velocity, noise, duration, n_members, initial_spread, settle_time,
    laminar_time, method, seed, constants.
    progress : called with the fraction done; a bar or log lines if not given.
    """
    chain = ChainParameters(
        settings["n_blocks"], settings["belt_velocity"], settings["noise"], **settings["model"]
    )
    n_members = settings["n_members"]
    arrays = escapes(
        [chain] * n_members,
        replicate=range(n_members),
        duration=settings["duration"],
        method=settings["method"],
        time_step=settings["time_step"],
        seed=settings["seed"],
        initial_spread=settings["initial_spread"],
        laminar_time=settings["laminar_time"],
        settle_time=settings["settle_time"],
        progress=progress or scripting.Progress(chain.describe()),
    )
    attributes = provenance.attributes("ensemble", preset, settings) | {
        "n_blocks": chain.n_blocks,
        "noise": chain.noise,
        "n_members": settings["n_members"],
        "initial_spread": settings["initial_spread"],
        "laminar_time": settings["laminar_time"],
        "settle_time": settings["settle_time"],
    }
    store.write(output, arrays, attributes)


def main(job):
    scripting.use_threads(job.threads)
    ensemble_member(job.params.settings, job.params.preset, job.output[0])


if __name__ == "__main__":
    scripting.run(main, snakemake)
