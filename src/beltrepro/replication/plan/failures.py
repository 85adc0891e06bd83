"""What is shown of failed jobs: one line each, and all lines once more at the end of the run."""

import logging
import re
import signal
from collections.abc import Iterable
from pathlib import Path
from typing import Any

# Where executors on a cluster end, and Snakemake or the whole command of sbatch begins.
_REST_OF_WORDS = re.compile(r"For further error details|\n\s*sbatch (call|script):")
_STATUS = re.compile(r"non-zero exit status (\d+)|died with <Signals\.\w+: (\d+)>")
_SIGNALS = {128 + one: one.name for one in signal.Signals}  # by exit status, as a shell has it
_ENDINGS = (
    "Exiting because a job execution failed",
    "WorkflowError:\nAt least one job did not complete",
)


class Failures:
    """The lines of failed jobs, which replace on the screen what Snakemake says of them.

    Snakemake's log keeps all that it says.
    """

    def __init__(self, logger: logging.Logger) -> None:
        self._lines: list[str] = []
        for handler in logger.handlers:
            if not isinstance(handler, logging.FileHandler):
                handler.addFilter(_Brief(handler, self._lines))

    def summary(self, logs: Iterable[str]) -> str:
        """What failed jobs wrote in their logs, which Snakemake repeats in its own, and the lines.

        A job that wrote why it failed may have a line, too, with the same words.
        """
        text = "".join(Path(log).read_text(encoding="utf-8", errors="replace") for log in logs)
        said = list(dict.fromkeys(re.findall(r"^[0-9:]+ ERROR (.*)$", text, re.M)))
        rest = [line for line in self._lines if not any(words in line for words in said)]
        return "\n".join([*(f"error: {words}" for words in said), *dict.fromkeys(rest)])


class _Brief(logging.Filter):
    """Shows a line of each failed job instead of what Snakemake says of it."""

    def __init__(self, handler: logging.Handler, lines: list[str]) -> None:
        super().__init__()
        self._handler = handler
        self._lines = lines
        self._status: dict[int | None, int] = {}  # of the job that ended last in a thread

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a record is shown as it is."""
        event = getattr(getattr(record, "event", None), "name", "")
        if event in ("JOB_ERROR", "GROUP_ERROR"):
            line = self._of_job(record) if event == "JOB_ERROR" else _of_group(record)
            if line:
                self._lines.append(line)
                shown = record.__dict__ | {"msg": line, "event": None}
                self._handler.handle(logging.makeLogRecord(shown))
            return False
        text = str(record.msg)
        if getattr(record, "exception", "") == "RuleException" and "CalledProcessError" in text:
            if status := _STATUS.search(text):
                self._status[record.thread] = int(status[1] or 0) or 128 + int(status[2])
            return False
        return not text.startswith(_ENDINGS)

    def _of_job(self, record: Any) -> str:
        """The line of a job; empty if the job, or a line of its group, has said it."""
        status = self._status.pop(record.thread, None)  # the record before, of the same job
        if record.indent:
            return ""
        words = " ".join(_REST_OF_WORDS.split(record.rule_msg or "")[0].split())
        if line := _line_in(record.log):
            return line
        if not words and _is_said(record.log):
            return ""
        begin = f"error in rule {record.rule_name}: the job of {record.output[0]}"
        if words:
            return f"{begin}: {words}"
        return f"{begin} {_ending(status, record.log)}"


def _of_group(record: Any) -> str:
    """The line of jobs that were one job on a cluster."""
    line = _line_in(record.aux_logs)
    if line:
        return line
    begin = f"error in group {record.groupid}: {len(record.job_error_info)} jobs"
    if not hasattr(record, "external_jobid"):
        return f"{begin} were not accepted; `snakemake --verbose` shows how they were sent"
    logs = ", ".join(record.aux_logs)
    return f"{begin}, sent as {record.external_jobid}, ended without a word; see {logs}"


def _ending(status: int | None, logs: list[str]) -> str:
    """How a process ended that said nothing, and what to do."""
    if name := _SIGNALS.get(status or 0):
        memory = ", perhaps for want of memory" if name == "SIGKILL" else ""
        return f"was killed by {name}{memory}; run the same command again"
    how = "ended" if status is None else f"ended with status {status} and"
    return f"{how} without a word; see {', '.join(logs)}"


def _line_in(logs: list[str]) -> str:
    """The first line of a job in the log of a cluster: there Snakemake runs in Snakemake."""
    lines = re.findall(r"^error in rule .*$", "\n".join(map(_text, logs)), re.M)
    return lines[0] if lines else ""


def _is_said(logs: list[str]) -> bool:
    """Whether a job has written in its log why it failed."""
    return any(" ERROR " in _text(log) for log in logs)


def _text(log: str) -> str:
    try:
        return Path(log).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
