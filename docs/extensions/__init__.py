"""Pages of the reference, written from the code when the site is built."""

import re
from collections.abc import Iterable
from pathlib import Path

_MARKS = re.compile(r"[*_<>\[\]#]")


def write(folder: Path, pages: dict[str, str]) -> None:
    """Write pages by file name. One that is as it was keeps its time: Sphinx reads it once."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def table(heads: list[str], rows: Iterable[Iterable[object]]) -> str:
    """A table in Markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(map(_cell, line)) + " |" for line in lines)


def plain(text: str) -> str:
    """Words as they are: what Markdown would take for marks stays a letter, but for code."""
    outside = " ".join(text.split()).split("`")
    outside[::2] = [_MARKS.sub(r"\\\g<0>", words) for words in outside[::2]]
    return "`".join(outside)


def _cell(value: object) -> str:
    return " ".join(str(value).replace("|", "\\|").split())
