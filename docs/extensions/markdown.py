"""Directives whose content is Markdown that a function writes."""

import re
from collections.abc import Callable, Iterable

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective

_MARKS = re.compile(r"[*_<>\[\]#]")


def directive(write: Callable[[], str], *sources: object) -> type[SphinxDirective]:
    """A directive without content that stands for the Markdown which `write` returns.

    sources : files or modules that the page depends on, so that a change of them makes it anew
    """

    class Written(SphinxDirective):
        def run(self) -> list[nodes.Node]:
            for source in sources:
                self.env.note_dependency(str(getattr(source, "__file__", source)))
            lines = StringList(write().splitlines(), source=self.env.docname)
            container = nodes.section()
            container.document = self.state.document
            self.state.nested_parse(lines, 0, container, match_titles=True)
            return container.children

    return Written


def table(heads: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A table in Markdown."""
    heads = list(heads)
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(cell(each) for each in line) + " |" for line in lines)


def cell(value: object) -> str:
    """A value as the text of a cell."""
    return " ".join(str(value).replace("|", "\\|").split())


def plain(text: str) -> str:
    """Words as they are: what Markdown would take for marks stays a letter, but for code."""
    outside = text.split("`")
    outside[::2] = [_MARKS.sub(r"\\\g<0>", words) for words in outside[::2]]
    return "`".join(outside)


def code(value: object) -> str:
    """A name or value in the type of code."""
    return f"`{value}`"
