"""What the rules of the workflow ask: files of a run, what jobs are told, the code behind them."""

import dataclasses
import hashlib
import json
import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from beltrepro.replication.plan import dependencies, files, jobs, manifest, registry
from beltrepro.replication.plan.filming import FILM, TRACK
from beltrepro.replication.plan.plan import Batch, make_plan

SCRIPTS = Path("workflow", "scripts")
# Minutes that a simulation asks of a cluster: for its start and a compilation, and for its work.
# The dearest class of jobs took 1.5e-6 s for a block and a unit of time.
_START, _PER_WORK = 10.0, 4e-6 / 60


class Workflow:
    """The files of a run and the jobs that make them, as Snakemake's rules have them.

    Paths begin with "<results>", which stands for the folder of the run. What takes `wildcards` is
    called by Snakemake. What files must say of themselves is known by the name of what they hold:
    that of a dataset or table is its own; a film F and its track are "F_film" and "F_track".
    """

    def __init__(self, config: dict, top: Path = Path()) -> None:
        self.plan = make_plan(config)
        self.tables, self.figures = registry.tables(), registry.figures()
        self.results = top / "results" / self.plan.run
        self.deposited = manifest.datasets(top, self.plan.run)
        self.filmed = {
            f"{name}{end}": film for name, film in self.plan.films.items() for end in (FILM, TRACK)
        }
        self.judged = [*self.plan.datasets, *(f"{name}{TRACK}" for name in self.plan.films)]
        self._top = top
        self._known: dict[str, dict] = {}
        self._codes = dependencies.KeptHashes(top / ".snakemake" / "code_hashes.json")
        self._package = dependencies.Sources()
        registry.check_names(self.plan.datasets)
        inputs = [*self.plan.datasets, *self.filmed, *self.tables]
        for entries in (self.tables, self.figures):
            registry.check_uses(entries, inputs, f"preset {self.plan.preset}")

    # --- files ---

    def wildcards(self) -> dict[str, str]:
        """Patterns of the wildcards."""
        return {
            "dataset": "|".join(self.plan.datasets),
            "film": "|".join(self.plan.films),
            "table": "|".join(table.file(name) for name, table in self.tables.items()),
            "figure": "|".join(self.figures),
        }

    def joined(self) -> str:
        """Pattern of the datasets made here; one that came with an archive is no output."""
        return "|".join(name for name in self.plan.datasets if name not in self.deposited) or "(?!)"

    def file_of(self, name: str) -> str:
        """The file of a dataset or table, or of a film or track."""
        if name in self.tables:
            return f"<results>/{self.tables[name].file(name)}.csv"
        if name in self.filmed:
            ending = ".mp4" if name.endswith(FILM) else ".csv"
            return f"<results>/experiment/{self.filmed[name].name}{ending}"
        return f"<results>/datasets/{name}.h5"

    def files_of(self, *names: str) -> dict[str, str]:
        """Files by name."""
        return {name: self.file_of(name) for name in names}

    def datasets(self) -> list[str]:
        """Files of all datasets."""
        return list(self.files_of(*self.plan.datasets).values())

    def batches(self, wildcards: Any) -> list[str]:
        """Files of the batches of a dataset."""
        return self._batch_files(wildcards.dataset, self.plan.datasets[wildcards.dataset].batches)

    def runs_so_far(self, wildcards: Any) -> list[str]:
        """Files of the batches that hold the runs to which more may be added."""
        return self._batch_files(wildcards.dataset, self._batch(wildcards).looks_at)

    def _batch_files(self, dataset: str, names: Iterable[str]) -> list[str]:
        return [f"<results>/batches/{dataset}/{name}.h5" for name in names]

    def with_metadata(self, name: str) -> list[str]:
        """A table, film or track, and the file that says what it is."""
        return [self.file_of(name), f"{self.file_of(name)}-metadata.json"]

    def claims(self) -> list[str]:
        """The tables of claims and estimates, and what they are."""
        tables = [f"<results>/{name}.csv" for name in ("claims", "estimates")]
        return [*tables, *(f"{path}-metadata.json" for path in tables)]

    def drawn(self, *endings: str, category: str | None = None) -> list[str]:
        """Files of all figures, or of those of one category."""
        return [
            f"<results>/figures/{name}.{ending}"
            for name, figure in self.figures.items()
            if category in (None, figure.category)
            for ending in endings
        ]

    def everything(self) -> list[str]:
        """What the target `all` makes: all that is compared and published."""
        return [
            *self.datasets(),
            *self.drawn("png", "pdf"),
            *(path for name in (*self.filmed, *self.tables) for path in self.with_metadata(name)),
            *self.claims(),
            "<results>/report.html",
        ]

    def compared(self) -> list[str]:
        """Tables of claims of other runs: those here, or published in docs/results."""
        tables: dict[str, str] = {}
        for folder in ("docs/results", "results"):
            paths = (self._top / folder).glob("*/claims.csv")
            tables |= {path.parent.name: str(path) for path in paths}
        return [path for name, path in sorted(tables.items()) if name != self.plan.run]

    def is_made(self, path: str, is_output: Callable[[str], bool]) -> bool:
        """Whether a target is a file of this run; of batches, only those that there are."""
        place = Path(path)
        if place.is_relative_to(f"results/{self.plan.run}/batches"):
            return path in {
                f"results/{self.plan.run}/{job.name}.h5" for job in jobs.simulation_jobs(self.plan)
            }
        in_datasets = place.parent == Path(f"results/{self.plan.run}/datasets")
        return (in_datasets and place.stem in self.deposited) or is_output(path)

    def sampled(self, wildcards: Any) -> list[str]:
        """Results of the jobs by which the time of the preset is judged."""
        first = [job for job in jobs.simulation_jobs(self.plan) if not job.adds]
        sample = jobs.draw(first, self.plan.seed)
        return [f"<results>/{job.name}.h5" for job in sample]

    def minutes_of_batch(self, wildcards: Any, attempt: int) -> int:
        """Time that a batch may take on a cluster; each attempt asks for as much again."""
        work = self.plan.datasets[wildcards.dataset].work(self._batch(wildcards).most)
        return attempt * math.ceil(_START + _PER_WORK * work)

    def simulation_jobs(self) -> list[tuple]:
        """All simulation jobs; plain tuples, which travel to a script as parameters."""
        return [dataclasses.astuple(job) for job in jobs.simulation_jobs(self.plan)]

    # --- what single jobs are made from ---

    def sources(self, wildcards: Any) -> dict[str, str]:
        """Files that a table, figure or film is made from, by name of what they hold."""
        return self.files_of(*self._sources(wildcards))

    def about(self, field: str) -> Callable[[Any], Any]:
        """What the entry of a figure or table says under this name, for a directive."""
        return lambda wildcards: getattr(self._entry(wildcards), field)

    def _sources(self, wildcards: Any) -> tuple[str, ...]:
        if hasattr(wildcards, "film"):
            return (self.plan.films[wildcards.film].dataset,)
        return self._entry(wildcards).uses

    def _entry(self, wildcards: Any) -> registry.Figure | registry.Table:
        if hasattr(wildcards, "figure"):
            return self.figures[wildcards.figure]
        return self.tables[Path(wildcards.table).name]  # it may lie at the top of the results

    def _batch(self, wildcards: Any) -> Batch:
        return self.plan.datasets[wildcards.dataset].batches[wildcards.batch]

    # --- what files must say of themselves ---

    def expected(self, *names: str) -> dict[str, dict]:
        """What the files of these must say, by name."""
        return {name: self._expected(name) for name in names}

    def made_from(self, *names: str) -> dict:
        """What a table, figure or list of claims must say that is made from these."""
        return self._of(self.expected(*names))

    def expected_of_film(self, wildcards: Any) -> dict:
        """Of a film."""
        return self._expected(f"{wildcards.film}{FILM}")

    def expected_batches(self, wildcards: Any) -> list[dict]:
        """Of the batches that are joined, or that hold the runs to which more may be added."""
        adds = hasattr(wildcards, "batch")
        dataset = self.plan.datasets[wildcards.dataset]
        names = self._batch(wildcards).looks_at if adds else dataset.batches
        return [files.expected(self.plan.batch_spec(dataset.name, name)) for name in names]

    def expected_of_sources(self, wildcards: Any) -> dict[str, dict]:
        """Of what a table or film is made from."""
        return self.expected(*self._sources(wildcards))

    def expected_of_figure(self, wildcards: Any) -> dict:
        """Of what a figure is drawn from."""
        return self.made_from(*self._sources(wildcards))

    def expected_of_report(self) -> dict[str, dict]:
        """By name of the input of the report, and of the figure or dataset in it."""
        judged = self.made_from(*self.judged)
        return {
            "datasets": self.expected(*self.plan.datasets),
            **{name: {name: judged} for name in ("claims", "estimates")},
            "figures": {
                name: self.made_from(*figure.uses) for name, figure in self.figures.items()
            },
            **{name: {name: identity} for name, identity in self.expected(*self.tables).items()},
        }

    def _expected(self, name: str) -> dict:
        if name not in self._known:
            self._known[name] = self._made(name)
        return self._known[name]

    def _made(self, name: str) -> dict:
        if name in self.plan.datasets:
            return files.expected(self.plan.dataset_spec(name))
        if name in self.filmed:
            film = self.filmed[name]
            return self._of(self.expected(film.dataset) | {f"{film.name}{FILM}": film.spec()})
        return self.made_from(*self.tables[name].uses)

    def _of(self, sources: dict) -> dict:
        return {"preset": self.plan.preset, "run": self.plan.run, "sources": sources}

    # --- the code behind a job ---
    # Snakemake does not see imported modules. Of a script it compares the time, by which a checkout
    # or a clone would make everything anew: profiles/default turns that off.

    def code(self, script: str, *functions: str, choices: tuple[str, ...] = ()) -> str:
        """Hash of the code behind the functions that a script calls, and of its own text."""
        path = self._top / SCRIPTS / script
        text = hashlib.sha256(path.read_bytes()).hexdigest()
        return self._codes.get(
            json.dumps([script, text, functions, choices]),
            lambda: self._package.code_hash(*functions, script=path, choices=choices),
        )

    def code_of_batch(self, wildcards: Any) -> str:
        """Code behind a batch: the function of its kind, by its own integrator."""
        batch = self._batch(wildcards)
        functions = [self.plan.datasets[wildcards.dataset].kind.record]
        if batch.looks_at:
            functions.append("beltrepro.replication.plan.more_runs:wanted")
        script = "add_runs.py" if batch.looks_at else "simulate.py"
        kicked = {"kicked" for point in batch.points if point.kick > 0}
        choices = sorted({point.method for point in batch.points} | kicked)
        return self.code(script, *functions, choices=tuple(choices))

    def code_of_table(self, wildcards: Any) -> str:
        """Code behind a table: the function of its name."""
        function = f"{self._entry(wildcards).module}:{Path(wildcards.table).name}"
        return self.code("derive.py", function)

    def code_of_figure(self, wildcards: Any) -> str:
        """Code behind a figure: what draws and what saves it."""
        draw = f"{self.figures[wildcards.figure].module}:draw"
        return self.code("figure.py", draw, "beltrepro.replication.drawing.style:save")

    # --- what each job reads and writes, for the crate ---

    def records(self) -> Iterator[tuple[str, str, list[str], list[str]]]:
        """Rule, name, inputs and outputs of each job of the run."""
        for name, dataset in self.plan.datasets.items():
            for batch in dataset.batches.values():
                rule, sources = "simulate", ["config.yaml"]
                if batch.looks_at:
                    rule, sources = "add_runs", self._batch_files(name, batch.looks_at)
                made = self._batch_files(name, [batch.name])
                yield rule, f"batches/{name}/{batch.name}", sources, made
            batches = self._batch_files(name, dataset.batches)
            yield "join", f"datasets/{name}", batches, [self.file_of(name)]
        for name, planned in self.plan.films.items():
            film, track = self.with_metadata(f"{name}{FILM}"), self.with_metadata(f"{name}{TRACK}")
            yield "film", f"experiment/{name}.film", [self.file_of(planned.dataset)], film
            yield "track", f"experiment/{name}.track", film[:1], track
        for name, table in self.tables.items():
            sources = list(self.files_of(*table.uses).values())
            yield "derive", table.file(name), sources, self.with_metadata(name)
        for name, figure in self.figures.items():
            outputs = [f"<results>/figures/{name}.{ending}" for ending in ("png", "pdf")]
            yield "draw", f"figures/{name}", list(self.files_of(*figure.uses).values()), outputs
        claims, datasets = self.claims()[:2], self.datasets()
        yield "claims", "claims", list(self.files_of(*self.judged).values()), self.claims()
        tables = list(self.files_of(*self.tables).values())
        shown = [*datasets, *tables, *claims, *self.drawn("png")]
        yield "report", "report", shown, ["<results>/report.html"]

    def crate_spec(self, rule_of: Callable[[str], Any]) -> dict:
        """What `deposit.crate.Run` is made of, as plain values; rule_of : a rule by its name."""
        records = [
            (rule, name, self._below_project(inputs), self._below_project(outputs))
            for rule, name, inputs, outputs in self.records()
        ]
        rules = {name: rule_of(name) for name in dict.fromkeys(record[0] for record in records)}
        return {
            "name": self.plan.run,
            "preset": self.plan.preset,
            "seed": self.plan.seed,
            "rules": {
                name: (rule.docstring, f"{SCRIPTS}/{Path(rule.script).name}")
                for name, rule in rules.items()
            },
            "records": records,
        }

    def _below_project(self, paths: list[str]) -> list[str]:
        return [path.replace("<results>", f"results/{self.plan.run}") for path in paths]
