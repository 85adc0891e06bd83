"""What figures, tables, claims and the report are made from: files that are read and checked."""

import json
from functools import partial
from pathlib import Path
from typing import Any

from beltrepro.base import provenance, seal
from beltrepro.base.errors import InputError
from beltrepro.base.store import Dataset
from beltrepro.replication.plan import described, files
from beltrepro.replication.plan.kinds import FILM, TRACK


def load(paths: dict[str, str | Path], expected: dict[str, dict]) -> dict:
    """Read datasets (.h5), tables (.csv) and what the virtual experiment made."""
    return {name: _read(name, Path(path), expected) for name, path in paths.items()}


def lineage(paths: dict[str, str | Path], data: dict) -> dict[str, dict]:
    """What made the datasets behind a figure or table, to be written into it."""
    origins: dict[str, dict] = {}
    for name, content in data.items():
        if isinstance(content, Dataset):
            origins[name] = _origin(content.attributes)
        else:
            origins |= described.lineage(Path(paths[name]))
    return dict(sorted(origins.items()))


def check(path: str | Path, expected: dict) -> None:
    """Check that a file of results is whole and is what it should be."""
    path = Path(path)
    if path.suffix == ".h5":
        files.read(path, expected)
    elif path.suffix == ".png":
        _check_figure(path, expected)
    else:
        described.check(path, expected)


def source(expected: dict) -> str:
    """What the PNG of a figure says that it is drawn from."""
    return f"{expected['preset']}, {expected['run']}, {files.digest(expected)}"


def _origin(attributes: dict) -> dict:
    texts = ("config", "library_versions")  # JSON
    return {
        name: json.loads(attributes[name]) if name in texts else attributes[name]
        for name in ("digest", "config", *provenance.origin())
    }


def _read(name: str, path: Path, expected: dict[str, dict]) -> Any:
    if path.suffix == ".h5":
        dataset = files.read(path, expected[name])
        return files.single_run(dataset) if files.is_single_run(dataset) else dataset
    if name in expected:
        described.check(path, expected[name])
    if name.endswith(FILM):
        from beltrepro.replication.camera.video import read_video

        return partial(read_video, path)
    if name.endswith(TRACK):
        from beltrepro.replication.camera.track import Track

        return Track.load(path)
    from beltrepro.replication.plan import tables  # most figures need none, and no pandas

    return tables.read(path)


def _check_figure(path: Path, expected: dict) -> None:
    from PIL import Image  # only the report looks at figures

    try:
        seal.check(path)
        with Image.open(path) as image:
            said = image.info.get("Title"), image.info.get("Source")
            image.verify()  # those of older runs have no seal
            reason = ""
    except InputError as error:
        raise InputError(f"{error}; {files.repair(path, expected)}") from None
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        reason = f"not a whole PNG ({error})"
    if not reason and said != (path.stem, source(expected)):
        reason = f"another figure, {said[0]} of {said[1]}"
    if reason:
        raise InputError(f"{path}: {reason}; {files.repair(path, expected)}")
