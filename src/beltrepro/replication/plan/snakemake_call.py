"""What Snakemake was called with: one line for settings and targets that cannot be meant.

Snakemake itself answers `--config preset=smoke fig12` with a traceback, and a misspelt target with
a line that suggests nothing. It gives no hook for either: a setting is read before the Snakefile,
and the targets are known after it. So the command line is read once more, by Snakemake's parser.
"""

import argparse
import json
import os
import re
import signal
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from beltrepro.base.errors import InputError
from beltrepro.base.names import hint
from beltrepro.replication.plan.config import SOURCE, load_config

_SETTING = r"[a-zA-Z_][\w-]*\w"  # names that Snakemake takes


def end_if_unreadable() -> None:
    """End the process with one line if a setting of `--config`, or a file of them, is unreadable.

    The profiles of the workflow call it: Snakemake reads nothing else of a workflow so early.
    """
    options = _options()
    try:
        check_settings(options.config or ())
        for path in [*filter(os.path.exists, [SOURCE]), *(options.configfile or ())]:
            load_config(path)  # Snakemake would take some that hold no settings
    except InputError as error:
        sys.exit(f"error: {error}")


def end_quietly_when_interrupted() -> None:
    """Let Ctrl-C end the process without a traceback until the workflow takes it over.

    The profiles call it, too. `lifecycle.stop_at_once` comes after it.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def check_settings(entries: Iterable[str]) -> None:
    """Refuse what Snakemake cannot read as a setting."""
    names: set[str] = set()
    for entry in entries:
        entry = " ".join(entry.split())
        name, equals, value = entry.partition("=")
        if name in names:
            raise InputError(f"--config {entry}: {name} is given twice")
        names.add(name)
        if not equals:
            raise InputError(
                f"--config {entry}: NAME=VALUE is needed; targets stand before --config, as in "
                f"snakemake --cores 2 {entry} --config preset=smoke"
            )
        if name == "run" and (read := _as_number(value)) not in ("", value):
            raise InputError(
                f"--config {entry}: is read as the number {read}; a name with a letter is needed"
            )
        if re.fullmatch(_SETTING, name):
            continue
        first, *keys = name.split(".")
        if keys and all(re.fullmatch(_SETTING, key) for key in (first, *keys)):
            meant = _plain(value)
            for key in reversed(keys):
                meant = {key: meant}
            right = f"--config '{first}={json.dumps(meant)}'"
            raise InputError(f"--config {entry}: a key below another is given as {right}")
        raise InputError(f"--config {entry}: {name!r} is no name of a setting")


def check_counts(resources: Any) -> None:
    """Refuse a number of cores or jobs with which no job would ever begin."""
    for name, count in (("cores", resources.cores), ("jobs", resources.nodes)):
        if count is not None and count < 1:
            raise InputError(f"--{name} {count}: must be at least 1")


def end_if_unknown(rules: Iterable[Any], is_file: Callable[[str], bool]) -> None:
    """End the process with one line if the command line asks for what the workflow lacks."""
    rules = list(rules)
    targets = [rule.name for rule in rules if not rule.has_wildcards()]
    others = [rule.name for rule in rules if rule.has_wildcards()]
    try:
        check_targets(targets, others, is_file)
    except InputError as error:
        sys.exit(f"error: {error}")


def check_targets(
    targets: Iterable[str], chosen: Iterable[str], is_file: Callable[[str], bool]
) -> None:
    """Refuse targets that the workflow does not have.

    Nothing is refused where the workflow was not started from the command line.
    """
    options, targets = _options(), sorted(targets)
    chosen_rules = (options.forcerun, options.until, options.omit_from, options.prioritize)
    asked = [(name, targets) for name in sorted(options.targets)]
    rules = [*targets, *chosen]
    asked += [(name, rules) for names in chosen_rules for name in sorted(names or ())]
    for name, allowed in asked:
        if name not in allowed and not is_file(os.path.relpath(name or os.curdir)):
            raise InputError(
                f"target {name!r}: allowed are files of this run and {', '.join(allowed)}"
                f"{hint(name, allowed)}"
            )


def _options() -> argparse.Namespace:
    """The command line, as Snakemake's parser reads it."""
    from snakemake.cli import get_argument_parser

    # the command, or python -m snakemake; a program that uses Snakemake has other words there
    is_command = "snakemake" in Path(sys.argv[0]).parts[-2:]
    return get_argument_parser().parse_known_args(sys.argv[1:] if is_command else [])[0]


def _as_number(value: str) -> str:
    """What Snakemake makes of a text that it takes for a number; empty if it does not."""
    for number in (int, float):
        try:
            return str(number(value))
        except ValueError:
            continue
    return ""


def _plain(value: str) -> object:
    """The value of a setting as JSON has it, or as text."""
    try:
        return json.loads(value)
    except ValueError:
        return value
