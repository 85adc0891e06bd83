"""Simulate one block of points of a scan and write what was measured at each."""

from typing import TYPE_CHECKING

from beltrepro import ChainParameters, provenance, scripting, store
from beltrepro.simulation import scan

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def scan_block(settings: dict, preset: str, output, progress=None) -> None:
    """Measure the points of a block.

    settings : points [(N, u, sigma), ...], lengths, method, seed, constants; what to record.
    progress : called with the fraction done; a bar or log lines if not given.
    """
    chains = [
        ChainParameters(n_blocks, belt_velocity, noise, **settings["model"])
        for n_blocks, belt_velocity, noise in settings["points"]
    ]
    sections = settings["section_position"]
    arrays = scan(
        chains,
        duration=settings["duration"],
        transient=settings["transient"],
        method=settings["method"],
        time_step=settings["time_step"],
        seed=settings["seed"],
        section_position=[sections[chain.n_blocks] for chain in chains],
        section_values=settings["section_values"],
        laminar_time=settings["laminar_time"],
        progress=progress or scripting.Progress(f"{len(chains)} points"),
    )
    store.write(output, arrays, provenance.attributes("scan", preset, settings))


def main(job):
    scripting.use_threads(job.threads)
    scan_block(job.params.settings, job.params.preset, job.output[0])


if __name__ == "__main__":
    scripting.run(main, snakemake)
