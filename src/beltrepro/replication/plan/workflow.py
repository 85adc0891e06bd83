"""What the rules of the workflow ask: files of a run, what jobs are told, the code behind them."""

import logging
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tqdm import tqdm

from beltrepro.base import process
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import dependencies, registry
from beltrepro.replication.plan.config import SOURCE, load_config
from beltrepro.replication.plan.kinds import FILM, TRACK
from beltrepro.replication.plan.plan import FIRST_BATCH, make_plan
from beltrepro.replication.plan.points import plain, points_of

BATCH = "beltrepro.replication.plan.batch"


@contextmanager
def one_line() -> Iterator[None]:
    """End the process with one line where a value is refused."""
    try:
        yield
    except InputError as error:
        sys.exit(f"error: {error}")


def check_call() -> None:
    """Set the process right; end with one line what Snakemake would answer with a traceback.

    It would also take a file in which a key is given twice. The profile calls this, because nothing
    else of a workflow is read before these.
    """
    process.set_right()
    place = str(Path.cwd())
    if place.encode(errors="ignore").decode() != place:  # what reads the imports ends badly
        sys.exit(f"error: {place!r}: the path of the project must be text in UTF-8")
    from snakemake.cli import get_argument_parser
    from snakemake.settings.types import ExecMode

    options, _ = get_argument_parser().parse_known_args()
    if options.mode is not ExecMode.DEFAULT:  # in a job, whose call Snakemake has written
        return
    for entry in options.config or ():
        name, equals, _ = entry.partition("=")
        if not equals:
            call = f"snakemake --cores 2 {entry} --config preset=smoke"
            sys.exit(
                f"error: --config {entry}: must be NAME=VALUE; targets stand before it: {call}"
            )
        if not re.fullmatch(r"[a-zA-Z_][\w-]*\w", name):
            nested = "'defaults={\"noise\": 1}'"
            sys.exit(f"error: --config {entry}: no key; one below another is given as {nested}")
    with one_line():
        for path in (Path(options.directory or "", SOURCE), *(options.configfile or ())):
            load_config(path)


class RunProgress(logging.Handler):
    """How far a run is, in one line that moves: jobs, time left, figures that are ready."""

    _BAR = "{n_fmt} of {total_fmt} jobs |{bar}| {elapsed}, {remaining} left{postfix}"

    def __init__(self) -> None:
        super().__init__()
        self._bar = tqdm(bar_format=self._BAR, smoothing=0, dynamic_ncols=True)
        self._drawn: dict[int, str] = {}  # figures by the number of their job
        self._ready: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Take what Snakemake tells of its jobs."""
        event, about = getattr(record, "event", None), vars(record)
        if event == "job_info" and about["rule_name"] == "draw":
            self._drawn[about["jobid"]] = about["wildcards"]["figure"]
        elif event == "job_finished" and about["job_id"] in self._drawn:
            self._ready.append(self._drawn[about["job_id"]])
            self._bar.set_postfix_str(f"figures: {len(self._ready)}, last {self._ready[-1]}")
        elif event == "progress":
            self._bar.total = about["total"]
            self._bar.update(about["done"] - self._bar.n)
            if about["done"] == about["total"]:
                self._bar.close()


class Workflow:
    """The files of a run and the jobs that make them, as Snakemake's rules have them.

    Paths begin with "<results>", which stands for the folder of the run. What takes `wildcards` is
    called by Snakemake. The name of a dataset or table is its own; the film of dataset D and its
    track are "D_film" and "D_track".
    """

    def __init__(self, config: dict) -> None:
        self.plan = make_plan(config)
        self.tables, self.figures = registry.tables(), registry.figures()
        self.results = Path("results", self.plan.run)
        registry.check_names(self.plan.datasets)
        films = self.plan.films
        self.made = {  # of datasets: all but these
            **{f"{name}{FILM}": f"<results>/experiment/{name}.mp4" for name in films},
            **{f"{name}{TRACK}": f"<results>/experiment/{name}.csv" for name in films},
            **{name: f"<results>/tables/{name}.csv" for name in self.tables},
        }
        self.datasets = {name: f"<results>/datasets/{name}.h5" for name in self.plan.datasets}
        self.judged = [*self.datasets, *(f"{name}{TRACK}" for name in films)]
        for entries in (self.tables, self.figures):
            registry.check_uses(entries, self.datasets | self.made, f"preset {self.plan.preset}")

    def wildcards(self) -> dict[str, str]:
        """Patterns of the wildcards."""
        return {
            "dataset": "|".join(self.datasets),
            "method": "|".join(dependencies.INTEGRATORS),
            "film": "|".join(self.plan.films),
            "table": "|".join(self.tables),
            "figure": "|".join(self.figures),
        }

    def files(self, names: Iterable[str]) -> dict[str, str]:
        """Files of datasets, tables, films and tracks by name."""
        return {name: (self.datasets | self.made)[name] for name in names}

    def batches(self, wildcards: Any) -> list[str]:
        """Files of the batches of a dataset."""
        batches = self.plan.datasets[wildcards.dataset].batches
        return [f"<results>/batches/{wildcards.dataset}/{batch}.h5" for batch in batches]

    def drawn(self, *endings: str) -> list[str]:
        """Files of all figures."""
        return [f"<results>/figures/{name}.{ending}" for name in self.figures for ending in endings]

    def code(self, script: str, *functions: str, **how: Any) -> str:
        """Hash of the code behind a script and the functions that it calls."""
        path = Path("workflow", "scripts", f"{script}.py")
        return dependencies.code_hash(*functions, script=path, **how)

    def of_one_batch(self) -> str:
        """Pattern of the datasets that one job simulates."""
        return "|".join(name for name, one in self.plan.datasets.items() if len(one.batches) == 1)

    def points(self, wildcards: Any) -> dict:
        """The points of a batch, or of the only one of a dataset, as plain values."""
        dataset = self.plan.datasets[wildcards.dataset]
        return plain(dataset.batches[wildcards.get("batch", FIRST_BATCH)])

    def code_of_batch(self, wildcards: Any) -> str:
        """Code behind a batch: what records it, and the integrators of its points."""
        kind = self.plan.datasets[wildcards.dataset].kind
        return self.code("simulate", BATCH, kind.record, methods=self._methods(wildcards))

    def kernels(self, wildcards: Any) -> list[str]:
        """What says that the integrators of a batch are compiled."""
        return [f"<results>/kernels/{method}.compiled" for method in self._methods(wildcards)]

    def _methods(self, wildcards: Any) -> tuple[str, ...]:
        """Integrators of the points of a batch."""
        return tuple(sorted({point.method for point in points_of(self.points(wildcards))}))
