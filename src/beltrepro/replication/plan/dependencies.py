"""The code behind a job: the definitions that its function uses, wherever they stand.

From a function its names are followed through the imports of the package, definition by
definition; of a class, the methods that somebody asks for. So an edit reruns a job if it can change
what the job makes: comments, docstrings and what other jobs use do not count. What cannot be
followed (a module as a value) counts whole. Where a table chooses by method, only what is chosen
counts.
"""

import ast
import functools
import hashlib
import io
import json
import re
import tokenize
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from beltrepro.base.atomic import replacing
from beltrepro.base.provenance import PACKAGE, ROOT

_DERIVED = (".pyc", ".nbi", ".nbc")  # caches of Python and Numba
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_MODULE = re.compile(rf"{PACKAGE}(\.\w+)+(:\w+)?")
WHOLE = ""  # in place of the name of a definition: all of the module


def code_hash(
    *functions: str,
    script: Path | None = None,
    choices: Iterable[str] = (),
    tree: "Tree | None" = None,
) -> str:
    """Hash of the code behind functions, named as "module:function".

    script : counts by its own text only. choices : methods of the points, where a table chooses.
    """
    digest = hashlib.sha256()
    texts = definitions(*functions, choices=choices, tree=tree)
    for (module, name), text in sorted(texts.items()):
        digest.update(f"{module}:{name}\0{text}\0".encode())
    if script is not None:
        digest.update(f"{script.name}\0".encode() + script.read_bytes())
    return digest.hexdigest()[:16]


def definitions(
    *functions: str, choices: Iterable[str] = (), tree: "Tree | None" = None
) -> dict[tuple[str, str], str]:
    """Text of each definition behind functions, by module and name; of data files their hash."""
    search = _Search(frozenset(choices), tree or Tree())
    for function in functions:
        module, _, name = function.partition(":")
        search.ask(module, name)
    return search.finish()


class KeptHashes:
    """Hashes in a file, as long as no source of the package changes: the search takes seconds.

    Every job of a run starts a process that asks for them.
    """

    def __init__(self, path: Path, root: Path = ROOT) -> None:
        self._path, self._state = path, _state(root)
        self._hashes: dict[str, str] = {}
        try:
            kept = json.loads(path.read_text(encoding="utf-8"))
            if kept["sources"] == self._state:
                self._hashes = dict(kept["hashes"])
        except (OSError, ValueError, TypeError, KeyError):
            pass  # none are kept, or by a version that wrote another form

    def get(self, key: str, make: Callable[[], str]) -> str:
        """The hash of this key, made and kept if it is not there."""
        if key not in self._hashes:
            self._hashes[key] = make()
            if self._path.parent.is_dir():
                with replacing(self._path) as unfinished:
                    kept = {"sources": self._state, "hashes": self._hashes}
                    unfinished.write_text(json.dumps(kept), encoding="utf-8")
        return self._hashes[key]


def _state(root: Path) -> str:
    """Hash of all sources and data files of the package."""
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts and path.suffix not in _DERIVED:
            digest.update(f"{path.relative_to(root)}\0".encode())
            digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


class Tree:
    """The sources of the package as they were when they were first asked for."""

    def __init__(self, root: Path = ROOT) -> None:
        self.root = root
        self._sources: dict[str, Path | None] = {}
        self._modules: dict[str, _Module] = {}

    def source(self, module: str) -> Path | None:
        """File with the text of a module, if there is one."""
        if module not in self._sources:
            self._sources[module] = _source(self.root, module)
        return self._sources[module]

    def module(self, module: str) -> "_Module":
        """A module that has a source."""
        if module not in self._modules:
            source = self.source(module)
            assert source is not None, module
            self._modules[module] = _module(source, source.read_text(encoding="utf-8"), module)
        return self._modules[module]


@dataclass
class _Uses:
    """What a piece of code mentions."""

    names: set[str] = field(default_factory=set)  # but as the base of an attribute
    pairs: set[tuple[str, str]] = field(default_factory=set)  # name and attribute
    words: set[str] = field(default_factory=set)  # all attributes, and texts that may be one
    modules: set[tuple[str, str]] = field(default_factory=set)  # named in texts
    imports: dict[str, tuple[str, str]] = field(default_factory=dict)


@dataclass
class _Definition:
    """A statement at the top of a module, or a method; looked into only when it is asked for."""

    node: ast.stmt
    lines: list[str]  # of the module
    package: str
    is_registered: bool = False  # whether it counts as soon as its module does

    @functools.cached_property
    def methods(self) -> dict[str, "_Definition"]:
        """Of a class."""
        inner = [part for part in getattr(self.node, "body", ()) if _is_method(self.node, part)]
        return {part.name: _Definition(part, self.lines, self.package) for part in inner}

    @functools.cached_property
    def uses(self) -> _Uses:
        """What it mentions."""
        left_out = {id(method.node) for method in self.methods.values()}
        return _mentioned(self.node, self.package, left_out)

    @functools.cached_property
    def text(self) -> str:
        """What counts of it."""
        return _text(self.node, self.lines, [method.node for method in self.methods.values()])

    @functools.cached_property
    def choices(self) -> dict[str, _Uses]:
        """Of a table by method: what each entry mentions."""
        table = getattr(self.node, "value", None)
        if not isinstance(table, ast.Dict) or not _chooses_by_method(table):
            return {}
        entries = zip(table.keys, table.values, strict=True)
        return {key.value: _mentioned(choice, self.package) for key, choice in entries}  # type: ignore[union-attr]


class _Search:
    """Follows names from some functions, until there are no new ones."""

    def __init__(self, choices: frozenset[str], tree: Tree) -> None:
        self._choices, self._tree = choices, tree
        self._waiting: list[tuple[str, str]] = []
        self._found: dict[tuple[str, str], str] = {}
        self._asked: set[tuple[str, str]] = set()
        self._touched: set[str] = set()
        self._words: set[str] = set()
        self._methods: dict[str, list[tuple[str, str, _Definition]]] = {}  # not asked for yet

    def ask(self, module: str, name: str) -> None:
        """Follow a definition, or with WHOLE all of a module."""
        if (module, name) not in self._asked:
            self._asked.add((module, name))
            self._waiting.append((module, name))

    def finish(self) -> dict[tuple[str, str], str]:
        """Follow all that waits."""
        while self._waiting:
            self._look_up(*self._waiting.pop())
        return self._found

    def _look_up(self, module: str, name: str) -> None:
        if self._tree.source(module) is None:
            self._found[module, name] = "missing"  # the job that needs it will say so
            return
        contents = self._tree.module(module)
        self._touch(module)
        if name == WHOLE:
            for key in contents.definitions:
                self.ask(module, key)
        elif name in contents.definitions:
            self._take(module, name, contents.definitions[name], contents)
        elif name in contents.imports:
            self._ask_import(*contents.imports[name])
        elif self._tree.source(f"{module}.{name}"):
            self.ask(f"{module}.{name}", WHOLE)
        elif "__getattr__" in contents.definitions:  # of names that are imported late
            self.ask(module, "__getattr__")

    def _touch(self, module: str) -> None:
        """Take what counts as soon as a module is imported, in it and in those that it imports."""
        if module in self._touched or not self._tree.source(module):
            return
        self._touched.add(module)
        contents = self._tree.module(module)
        for key, definition in contents.definitions.items():
            if definition.is_registered:
                self._take(module, key, definition, contents)
        for origin, name in contents.imports.values():
            self._touch(origin)
            self._touch(f"{origin}.{name}")

    def _take(self, module: str, name: str, definition: _Definition, contents: "_Module") -> None:
        if (module, name) in self._found:
            return
        text, uses = definition.text, [definition.uses]
        if definition.choices:
            chosen = sorted(set(definition.choices) & self._choices or set(definition.choices))
            text, uses = f"{name}: {chosen}", [definition.choices[key] for key in chosen]
        self._found[module, name] = text
        for part in uses:
            self._follow(module, part, contents)
        for method, inner in definition.methods.items():
            word = f".{method}" if "classmethod" in inner.uses.names else method
            if method.startswith("__") or {word, f".{method}"} & self._words:
                self._take(module, f"{name}.{method}", inner, contents)
            else:
                place = module, f"{name}.{method}", inner
                self._methods.setdefault(word, []).append(place)

    def _follow(self, module: str, uses: _Uses, contents: "_Module") -> None:
        imports = contents.imports | uses.imports
        words = set(uses.words)
        for name in uses.names:
            if name in imports:
                self._ask_import(*imports[name])
            elif name in contents.definitions:
                self.ask(module, name)
        for name, attribute in uses.pairs:
            origin = ".".join(filter(None, imports.get(name, ())))
            if self._tree.source(origin):
                self.ask(origin, attribute)
                continue
            # through an instance, or through a class, which alone has class methods
            words.add(f".{attribute}" if name[0].isupper() or name == "cls" else attribute)
            if name in imports:
                self.ask(*imports[name])
            elif name in contents.definitions:
                self.ask(module, name)
        if PACKAGE in uses.names | {name for name, _ in uses.pairs}:  # import package.module
            for origin in (origin for name, (origin, _) in imports.items() if "." in name):
                self.ask(origin, WHOLE)
        for named, name in uses.modules:
            if self._tree.source(named):
                self.ask(named, name)
                if not name:
                    self._take_data(named)
        if uses.names & {"__file__", "resources"} or ("resources", "files") in uses.pairs:
            self._take_data(module if contents.is_package else module.rpartition(".")[0])
        for word in words - self._words:
            self._words.add(word)
            for key in {word, word.removeprefix(".")}:
                for owner, name, method in self._methods.pop(key, ()):
                    self._take(owner, name, method, self._tree.module(owner))

    def _ask_import(self, origin: str, name: str) -> None:
        submodule = f"{origin}.{name}" if name else origin
        is_module = self._tree.source(submodule) is not None
        self.ask(*((submodule, WHOLE) if is_module else (origin, name)))

    def _take_data(self, package: str) -> None:
        """Templates, styles and lists of a package, and of those in it."""
        place = self._tree.root.joinpath(*package.split(".")[1:])
        for path in sorted(place.rglob("*")):
            hidden = any(part.startswith((".", "__")) for part in path.relative_to(place).parts)
            if path.is_file() and not hidden and path.suffix not in (".py", *_DERIVED):
                digest = hashlib.sha256(path.read_bytes()).hexdigest()
                self._found[package, path.relative_to(place).as_posix()] = digest


@dataclass(frozen=True)
class _Module:
    """A module as its text says it, none of it run."""

    definitions: dict[str, _Definition]
    imports: dict[str, tuple[str, str]]  # name here -> module and name there
    is_package: bool


def _module(path: Path, text: str, module: str) -> _Module:
    is_package = path.name == "__init__.py"
    package = module if is_package else module.rpartition(".")[0]
    lines = text.splitlines(keepends=True)
    definitions: dict[str, _Definition] = {}
    imports: dict[str, tuple[str, str]] = {}
    tree = ast.parse(text, str(path))
    for number, node in enumerate(tree.body):
        if isinstance(node, ast.Import | ast.ImportFrom):
            imports |= _imports(node, package)
        elif _is_text(node) or _is_for_others(node):
            continue
        else:
            definition = _Definition(node, lines, package)
            names = list(_names(node))
            if not names or isinstance(node, ast.ClassDef):  # as in try: import
                imports |= definition.uses.imports
            definition.is_registered = not names
            for name in names or [f"statement {number}"]:
                definitions[name] = definition
    ours = definitions.keys() | imports.keys()
    for definition in definitions.values():
        decorators = getattr(definition.node, "decorator_list", ())
        calls = [part for part in decorators if isinstance(part, ast.Call)]
        definition.is_registered |= any(_base(call) in ours for call in calls)  # as @claim("id")
    return _Module(definitions, imports, is_package)


def _is_method(owner: ast.AST, part: ast.AST) -> bool:
    return isinstance(owner, ast.ClassDef) and isinstance(part, _FUNCTIONS)


def _chooses_by_method(table: ast.Dict) -> bool:
    """Whether the keys of a table are methods, and each says what is used by it."""
    keys = {key.value for key in table.keys if isinstance(key, ast.Constant)}
    return len(table.keys) > 1 and len(keys) == len(table.keys) and {"verlet", "event"} <= keys


def _mentioned(node: ast.AST, package: str, left_out: set[int] | None = None) -> _Uses:
    uses = _Uses()
    _collect(node, uses, package, left_out or set())
    return uses


def _collect(node: ast.AST, uses: _Uses, package: str, left_out: set[int]) -> None:
    """Add what a piece of code mentions, but for its annotations."""
    if id(node) in left_out:
        return
    if isinstance(node, ast.Import | ast.ImportFrom):
        uses.imports |= _imports(node, package)
        for name in _imports(node, package):
            uses.names.add(name)
        return
    if isinstance(node, ast.Attribute):
        if isinstance(node.value, ast.Name):
            uses.pairs.add((node.value.id, node.attr))
            return
        uses.words.add(node.attr)
    elif isinstance(node, ast.Name):
        uses.names.add(node.id)
    elif isinstance(node, ast.Constant) and isinstance(node.value, str):
        if node.value.isidentifier():
            uses.words.add(node.value)
        elif _MODULE.fullmatch(node.value):
            module, _, name = node.value.partition(":")
            uses.modules.add((module, name))
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns"):
            continue
        for part in value if isinstance(value, list) else [value]:
            if isinstance(part, ast.AST):
                _collect(part, uses, package, left_out)


def _imports(node: ast.Import | ast.ImportFrom, package: str) -> dict[str, tuple[str, str]]:
    """Names that an import of this package makes, and the module and name that each stands for."""
    if isinstance(node, ast.Import):
        aliases = [(alias.asname or alias.name, alias.name, "") for alias in node.names]
    else:
        parents = package.split(".")
        base = parents[: len(parents) - node.level + 1] if node.level else []
        origin = ".".join([*base, *filter(None, [node.module])])
        aliases = [(alias.asname or alias.name, origin, alias.name) for alias in node.names]
    return {
        name: (origin, part) for name, origin, part in aliases if origin.split(".")[0] == PACKAGE
    }


def _names(node: ast.stmt) -> Iterator[str]:
    """Names that a statement defines."""
    if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        yield node.name
    elif isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        for target in targets:
            yield from (part.id for part in ast.walk(target) if isinstance(part, ast.Name))


def _base(node: ast.AST) -> str:
    """The first name in an expression."""
    return next((part.id for part in ast.walk(node) if isinstance(part, ast.Name)), "")


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _is_for_others(node: ast.stmt) -> bool:
    """Whether a statement is for the checker of types, or for the module as a command."""
    test = ast.unparse(node.test) if isinstance(node, ast.If) else ""
    return test == "TYPE_CHECKING" or test.startswith("__name__ ==")


def _text(node: ast.stmt, lines: list[str], left_out: list[ast.stmt]) -> str:
    """The text of a definition without docstrings, comments, blank lines and methods."""
    numbers = range(_first(node), (node.end_lineno or node.lineno) + 1)
    gone: set[int] = set()
    skipped: list[ast.stmt] = []
    if any(lines[number - 1].lstrip()[:1] in ("'", '"') for number in numbers):
        skipped = [part for part in ast.walk(node) if isinstance(part, ast.stmt) and _is_text(part)]
    for part in (*skipped, *left_out):
        gone |= set(range(_first(part), (part.end_lineno or part.lineno) + 1))
    text = "".join(lines[number - 1] for number in numbers if number not in gone)
    if "#" in text:
        text = _without_comments(text)
    return "\n".join(line.rstrip() for line in text.splitlines() if line.strip())


def _first(node: ast.stmt) -> int:
    decorators = getattr(node, "decorator_list", ())
    return min(part.lineno for part in (node, *decorators))


def _without_comments(text: str) -> str:
    lines = text.splitlines(keepends=True)
    try:
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type == tokenize.COMMENT:
                row, column = token.start
                lines[row - 1] = lines[row - 1][:column] + "\n"
    except (tokenize.TokenError, IndentationError):
        return text  # of a class without its methods, perhaps: its comments count
    return "".join(lines)


def _source(root: Path, module: str) -> Path | None:
    """File with the text of a module of this package, if there is one."""
    first, *parts = module.split(".")
    if first != PACKAGE:
        return None
    place = root.joinpath(*parts)
    if (place / "__init__.py").is_file():
        return place / "__init__.py"
    source = place.with_suffix(".py")
    return source if parts and source.is_file() else None
