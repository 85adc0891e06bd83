"""The code behind a job: what an edit reruns, and what it does not."""

from pathlib import Path

import pytest

from beltrepro.replication.plan import dependencies, registry
from beltrepro.replication.plan.workflow import BATCH

ROOT = Path(__file__).parents[2]
BOTH = "scan event verlet"
SCRIPT = ROOT / "workflow" / "scripts" / "simulate.py"
FILES = "beltrepro.replication.plan.io"
REPORT, CLAIMS = "beltrepro.replication.report.page", "beltrepro.replication.studies.every_claim"
JOBS = {
    **{
        f"scan {' '.join(names)}": ((BATCH, "beltrepro.simulation.scans"), names)
        for names in (("event",), ("verlet",), ("event", "verlet"))
    },
    "join": ((FILES,), ()),
    "fig12": ((FILES, registry.figures()["fig12"].module), ()),
    "claims": ((FILES, CLAIMS), ()),
    "report": ((REPORT,), ()),
}


def hashes():
    return {
        name: dependencies.code_hash(
            *modules, script=SCRIPT, methods=methods, words=REPORT in modules
        )
        for name, (modules, methods) in JOBS.items()
    }


BATCHES, READERS = {name for name in JOBS if "scan" in name}, {"join", "fig12", "claims", "report"}
STUDY = "replication/studies/transition"


@pytest.mark.parametrize(
    ("file", "old", "new", "reruns"),
    [
        ("engine/event.py", b"(", b"(1 + ", {"scan event", BOTH}),
        ("engine/leaps.py", b"(", b"(1 + ", {"scan verlet", BOTH}),
        ("engine/noise.py", b"(", b"(1 + ", {"scan event", "scan verlet", BOTH}),
        (f"{STUDY}/figures.py", b"(", b"(1 + ", {"fig12"}),
        (f"{STUDY}/words.yaml", b"critical", b"decisive", {"report"}),
        (f"{STUDY}/claims.yaml", b"paper", b"print", {"fig12", "claims", "report"}),
        ("replication/drawing/beltrepro.mplstyle", b"", b"font.size: 8", {"fig12"}),
        ("replication/plan/batch.py", b"(", b"(1 + ", BATCHES),
        ("replication/plan/points.py", b"(", b"(1 + ", {*BATCHES, *READERS}),
        ("replication/plan/io.py", b"(", b"(1 + ", READERS),
        ("replication/plan/kinds.py", b"(", b"(1 + ", READERS),
        ("replication/plan/lock.py", b"(", b"(1 + ", set()),
        ("simulation/artists.py", b"(", b"(1 + ", {"fig12"}),
        ("simulation/plots.py", b"(", b"(1 + ", set()),
    ],
)
def test_an_edit_reruns_what_depends_on_it_and_nothing_else(monkeypatch, file, old, new, reruns):
    before, content = hashes(), dependencies._content.__wrapped__
    edited = dependencies.ROOT / file
    assert old in edited.read_bytes()
    dependencies.code_hash.cache_clear()

    def read(path):
        return content(path).replace(old, new, 1) if path == edited else before_edit(path)

    before_edit = dependencies._content
    monkeypatch.setattr(dependencies, "_content", read)
    try:
        after = hashes()
    finally:
        dependencies.code_hash.cache_clear()
    changed = {name for name in before if before[name] != after[name]}
    if file.startswith("engine/"):  # of claims and the report: those that look at trajectories
        changed -= {"claims", "report"}
    assert changed == reruns


def test_comments_and_docstrings_do_not_count(tmp_path):
    read = dependencies._content.__wrapped__
    one, other = tmp_path / "one.py", tmp_path / "other.py"
    one.write_text('"""A."""\ndef f(x):\n    """B."""\n    # c\n    return x\n')
    other.write_text("def f(x): return x\n")
    assert read(one) == read(other)
    other.write_text("def f(x): return x + 1\n")
    assert read(one) != read(other)
