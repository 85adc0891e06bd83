# What the rules share: the plan made from the configuration, and the functions by which rules ask it.

import dataclasses
import functools
import sys

from beltrepro import config as configuration
from beltrepro import jobs, provenance
from beltrepro.errors import InputError

try:
    schema = configuration.load(workflow.source_path("../schemas/config.schema.yaml"))
    PLAN = configuration.make_plan(config, schema)
except InputError as error:
    sys.exit(f"error: {error}")


pathvars:
    results=f"results/{PLAN.preset}",
    logs=f"results/{PLAN.preset}/logs",
    benchmarks=f"results/{PLAN.preset}/benchmarks",


wildcard_constraints:
    scan="|".join(PLAN.scans),
    series="|".join(PLAN.series),
    catalogue="|".join(PLAN.catalogues),
    ensemble="|".join(PLAN.ensembles),
    figure="|".join(PLAN.figures),
    part="|".join(configuration.PARTS),
    role="|".join(configuration.ROLES),
    block="[0-9]{4}",
    member="[0-9]{4}",


# --- files ---


def dataset_file(kind, name):
    return f"<results>/{kind}/{name}.h5"


def datasets_by_kind():
    """All datasets of the preset, as named inputs `scans`, `series`, ..."""
    kinds = configuration.KINDS
    return {kind: [dataset_file(kind, name) for name in getattr(PLAN, kind)] for kind in kinds}


def scan_blocks(wildcards):
    count = len(PLAN.scans[wildcards.scan].blocks)
    return [f"<results>/blocks/{wildcards.scan}/{block:04d}.h5" for block in range(count)]


def ensemble_members(wildcards):
    count = len(PLAN.ensembles[wildcards.ensemble].belt_velocities)
    return [f"<results>/ensembles/{wildcards.ensemble}/{member:04d}.h5" for member in range(count)]


def figure_data(wildcards):
    """Datasets of a figure, by name."""
    return {name: dataset_file(kind, name) for kind, name in PLAN.figures[wildcards.figure].uses}


def figure_images(wildcards):
    return [f"<results>/figures/{figure}.png" for figure in PLAN.figures]


def figure_files(wildcards):
    return [
        f"<results>/figures/{figure}.{kind}" for figure in PLAN.figures for kind in ("png", "pdf")
    ]


AGREEMENT_FIGURES = ("trajectories", "disorder", "attractors")


def agreement_part(wildcards):
    """Runs of one part of the comparison, by role of the integrator."""
    return {role: f"<results>/agreement/{wildcards.part}/{role}.h5" for role in configuration.ROLES}


def agreement_files():
    return [
        f"<results>/agreement/{part}/{role}.h5"
        for part in configuration.PARTS
        for role in configuration.ROLES
    ]


def agreement_figure_files(wildcards):
    return [
        f"<results>/figures/agreement_{part}.{kind}"
        for part in AGREEMENT_FIGURES
        for kind in ("png", "pdf")
    ]


def agreement_images(wildcards):
    return [f"<results>/figures/agreement_{part}.png" for part in AGREEMENT_FIGURES]


# Plain tuples: they travel to the script as parameters.
SIMULATION_JOBS = [dataclasses.astuple(job) for job in jobs.simulation_jobs(PLAN)]


def sampled_jobs(wildcards):
    sample = jobs.draw(jobs.simulation_jobs(PLAN), PLAN.seed)
    return [f"<results>/{job.name}.h5" for job in sample]


# --- what a job is told; all of it in params, so that a change reruns the job ---


def block_settings(wildcards):
    scan = PLAN.scans[wildcards.scan]
    settings = scan.block_settings(int(wildcards.block))
    sizes = sorted({n_blocks for n_blocks, *_ in settings["points"]})
    numerics = PLAN.numerics
    recording = {
        "laminar_time": numerics.laminar_time,
        "section_values": numerics.section_values,
        "section_position": {n_blocks: numerics.section_position[n_blocks] for n_blocks in sizes},
    }
    return PLAN.constants | recording | settings


def scan_settings(wildcards):
    return PLAN.constants | PLAN.scans[wildcards.scan].settings()


def series_settings(wildcards):
    return PLAN.constants | PLAN.series[wildcards.series].settings()


def catalogue_settings(wildcards):
    return PLAN.constants | PLAN.catalogues[wildcards.catalogue].settings()


def member_settings(wildcards):
    ensemble = PLAN.ensembles[wildcards.ensemble]
    recording = {"laminar_time": PLAN.numerics.laminar_time}
    return PLAN.constants | recording | ensemble.member_settings(int(wildcards.member))


def ensemble_settings(wildcards):
    return PLAN.constants | PLAN.ensembles[wildcards.ensemble].settings()


def agreement_settings(wildcards):
    numerics = PLAN.numerics
    recording = {
        "laminar_time": numerics.laminar_time,
        "section_values": numerics.section_values,
    }
    settings = (
        PLAN.constants | recording | PLAN.agreement.run_settings(wildcards.part, wildcards.role)
    )
    if wildcards.part == "disorder":
        sizes = settings["n_blocks"]
        positions = {n_blocks: numerics.section_position[n_blocks] for n_blocks in sizes}
        settings |= {"section_position": positions}
    return settings


# --- hashes of the code behind a result: Snakemake does not see imported modules ---

INTEGRATORS = {
    "verlet": "beltrepro.engine.verlet_integrators",
    "event": "beltrepro.engine.event_integrator",
}


@functools.cache
def code_hash(*modules, without=()):
    return provenance.code_hash(*modules, without=without)


def simulation_code(method, *more):
    """Code behind a simulation with one integrator; the other one does not matter to it."""
    others = tuple(module for name, module in INTEGRATORS.items() if name != method)
    return code_hash("beltrepro.simulation", INTEGRATORS[method], *more, without=others)


def block_code(wildcards):
    return simulation_code(block_settings(wildcards)["method"])


def series_code(wildcards):
    return simulation_code(PLAN.series[wildcards.series].method)


def catalogue_code(wildcards):
    return simulation_code(PLAN.catalogues[wildcards.catalogue].method)


def member_code(wildcards):
    return simulation_code(PLAN.ensembles[wildcards.ensemble].method)


def agreement_run_code(wildcards):
    more = ["beltrepro.analysis.steps"] if wildcards.part == "trajectories" else []
    return simulation_code(PLAN.agreement.methods[wildcards.role], *more)


def agreement_figure_code(wildcards):
    return code_hash(f"beltrepro.figures.agreement_{wildcards.part}", "beltrepro.figures.style")


def figure_code(wildcards):
    return code_hash(f"beltrepro.figures.{wildcards.figure}", "beltrepro.figures.style")
