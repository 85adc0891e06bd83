"""What the rules of the workflow ask: files of a run, what jobs are told, the code behind them."""

import hashlib
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from beltrepro.replication.plan import dependencies, files, registry
from beltrepro.replication.plan.filming import FILM, TRACK
from beltrepro.replication.plan.plan import make_plan

SCRIPTS = Path("workflow", "scripts")


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
        if not place.is_relative_to(f"results/{self.plan.run}/batches"):
            return is_output(path)
        dataset = self.plan.datasets.get(place.parent.name)
        return dataset is not None and place.suffix == ".h5" and place.stem in dataset.batches

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

    # --- what files must say of themselves ---

    def expected(self, *names: str) -> dict[str, dict]:
        """What the files of these must say, by name."""
        return {name: self._expected(name) for name in names}

    def made_from(self, *names: str) -> dict:
        """What a table, figure or list of claims must say that is made from these."""
        return self._of(self.expected(*names))

    def expected_batches(self, wildcards: Any) -> list[dict]:
        """Of the batches that are joined."""
        name = wildcards.dataset
        batches = self.plan.datasets[name].batches
        return [files.expected(self.plan.batch_spec(name, batch)) for batch in batches]

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
        dataset = self.plan.datasets[wildcards.dataset]
        choices = {point.method for point in dataset.batches[wildcards.batch]}
        return self.code("simulate.py", dataset.kind.record, choices=tuple(sorted(choices)))

    def code_of_table(self, wildcards: Any) -> str:
        """Code behind a table: the function of its name."""
        function = f"{self._entry(wildcards).module}:{Path(wildcards.table).name}"
        return self.code("derive.py", function)

    def code_of_figure(self, wildcards: Any) -> str:
        """Code behind a figure: what draws and what saves it."""
        draw = f"{self.figures[wildcards.figure].module}:{wildcards.figure}"
        return self.code("figure.py", draw, "beltrepro.replication.drawing.style:save")
