"""The live chain: its scheme against that of the library, and its page in a browser."""

import json
import shutil
import subprocess
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

import browser
import pages
from beltrepro import ChainParameters, ChainState, simulate
from beltrepro.model import section_position
from beltrepro.replication.report.page import live_chain

FOLDER = resources.files("beltrepro.replication.report") / "live"
SETTINGS = live_chain()["settings"]
LOW = next(preset["start"] for preset in SETTINGS["presets"] if "start" in preset)

NODE = shutil.which("node") or ""
needs_javascript = pytest.mark.skipif(not NODE, reason="Node is not installed")


def computed(script):
    """What a script with the functions of chain.js answers."""
    chain = (FOLDER / "chain.js").read_text(encoding="utf-8")
    given = f"const law = {json.dumps(SETTINGS['law'])}, low = {json.dumps(LOW)};"
    given += "const answer = (value) => console.log(JSON.stringify(value));"
    call = [NODE, "-e", chain + given + script]
    done = subprocess.run(call, capture_output=True, text=True, timeout=120, check=True)
    return json.loads(done.stdout)


def scheme(parameters, start=None, duration=20.0):
    options = {"initial_state": start} if start else {}
    return simulate(
        parameters, duration=duration, sample_interval=1.0, method="verlet", **options
    ).positions[1:]


@needs_javascript
def test_the_page_and_the_library_take_the_same_steps():
    """Positions over 20 units of time to 1e-9: from rest, of other chains, and in motion."""
    chains = [(5, 1.0, 0.45), (5, 7.0, 0.45), (3, 17.0, 0.6), (10, 17.0, 0.45), (1, 9.0, 0.3)]
    script = """
      const path = (chain) =>
        Array.from({ length: 20 }, () => (chain.advance(1000), chain.positions()));
      const at = (blocks, velocity, ratio, start) =>
        path(new Chain({ blocks, velocity, noise: 0, ratio }, law, start));
      answer([%s.map((chain) => at(...chain)), at(5, 15, 0.45, low)]);
    """
    at_rest, in_motion = computed(script % json.dumps(chains))
    for (blocks, velocity, ratio), path in zip(chains, at_rest, strict=True):
        expected = scheme(ChainParameters(blocks, velocity, friction_ratio=ratio))
        assert np.abs(np.array(path) - expected).max() < 1e-9
    chain = ChainParameters(5, 15.0)
    start = ChainState.in_motion(chain, LOW["positions"], LOW["velocities"])
    assert np.abs(np.array(in_motion) - scheme(chain, start)).max() < 1e-9


@needs_javascript
def test_with_noise_r_is_that_of_the_library():
    """Means over runs with noise of their own agree within three standard errors."""
    runs, transient, duration = 12, 100, 400
    script = """
      answer(Array.from({ length: %d }, (_, seed) => {
        const chain = new Chain({ blocks: 3, velocity: 9, noise: 3, ratio: 0.45 }, law, {}, seed);
        const record = new Record(chain);
        record.transient = %d;
        record.advance(%d);
        return [record.spread.r, record.section.length];
      }));
    """
    live = np.array(computed(script % (runs, transient, 1000 * duration)))
    options = {"duration": duration, "transient": transient, "method": "verlet"}
    options["replicate"] = range(2 * runs)
    chains = simulate([ChainParameters(3, 9.0, 3.0)] * (2 * runs), **options)
    library = np.array([run.disorder_parameter for run in chains])
    error = np.hypot(*(np.std(r, ddof=1) / np.sqrt(r.size) for r in (live[:, 0], library)))
    assert abs(live[:, 0].mean() - library.mean()) < 3 * error < 0.1 * library.mean()
    assert np.ptp(live[:, 0]) > 0 and np.all(live[:, 1] > 5)


@needs_javascript
def test_amplitudes_and_deviates():
    script = """
      const wave = (i) => 7 + 3 * Math.cos(2 * Math.PI * 5 * i / 64) + i % 2;
      const values = Array.from({ length: 64 }, (_, i) => wave(i));
      const normals = new Normals(3);
      answer([[...amplitudes(values)], Array.from({ length: 20000 }, () => normals.next()),
              [1, 5, 10].map((blocks) => sectionPosition(blocks, 0.45, law))]);
    """
    shown, normals, sections = computed(script)
    expected = np.zeros(31)
    expected[4] = 3.0
    np.testing.assert_allclose(shown, expected, atol=1e-12)
    normals = np.array(normals)
    assert abs(normals.mean()) < 0.03 and abs(normals.var() - 1) < 0.05
    assert abs(np.mean(normals**4) - 3) < 0.3 and abs(np.mean(normals[1:] * normals[:-1])) < 0.03
    assert sections == [section_position(ChainParameters(n, 1.0)) for n in (1, 5, 10)]


@pytest.mark.skipif(not browser.BROWSER, reason="no Chromium is installed")
def test_the_page_works(tmp_path):
    """Presets, sliders, keys, links and the clock, as a reader would use them."""
    script = Path(__file__).with_name("live_script.js").read_text(encoding="utf-8")
    # pictures come at a fixed pace, whatever the machine does
    pace = "requestAnimationFrame = (f) => setTimeout(() => f(performance.now()), 16);"
    # and the chain is in sight, whether a frame of the browser has been drawn or not
    pace += "IntersectionObserver = function (f) {"
    pace += " this.observe = () => setTimeout(() => f([{ isIntersecting: true }]), 0); };"
    html = pages.written(tmp_path, pages.material(tmp_path, figures=["fig12"]))
    html = html.replace("<body>", f"<body><script>{pace}</script>")
    path = tmp_path / "live.html"
    path.write_text(html.replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
    seen = browser.seen(path.as_uri() + "#live?n=3&u=9&sigma=1&f=0.5&speed=20", tmp_path)
    assert seen["errors"] == [] and seen["requests"] == []
    assert seen["linked"] == ["3", "9", "1", "0.5", "20"]
    assert seen["played"] > 5 and seen["stood"]
    assert seen["restarted"] < 0.1 and seen["keys"] == ["Play", "Pause", "10"]
    assert [len(SETTINGS["presets"])] * 2 == [len(seen["presets"]), len(set(seen["presets"]))]
    assert seen["pairs"] == [
        preset["settings"]["second"] != "none" for preset in SETTINGS["presets"]
    ]
    assert "n=7" in seen["link"]
    assert min(seen["small"]) >= 44 and all(seen["names"]) and seen["overflow"] <= 0
    assert all(len(set(pixels)) > 1 for pixels in seen["drawn"])
