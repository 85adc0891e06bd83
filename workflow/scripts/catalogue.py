"""Simulate several chains with the same parameters; write slips, avalanches and section points."""

from typing import TYPE_CHECKING

from beltrepro import ChainParameters, provenance, scripting, store
from beltrepro import catalogue as record

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def catalogue(settings: dict, preset: str, output, progress=None) -> None:
    """Record a catalogue.

    settings : n_blocks, belt_velocity, noise, lengths, section, n_chains, method, seed, constants.
    progress : called with the fraction done; a bar or log lines if not given.
    """
    chain = ChainParameters(
        settings["n_blocks"], settings["belt_velocity"], settings["noise"], **settings["model"]
    )
    n_chains = settings["n_chains"]
    arrays = record(
        [chain] * n_chains,
        duration=settings["duration"],
        transient=settings["transient"],
        method=settings["method"],
        time_step=settings["time_step"],
        seed=settings["seed"],
        section_block=settings["section_block"],
        section_position=settings["section_position"],
        replicate=range(n_chains),
        initial_spread=1e-3,
        progress=progress or scripting.Progress(f"{settings['n_chains']} chains"),
    )
    attributes = provenance.attributes("catalogue", preset, settings) | {
        "n_blocks": chain.n_blocks,
        "belt_velocity": chain.belt_velocity,
        "noise": chain.noise,
        "section_block": settings["section_block"],
        "section_position": settings["section_position"],
        "n_chains": settings["n_chains"],
    }
    store.write(output, arrays, attributes)


def main(job):
    scripting.use_threads(job.threads)
    catalogue(job.params.settings, job.params.preset, job.output[0])


if __name__ == "__main__":
    scripting.run(main, snakemake)
