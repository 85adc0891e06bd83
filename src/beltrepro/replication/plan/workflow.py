"""What the rules of the workflow ask: files of a run, what jobs are told, the code behind them."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from beltrepro.replication.plan import dependencies, files, registry
from beltrepro.replication.plan.kinds import FILM, TRACK
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
        self.filmed = {f"{name}{end}": name for name in self.plan.films for end in (FILM, TRACK)}
        self.judged = [*self.plan.datasets, *(f"{name}{TRACK}" for name in self.plan.films)]
        self._top = top
        self._known: dict[str, dict] = {}
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
            return f"<results>/experiment/{self.filmed[name]}{ending}"
        return f"<results>/datasets/{name}.h5"

    def files_of(self, *names: str) -> dict[str, str]:
        """Files by name."""
        return {name: self.file_of(name) for name in names}

    def datasets(self) -> list[str]:
        """Files of all datasets."""
        return list(self.files_of(*self.plan.datasets).values())

    def batches(self, wildcards: Any) -> list[str]:
        """Files of the batches of a dataset."""
        name = wildcards.dataset
        return [
            f"<results>/batches/{name}/{batch}.h5" for batch in self.plan.datasets[name].batches
        ]

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
        tables = [self.file_of(name) for name in (*self.filmed, *self.tables)]
        tables += [f"<results>/{name}.csv" for name in ("claims", "estimates")]
        described = [f"{path}-metadata.json" for path in tables]
        pictures = self.drawn("png", "pdf")
        return [*self.datasets(), *pictures, *tables, *described, "<results>/report.html"]

    def compared(self) -> list[str]:
        """Tables of claims of other runs: those here, or published in docs/results."""
        tables: dict[str, str] = {}
        for folder in ("docs/results", "results"):
            paths = (self._top / folder).glob("*/claims.csv")
            tables |= {path.parent.name: str(path) for path in paths}
        return [path for name, path in sorted(tables.items()) if name != self.plan.run]

    # --- what single jobs are made from ---

    def sources(self, wildcards: Any) -> dict[str, str]:
        """Files that a table, figure or film is made from, by name of what they hold."""
        return self.files_of(*self._sources(wildcards))

    def table(self, wildcards: Any) -> registry.Table:
        """What a table says of itself; its file lies in tables/ or at the top of the results."""
        return self.tables[Path(wildcards.table).name]

    def _sources(self, wildcards: Any) -> Iterable[str]:
        if hasattr(wildcards, "film"):
            return (wildcards.film,)
        if hasattr(wildcards, "figure"):
            return self.figures[wildcards.figure].uses
        return self.table(wildcards).uses

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
        return [files.expected(self.plan.spec(name, batch)) for batch in batches]

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
            return files.expected(self.plan.spec(name))
        if name in self.filmed:
            film = self.filmed[name]
            return self._of(self.expected(film) | {f"{film}{FILM}": self.plan.films[film]})
        return self.made_from(*self.tables[name].uses)

    def _of(self, sources: dict) -> dict:
        return {"preset": self.plan.preset, "run": self.plan.run, "sources": sources}

    # --- the code behind a job ---

    def code(self, script: str, *functions: str, **how: Any) -> str:
        """Hash of the code behind a script and the functions that it calls."""
        path = self._top / SCRIPTS / f"{script}.py"
        return dependencies.code_hash(*functions, script=path, **how)

    def code_of_batch(self, wildcards: Any) -> str:
        """Code behind a batch: the function of its kind, and the integrator of all its points."""
        dataset = self.plan.datasets[wildcards.dataset]
        method = dataset.batches[wildcards.batch][0].method
        return self.code("simulate", dataset.kind.record, method=method)

    def code_of_figure(self, wildcards: Any) -> str:
        """Code behind a figure: what draws and what saves it."""
        module = self.figures[wildcards.figure].module
        return self.code("figure", module, "beltrepro.replication.drawing.style")
