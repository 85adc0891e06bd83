"""The code behind a job: the definitions that its function uses, wherever they stand.

Names are followed through the imports of the package, definition by definition; of a class, the
methods that somebody mentions. So an edit reruns a job if it can change what the job makes:
comments, docstrings, annotations and what other jobs use do not count. What cannot be followed
counts whole: a module as a value, and of each module what is done when it is imported. Where a
table chooses by method, only what is chosen counts.
"""

import ast
import functools
import hashlib
import json
import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from beltrepro.base.atomic import replacing
from beltrepro.base.provenance import PACKAGE, ROOT

_NO_DATA = (".py", ".pyc", ".nbi", ".nbc")  # sources, and caches of Python and Numba
_MODULE = re.compile(rf"{PACKAGE}(\.\w+)+(:\w+)?")
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
WHOLE = ""  # in place of the name of a definition: all of the module

Place = tuple[str, str]
"""A module and the name of a definition in it."""


class Sources:
    """The sources of the package as they were when they were first asked for."""

    def __init__(self, root: Path = ROOT) -> None:
        self._root = root
        self.module = functools.cache(self._module)

    def code_hash(
        self, *functions: str, script: Path | None = None, choices: Iterable[str] = ()
    ) -> str:
        """Hash of the code behind functions, named as "module:function".

        script : counts by its own text only. choices : methods of the points.
        """
        digest = hashlib.sha256()
        for (module, name), text in sorted(self.definitions(*functions, choices=choices).items()):
            digest.update(f"{module}:{name}\0{text}\0".encode())
        if script is not None:
            digest.update(f"{script.name}\0".encode() + script.read_bytes())
        return digest.hexdigest()[:16]

    def definitions(self, *functions: str, choices: Iterable[str] = ()) -> dict[Place, str]:
        """Text of each definition behind functions; of data files their hash."""
        texts: dict[Place, str] = {}
        words: set[str] = set()  # attributes that are mentioned
        methods: set[Place] = set()  # that nobody has mentioned so far
        waiting = [_place(function) for function in functions]
        while waiting:
            place = name, definition_name = waiting.pop()
            module = self.module(name)
            if place in texts or module is None:
                texts.setdefault(place, "missing")  # the job that needs it will say so
                continue
            waiting += module.effects
            definition = module.definitions.get(definition_name)
            if definition is None:
                texts[place] = ""
                waiting += module.behind(definition_name)
                continue
            chosen = [key for key in sorted(definition.choices) if key in choices]
            texts[place] = f"{chosen}" if chosen else definition.text
            for uses in [definition.choices[key] for key in chosen] or [definition.uses]:
                waiting += uses.places
                words |= uses.words
                for package in uses.data:
                    texts |= self._data(package)
            methods |= {(name, method) for method in definition.methods}
            mentioned = {method for method in methods if method[1].partition(".")[2] in words}
            methods -= mentioned
            waiting += mentioned
        return texts

    def _module(self, name: str) -> "_Module | None":
        first, *parts = name.split(".")
        place = self._root.joinpath(*parts)
        for path in (place / "__init__.py", place.with_suffix(".py")):
            if first == PACKAGE and path.is_file():
                return _Module(self, name, path)
        return None

    def _data(self, package: str) -> dict[Place, str]:
        """Templates, styles and lists of a package, and of those in it."""
        place = self._root.joinpath(*package.split(".")[1:])
        data = {}
        for path in place.rglob("*"):
            name = path.relative_to(place)
            hidden = any(part.startswith((".", "__")) for part in name.parts)
            if path.is_file() and not hidden and path.suffix not in _NO_DATA:
                data[package, name.as_posix()] = hashlib.sha256(path.read_bytes()).hexdigest()
        return data


class KeptHashes:
    """Hashes in a file, as long as no source of the package changes: the search takes seconds.

    Every start of Snakemake asks for them, and so each job on a cluster.
    """

    def __init__(self, path: Path, root: Path = ROOT) -> None:
        self._path = path
        self._kept: dict[str, Any] = {"sources": _state(root), "hashes": {}}
        with suppress(OSError, ValueError, TypeError, KeyError):  # none, or of another version
            kept = json.loads(path.read_text(encoding="utf-8"))
            if kept["sources"] == self._kept["sources"]:
                self._kept["hashes"] = dict(kept["hashes"])

    def get(self, key: str, make: Callable[[], str]) -> str:
        """The hash of this key, made and kept if it is not there."""
        hashes = self._kept["hashes"]
        if key not in hashes:
            hashes[key] = make()
            if self._path.parent.is_dir():
                with replacing(self._path) as unfinished:
                    unfinished.write_text(json.dumps(self._kept), encoding="utf-8")
        return hashes[key]


def _state(root: Path) -> str:
    """Hash of all sources and data files of the package."""
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*")):
        if path.is_file() and path.suffix not in _NO_DATA[1:]:
            digest.update(f"{path.relative_to(root)}\0".encode())
            digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


class _Uses(NamedTuple):
    """What a piece of code mentions."""

    places: set[Place]
    words: set[str]  # attributes, and texts that may be one
    data: set[str]  # packages of which it may read files


class _Definition:
    """A statement at the top of a module, or a method; looked into only when it is asked for."""

    def __init__(self, module: "_Module", node: ast.AST, methods: Iterable[str] = ()) -> None:
        self._module, self._node = module, node
        self.methods = methods  # of a class: names of their definitions

    @functools.cached_property
    def text(self) -> str:
        """What counts of it."""
        return ast.unparse(self._node)

    @functools.cached_property
    def uses(self) -> _Uses:
        """What it mentions."""
        return self._module.uses(self._node)

    @functools.cached_property
    def choices(self) -> dict[str, _Uses]:
        """Of a table by method: what each entry mentions."""
        table = getattr(self._node, "value", None)
        if not isinstance(table, ast.Dict):
            return {}
        entries = [*zip(table.keys, table.values, strict=True)]
        choices = {key.value: value for key, value in entries if isinstance(key, ast.Constant)}
        is_by_method = {"verlet", "event"} <= choices.keys() and len(choices) == len(entries)
        return {str(key): self._module.uses(choices[key]) for key in choices if is_by_method}


class _Module:
    """A module as its text says it, none of it run."""

    def __init__(self, sources: Sources, name: str, path: Path) -> None:
        self._sources, self._name = sources, name
        self._package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        self._imports: dict[str, Place] = {}  # name here -> module and name there
        self.definitions: dict[str, _Definition] = {}
        self._done: list[Place] = []  # definitions that do something at the import
        for node in _Bare().visit(ast.parse(path.read_text(encoding="utf-8"))).body:
            self._define(node)

    def _define(self, node: ast.stmt) -> None:
        """Take a statement at the top of the module."""
        if isinstance(node, ast.Import | ast.ImportFrom):
            self._imports |= self._imported(node)
            return
        names, methods = _names(node), []
        if isinstance(node, ast.ClassDef):
            for part in [part for part in node.body if isinstance(part, _FUNCTIONS)]:
                if not part.name.startswith("__"):  # those Python itself calls
                    is_of_class = "classmethod" in map(ast.unparse, part.decorator_list)
                    methods.append(f"{node.name}.{'cls.' * is_of_class}{part.name}")
                    self.definitions[methods[-1]] = _Definition(self, part)
                    node.body.remove(part)
        if not names:  # as in try: import
            self._imports |= self._imported(node)
        calls = [one for one in getattr(node, "decorator_list", ()) if isinstance(one, ast.Call)]
        if not names or any(ast.unparse(call.func) != "dataclass" for call in calls):
            names = names or [f"line {node.lineno}"]
            self._done += [(self._name, name) for name in names]
        self.definitions |= dict.fromkeys(names, _Definition(self, node, methods))

    def _imported(self, node: ast.AST) -> dict[str, Place]:
        """Names of this package that imports in some code make: module and name of each there."""
        names: dict[str, Place] = {}
        for part in ast.walk(node):
            if isinstance(part, ast.Import):
                names |= {one.asname or one.name: (one.name, WHOLE) for one in part.names}
            elif isinstance(part, ast.ImportFrom):
                above = self._package.split(".")[: -part.level + 1 or None] if part.level else []
                origin = ".".join([*above, *filter(None, [part.module])])
                names |= {one.asname or one.name: (origin, one.name) for one in part.names}
        return {name: place for name, place in names.items() if place[0].startswith(PACKAGE)}

    @functools.cached_property
    def effects(self) -> list[Place]:
        """What is done when it is imported, in it and in all that it imports."""
        modules, waiting = {}, [self._name]
        while waiting:
            name = waiting.pop()
            if name not in modules and (module := self._sources.module(name)):
                modules[name] = module
                waiting += [place[0] for place in module._imports.values()]
                waiting += [".".join(place) for place in module._imports.values()]
        return [place for module in modules.values() for place in module._done]

    def uses(self, node: ast.AST) -> _Uses:
        """What a piece of code of this module mentions."""
        imports = self._imports | self._imported(node)
        places, words, data, bases = set(), set(), set(), set()
        for part in ast.walk(node):  # an attribute comes before its base
            match part:
                case ast.Attribute(value=ast.Name(id=name), attr=attribute) if (
                    module := self._as_module(imports.get(name))
                ):
                    bases.add(part.value)
                    places.add((module, attribute))
                case ast.Attribute(value=ast.Name(id=name), attr=word):
                    words |= {word, f"cls.{word}"} if name == "cls" or name[0].isupper() else {word}
                case ast.Attribute(attr=word):
                    words.add(word)
                case ast.Name(id="__file__" | "resources"):
                    data.add(self._package)
                case ast.Name(id=name, ctx=ast.Load()) if part not in bases:
                    # import package.module makes the name of the package
                    asked = [one for one in imports if one == name or one.startswith(f"{name}.")]
                    places |= {self._whole(imports[one]) for one in asked}
                    if name in self.definitions and not asked:
                        places.add((self._name, name))
                case ast.Constant(value=str(text)) if _MODULE.fullmatch(text):
                    places |= {_place(text)} if self._sources.module(_place(text)[0]) else set()
                    data |= {text} if ":" not in text else set()
                case ast.Constant(value=str(text)):
                    words.add(text)
        return _Uses(places, words, data)

    def _as_module(self, place: Place | None) -> str:
        """Name of the module that an imported name stands for; empty if it stands for none."""
        name = ".".join(filter(None, place or ()))
        return name if self._sources.module(name) else ""

    def _whole(self, place: Place) -> Place:
        """A place, or the whole module that it stands for."""
        module = self._as_module(place)
        return (module, WHOLE) if module else place

    def behind(self, name: str) -> list[Place]:
        """Where something stands that is not defined here; if nothing tells, all of this module."""
        place = self._imports.get(name, (self._name, name))
        if name and self._whole(place) != (self._name, name):
            return [self._whole(place)]
        return [(self._name, other) for other in self.definitions]


class _Bare(ast.NodeTransformer):
    """Takes away what changes no result: docstrings, annotations of functions, and at the top of a
    module what is for the checker of types, or for the module as a command."""

    def visit_Expr(self, node: ast.Expr) -> Any:
        """Take away a docstring."""
        return None if isinstance(node.value, ast.Constant) else node

    def visit_If(self, node: ast.If) -> Any:
        """Take away what is not done in a job."""
        test = ast.unparse(node.test)
        return None if test == "TYPE_CHECKING" or test.startswith("__name__ ==") else node

    def visit_AnnAssign(self, node: ast.AnnAssign) -> Any:
        """Take away the annotation of what has a value."""
        return ast.Assign([node.target], node.value, lineno=0) if node.value else node

    def visit_arg(self, node: ast.arg) -> Any:
        """Take away an annotation."""
        return ast.arg(node.arg)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> Any:
        """Take away the annotation of what is returned."""
        node.returns = None
        return self.generic_visit(node)


def _names(node: ast.stmt) -> list[str]:
    """Names that a statement defines; of an import none."""
    if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        return [node.name]
    targets = getattr(node, "targets", [getattr(node, "target", None)])
    parts = [part for target in targets if target for part in ast.walk(target)]
    is_assignment = isinstance(node, ast.Assign | ast.AnnAssign)
    return [part.id for part in parts if isinstance(part, ast.Name)] if is_assignment else []


def _place(text: str) -> Place:
    module, _, name = text.partition(":")
    return module, name
