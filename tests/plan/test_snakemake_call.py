"""What Snakemake is called with: one line for settings and targets that cannot be meant."""

from types import SimpleNamespace

import pytest

from beltrepro.base.errors import InputError
from beltrepro.replication.plan import snakemake_call


def line(error, *words):
    message = str(error)
    assert "\n" not in message
    assert all(word in message for word in words), (words, message)


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("fig12", "snakemake --cores 2 fig12 --config preset=smoke"),
        ("model.friction_ratio=0.6", """--config 'model={"friction_ratio": 0.6}'"""),
        ("presets.own.run=x", """--config 'presets={"own": {"run": "x"}}'"""),
        ("preset=paper", "preset is given twice"),
        ("=3", "'' is no name of a setting"),
        ("1=2", "'1' is no name of a setting"),
        ("run=2026_11_22", "is read as the number 20261122; a name with a letter is needed"),
        ("run=1.10", "is read as the number 1.1;"),
        ("run=01", "is read as the number 1;"),
    ],
)
def test_settings_that_snakemake_cannot_read(entry, words):
    for run in ("run=", "run=f06", "run=6", "run=0.6"):
        snakemake_call.check_settings(["preset=smoke", run])
    with pytest.raises(InputError) as caught:
        snakemake_call.check_settings(["preset=smoke", entry])
    line(caught.value, entry.partition("=")[0], words)


def test_files_of_settings_are_read_before_snakemake_reads_them(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config.yaml").write_text("seed: 1")
    (tmp_path / "more.yaml").write_text("seed: 1\nseed: 2")
    monkeypatch.setattr("sys.argv", ["bin/snakemake", "--configfile", "config.yaml"])
    snakemake_call.end_if_unreadable()
    monkeypatch.setattr("sys.argv", ["bin/snakemake", "--configfile", "config.yaml", "more.yaml"])
    with pytest.raises(SystemExit, match=r"error: more.yaml, line 2: .*'seed' is given twice"):
        snakemake_call.end_if_unreadable()
    monkeypatch.setattr("sys.argv", ["bin/snakemake", "--configfile", "no.yaml", "--cores", "1"])
    with pytest.raises(SystemExit, match=r"error: no\.yaml: no such file"):
        snakemake_call.end_if_unreadable()


@pytest.mark.parametrize(("cores", "nodes", "words"), [
    (0, None, "--cores 0: must be at least 1"), (-1, 2, "--cores -1:"), (None, 0, "--jobs 0:")
])  # fmt: skip
def test_numbers_of_cores_with_which_no_job_begins(cores, nodes, words):
    snakemake_call.check_counts(SimpleNamespace(cores=1, nodes=None))
    with pytest.raises(InputError, match=words):
        snakemake_call.check_counts(SimpleNamespace(cores=cores, nodes=nodes))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["fig2"], "target 'fig2': allowed are files of this run and all, fig12; did you mean"),
        (["--cores", "2", "alll", "--config", "preset=smoke"], "did you mean 'all'?"),
        (["results/no.csv"], "target 'results/no.csv'"),
        (["draw"], "target 'draw'"),
        (["--forcerun", "drew", "--cores", "1"], "did you mean 'draw'?"),
        (["--omit-from", "drew", "--cores", "1"], "did you mean 'draw'?"),
    ],
)
def test_targets_that_are_none(monkeypatch, words, message):
    def check(*called):
        monkeypatch.setattr("sys.argv", list(called))
        snakemake_call.check_targets(["fig12", "all"], ["draw"], lambda path: path == "a/b.csv")

    check("bin/snakemake", "all", "a/b.csv", "./a/b.csv", "--forcerun", "draw")
    check("bin/snakemake", "-n", "--config", "preset=smoke")
    check("bin/pytest", *words)  # another program's words
    with pytest.raises(InputError) as caught:
        check("site-packages/snakemake/__main__.py", *words)
    line(caught.value, message)
