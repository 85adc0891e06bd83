"""The reference of results: figures and tables by their entries, claims by the ledger."""

from beltrepro.replication.plan import registry
from beltrepro.replication.verdicts.ledger import load_ledger
from extensions import markdown


def figure_list() -> str:
    """Every figure by category: its target, what it shows, and what it is drawn from."""
    parts = []
    for category in registry.CATEGORIES:
        parts.append(f"### {category}")
        parts += [
            _figure(name, entry)
            for name, entry in registry.figures().items()
            if entry.category == category
        ]
    return "\n\n".join(parts)


def table_list() -> str:
    """Every table: what it is, what it is derived from, and its columns."""
    parts = []
    for name, entry in registry.tables().items():
        title = markdown.plain(entry.title)
        parts += [f"### {entry.file(name)}.csv", title, _made_from(entry.uses)]
        if entry.columns:
            rows = [(markdown.code(k), markdown.plain(text)) for k, text in entry.columns.items()]
            parts.append(markdown.table(["column", "what it is"], rows))
    return "\n\n".join(parts)


def claim_list() -> str:
    """Every claim: what the paper says, and the criteria that decide."""
    parts = []
    for claim in load_ledger().values():
        where = f" Figure {claim.figure} of the paper." if claim.figure else ""
        quoted = [f"> {markdown.plain(claim.says)}"] if claim.says else []
        parts += [f"### {claim.id}", *quoted, markdown.plain(claim.statement) + where]
        shown = [name for name in registry.figures() if claim.id in _claims(name)]
        parts += [f"Shown in {_links(shown)}."] if shown else []
        for question, criterion in claim.criteria.items():
            allowed = criterion.untestable or f"allowed is {criterion.ranges}"
            words = "; ".join(filter(None, (criterion.how, allowed)))
            parts.append(f"*{question.capitalize()}:* {markdown.plain(words)}.")
        if claim.starts:
            parts.append(f"*On starts at rest:* {markdown.plain(claim.starts)}.")
        if claim.needs:
            parts.append(_made_from(claim.needs, "Needs"))
    return "\n\n".join(parts)


def _figure(name: str, entry: registry.Figure) -> str:
    number = f"Fig. {entry.number}: " if entry.number else ""
    words = f"**{number}{markdown.plain(entry.title)}** {markdown.plain(entry.words)}"
    claims = _claims(name)
    about = [f"Judged with it: {_links(claims)}."] if claims else []
    return "\n\n".join([f"#### {name}", words, *about, _made_from(entry.uses)])


def _claims(figure: str) -> list[str]:
    """Names of the claims of a figure of the paper, or of which a figure shows a number."""
    entry = registry.figures()[figure]
    shown = {key.partition(":")[0] for key in entry.shows}
    return [
        name
        for name, claim in load_ledger().items()
        if name in shown or str(claim.figure or "") == entry.number != ""
    ]


def _links(names: list[str]) -> str:
    return ", ".join(f"[{name}](#{name})" for name in names)


def _made_from(names, word: str = "Made from") -> str:
    listed = ", ".join(map(markdown.code, names)) if names else "the model alone"
    return f"{word}: {listed}."


def setup(app) -> dict:
    """Called by Sphinx."""
    ledger = sorted(registry.STUDIES.rglob("*.yaml"))
    modules = sorted(registry.STUDIES.rglob("*.py"))
    app.add_directive("figure-list", markdown.directive(figure_list, *modules))
    app.add_directive("table-list", markdown.directive(table_list, *modules))
    app.add_directive("claim-list", markdown.directive(claim_list, *ledger))
    return {"parallel_read_safe": True}
