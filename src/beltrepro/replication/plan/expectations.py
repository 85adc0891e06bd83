"""What each file of a run must say of itself: its settings, or what it is made from."""

from beltrepro.replication.plan import files, registry
from beltrepro.replication.plan.films import FILM, TRACK
from beltrepro.replication.plan.plan import Plan


class Expectations:
    """What the files of a run must say of themselves, by the name of what they hold.

    The name of a dataset or table is its own; a film F and its track are "F_film" and "F_track".
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._known: dict[str, dict] = {}
        self.filmed = {
            f"{name}{end}": film for name, film in plan.films.items() for end in (FILM, TRACK)
        }
        self.judged = [*plan.datasets, *(f"{name}{TRACK}" for name in plan.films)]

    def each(self, *names: str) -> dict[str, dict]:
        """What the files of these must say, by name."""
        return {name: self._one(name) for name in names}

    def made_from(self, *names: str) -> dict:
        """What a table, figure or list of claims must say that is made from these."""
        return self._of(self.each(*names))

    def _one(self, name: str) -> dict:
        if name not in self._known:
            self._known[name] = self._found(name)
        return self._known[name]

    def _found(self, name: str) -> dict:
        if name in self._plan.datasets:
            return files.expected(self._plan.told(name))
        if name in self.filmed:
            film = self.filmed[name]
            return self._of({**self.each(film.dataset), f"{film.name}{FILM}": film.told()})
        return self.made_from(*registry.tables()[name].uses)

    def _of(self, sources: dict) -> dict:
        return {"preset": self._plan.preset, "run": self._plan.run, "sources": sources}
