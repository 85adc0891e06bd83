"""Pages in a headless browser: how wide they are, and what an accessibility check says of them."""

import html
import json
import re
import shutil
import subprocess
from importlib import resources
from pathlib import Path

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), "")


def widths(page: str, folder: Path, width: int) -> dict:
    """How wide a page of this width is, and the elements that stick out of it.

    Elements within a box that scrolls by itself do not count.
    """
    frame = (
        f'<iframe id="frame" width="{width}" height="800" srcdoc="{html.escape(page)}"></iframe>'
    )
    script = """
      frame.onload = () => {
        const root = frame.contentDocument.documentElement;
        const scrolled = (each) => each.closest(".wide") && !each.matches(".wide");
        for (const each of root.querySelectorAll("details")) each.open = true;
        const out = [...root.querySelectorAll("body *")].filter(
          (each) => each.getBoundingClientRect().right > root.clientWidth + 1 && !scrolled(each));
        answer({asked: root.clientWidth, needed: root.scrollWidth,
                out: out.map((each) => each.outerHTML.slice(0, 120))});
      };"""
    return _ask(f"<!DOCTYPE html><body>{frame}<script>{_FUNCTION}{script}</script>", folder)


def violations(page: str, folder: Path) -> list[dict]:
    """What axe finds wrong with a page: rule, and the first element that breaks it."""
    axe = resources.files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8")
    script = """
      for (const each of document.querySelectorAll("details")) each.open = true;
      axe.run(document).then((found) => answer(found.violations.map(
        (each) => ({rule: each.id, help: each.help, count: each.nodes.length,
                    first: each.nodes[0].html.slice(0, 200)}))));"""
    end = f"<script>{axe}</script><script>{_FUNCTION}{script}</script></body>"
    return _ask(page.replace("</body>", end), folder)


_FUNCTION = """
  function answer(found) {
    const place = document.createElement("pre");
    place.id = "seen";
    place.textContent = JSON.stringify(found);
    document.documentElement.replaceChildren(place);
  }
"""


def _ask(page: str, folder: Path):
    path = folder / "asked.html"
    path.write_text(page, encoding="utf-8")
    # what moves would move all the time that the page is given
    return seen(path.as_uri(), folder, "--window-size=1300,900", "--force-prefers-reduced-motion")


def seen(address: str, folder: Path, *flags: str):
    """What the scripts of a page leave in its element `seen`; no other host is reached."""
    call = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"]
    call += ["--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1", *flags]
    call += ["--virtual-time-budget=60000", f"--user-data-dir={folder / 'browser'}"]
    call += ["--dump-dom", address]
    done = subprocess.run(call, capture_output=True, text=True, timeout=300, check=True)
    text = re.search(r'<pre id="seen">(.+?)</pre>', done.stdout, re.S)
    assert text, done.stderr[-2000:]
    return json.loads(html.unescape(text[1]))
