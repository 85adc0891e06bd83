"""`beltrepro claims`: the verdicts of a run in the terminal."""

import argparse
import json
import shutil
import textwrap
from collections import Counter
from pathlib import Path
from typing import Any

from beltrepro.errors import InputError


def add(commands: Any) -> None:
    """Add the command.

    Parameters
    ----------
    commands : object
        What `add_subparsers` returns.
    """
    claims = commands.add_parser(
        "claims",
        help="print the verdicts of a run on the claims of the paper",
        description="Print each claim of the paper with its verdict and the numbers it rests on: "
        "95 %% intervals, and in brackets the allowed ranges.",
    )
    option = claims.add_argument
    option("--preset", default="standard", metavar="NAME", help="run to read: results/NAME")
    option("--results", type=Path, metavar="FOLDER", help="another folder than results/NAME")
    option("--verdict", metavar="WORD", help="only claims with this verdict, as fails")
    option("--json", action="store_true", help="print everything as JSON")
    claims.set_defaults(action=run)


def run(options: argparse.Namespace) -> int:
    """Print the table.

    Parameters
    ----------
    options : argparse.Namespace
        Those of the command.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError
        If the run has no claims, or none with the verdict that is asked for.
    """
    folder = options.results or Path("results", options.preset)
    found = _read(folder)
    if options.verdict:
        known = {each["verdict"] for each in found}
        if options.verdict not in known:
            raise InputError(
                f"--verdict {options.verdict}: no claim of {folder} has it; "
                f"they have {', '.join(sorted(known))}"
            )
        found = [each for each in found if each["verdict"] == options.verdict]
    if options.json:
        print(json.dumps(found, indent=1))
        return 0
    print(_table(found))
    counts = Counter(each["verdict"] for each in found)
    print("\n" + ", ".join(f"{count} {verdict}" for verdict, count in counts.most_common()))
    return 0


def _read(folder: Path) -> list[dict[str, Any]]:
    """Claims in the reading that counts, each with its numbers under `estimates`."""
    import pandas as pd

    paths = [folder / f"{name}.csv" for name in ("claims", "estimates")]
    for path in paths:
        if not path.is_file():
            raise InputError(
                f"{path}: no such file; `snakemake --cores 2 claims --config preset=...` makes it"
            )
    table = pd.read_csv(paths[0], dtype=str, keep_default_na=False)
    numbers = pd.read_csv(paths[1], dtype={"variant": str}).fillna({"variant": ""})
    numbers = numbers.drop(columns="variant")[numbers["variant"] == ""]
    of_claim = {
        name: json.loads(own.drop(columns="id").to_json(orient="records"))
        for name, own in numbers.groupby("id")
    }
    counted = table[table["variant"] == ""].drop(columns="variant").to_dict("records")
    return [row | {"estimates": of_claim.get(row["id"], [])} for row in counted]


def _table(claims: list[dict[str, Any]]) -> str:
    from tabulate import tabulate

    width = max(30, shutil.get_terminal_size((110, 24)).columns - 50)
    rows = [
        (
            each["id"],
            each["figure"],
            each["verdict"],
            "\n".join(line for part in _parts(each) for line in textwrap.wrap(part, width)),
        )
        for each in claims
    ]
    return tabulate(rows, headers=("claim", "figure", "verdict", "measured"), tablefmt="simple")


def _parts(claim: dict[str, Any]) -> list[str]:
    """One line for each number, or the reason where there are none."""
    from beltrepro.claims.criteria import range_in_words

    allowed = {
        each[
            "name"
        ]: f" [{range_in_words([_end(each['allowed_low']), _end(each['allowed_high'], 1)])}]"
        for each in claim["estimates"]
        if each["verdict"]
    }
    parts = claim["measured"].split("; ") if claim["measured"] else [claim["note"]]
    return [part + allowed.get(part.rpartition(": ")[0], "") for part in parts]


def _end(value: float | None, sign: float = -1.0) -> float:
    """An end of a range; JSON has none for infinity."""
    return sign * float("inf") if value is None else value
