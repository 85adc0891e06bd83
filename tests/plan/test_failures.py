"""What is shown of failed jobs, here and on a cluster."""

import logging
from pathlib import Path

import pytest
from beltrepro.replication.plan.failures import Failures

RESULT = "results/smoke/batches/u1/0000.h5"
BEGIN = f"error in rule simulate: the job of {RESULT}"


class Event:
    """As Snakemake's `LogEvent`."""

    def __init__(self, name):
        self.name = name


class Screen:
    """What is shown of what Snakemake's logger is told, and what its own log keeps."""

    def __init__(self, tmp_path: Path):
        self.lines = []
        self.log = tmp_path / "snakemake.log"
        screen = logging.StreamHandler()
        screen.emit = lambda one: self.lines.append(str(one.msg))
        self.logger = logging.Logger("like Snakemake's")
        self.logger.addHandler(screen)
        self.logger.addHandler(logging.FileHandler(self.log))
        self.failures = Failures(self.logger)

    def tell(self, text: str = "", **record) -> list[str]:
        """Lines shown for a record."""
        self.lines.clear()
        self.logger.error(text, extra=record)
        return list(self.lines)

    def exception(self, text: str) -> list[str]:
        return self.tell(f"RuleException:\n{text}", exception="RuleException")

    def job_error(self, *logs: Path, words: str | None = None, indent: bool = False) -> list[str]:
        record = {"rule_name": "simulate", "rule_msg": words, "output": [RESULT], "indent": indent}
        return self.tell("Error in rule", event=Event("JOB_ERROR"), log=[*map(str, logs)], **record)


@pytest.fixture
def screen(tmp_path):
    return Screen(tmp_path)


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "0000.log"
    path.write_text("10:00:00 INFO u1: started\n")
    return path


def test_a_job_that_has_said_why_is_not_explained_again(screen, log):
    log.write_text("10:00:00 ERROR N=5: went wrong\n")
    assert screen.exception("CalledProcessError in file x:\nreturned non-zero exit status 1.") == []
    assert screen.job_error(log) == []
    assert screen.tell("Exiting because a job execution failed. Look above") == []


@pytest.mark.parametrize(
    ("ending", "words"),
    [
        ("died with <Signals.SIGKILL: 9>.", " was killed by SIGKILL, perhaps for want of memory; "),
        ("returned non-zero exit status 137.", " was killed by SIGKILL, perhaps for want of mem"),
        ("died with <Signals.SIGSEGV: 11>.", " was killed by SIGSEGV; run the same command again"),
        ("returned non-zero exit status 143.", " was killed by SIGTERM; run the same command"),
        ("returned non-zero exit status 3.", " ended with status 3 and without a word; see {log}"),
        ("returned non-zero exit status 255.", " ended with status 255 and without a word; see"),
        ("no status", " ended without a word; see {log}"),
    ],
)
def test_a_job_without_a_word_is_one_line_and_only_a_kill_is_want_of_memory(
    screen, log, ending, words
):
    assert screen.exception(f"CalledProcessError in file x, line 3:\nCommand 'y' {ending}") == []
    (line,) = screen.job_error(log)
    assert line.startswith(BEGIN + words.format(log=log))
    assert "\n" not in line
    (line,) = screen.job_error(log)  # the status was that of the job before
    assert "SIG" not in line


def test_what_sbatch_says_is_one_line_also_if_an_earlier_job_wrote_the_log(screen, log):
    said = "SLURM sbatch failed. The error message was 'sbatch: error: invalid partition: no\n"
    said += "sbatch: error: Batch job submission failed'."
    ending = "\n    sbatch call:\n        sbatch -p no\nFor further error details see the log."
    log.write_text("10:00:00 ERROR an earlier one\n")
    (line,) = screen.job_error(log, words=said + ending)
    assert line == f"{BEGIN}: {' '.join(said.split())}"
    assert screen.log.read_text() == "Error in rule\n"  # in its own log, Snakemake says it all


def test_a_job_of_a_cluster_gets_its_line_or_the_words_of_the_cluster(screen, log, tmp_path):
    cluster = tmp_path / "7.log"
    cluster.write_text("Building DAG of jobs...\n")
    state = "SLURM-job '7' failed, SLURM status is: 'CANCELLED'."
    assert screen.job_error(log, cluster, words=state) == [f"{BEGIN}: {state}"]
    cluster.write_text("Building\nerror in rule simulate: N=5: went wrong\n1 of 1 jobs failed\n")
    assert screen.job_error(log, cluster, words=state) == [
        "error in rule simulate: N=5: went wrong"
    ]


def test_a_group_is_one_line(screen, log, tmp_path):
    cluster = tmp_path / "8.log"
    group = {"event": Event("GROUP_ERROR"), "groupid": "join", "job_error_info": [{}, {}, {}]}
    (line,) = screen.tell(aux_logs=[], **group)
    assert line.startswith("error in group join: 3 jobs were not accepted")
    sent = group | {"aux_logs": [str(cluster)], "external_jobid": "8"}
    (line,) = screen.tell(**sent)
    assert line == f"error in group join: 3 jobs, sent as 8, ended without a word; see {cluster}"
    cluster.write_text("error in rule join: u1: two batches are the same\n")
    assert screen.tell(**sent) == ["error in rule join: u1: two batches are the same"]
    assert screen.job_error(log, indent=True) == []  # a job of it


def test_other_words_of_snakemake_stay(screen):
    words = "MissingInputException in rule draw"
    assert screen.tell(words, exception="RuleException") == [words]


def test_at_the_end_each_failure_is_said_once_more(screen, log, tmp_path):
    """What jobs wrote, from Snakemake's log, and the lines of the others."""
    cluster = tmp_path / "9.log"
    cluster.write_text("error in rule simulate: N=5: went wrong\n")
    for _ in range(2):
        screen.job_error(log)
        screen.job_error(log, cluster)
    whole = tmp_path / "whole.log"
    whole.write_text("10:00:00 ERROR N=5: went wrong\n10:00:01 ERROR N=5: went wrong\n")
    assert screen.failures.summary([str(whole)]).splitlines() == [
        "error: N=5: went wrong",
        f"{BEGIN} ended without a word; see {log}",
    ]
