"""Rendering of the report from a template."""

import base64
import os
from importlib import resources
from pathlib import Path

import jinja2

from beltrepro.claims.criteria import VERDICTS
from beltrepro.report import agreement, gathering

TEMPLATE = "report.html.j2"
STYLE = "report.css"
SYMBOLS = dict(zip(VERDICTS, "✓◐✗–○", strict=True))


def render(
    output: Path,
    figures: dict[str, Path],
    claims_csv: Path,
    datasets: list[Path],
    benchmarks: Path,
    preset: str,
    settings: dict,
    agreement_tables: agreement.Tables | None = None,
    agreement_figures: dict[str, Path] | None = None,
) -> None:
    """Write the report of one preset as a single HTML file.

    Parameters
    ----------
    output : the file to write.
    figures : PNG files by name of the figure ("fig08"), in the order to show; embedded.
    claims_csv : table of claims as written by `beltrepro.claims.measure`.
    datasets : HDF5 files that figures and claims rest on: their attributes say what was run.
    benchmarks : folder of Snakemake's benchmark files; may lack or be empty.
    preset, settings : name and resolved configuration of the preset.
    agreement_tables, agreement_figures : comparison of the integrators, its PNG files by name; the
        page has no such section without the tables.

    Every number in the report comes from these files.
    """
    content = gathering.read_content()
    claims = gathering.read_claims(claims_csv)
    described = gathering.read_datasets(datasets)
    page = _environment().get_template(TEMPLATE)
    shown = [_figure(name, path, content, claims, settings) for name, path in figures.items()]
    html = page.render(
        style=_style(),
        content=content,
        preset=preset,
        claims=claims,
        counts=gathering.count_verdicts(claims),
        verdicts=VERDICTS,
        figures=shown,
        agreement=agreement_tables and agreement.describe(agreement_tables, settings),
        agreement_figures=[
            _comparison_figure(name, path, content)
            for name, path in (agreement_figures or {}).items()
        ],
        anchors={figure["number"]: figure["name"] for figure in shown},
        datasets=described,
        environment=gathering.environment(described),
        cores=os.cpu_count(),
        benchmarks=gathering.read_benchmarks(benchmarks),
        ambiguities=gathering.ambiguities(content, claims, settings),
        deviations=gathering.deviations(content, described),
        settings=settings,
    )
    Path(output).write_text(html, encoding="utf-8")


def _figure(name, path, content, claims, settings) -> dict:
    words = content["figures"].get(name, {"paper": "", "alt": name})
    number = name.removeprefix("fig").lstrip("0")
    return {
        "name": name,
        "number": number,
        "title": settings["figures"].get(name, {}).get("title", ""),
        "paper": words["paper"],
        "alt": words["alt"],
        "image": _embedded(path),
        "claims": [claim for claim in claims if claim["figure"] == number],
        "uses": ["/".join(use) for use in settings["figures"].get(name, {}).get("uses", [])],
    }


def _comparison_figure(name, path, content) -> dict:
    return {"name": name, "image": _embedded(path)} | content["agreement"]["figures"][name]


def _embedded(path) -> str:
    return base64.b64encode(Path(path).read_bytes()).decode()


def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("beltrepro.report", "."),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "slug": lambda verdict: verdict.replace(" ", "-"),
        "symbol": SYMBOLS.__getitem__,
        "minus": lambda text: text.replace("-", "\u2212") if _is_number(text) else text,
        "time": _time,
    }
    return environment


def _style() -> str:
    return resources.files("beltrepro.report").joinpath(STYLE).read_text(encoding="utf-8")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _time(seconds: float) -> str:
    """Seconds as 12.3 s, 4 min 05 s or 2 h 03 min."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"
