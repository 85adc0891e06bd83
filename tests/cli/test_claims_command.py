"""`beltrepro claims`: the verdicts of a run in the terminal."""

import json
import os
import subprocess
import sys

import pytest
from test_claims import SETTINGS

from beltrepro.cli import app as cli
from beltrepro.replication.studies.every_claim import measure


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """What a run without datasets leaves: only what the model alone decides is measured."""
    folder = tmp_path_factory.mktemp("results")
    found = measure({}, SETTINGS)
    for name in ("claims", "estimates"):
        getattr(found, name).to_csv(folder / f"{name}.csv", index=False)
    return folder


@pytest.fixture(autouse=True)
def wide_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "110")


def printed(capsys, *words):
    status = cli.main(["claims", *map(str, words)])
    return status, capsys.readouterr()


def test_the_table_has_every_claim_with_its_numbers(capsys, results):
    status, said = printed(capsys, "--results", results)
    assert status == 0
    lines = said.out.splitlines()
    units = next(line for line in lines if line.startswith("units"))
    assert "holds" in units and "time_s: 0.07648 [0.07645 to 0.07655]" in units
    assert any("no force with undeformed springs: yes [yes]" in line for line in lines)
    assert any(line.startswith("u-critical") and "not measured" in line for line in lines)
    assert lines[-1].endswith("4 holds")


@pytest.mark.parametrize("words", [["--json"], ["--verdict", "holds"]])
def test_a_reader_that_has_gone_is_no_error(results, words):
    """As after `beltrepro claims | head`; much and little output."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "beltrepro", "claims", "--results", str(results), *words]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True)
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, "")


def test_json_has_intervals_and_ranges(capsys, results):
    _, said = printed(capsys, "--results", results, "--json", "--verdict", "holds")
    found = {each["id"]: each for each in json.loads(said.out)}
    assert set(found) == {"units", "friction-constants", "spring-law", "setup"}
    (force,) = (each for each in found["units"]["estimates"] if each["name"] == "force_N")
    assert force["low"] == force["value"] == force["high"]
    assert force["allowed_low"] < force["value"] < force["allowed_high"]
    assert force["verdict"] == "holds"


def test_what_is_not_there_is_named(capsys, results, tmp_path):
    status, said = printed(capsys, "--results", tmp_path)
    assert status == 2 and "claims.csv: no such file" in said.err
    status, said = printed(capsys, "--results", results, "--verdict", "fails")
    assert status == 2 and "--verdict fails: no claim" in said.err
    assert "they have holds, not measured" in said.err
