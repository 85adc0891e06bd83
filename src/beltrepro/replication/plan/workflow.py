"""What the rules of the workflow ask: files of a run, what jobs are told, the code behind them."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from beltrepro.replication.plan import dependencies, registry
from beltrepro.replication.plan.filming import FILM, TRACK
from beltrepro.replication.plan.plan import make_plan

SCRIPTS = Path("workflow", "scripts")


class Workflow:
    """The files of a run and the jobs that make them, as Snakemake's rules have them.

    Paths begin with "<results>", which stands for the folder of the run. What takes `wildcards` is
    called by Snakemake. The name of a dataset or table is its own; a film F and its track are
    "F_film" and "F_track".
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
        return [*self.datasets(), *self.drawn("png", "pdf"), *tables, "<results>/report.html"]

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
            return (self.plan.films[wildcards.film].dataset,)
        if hasattr(wildcards, "figure"):
            return self.figures[wildcards.figure].uses
        return self.table(wildcards).uses

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
