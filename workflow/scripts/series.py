"""Simulate one trajectory and write its samples and events after the transient."""

from typing import TYPE_CHECKING

from beltrepro import ChainParameters, provenance, scripting, store
from beltrepro.simulation import simulate

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def series(settings: dict, preset: str, output, progress=None) -> None:
    """Sample one trajectory.

    settings : n_blocks, belt_velocity, noise, lengths, sample_interval, method, seed, constants.
    progress : called with the fraction done; a bar or log lines if not given.
    """
    chain = ChainParameters(
        settings["n_blocks"], settings["belt_velocity"], settings["noise"], **settings["model"]
    )
    run = simulate(
        chain,
        duration=settings["duration"],
        transient=settings["transient"],
        method=settings["method"],
        time_step=settings["time_step"],
        seed=settings["seed"],
        sample_interval=settings["sample_interval"],
        sample_start=settings["transient"],
        progress=progress or scripting.Progress(chain.describe()),
    )
    arrays = {
        "time": run.time,
        "positions": run.positions,
        "velocities": run.velocities,
        "friction": run.friction,
        "events": run.events[run.events["time"] >= settings["transient"]],
    }
    attributes = provenance.attributes("series", preset, settings) | {
        "n_blocks": chain.n_blocks,
        "belt_velocity": chain.belt_velocity,
        "noise": chain.noise,
        "sample_interval": settings["sample_interval"],
        "disorder_parameter": run.disorder_parameter,
        "mean_length": run.mean_length,
        "energy_residual": run.energy_residual,
    }
    store.write(output, arrays, attributes)


def main(job):
    scripting.use_threads(job.threads)
    series(job.params.settings, job.params.preset, job.output[0])


if __name__ == "__main__":
    scripting.run(main, snakemake)
