"""JavaScript outside a page, by Node or, where that is not installed, by the browser."""

import json
import shutil
import subprocess
from pathlib import Path

import browser

NODE = shutil.which("node") or ""
MISSING = "" if NODE or browser.BROWSER else "neither Node nor Chromium is installed"


def value(script: str, folder: Path):
    """What the function `answer` is given by a script."""
    if NODE:
        call = "const answer = (value) => console.log(JSON.stringify(value));"
        done = subprocess.run(
            [NODE, "-e", call + script], capture_output=True, text=True, timeout=120, check=True
        )
        return json.loads(done.stdout)
    return browser.answer(script, folder)
