"""The reference of results: figures and tables by their entries, claims by the ledger."""

import json
from collections.abc import Iterator
from pathlib import Path

from beltrepro.replication.plan import registry
from beltrepro.replication.verdicts.ledger import load_ledger, read_yaml
from extensions import plain, table, write

PUBLISHED = Path(__file__).parent.parent / "results/paper/figures"


def page() -> str:
    """Every figure by category, every table and every claim."""
    head = "The name of a figure is also its target: `snakemake --cores 2 fig12`."
    parts = ["# Figures, tables and claims", head, "## Figures", *_figures()]
    return "\n\n".join([*parts, "## Tables", *_tables(), "## Claims", *_claims()]) + "\n"


def _figures() -> Iterator[str]:
    """A grid for each category: pictures, each over a line, and folded how to read it."""
    captions = read_yaml("beltrepro.replication.report", "captions.yaml")
    entries = registry.figures()
    for category in registry.CATEGORIES:
        yield f"### {category}"
        yield "`````{container} figures"
        for name, entry in entries.items():
            if entry.category == category:
                number = f"**Fig. {entry.number} of the paper.** " if entry.number else ""
                yield f"````{{container}} figure\n\n({name})="
                if (PUBLISHED / f"{name}.png").exists():
                    options = f":alt: {json.dumps(entry.alt)}\n:target: ../_images/{name}.png"
                    picture = f"../results/paper/figures/{name}.png"
                    yield f"```{{image}} {picture}\n{options}\n```"
                yield number + plain(captions.get(entry.number, entry.title))
                yield f"<details><summary>{name}</summary>"
                title = f"**{plain(entry.title)}** " if number else ""
                yield title + plain(entry.words)
                yield f"{_made_from(entry.uses)}\n\n</details>\n\n````"
        yield "`````"


def _tables() -> Iterator[str]:
    for name, entry in registry.tables().items():
        yield from (f"### tables/{name}.csv", plain(entry.title), _made_from(entry.uses))
        if entry.columns:
            rows = [(f"`{column}`", plain(text)) for column, text in entry.columns.items()]
            yield table(["column", "what it is"], rows)


def _claims() -> Iterator[str]:
    for claim in load_ledger().values():
        yield f"### {claim.id}"
        if claim.says:
            yield f"> {plain(claim.says)}"
        where = f" Figure {claim.figure} of the paper." if claim.figure else ""
        yield plain(claim.statement) + where
        shown = [
            f'<a href="#{name}">{name}</a>'
            for name, entry in registry.figures().items()
            if claim.id in {key.partition(":")[0] for key in entry.shows}
            or str(claim.figure or "") == entry.number != ""
        ]
        if shown:
            yield f"Shown in {', '.join(shown)}."
        for question, criterion in claim.criteria.items():
            allowed = criterion.untestable or f"allowed is {criterion.ranges}"
            words = "; ".join(filter(None, (criterion.how, allowed)))
            yield f"*{question.capitalize()}:* {plain(words)}."
        if claim.needs:
            yield _made_from(claim.needs, "Needs")


def _made_from(names, word: str = "Made from") -> str:
    return f"{word}: {', '.join(f'`{name}`' for name in names) or 'the model alone'}."


def setup(app) -> dict:
    """Called by Sphinx."""
    folder = Path(app.srcdir) / "reference"
    app.connect("builder-inited", lambda _: write(folder, {"results.md": page()}))
    return {"parallel_read_safe": True}
