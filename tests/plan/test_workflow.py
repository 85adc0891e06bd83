"""The workflow: targets, reruns after a change of code, errors, and (slow) the smoke preset."""

import contextlib
import logging
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import snakemake_calls
from beltrepro.base import seal, store
from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.cli import app as cli
from beltrepro.replication.plan import lock, registry, scripting
from beltrepro.replication.plan.config import load_config
from beltrepro.replication.plan.plan import FIRST_BATCH, Plan, make_plan
from beltrepro.replication.plan.points import points_of
from beltrepro.replication.plan.workflow import BATCH, RunProgress, Workflow
from interruptions import copy_of_project

ROOT = Path(__file__).parents[2]
CONFIG = load_config(ROOT / "config.yaml")
FIGURES = registry.figures()
TABLES = registry.tables()


def snakemake(tree: Path, *arguments: str, settings=("preset=smoke",)):
    """The finished process of Snakemake on a copy of the project, with the package of that copy."""
    return snakemake_calls.call(tree, *arguments, "--config", *settings)


def jobs(dry_run: subprocess.CompletedProcess) -> dict[str, int]:
    """Number of jobs by rule that a dry run announces."""
    assert dry_run.returncode == 0, dry_run.stderr
    table = re.search(r"^job +count\n[- ]+\n(.*?)^total ", dry_run.stdout, re.M | re.S)
    rows = table[1].splitlines() if table else ()
    return {name: int(count) for name, count in map(str.split, rows)}


def smoke_plan() -> Plan:
    return make_plan(CONFIG | {"preset": "smoke"})


def drawn(dry_run: subprocess.CompletedProcess) -> set[str]:
    """Figures that a dry run would draw."""
    return set(re.findall(r": Drawing (\w+)", dry_run.stdout))


def simulated(dry_run: subprocess.CompletedProcess) -> set[str]:
    """Batches that a dry run would simulate."""
    result = re.findall(r": Simulating (?:batch (\d+) of )?(\S+)", dry_run.stdout)
    return {f"{dataset}/{number or FIRST_BATCH}" for number, dataset in result}


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    return copy_of_project(tmp_path_factory.mktemp("project"))


@pytest.fixture(scope="module")
def finished(tree):
    """The same, as after a complete run: every file is there (but empty) and known to Snakemake."""
    rows = snakemake(tree, "--summary", "all").stdout.splitlines()
    header, *others = (row.split("\t") for row in rows if "\t" in row)
    for row in others:
        path = tree / row[header.index("output_file")]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    done = snakemake(tree, "--touch", "--forceall", "--cores", "1", "all")
    assert done.returncode == 0, done.stderr
    return tree


# --- targets ---


def test_every_target_dry_runs_in_the_folder_of_the_run(tree):
    targets = [*FIGURES, "figures", "claims", "report", "all"]
    dry_run = snakemake(tree, "--dry-run", *targets, settings=["preset=standard", "run=f06"])
    count = jobs(dry_run)
    assert all(count[target] == 1 for target in targets)
    assert count["draw"] == len(FIGURES)
    assert count["derive"] == len(TABLES)
    assert "results/f06/report.html" in dry_run.stdout
    assert "results/standard/" not in dry_run.stdout


@pytest.mark.slow
def test_lint_is_clean(tree):
    faults = re.findall(r"^ +\* (.+)$", snakemake(tree, "--lint").stderr, re.M)
    # jobs run in the environment that starts Snakemake
    assert {*faults} == {"Specify a conda environment or container for each rule.:"}


# --- reruns: which code is behind which job is told by test_dependencies ---


@contextlib.contextmanager
def edited(path, old="return ", new="return 0 or "):
    """A file with its last occurrence of a text replaced."""
    text = path.read_text()
    path.write_text(new.join(text.rsplit(old, 1)))
    yield
    path.write_text(text)


@pytest.mark.thorough
@pytest.mark.parametrize("compiling", ["30.0", "31.0"])
def test_an_edited_kernel_reruns_the_batches_by_it(finished, compiling):
    """Also if what compiles the kernels is edited, for which batches do not wait."""
    package = finished / "src/beltrepro"
    cache = edited(package / "extras/cache.py", "30.0", compiling)
    with cache, edited(package / "engine/event_integrator.py"):
        dry_run = snakemake(finished, "--dry-run")
    plan = smoke_plan()
    assert jobs(dry_run)["film"] == len(plan.films)
    assert not drawn(dry_run) & {"fig01", "fig06", "fig11"} and len(drawn(dry_run)) > 20
    by_event = {
        f"{name}/{batch}"
        for name, dataset in plan.datasets.items()
        for batch, points in dataset.batches.items()
        if "event" in {point.method for point in points}
    }
    # by verlet, but what says how long their motion is irregular can also follow `event`
    settling = {f"survival_scheme/{FIRST_BATCH}"}
    assert simulated(dry_run) == by_event | settling


STUDY = "src/beltrepro/replication/studies/transition"
MAIN = "run(main", "run(0 or main"


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("place", "edit", "rules", "figures"),
    [
        (f"{STUDY}/figures.py", (), {"draw", "report"},
         {"fig11", "fig12", "critical_velocity"}),
        (f"{STUDY}/words.yaml", ("from other starts", "from other ones"), {"report"}, set()),
        ("workflow/scripts/join.py", MAIN,
         {"join", "derive", "draw", "claims", "report"}, None),
    ],
)  # fmt: skip
def test_an_edit_reruns_what_uses_it_and_no_simulation(finished, place, edit, rules, figures):
    with edited(finished / place, *edit):
        dry_run = snakemake(finished, "--dry-run")
    assert set(jobs(dry_run)) - {"all"} == rules
    assert figures is None or drawn(dry_run) == figures


@pytest.mark.thorough
def test_touched_file_without_a_change_reruns_nothing_and_a_deleted_one_its_job(finished):
    """As after a checkout: all files of the project but the results are younger than these."""
    for folder in ("src", "workflow"):
        for path in (finished / folder).rglob("*.*"):
            path.touch()
    (finished / "config.yaml").touch()
    assert jobs(snakemake(finished, "--dry-run", "all")) == {}
    (finished / "results/smoke/datasets/survival_many.h5").unlink()
    count = jobs(snakemake(finished, "--dry-run"))
    assert count["join"] == 1 and "simulate" not in count


def test_a_batch_names_its_points_its_integrators_and_the_code_behind_both(monkeypatch):
    flow = Workflow(CONFIG | {"preset": "smoke"})
    monkeypatch.setattr(flow, "code", lambda *names, **how: (names, how["methods"]))
    single, used = flow.of_one_batch().split("|"), set()
    for name, dataset in flow.plan.datasets.items():
        assert (name in single) == (len(dataset.batches) == 1)
        for batch, points in dataset.batches.items():
            about = {"dataset": name} | ({} if name in single else {"batch": batch})
            wildcards = SimpleNamespace(**about, get=about.get)
            methods = tuple(sorted({point.method for point in points}))
            assert points_of(flow.points(wildcards)) == list(points)
            assert [Path(path).stem for path in flow.kernels(wildcards)] == [*methods]
            assert flow.code_of_batch(wildcards) == (
                ("simulate", BATCH, dataset.kind.record),
                methods,
            )
            used.add(methods)
    assert used == {("event",), ("verlet",), ("event", "verlet")}


# --- what is seen on a terminal ---


def test_one_line_tells_jobs_and_figures_that_are_ready(capsys):
    shown = RunProgress()
    for about in (
        {"event": "progress", "done": 0, "total": 3},
        {"event": "job_info", "rule_name": "draw", "jobid": 7, "wildcards": {"figure": "fig12"}},
        {"event": "job_info", "rule_name": "join", "jobid": 8, "wildcards": {"dataset": "u1"}},
        {"event": "job_finished", "job_id": 8},
        {"event": "job_finished", "job_id": 7},
        {"event": "progress", "done": 3, "total": 3},
    ):
        shown.emit(logging.makeLogRecord(about))
    line = capsys.readouterr().err.split("\r")[-1]
    assert "3 of 3 jobs" in line and "figures: 1, last fig12" in line and line.endswith("\n")


# --- two at once ---


@pytest.mark.thorough
def test_a_second_run_is_refused_in_one_line(tree):
    target = "results/held/datasets/u20.h5"
    settings = ["preset=smoke", "run=held"]
    lock.take(tree / "results" / "held")
    done = snakemake(tree, "--cores", "1", target, settings=settings)
    assert done.returncode == 1
    errors = [line for line in done.stderr.splitlines() if "rror" in line]
    assert errors == [
        "error: results/held: another run is at work there; wait for its end or give this one a "
        "name: --config run=NAME"
    ]
    assert not (tree / target).exists()
    # looking is allowed, and Snakemake's lock is not taken
    assert jobs(snakemake(tree, "--dry-run", target, settings=settings)) != {}
    assert list((tree / ".snakemake" / "locks").glob("*")) == []


# --- errors ---


NEGATIVE = 'presets={"smoke": {"datasets": {"n5_map": {"belt_velocity": -3}}}}'
MISSPELT = 'presets={"smoke": {"datasets": {"n5_u7": {"also": {"belt_velosity": 1}}}}}'


def wrong_calls():
    """Which values of settings are bad, and what is said of each: test_config."""
    smoke = "preset=smoke"
    yield pytest.param([], [smoke, NEGATIVE], "must be greater than 0")
    for case in (
        ([], [smoke, MISSPELT], "did you mean 'belt_velocity'?"),
        (["fig2"], [smoke], "did you mean 'fig22'?"),
        ([], [smoke, "fig12"], "targets stand before it: snakemake --cores 2 fig12 --config"),
        (["--configfile", "missing.yaml"], [smoke], "missing.yaml: no such file"),
        (["--configfile", "twice.yaml"], [smoke], "twice.yaml, line 2: the key 'seed' is given"),
    ):
        yield pytest.param(*case, marks=pytest.mark.thorough)


@pytest.mark.parametrize(("arguments", "settings", "words"), list(wrong_calls()))
def test_a_wrong_call_is_one_line(tree, arguments, settings, words):
    (tree / "twice.yaml").write_text("seed: 1\nseed: 2\n")
    done = snakemake(tree, "--dry-run", *arguments, settings=settings)
    lines = [line for line in done.stderr.splitlines() if not line.startswith(("Using", "Config"))]
    assert done.returncode == 1
    assert len(lines) == 1 and lines[0].startswith("error: ") and words in lines[0], done.stderr
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.thorough
def test_a_path_that_is_no_text_is_one_line(tmp_path):
    tree = copy_of_project(Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff")))
    done = subprocess.run(
        [sys.executable, "-m", "snakemake", "--dry-run"],
        **{"cwd": tree, "env": os.environ | {"PYTHONPATH": str(tree / "src")}},
        **{"capture_output": True, "text": True},
    )
    assert done.returncode == 1
    assert done.stderr.splitlines()[1:] == [
        f"error: {str(tree)!r}: the path of the project must be text in UTF-8"
    ]


@pytest.mark.thorough
def test_a_failed_job_is_one_line_and_once_more_at_the_end(tree):
    """A dataset is a folder, which no job can read."""
    (tree / "results/failing/datasets/u1.h5/in").mkdir(parents=True)
    done = snakemake(tree, "--cores", "1", "fig08", settings=["preset=smoke", "run=failing"])
    errors = [line for line in done.stderr.splitlines() if line.lower().startswith("error")]
    assert done.returncode == 1
    assert [line.partition(": ")[0] for line in errors] == ["error in rule draw", "error"]
    assert errors[0].partition(": ")[2] == errors[1].partition(": ")[2]
    assert "Traceback" not in done.stderr and "CalledProcessError" not in done.stderr


@pytest.mark.thorough
@pytest.mark.parametrize("redirected", ["", "<&- >&- 2>&-"])
def test_a_job_is_done_whatever_it_inherits(tmp_path, redirected):
    """As from a notebook, a service or a debugger, in a folder with letters that mean something."""
    tree = tmp_path / "-{a} %s 'b' \"ü\" $c;d*"
    tree.mkdir()
    copy_of_project(tree)
    inherited = {
        **{"MPLBACKEND": "module://matplotlib_inline.backend_inline", "HOME": "/dev/null"},
        **{"NUMBA_DISABLE_JIT": "1", "PYTHONWARNINGS": "error", "SOURCE_DATE_EPOCH": "today"},
        **{"OMP_NUM_THREADS": "1", "PYTHONHASHSEED": "7", "NO_COLOR": "1", "COLUMNS": "wide"},
        **{"TMPDIR": "/none", "LC_ALL": "C", "GIT_DIR": "/none"},
    }
    words = ["bash", "-c", f'umask 077; "$@" {redirected}', "", sys.executable, "-m", "snakemake"]
    done = subprocess.run(
        [*words, "--cores", "1", "fig07", "--config", "preset=smoke"],
        **{"cwd": tree, "env": os.environ | {"PYTHONPATH": str(tree / "src")} | inherited},
        **{"capture_output": True, "text": True},
    )
    assert done.returncode == 0, done.stderr
    assert seal.check(tree / "results/smoke/figures/fig07.png")


@pytest.fixture
def job(tmp_path):
    log = [str(tmp_path / "logs" / "job.log")]
    yield SimpleNamespace(log=log, output=[], rule="simulate", threads=1)
    logging.captureWarnings(False)
    logging.basicConfig(force=True)


@pytest.mark.parametrize(
    ("error", "words", "is_expected"),
    [
        (InputError("N=5, u=1: went wrong"), "N=5, u=1: went wrong", True),
        (ModelStateError("N=5: broke"), "N=5: broke", True),
        (ZeroDivisionError("oops\nand"), "ZeroDivisionError: oops (traceback in {log})", False),
    ],
)
def test_an_error_of_a_job_is_one_line_and_in_its_log(job, error, words, is_expected):
    def main(job):
        raise error

    with pytest.raises(SystemExit) as caught:
        scripting.run(main, job)
    assert caught.value.code == f"error in rule simulate: {words.format(log=job.log[0])}"
    first, *others = Path(job.log[0]).read_text().splitlines()
    assert words.partition(" (")[0] in first and is_expected == (others == [])
    assert is_expected or "Traceback" in str(others)


# --- the whole, slow ---


@pytest.fixture(scope="module")
def smoke(tree):
    """Results of the smoke preset, made in the copy of the project."""
    shutil.rmtree(tree / "results", ignore_errors=True)
    command = [sys.executable, "-m", "snakemake", "--cores", "2", "--config", "preset=smoke"]
    environment = os.environ | {"PYTHONPATH": str(tree / "src")}
    done = subprocess.run(command, cwd=tree, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return tree / "results" / "smoke"


@pytest.mark.slow
@pytest.mark.parametrize("name", FIGURES)
def test_smoke_draws_every_figure(smoke, name):
    from matplotlib.image import imread

    image = imread(smoke / "figures" / f"{name}.png")[..., :3]
    assert min(image.shape[:2]) > 300
    ink = (image < 0.9).any(axis=-1)
    assert 0.005 < ink.mean() < 0.95
    assert (smoke / "figures" / f"{name}.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.slow
def test_smoke_has_nothing_left_to_do(tree, smoke):
    assert jobs(snakemake(tree, "--dry-run")) == {}


@pytest.mark.slow
def test_smoke_has_the_numbers_of_the_published_list(smoke, capsys):
    """On a like machine the same bits; elsewhere within the bounds of docs/workflow.md."""
    status = cli.main(["verify", str(smoke), "--list", str(ROOT / "docs/results/smoke.json")])
    assert status == 0, capsys.readouterr()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["n5_columns", "pairs_paths_event", "slips_u1"])
def test_a_dataset_does_not_depend_on_how_it_is_cut_and_on_the_cores(tree, smoke, name):
    target = f"results/smoke/datasets/{name}.h5"
    whole = store.read(tree / target).arrays
    cut = f'presets={{"smoke": {{"datasets": {{"{name}": {{"points_per_job": 5}}}}}}}}'
    done = snakemake(tree, "--cores", "1", target, settings=["preset=smoke", cut])
    assert done.returncode == 0, done.stdout + done.stderr
    batches = list((tree / f"results/smoke/batches/{name}").glob("*.h5"))
    assert len(batches) > len(smoke_plan().datasets[name].batches)
    for array, values in store.read(tree / target).arrays.items():
        np.testing.assert_array_equal(values, whole[array], err_msg=array)
