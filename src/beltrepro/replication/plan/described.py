"""Files that cannot say of themselves what they are: beside each lies a JSON file that does.

It follows CSV on the Web (W3C, https://www.w3.org/TR/tabular-metadata/) also for films: NAME.csv
stays plain, NAME.csv-metadata.json has its title, its sources, what made it, and its checksum.
"""

import hashlib
import json
from pathlib import Path
from typing import Any

from beltrepro.base import provenance
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
        "beltrepro:checksum": checksum(path.read_bytes()),
        **more,
    }
    with replacing(metadata_path(path)) as unfinished:
        unfinished.write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")


def origin_of(path: Path) -> dict[str, Any]:
    """What a file says that it is made from, for a file that is made from it alone."""
    about, reason = _about(path)
    if reason:
        raise InputError(f"{path}: {reason}")
    return {"sources": about["dc:source"], "lineage": about["beltrepro:lineage"]}


def lineage(path: Path) -> dict[str, dict]:
    """What made the datasets behind a file."""
    return origin_of(path)["lineage"]


def check(path: Path, expected: dict) -> None:
    """Check that a file is whole and is what it should be."""
    about, reason = _about(path)
    if not reason and about["dc:source"] != json.loads(json.dumps(expected["sources"])):
        reason = "was made from other datasets"
    if reason:
        raise InputError(f"{path}: {reason}; {repair(path, expected)}")


def checksum(content: bytes) -> str:
    """Of the bytes of a file."""
    return hashlib.sha256(content).hexdigest()[:16]


def metadata_path(path: Path) -> Path:
    """Where it is said what a file is: beside it."""
    return path.with_name(f"{path.name}-metadata.json")


def _about(path: Path) -> tuple[dict[str, Any], str]:
    """What is said of a file, and what is wrong with the file."""
    try:
        content = path.read_bytes()
        about = json.loads(metadata_path(path).read_text(encoding="utf-8"))
        known = about["url"], about["beltrepro:checksum"], about["dc:source"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        return {}, f"cannot be read with its metadata ({type(error).__name__})"
    if known[:2] != (path.name, checksum(content)):
        return {}, "damaged, or another file: it does not have its checksum"
    if "beltrepro:lineage" not in about:
        return {}, "of an older version, which did not say what made its data: remove it"
    return about, ""
