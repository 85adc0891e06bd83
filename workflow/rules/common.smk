# What the rules share: the plan made from the configuration, and the functions by which rules ask it.

import dataclasses
import functools
import sys

from beltrepro import config as configuration
from beltrepro import jobs, provenance
from beltrepro.errors import InputError
from beltrepro.figures import registry


def files_of_figures(plan):
    """Files that a figure can be drawn from, by the names in its entry."""
    files = {
        f"slips_{name}" if kind == "catalogues" else name: f"<results>/{kind}/{name}.h5"
        for kind in configuration.KINDS
        for name in getattr(plan, kind)
    }
    return files | {
        f"{part}_{role}": f"<results>/agreement/{part}/{role}.h5"
        for part in configuration.PARTS
        for role in configuration.ROLES
    }


try:
    schema = configuration.load(workflow.source_path("../schemas/config.schema.yaml"))
    PLAN = configuration.make_plan(config, schema)
    FIGURES = registry.entries()
    registry.check_uses(files_of_figures(PLAN), f"presets.{PLAN.preset}")
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
    figure="|".join(FIGURES),
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
    """Datasets and tables of a figure, by name."""
    files = files_of_figures(PLAN)
    return {name: files[name] for name in FIGURES[wildcards.figure].uses}


def drawn(*kinds, category=None):
    """Files of all figures, or of those of one category: kinds "png", "pdf"."""
    return [
        f"<results>/figures/{name}.{kind}"
        for name, entry in FIGURES.items()
        if category in (None, entry.category)
        for kind in kinds
    ]


def of_figure(field):
    """What the entry of the figure says under this name, for a directive."""
    return lambda wildcards: getattr(FIGURES[wildcards.figure], field)


def figure_labels(wildcards):
    return {"figure": wildcards.figure, "title": FIGURES[wildcards.figure].title}


def agreement_files():
    return [
        f"<results>/agreement/{part}/{role}.h5"
        for part in configuration.PARTS
        for role in configuration.ROLES
    ]


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
    "verlet": "beltrepro.engine.verlet_ensemble",
    "event": "beltrepro.engine.event_ensemble",
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


def figure_code(wildcards):
    return code_hash(f"beltrepro.figures.{wildcards.figure}", "beltrepro.figures.style")
