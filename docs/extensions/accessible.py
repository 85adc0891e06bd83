"""What the theme leaves out for readers without a mouse or screen.

What scrolls can be reached by key, the two sidebars have names, and every heading has its level.
"""

from pathlib import Path

_MENDED = {
    "<pre>": '<pre tabindex="0">',
    '<div class="table-wrapper ': '<div tabindex="0" class="table-wrapper ',
    '<div class="math-wrapper ': '<div tabindex="0" class="math-wrapper ',
    '<p class="caption" role="heading">': '<p class="caption" role="heading" aria-level="2">',
    '<div id="search-results"></div>': '<h1>Search</h1><div id="search-results"></div>',
    '<aside class="sidebar-drawer">': '<aside class="sidebar-drawer" aria-label="Pages">',
    '<aside class="toc-drawer">': '<aside class="toc-drawer" aria-label="On this page">',
}


def mend(app, failure) -> None:
    """Mend each page that was written."""
    if failure or app.builder.format != "html":
        return
    for page in Path(app.outdir).rglob("*.html"):
        before = after = page.read_text(encoding="utf-8")
        for words, mended in _MENDED.items():
            after = after.replace(words, mended)
        if after != before:
            page.write_text(after, encoding="utf-8")


def setup(app):
    """Register with Sphinx."""
    app.connect("build-finished", mend)
    return {"parallel_read_safe": True}
