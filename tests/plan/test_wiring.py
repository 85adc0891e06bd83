"""Wiring: each thing that a job is told reaches what it is for."""

import ast
import copy
import re
from pathlib import Path

import numpy as np
import pytest

import small_plans
from beltrepro import simulate
from beltrepro.replication.plan import batch, dependencies, io, kinds
from beltrepro.replication.plan.kinds import KINDS
from beltrepro.replication.plan.points import (
    CHAIN,
    DEFAULTS,
    QUANTITIES,
    columns,
    plain,
    points_of,
)
from beltrepro.replication.plan.points import chain as chain_of
from beltrepro.replication.plan.workflow import BATCH

ROOT = Path(__file__).parents[2]
WORKFLOW = ROOT / "workflow"
FILES, KINDS_OF_DATA = io.__name__, kinds.__name__
OTHER = {  # than those of `planned`, and sensible
    "method": "verlet",
    "samples": ["velocities"],
    "noise_clock": "laboratory",
    "energies": [5.0, 2.0],
    "slips": [4],
    "friction_ratios": [0.7],
    "section_block": 1,
    "section_position": 61.5,
    "weakening_velocity": 500.0,
}


def planned(kind="scan", **keys):
    """A dataset of three points of two sizes, cut into unequal batches."""
    points = {"n_blocks": [2, 3], "belt_velocity": {2: [5, 7], 3: 6}, "noise": 1, "replicate": 2}
    return small_plans.planned(kind, **points | {"initial_spread": 0.5, "points_per_job": 2} | keys)


def changed(spec, name):
    """The same with another value of a quantity or setting."""
    spec = copy.deepcopy(spec)
    part = spec["points"] if name in QUANTITIES else spec["settings"]
    value = part.get(name, DEFAULTS.get(name))
    value = value[0] if name in QUANTITIES and isinstance(value, list) else value
    part[name] = OTHER[name] if name in OTHER else value * 0.5 if value % 1 else value + 1
    if name == "weakening_velocity":
        part["noise"] = 0.0  # with noise event refuses it
    return spec


# --- from the plan to the function of a kind ------------------------------------------------------


@pytest.mark.filterwarnings("ignore:.*repeat another")
@pytest.mark.parametrize("kind", KINDS)
def test_each_quantity_and_setting_reaches_the_function_of_the_kind(kind, monkeypatch):
    calls = []

    def recording(setup, **spec):
        calls.append((setup.cases, spec))
        return {}

    monkeypatch.setattr(batch, "resolve_name", {KINDS[kind].record: recording}.__getitem__)
    plan = planned(kind)
    whole = plan.spec("one") | {"points": plain(plan.datasets["one"].points)}
    names = [*QUANTITIES, *KINDS[kind].settings]
    heard = set()
    for spec in (whole, *(changed(whole, name) for name in names)):
        points = points_of(spec["points"])
        columns = batch.record(KINDS[kind].record, (), points, spec["settings"], progress=print)
        cases, settings = calls[-1]
        assert settings == spec["settings"] | {"progress": print}
        for row, (point, case) in enumerate(zip(points, cases, strict=True)):
            assert all(getattr(case.parameters, name) == getattr(point, name) for name in CHAIN)
            for name in ("method", "time_step", "initial_spread"):
                assert getattr(case, name) == getattr(point, name)
            assert (case.state.seed, case.state.replicate) == (point.seed, point.replicate)
            for name, values in columns.items():
                assert values[row] == getattr(point, name)
        heard.add(repr((spec["settings"], points)))
    assert len(heard) == len(names) + 1


@pytest.mark.parametrize("kind", KINDS)
def test_each_key_of_a_dataset_changes_the_digest_of_its_file(kind, monkeypatch):
    digests: list = []
    place = {"section_position": 61.5} if "section_block" in KINDS[kind].settings else {}
    monkeypatch.setattr(io.store, "write", lambda *file: digests.append(file[2]["digest"]))
    others = {}, {"preset": "further"}, {"name": "two"}
    plans = [planned(kind, **place | other) for other in others]
    spec = plans[0].spec("one")
    for name in (*QUANTITIES, *KINDS[kind].settings):
        if name in place or (name == "method" and KINDS[kind].follows_tangents):
            continue
        if name == "weakening_velocity" or (kind, name) == ("basins", "viscosity"):
            continue  # refused, with noise by event, and of starts of one energy
        part = changed(spec, name)["points" if name in QUANTITIES else "settings"]
        plans.append(planned(kind, **place | {name: part[name]}))
    for plan in plans:
        (name,) = plan.datasets
        io.write("", plan.spec(name), columns(plan.datasets[name].points))
    assert len(set(digests)) == len(digests) > len(QUANTITIES)


def test_series_of_several_sizes_are_the_runs_of_each():
    points = planned("series").datasets["one"].points
    told = {"duration": 40.0, "transient": 5.0, "sample_interval": 0.5}
    kind = KINDS["series"].record, KINDS["series"].recorded
    made = batch.record(*kind, points, told | {"samples": ["positions", "friction"]})
    assert "velocities" not in made
    for row, point in enumerate(points):
        how = {name: getattr(point, name) for name in ("seed", "replicate", "initial_spread")}
        run, n = simulate(chain_of(point), sample_start=5.0, **told, **how), point.n_blocks
        np.testing.assert_array_equal(made["time"], run.time)
        assert made["disorder_parameter"][row] == run.disorder_parameter
        for name in ("positions", "friction"):
            np.testing.assert_array_equal(made[name][row, :, :n], getattr(run, name))
            assert np.isnan(made[name][row, :, n:]).all()
        events = made["events"][made["events"]["point"] == row]
        late = run.events[run.events["time"] >= 5.0]
        assert events[[*late.dtype.names]].tolist() == late.tolist() != []


# --- scripts --------------------------------------------------------------------------------------


def rules():
    """Text of each rule that runs a script, but one without parameters, by name of the script."""
    for path in sorted((WORKFLOW / "rules").glob("*.smk")):
        for rule in re.split(r"^rule ", path.read_text(), flags=re.M)[1:]:
            named = re.search(r'"\.\./scripts/(\w+)\.py"', rule)
            if named and named[1] != "compile":  # which changes no result
                yield named[1], rule


@pytest.mark.parametrize(("name", "rule"), list(rules()), ids=[name for name, _ in rules()])
def test_a_script_reads_each_parameter_of_its_rule_and_no_other(name, rule):
    block = re.search(r"^    params:\n((?:        .*\n)+)", rule, re.M)[1]
    values = set(re.findall(r"^        (\w+)=", block, re.M))
    tree = ast.parse((WORKFLOW / "scripts" / f"{name}.py").read_text())
    bases = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    read = {node.attr for node in bases if ast.unparse(node.value) in ("job.params", "params")}
    whole = values - read - {"code", "shown"}  # of reruns
    assert whole == set(), "never read"
    assert read & {"spec", "settings", "code", "benchmarks"} <= values


@pytest.mark.parametrize(("name", "rule"), list(rules()), ids=[name for name, _ in rules()])
def test_an_edit_of_what_a_script_imports_reruns_its_rule(name, rule):
    graph = dependencies._graph(())
    told = re.findall(r'"(beltrepro\.[\w.]+)"', rule)
    told += [FILES] * ("FILES" in rule) + [BATCH] * ("FLOW.code_of_batch" in rule)
    behind = set(told).union(*map(graph.find_upstream_modules, told))
    tree = ast.parse((WORKFLOW / "scripts" / f"{name}.py").read_text())
    froms = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    pairs = [(node.module, f"{node.module}.{one.name}") for node in froms for one in node.names]
    imported = {name if name in graph.modules else module for module, name in pairs}
    imported &= graph.modules
    # logs are the same for all jobs; a new kind, or words about an array, change no number
    shared = ("beltrepro.base", "beltrepro.replication.plan.scripting")
    kept = {KINDS_OF_DATA, FILES} if name == "simulate" else set()
    assert {module for module in imported if not module.startswith(shared)} <= behind | kept
