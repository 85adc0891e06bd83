# What the rules share: the plan made from the configuration, and the functions by which rules ask it.

import atexit
import dataclasses
import functools
import os
import re
import sys
from pathlib import Path

from snakemake.logging import logger

from beltrepro.replication.plan import jobs, lifecycle, snakemake_call
from beltrepro.base import provenance
from beltrepro.replication.plan import files, plan
from beltrepro.replication.plan.films import FILM
from beltrepro.replication.plan import manifest
from beltrepro.base.errors import InputError
from beltrepro.replication.plan.expectations import Expectations
from beltrepro.replication.plan import registry

try:
    PLAN = plan.make_plan(config)
    EXPECTED = Expectations(PLAN)
    FILMED = EXPECTED.filmed
    TABLES = registry.tables()
    FIGURES = registry.figures()
    registry.check_names(PLAN.datasets)
    for entries in (TABLES, FIGURES):
        known = [*PLAN.datasets, *FILMED, *TABLES]
        registry.check_uses(entries, known, f"preset {PLAN.preset}")
    DEPOSITED = manifest.datasets(Path(), PLAN.run)
except InputError as error:
    sys.exit(f"error: {error}")


# Claims take long, and wait for nearly all datasets. So these come first, and figures are drawn
# while claims are measured.
BEFORE_FIGURES = 1


pathvars:
    results=f"results/{PLAN.run}",
    logs=f"results/{PLAN.run}/logs",
    benchmarks=f"results/{PLAN.run}/benchmarks",


wildcard_constraints:
    dataset="|".join(PLAN.datasets),
    batch="[0-9]{4}",
    film="|".join(PLAN.films),
    table="|".join(entry.file(name) for name, entry in TABLES.items()),
    figure="|".join(FIGURES),


# --- files ---


def file_of(name):
    """The file of a dataset or table, or of a film or track."""
    if name in TABLES:
        return f"<results>/{TABLES[name].file(name)}.csv"
    if name in FILMED:
        ending = ".mp4" if name.endswith(FILM) else ".csv"
        return f"<results>/experiment/{FILMED[name].name}{ending}"
    return f"<results>/datasets/{name}.h5"


def dataset_files():
    return [file_of(name) for name in PLAN.datasets]


def filmed(wildcards):
    """The dataset that is filmed, under its name."""
    name = PLAN.films[wildcards.film].dataset
    return {name: file_of(name)}


def joined():
    """Pattern of the datasets that are made here; one that came with an archive is no output."""
    return "|".join(name for name in PLAN.datasets if name not in DEPOSITED) or "(?!)"


def batches(wildcards):
    count = len(PLAN.datasets[wildcards.dataset].batches)
    return [f"<results>/batches/{wildcards.dataset}/{number:04d}.h5" for number in range(count)]


def table_of(wildcards):
    """Name and entry of the table of a file, which may lie at the top of the results."""
    name = Path(wildcards.table).name
    return name, TABLES[name]


def everything():
    """What the target `all` makes: all that is compared and published, so that none stays missing."""
    return [
        *dataset_files(),
        *drawn("png", "pdf"),
        *(path for name in TABLES for path in with_metadata(name)),
        *claims_files(),
        "<results>/report.html",
        "<results>/article.pdf",
    ]


def compared():
    """Tables of claims of other runs: those here, or published in docs/results."""
    found = {}
    for folder in ("docs/results", "results"):
        found |= {path.parent.name: str(path) for path in Path(folder).glob("*/claims.csv")}
    return [path for name, path in sorted(found.items()) if name != PLAN.run]


def table_data(wildcards):
    return {name: file_of(name) for name in table_of(wildcards)[1].uses}


def figure_data(wildcards):
    return {name: file_of(name) for name in FIGURES[wildcards.figure].uses}


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


# Plain tuples: they travel to the script as parameters.
SIMULATION_JOBS = [dataclasses.astuple(job) for job in jobs.simulation_jobs(PLAN)]


def sampled_jobs(wildcards):
    sample = jobs.draw(jobs.simulation_jobs(PLAN), PLAN.seed)
    return [f"<results>/{job.name}.h5" for job in sample]


# --- what a job is told; all of it in params, so that a change reruns the job ---


def told_batch(wildcards):
    return PLAN.told_batch(wildcards.dataset, int(wildcards.batch))


def told_dataset(wildcards):
    return PLAN.told(wildcards.dataset)


def told_film(wildcards):
    return PLAN.films[wildcards.film].told()


def expected_batches(wildcards):
    count = len(PLAN.datasets[wildcards.dataset].batches)
    return [files.expected(PLAN.told_batch(wildcards.dataset, number)) for number in range(count)]


def expected_of_report():
    """By name of the input of the report, and of the figure or dataset in it."""
    return {
        "datasets": EXPECTED.each(*PLAN.datasets),
        **{name: {name: EXPECTED.made_from(*EXPECTED.judged)} for name in ("claims", "estimates")},
        "figures": {name: EXPECTED.made_from(*entry.uses) for name, entry in FIGURES.items()},
        **{name: {name: each} for name, each in EXPECTED.each(*TABLES).items()},
    }


def expected_of_article():
    told = expected_of_report()
    return {name: told[name] for name in ("claims", "estimates", "figures")}


def expected_of_table(wildcards):
    return EXPECTED.each(*table_of(wildcards)[1].uses)


def expected_of_film(wildcards):
    return EXPECTED.each(PLAN.films[wildcards.film].dataset)


def expected_of_figure(wildcards):
    return EXPECTED.made_from(*FIGURES[wildcards.figure].uses)


# --- what each job reads and writes, for the crate ---


def records():
    """Rule, name, inputs and outputs of each job of the run, as deposit.crate.Record has them."""
    for name, dataset in PLAN.datasets.items():
        parts = [f"batches/{name}/{number:04d}" for number in range(len(dataset.batches))]
        paths = [f"<results>/{part}.h5" for part in parts]
        for part, path in zip(parts, paths):
            yield "simulate", part, ["config.yaml"], [path]
        yield "join", f"datasets/{name}", paths, [file_of(name)]
    for name, entry in TABLES.items():
        yield "derive", entry.file(name), list(map(file_of, entry.uses)), with_metadata(name)
    for name, entry in FIGURES.items():
        outputs = [f"<results>/figures/{name}.{kind}" for kind in ("png", "pdf")]
        yield "draw", f"figures/{name}", list(map(file_of, entry.uses)), outputs
    claims = [path for path in claims_files() if path.endswith(".csv")]
    yield "claims", "claims", dataset_files(), claims_files()
    shown = [*dataset_files(), *map(file_of, TABLES), *claims, *drawn("png")]
    yield "report", "report", shown, ["<results>/report.html"]
    told = [*claims, f"{claims[0]}-metadata.json", "CITATION.cff", *drawn("png")]
    yield "article", "article", told, ["<results>/article.pdf"]


def claims_files():
    tables = [f"<results>/{name}.csv" for name in ("claims", "estimates")]
    return [*tables, *(f"{path}-metadata.json" for path in tables)]


def with_metadata(table):
    return [file_of(table), f"{file_of(table)}-metadata.json"]


def told_crate(wildcards):
    """What deposit.crate.Run is made of, as plain values."""
    known = [
        (*names, below_project(inputs), below_project(outputs))
        for *names, inputs, outputs in records()
    ]
    steps = {name: workflow.get_rule(name) for name in dict.fromkeys(each[0] for each in known)}
    return {
        "name": PLAN.run,
        "preset": PLAN.preset,
        "seed": PLAN.seed,
        "rules": {
            name: (each.docstring, f"workflow/scripts/{Path(each.script).name}")
            for name, each in steps.items()
        },
        "records": known,
    }


def below_project(paths):
    return [path.replace("<results>", f"results/{PLAN.run}") for path in paths]


# --- hashes of the code behind a result ---

# Snakemake does not see imported modules. Of a script it compares the time, by which a checkout or a
# clone would make everything anew: profiles/default turns that off.

INTEGRATORS = {
    "verlet": "beltrepro.engine.verlet_integrators",
    "event": "beltrepro.engine.event_integrator",
}


BUILT_ON_EVENT = ("beltrepro.engine.tangent", "beltrepro.engine.kicks")
FOLLOWED = (
    "motion",
    "settling",
    "separation",
)  # kinds whose motion is judged while it is simulated


@functools.cache
def code_hash(*modules, script=None, without=()):
    path = script and Path(workflow.basedir, "workflow", "scripts", script)
    return provenance.code_hash(*modules, script=path, without=without)


# What a job is told says which quantities its points have; the words on them change no number, nor
# does how a run is drawn, written to a file of its own, or kept unfinished.
WORDS = (
    "beltrepro.replication.plan.quantities",
    "beltrepro.simulation.files",
    "beltrepro.simulation.picture",
    "beltrepro.simulation.checkpoints",
)


def batch_code(wildcards):
    """Code behind a batch: its own integrator and kind; what others use does not matter to it."""
    dataset = PLAN.datasets[wildcards.dataset]
    method = dataset.batches[int(wildcards.batch)][0].method
    others = [module for name, module in INTEGRATORS.items() if name != method]
    if method != "event":
        others += BUILT_ON_EVENT
    if dataset.kind.name not in FOLLOWED:
        others += ["beltrepro.chaos", *BUILT_ON_EVENT]
    # of the room of films only its trials are simulated
    others += ["beltrepro.replication.camera"]
    if dataset.kind.name != "trial":
        others += ["beltrepro.replication.camera.trials"]
    return code_hash(
        "beltrepro.replication.plan.running", INTEGRATORS[method], without=(*others, *WORDS)
    )


# The camera is given positions and the tracker a video: the code of simulations does not matter to
# them. Nor does each to the other: the room itself only lists what it has.
def experiment_code(module, script):
    without = ("beltrepro.replication.camera", "beltrepro.simulation.run")
    return code_hash(f"beltrepro.replication.camera.{module}", script=script, without=without)


def table_code(wildcards):
    return code_hash(table_of(wildcards)[1].module, script="derive.py")


def figure_code(wildcards):
    without = ("beltrepro.replication.camera",)
    return code_hash(
        FIGURES[wildcards.figure].module,
        "beltrepro.replication.drawing.style",
        script="figure.py",
        without=without,
    )


# --- beginning, stopping, failing ---

RESULTS = Path(f"results/{PLAN.run}")
WAS_LOCKED = lifecycle.is_locked(RESULTS)
os.environ[lifecycle.PARENT] = str(os.getpid())
shell.prefix(lifecycle.JOB_PREFIX)
lifecycle.shorten(logger)
if workflow.is_main_process:
    lifecycle.stop_at_once(RESULTS)


def begin():
    """Before the first job: take the folder of results, and end at once when told to."""
    try:
        lifecycle.begin(RESULTS, WAS_LOCKED)
    except InputError as error:
        sys.exit(f"error: {error}")
    if workflow.local_exec:
        lifecycle.stop_at_once(RESULTS)  # again: Snakemake has taken SIGTERM
        # Jobs here need no limit on how many start in a second. Its clock would wake the scheduler
        # once a second for each job that has ended: after 100 of them 100 times a second.
        workflow.scheduler.job_rate_limiter = None
    else:
        lifecycle.stop_as_usual()  # it cancels the jobs elsewhere


def say_at_exit(words):
    atexit.register(print, words, file=sys.stderr)


def refuse_unknown_targets():
    """End with one line if a target of the command line is none; when all rules are known."""
    if not workflow.is_main_process:
        return
    targets = [rule.name for rule in workflow.rules if not rule.has_wildcards()]
    others = [rule.name for rule in workflow.rules if rule.has_wildcards()]
    try:
        snakemake_call.check_targets(targets, others, is_made)
    except InputError as error:
        sys.exit(f"error: {error}")


def is_made(path):
    """Whether a rule makes this file; of batches, only those that there are."""
    if path.startswith(f"results/{PLAN.run}/batches/"):
        return path in [f"results/{PLAN.run}/{job.name}.h5" for job in jobs.simulation_jobs(PLAN)]
    came_along = (
        Path(path).stem in DEPOSITED and path == f"results/{PLAN.run}/datasets/{Path(path).name}"
    )
    return came_along or any(rule.is_producer(path) for rule in workflow.rules)


def said_of_failures(logs):
    """What failed jobs wrote in their logs, which Snakemake repeats in its own."""
    text = "".join(Path(log).read_text() for log in logs)
    said = dict.fromkeys(re.findall(r"^[0-9:]+ ERROR (.*)$", text, re.M))
    return "\n".join(f"error: {line}" for line in said)
