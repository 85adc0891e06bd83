"""Files that cannot say of themselves what they are: beside each lies a JSON file that does.

It follows CSV on the Web (W3C, https://www.w3.org/TR/tabular-metadata/) also for films: NAME.csv
stays plain, NAME.csv-metadata.json has its title, its sources, what made it, and its checksum.
"""

import json
from pathlib import Path
from typing import Any

from beltrepro.base import provenance, reading, seal
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.plan.files import repair


def describe(
    path: Path,
    *,
    title: str,
    sources: dict[str, Any],
    lineage: dict[str, dict] | None = None,
    units: str = "",
    **more: Any,
) -> None:
    """Write beside a file what it is and what made it."""
    about = {
        "@context": "http://www.w3.org/ns/csvw",
        "url": path.name,
        "dc:title": title,
        "dc:source": sources,
        "beltrepro:origin": provenance.origin() | ({"units": units} if units else {}),
        "beltrepro:lineage": lineage or {},
        seal.KEY: seal.digest_of(path)[:16],
        **more,
    }
    with replacing(seal.metadata_path(path)) as unfinished:
        unfinished.write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")


def lineage(path: Path) -> dict[str, dict]:
    """What made the datasets behind a file."""
    about, reason = _about(path)
    if reason:
        raise InputError(f"{path}: {reason}")
    return about["beltrepro:lineage"]


def check(path: Path, expected: dict) -> None:
    """Check that a file is whole and is what it should be."""
    about, reason = _about(path)
    if not reason and about["dc:source"] != json.loads(json.dumps(expected["sources"])):
        reason = "was made from other datasets"
    if reason:
        raise InputError(f"{path}: {reason}; {repair(path, expected)}")


def _about(path: Path) -> tuple[dict[str, Any], str]:
    """What is said of a file, and what is wrong with the file."""
    try:
        seal.check(path)
        about = reading.json_object(seal.metadata_path(path))
        named = about["url"], about[seal.KEY], about["dc:source"]
    except InputError as error:
        return {}, str(error).removeprefix(f"{path}: ")
    except KeyError as error:
        return {}, f"its metadata lack {error}"
    if named[0] != path.name:
        return {}, f"is another file: its metadata are those of {named[0]}"
    if "beltrepro:lineage" not in about:
        return {}, "of an older version, which did not say what made its data: remove it"
    return about, ""
