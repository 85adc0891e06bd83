"""Commands of the results of the workflow: verify, claims."""

import argparse
import shutil
import sys
import textwrap
from collections import Counter
from pathlib import Path

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.base.names import one_of
from beltrepro.cli.options import PLACED, command

_NAMED = 5  # of the files that are not made


@command(
    ("results", Path, PLACED, "folder of a run, as results/smoke"),
    ("list", Path, None, "the list (docs/results/NAME.json, of the same name as the folder)"),
    ("write", bool, False, "write the list from these results instead"),
)
def verify(options: argparse.Namespace) -> int:
    """Check results of the workflow, and compare them with the published list.

    Every dataset and table of a run must be whole, and as the list says: bit by bit if the
    processor, its instructions and the libraries are those of the list, otherwise within bounds
    (docs/trust.md). Exit status 1 if anything is wrong, with a line that says how to repair it, or
    if anything is not made yet.
    """
    from beltrepro.extras import verification

    usual = Path("docs", "results", f"{options.results.name}.json")
    path = checks.path("list", options.list or usual, (".json",))
    if options.write:
        count = verification.write_list(path, options.results)
        print(f"{path}: {count} datasets")
        return 0
    if not options.results.is_dir():
        raise InputError(f"{options.results}: no such folder")
    findings = list(verification.compare(options.results, verification.read_list(path)))
    for finding in findings:
        if finding.words:
            print(f"error: {finding.words}", file=sys.stderr)
    counts = Counter(finding.outcome for finding in findings)
    missing = [finding.name for finding in findings if finding.outcome == verification.MISSING]
    made = len(findings) - len(missing)
    if not made:
        raise InputError(f"{options.results}: nothing of what {path} lists is made there")
    if missing:
        print(f"not made: {', '.join(missing[:_NAMED])}{', ...' * (len(missing) > _NAMED)}")
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    meanings = verification.MEANINGS
    worst = next((outcome for outcome in meanings if counts[outcome]), verification.SAME)
    print(meanings[worst].format(made=made, listed=len(findings)))
    return int(worst in (verification.MISSING, verification.WRONG))


@command(
    ("preset", str, "standard", "run to read: results/NAME (standard)"),
    ("results", Path, None, "another folder than results/NAME"),
)
def claims(options: argparse.Namespace) -> None:
    """Print the verdicts of a run on the claims of the paper.

    Each claim has two, and what was found: whether it is replicated by the authors' protocol, and
    whether it is robust. The files claims.csv and estimates.csv of the run have all numbers.
    """
    from tabulate import tabulate

    from beltrepro.replication.report.claim_results import count, read

    results = read(options.results or _made(options.preset))
    width, rows = max(30, shutil.get_terminal_size((110, 24)).columns - 60), []
    for result in results.values():
        answers = dict.fromkeys(answer.found for answer in result.answers.values())
        sentences = [text for text in answers if text] or [result.claim.statement]
        lines = "\n".join(textwrap.fill(text, width) for text in sentences)
        rows.append((result.id, result.claim.figure, *result.verdicts.values(), lines))
    headers = ("claim", "figure", "replicated", "robust", "what was found")
    print(tabulate(rows, headers=headers, tablefmt="simple"))
    for question, numbers in count(results).items():
        words = ", ".join(f"{number} {verdict}" for verdict, number in numbers.items() if number)
        print(f"\n{question}: {words}", end="")
    print()


def _made(preset: str) -> Path:
    """The folder of a run by the name of its preset."""
    from beltrepro.replication.plan.config import SOURCE, load_config

    folder = Path("results", preset)
    if not folder.exists():
        if Path(SOURCE).exists():
            one_of("preset", preset, load_config(SOURCE).get("presets", {}))
        published = Path("docs", "results", preset)
        other = f"; to read the published one: --results {published}" if published.is_dir() else ""
        raise InputError(
            f"preset = {preset!r}: {folder} is not made yet: "
            f"snakemake --cores 2 --config preset={preset}{other}"
        )
    return folder
