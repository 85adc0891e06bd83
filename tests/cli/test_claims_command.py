"""`beltrepro claims`: the verdicts of a run in the terminal."""

import os
import re
import subprocess
import sys

import pytest

import made_up_results
from beltrepro.cli import app as cli
from beltrepro.replication.report.claim_results import count, read

GIVEN = {"u-critical": {"replicated": "yes", "robust": "open"}, "outliers": "missing"}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    made_up_results.write(folder, dict.fromkeys(made_up_results.load_ledger(), "yes") | GIVEN)
    return folder


@pytest.fixture(autouse=True)
def wide_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")


def printed(capsys, *words):
    status = cli.main(["claims", *map(str, words)])
    return status, capsys.readouterr()


def test_the_table_has_both_verdicts_of_every_claim(capsys, results):
    status, said = printed(capsys, "--results", results)
    assert status == 0
    lines, claims = said.out.splitlines(), read(results)
    rows = {line.split()[0]: line for line in lines if line and line.split()[0] in claims}
    assert list(rows) == list(claims)
    for name, words in (("u-critical", "yes +open"), ("r-jump", "yes +yes")):
        assert re.search(rf"^{name} +\d+ +{words} ", rows[name])
    assert f"replicated: {count(claims)['replicated']['yes']} yes" in said.out


def test_a_reader_that_has_gone_is_no_error(results):
    """As after `beltrepro claims | head`."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "beltrepro", "claims", "--results", str(results)]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True)
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, "")


def test_what_is_not_there_is_named(capsys, results, tmp_path, monkeypatch):
    folder = tmp_path / "docs/results/paper"
    folder.mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    (folder / "claims.csv").write_text("id,variant,verdict\nu-critical,,holds\n")
    (folder / "estimates.csv").write_text("id,variant,name\nu-critical,,a\n")
    (tmp_path / "config.yaml").write_text("presets: {paper: {}}")
    for words, messages in (
        (["--preset", "papr"], ["'papr': allowed are paper; did you mean 'paper'?"]),
        (["--results", tmp_path], ["claims.csv: no such file"]),
        (["--results", folder], ["made by an earlier version"]),
        (["--preset", "paper"], ["--config preset=paper", "--results docs/results/paper"]),
    ):
        status, said = printed(capsys, *words)
        assert status == 2 and all(message in said.err for message in messages)
