"""Write the report."""

from pathlib import Path
from typing import TYPE_CHECKING

from beltrepro import report, scripting

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main(job):
    kinds = ("scans", "series", "catalogues", "ensembles")
    report.render(
        output=Path(job.output[0]),
        figures={Path(path).stem: Path(path) for path in job.input.figures},
        claims_csv=Path(job.input.claims),
        datasets=[Path(path) for kind in kinds for path in job.input[kind]],
        benchmarks=Path(job.params.benchmarks),
        preset=job.params.preset,
        settings=job.params.settings,
        agreement_tables=report.AgreementTables(
            comparisons=Path(job.input.comparisons),
            families=Path(job.input.families),
            partings=Path(job.input.partings),
            convergence=Path(job.input.convergence),
        ),
        agreement_figures={Path(path).stem: Path(path) for path in job.input.agreement_figures},
    )


if __name__ == "__main__":
    scripting.run(main, snakemake)
