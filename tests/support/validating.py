"""Validate the crate of a run against its profile, without the network.

    .venv-deposit/bin/python tests/validating.py results/smoke

roc-validator reads the terms of RO-Crate from the network, or from its cache. They are put into a
cache here, from the library rocrate: its version in requirements-deposit.in has those of 1.1.
"""

import json
import subprocess
import sys
import tempfile
from importlib.resources import files
from pathlib import Path

from requests import Request
from requests_cache import CachedRequest, CachedResponse, CachedSession

TERMS = "https://w3id.org/ro/crate/1.1/context"
PROFILE = "provenance-run-crate"


def fill(cache: Path) -> None:
    """Put the terms into a cache, as if they had been read from the network."""
    text = files("rocrate").joinpath("data/ro-crate.jsonld").read_bytes()
    assert json.loads(text)["@id"] == TERMS, "rocrate has the terms of another version"
    answer = CachedResponse(
        status_code=200,
        url=TERMS,
        request=CachedRequest.from_request(Request("GET", TERMS).prepare()),
        headers={"Content-Type": "application/ld+json"},
    )
    answer._content = text  # as requests itself sets it
    CachedSession(str(cache), backend="sqlite").cache.save_response(answer)


def main(crate: Path, *options: str) -> int:
    """Exit status of the validator: 0 if the crate is valid."""
    with tempfile.TemporaryDirectory() as place:
        cache = Path(place) / "cache"
        fill(cache)
        command = [Path(sys.executable).with_name("rocrate-validator"), "--no-interactive"]
        settings = ["--offline", "--cache-path", cache, "--profile-identifier", PROFILE]
        return subprocess.run([*command, "validate", *settings, *options, crate]).returncode


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), *sys.argv[2:]))
