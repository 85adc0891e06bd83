"""The code behind a job: what an edit reruns, and what it does not."""

import re
from pathlib import Path

import pytest

from beltrepro.replication.plan import dependencies, registry
from beltrepro.replication.plan.kinds import KINDS

ROOT = Path(__file__).parents[2]
BOTH = "scan event verlet"
SCRIPT = ROOT / "workflow" / "scripts" / "simulate.py"
REPORT, CLAIMS = "beltrepro.replication.report.page", "beltrepro.replication.studies.every_claim"
JOBS = {
    **{
        f"scan {' '.join(names)}": ("beltrepro.simulation.scans", names)
        for names in (("event",), ("verlet",), ("event", "verlet"))
    },
    "join": ("beltrepro.replication.plan.io", ()),
    "fig12": (registry.figures()["fig12"].module, ()),
    "claims": (CLAIMS, ()),
    "report": (REPORT, ()),
}


def hashes():
    return {
        name: dependencies.code_hash(module, script=SCRIPT, methods=methods, words=module == REPORT)
        for name, (module, methods) in JOBS.items()
    }


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


def test_every_module_behind_a_job_is_there():
    rules = "".join(path.read_text() for path in (ROOT / "workflow").rglob("*.smk"))
    named = set(re.findall(r'"(beltrepro\.[\w.]+)"', rules)) | set(
        dependencies.INTEGRATORS.values()
    )
    named |= {kind.record.partition(":")[0] for kind in KINDS.values()} | {dependencies.KINDS}
    assert len(named) > 10 and named <= dependencies._graph("").modules
