"""Plant small errors, one at a time, in a copy of the tree and see which the quick tests notice.

    python tests/planting.py --draw 40 --seed 7 --rooms analysis,claims,observe
    python tests/planting.py --plants errors.yaml --all

Errors come from a list (YAML: entries with `file`, `old`, `new`, where `old` occurs once in the
file; paths from the root of the tree) or are drawn at random from the sources, without a look at
the tests: see `OPERATORS`. A room is a file or folder of src/beltrepro. By default the test files
run that can see the changed module by their imports, those that name it first; --all runs the
quick suite. --write keeps the list with its outcome, to be judged by hand: a change that leaves
every result as it was is no error.

Mutation tools on the market run the whole suite for each change, or rewrite functions in ways that
Numba cannot compile. This one forks each trial from a process with the libraries loaded and leaves
alone the time stamps of the other files, so that compiled kernels stay valid.
"""

import argparse
import ast
import functools
import importlib.util
import multiprocessing
import os
import random
import re
import shutil
import sys
import tempfile
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
PACKAGE = Path("src/beltrepro")
ROOMS = "analysis,claims,datasets,engine,figures,model,observe,report,simulation,jobs.py,"
ROOMS += "provenance.py,store.py,tables"
NOT_COPIED = (".git", ".venv", ".snakemake", ".pytest_cache", ".hypothesis", "results", "logs")
LIBRARIES = ("h5py", "matplotlib.pyplot", "mpmath", "numba", "numpy", "pandas")
LIBRARIES += ("jinja2", "jsonschema", "scipy.optimize", "scipy.signal", "scipy.stats")
LIMIT = 300.0  # seconds for the tests of one planted error
LIMIT_WITHOUT = 3600.0  # and for all of them without one, when kernels may have to be compiled


@dataclass
class Plant:
    """One error: `old`, at a byte offset of the file or where it occurs once, becomes `new`."""

    file: str
    old: str
    new: str
    operator: str = ""
    offset: int | None = None
    outcome: str = ""

    @property
    def room(self) -> str:
        """Folder or file of the package, or of the tree."""
        path = Path(self.file)
        inside = path.is_relative_to(PACKAGE)
        return (path.relative_to(PACKAGE) if inside else path).parts[0]

    def apply(self, text: bytes) -> bytes:
        """The text of the file with the error."""
        old, new = self.old.encode(), self.new.encode()
        if self.offset is None and text.count(old) != 1:
            raise SystemExit(f"{self.file}: {self.old!r} occurs {text.count(old)} times, not once")
        start = text.index(old) if self.offset is None else self.offset
        return text[:start] + new + text[start + len(old) :]


# --- errors at random -----------------------------------------------------------------------------

SIGNS = {
    ast.Lt: (b"<", b">="), ast.LtE: (b"<=", b">"), ast.Gt: (b">", b"<="), ast.GtE: (b">=", b"<"),
    ast.Eq: (b"==", b"!="), ast.NotEq: (b"!=", b"=="), ast.In: (b"in", b"not in"),
    ast.Add: (b"+", b"-"), ast.Sub: (b"-", b"+"), ast.Mult: (b"*", b"/"), ast.Div: (b"/", b"*"),
    ast.Pow: (b"**", b"*"), ast.BitAnd: (b"&", b"|"), ast.BitOr: (b"|", b"&"),
    ast.And: (b"and", b"or"), ast.Or: (b"or", b"and"),
}  # fmt: skip
EDGES = {ast.Lt: b"<=", ast.LtE: b"<", ast.Gt: b">=", ast.GtE: b">"}
DROPPED = {"sqrt", "abs", "log", "log10", "exp", "expm1", "sort", "cumsum", "diff", "unique"}
SYMMETRIC = {"maximum", "minimum", "max", "min", "hypot", "isclose", "allclose", "union1d"}
PAIRS = (
    "min max", "minimum maximum", "argmin argmax", "nanmin nanmax", "mean median", "any all",
    "floor ceil", "rows columns", "mean std", "ones zeros", "low high", "lower upper",
    "start stop", "begin end", "first last", "left right", "before after", "above below",
    "tested reference", "near far", "slips sticks", "slip stick", "positions velocities",
    "sine cosine", "rising falling", "HOLDS PARTLY", "transient duration", "longest shortest",
)  # fmt: skip
OPPOSITE = {a: b for pair in PAIRS for a, b in (pair.split(), pair.split()[::-1])}


def sites(file: Path) -> list[Plant]:
    """Every error that the operators can plant in one file."""
    text = (ROOT / file).read_bytes()
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []

    def span(node):
        begin = starts[node.lineno - 1] + node.col_offset
        return begin, starts[node.end_lineno - 1] + node.end_col_offset

    def plant(operator, begin, end, new):
        new = new if isinstance(new, str) else new.decode()
        found.append(Plant(str(file), text[begin:end].decode(), new, operator, begin))

    tree = ast.parse(text)
    words = set(re.findall(rb"\w+", text))
    keys = sorted({node.slice.value for node in ast.walk(tree) if _has_key(node)})
    for node in _code(tree):
        for operator in OPERATORS:
            operator(node, text, span, plant, words=words, keys=keys)
    return found


def _code(node):
    """Nodes that run: no docstrings, annotations, messages, imports or decorators."""
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            skipped = (ast.JoinedStr, ast.Raise, ast.Import, ast.ImportFrom)
            if not isinstance(child, ast.AST) or isinstance(child, skipped):
                continue
            if isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
                continue
            yield child
            yield from _code(child)


def _has_key(node):
    return (
        isinstance(node, ast.Subscript)
        and isinstance(node.slice, ast.Constant)
        and isinstance(node.slice.value, str)
    )


def _between(node):
    """(operator, left, right) of a comparison, a sum or product, or a logical expression."""
    if isinstance(node, ast.BinOp):
        yield node.op, node.left, node.right
    elif isinstance(node, ast.Compare):
        yield from zip(node.ops, [node.left, *node.comparators], node.comparators, strict=False)
    elif isinstance(node, ast.BoolOp):
        yield from ((node.op, *pair) for pair in zip(node.values, node.values[1:], strict=False))


def sign(node, text, span, plant, **_):
    """Comparison, arithmetic or logical sign turned round; edges of comparisons."""
    for operator, left, right in _between(node):
        begin, end = span(left)[1], span(right)[0]
        if type(operator) in SIGNS:
            old, new = SIGNS[type(operator)]
            at = begin + text[begin:end].index(old)
            plant("sign", at, at + len(old), new)
            if type(operator) in EDGES:
                plant("edge", at, at + len(old), EDGES[type(operator)])


def constant(node, text, span, plant, **_):
    """Number made larger: whole ones by one, others by half."""
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        value = node.value + 1 if type(node.value) is int else node.value * 1.5 or 1.0
        plant("constant", *span(node), repr(value))
    if isinstance(node, ast.Constant) and type(node.value) is bool:
        plant("constant", *span(node), repr(not node.value))


def function(node, text, span, plant, **_):
    """Function of one argument left out, as a square root; minus and negation left out."""
    if isinstance(node, ast.Call) and len(node.args) == 1 and not node.keywords:
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        if name in DROPPED:
            plant("function", span(node)[0], span(node.func)[1], b"")
    if isinstance(node, ast.UnaryOp):
        plant("function", span(node)[0], span(node.operand)[0], b"")


def arguments(node, text, span, plant, **_):
    """Neighbouring positional arguments swapped; keyword argument forgotten."""
    if not isinstance(node, ast.Call):
        return
    symmetric = getattr(node.func, "attr", getattr(node.func, "id", "")) in SYMMETRIC
    for one, two in zip(node.args, node.args[1:], strict=False):
        named = isinstance(one, (ast.Name, ast.Attribute)) and isinstance(two, type(one))
        if named and not symmetric:
            (a, b), (c, d) = span(one), span(two)
            plant("arguments", a, d, text[c:d] + text[b:c] + text[a:b])
    if node.keywords and (node.args or len(node.keywords) > 1):
        last = node.keywords[-1]
        before = [*node.args, *node.keywords][: len(node.args) + len(node.keywords) - 1]
        if last.arg not in (None, "strict", "dtype") and before:
            plant("arguments", max(span(item)[1] for item in before), span(last)[1], b"")


def name(node, text, span, plant, words, keys):
    """Another array of the file; the opposite of a word of a pair, where the file knows it."""
    if _has_key(node) and len(keys) > 1:
        place = keys.index(node.slice.value)
        plant("name", *span(node.slice), f'"{keys[place - 1]}"')
    if isinstance(node, (ast.Name, ast.Attribute)) and isinstance(node.ctx, ast.Load):
        own = node.id if isinstance(node, ast.Name) else node.attr
        parts = own.split("_")
        for index, part in enumerate(parts):
            other = "_".join([*parts[:index], OPPOSITE.get(part, part), *parts[index + 1 :]])
            known = other.encode() in words or (own in OPPOSITE and isinstance(node, ast.Attribute))
            if other != own and known:
                end = span(node)[1]
                plant("name", end - len(own), end, other)


def assignment(node, text, span, plant, **_):
    """Sum that grows made to shrink."""
    if isinstance(node, ast.AugAssign) and isinstance(node.op, (ast.Add, ast.Sub)):
        begin, end = span(node.target)[1], span(node.value)[0]
        old, new = SIGNS[type(node.op)]
        at = begin + text[begin:end].index(old)
        plant("assignment", at, at + 1, new)


OPERATORS = (sign, constant, function, arguments, name, assignment)


def draw(count: int, seed: int, rooms: list[str]) -> list[Plant]:
    """Errors at random: rooms in turn, then files by their size, then an operator, then a place."""
    choose = random.Random(seed)
    places = {room: [plant for file in files(room) for plant in sites(file)] for room in rooms}
    plants = []
    while len(plants) < count and any(places.values()):
        room = rooms[len(plants) % len(rooms)]
        file = choose.choice(places[room]).file
        own = [plant for plant in places[room] if plant.file == file]
        operator = choose.choice(sorted({plant.operator for plant in own}))
        chosen = choose.choice([plant for plant in own if plant.operator == operator])
        places[room].remove(chosen)
        plants.append(chosen)
    return plants


def files(room: str) -> list[Path]:
    """Python files of a room, paths from the root."""
    place = ROOT / PACKAGE / room
    found = [place] if place.suffix == ".py" else sorted(place.rglob("*.py"))
    if not found or not found[0].is_file():
        raise SystemExit(f"{room}: no such room in {PACKAGE}")
    return [path.relative_to(ROOT) for path in found if path.name != "__init__.py"]


# --- trials ---------------------------------------------------------------------------------------


def tests_for(file: str) -> list[str]:
    """Test files that can see a module by their imports: those that name it, then by their size.

    What is no module is seen by the tests of the workflow.
    """
    if not Path(file).is_relative_to(PACKAGE):
        return ["tests/test_workflow.py"]
    module = ".".join(Path(file).with_suffix("").relative_to("src").parts)
    ranks = {}
    for path in sorted((ROOT / "tests").glob("test_*.py")):
        named, seen = _imports(path)
        if module in seen:
            ranks[f"tests/{path.name}"] = (module not in named, len(seen))
    return sorted(ranks, key=ranks.get)


@functools.cache
def _imports(path):
    """Modules that a test file names, and all that these need."""
    provenance = _provenance()
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    names = {name for name in names if name.startswith("beltrepro")}
    return names, provenance.module_closure(*names)


@functools.cache
def _provenance():
    """That module by its file: the package must not be loaded before a trial loads the copy."""
    place = ROOT / PACKAGE / "provenance.py"
    specification = importlib.util.spec_from_file_location("provenance", place)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def attempt(tree: Path, plant: Plant, tests: list[str]) -> str:
    """Outcome of the tests with one error in the tree: the first failing test, or "survived"."""
    path = tree / plant.file
    right, stamp = path.read_bytes(), path.stat()
    try:
        path.write_bytes(plant.apply(right))
        return run(tree, tests)
    finally:
        path.write_bytes(right)
        os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))


def run(tree: Path, tests: list[str], limit: float = LIMIT) -> str:
    """Run tests in a process of their own: first failing test, or "survived"."""
    context = multiprocessing.get_context("fork")
    queue = context.SimpleQueue()
    process = context.Process(target=_pytest, args=(tree, tests, queue))
    process.start()
    process.join(limit)
    if process.is_alive():
        process.kill()
        process.join()
        return "noticed: takes too long"
    return "noticed: the process dies" if queue.empty() else queue.get()


class _FirstFailure:
    def __init__(self):
        self.where = ""

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self.where = self.where or report.nodeid

    def pytest_collectreport(self, report):
        if report.failed:
            self.where = self.where or report.nodeid


def _pytest(tree, tests, queue):
    os.chdir(tree)
    os.nice(5)
    sys.path[:0] = [str(tree / "src"), str(tree / "tests")]
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    failure = _FirstFailure()
    code = pytest.main(["-x", "-q", "-p", "no:cacheprovider", *tests], plugins=[failure])
    queue.put(f"noticed: {failure.where or code}" if code else "survived")


def copy_tree() -> Path:
    """Copy of the tree with time stamps and compiled kernels."""
    tree = Path(tempfile.mkdtemp(prefix="planting-"))
    shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(*NOT_COPIED), dirs_exist_ok=True)
    return tree


def main():
    """Command line; see the top of the file."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--plants", type=Path, help="YAML list of errors: file, old, new")
    parser.add_argument("--draw", type=int, default=0, help="number of errors drawn at random")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rooms", default=ROOMS, help=f"default: {ROOMS}")
    parser.add_argument("--all", action="store_true", help="run the whole quick suite")
    parser.add_argument("--tests", nargs="+", help="run only these, where they see the module")
    parser.add_argument("--list", action="store_true", help="only show the errors")
    parser.add_argument("--write", type=Path, help="YAML list of the errors with their outcome")
    options = parser.parse_args()

    listed = yaml.safe_load(options.plants.read_text()) if options.plants else []
    known = [field.name for field in fields(Plant)]  # a list may say more, for its reader
    plants = [Plant(**{name: entry[name] for name in known if name in entry}) for entry in listed]
    plants += draw(options.draw, options.seed, options.rooms.split(","))
    tree = copy_tree()
    os.environ["PYTHONPATH"] = str(tree / "src")
    sys.dont_write_bytecode = False  # compiled once in the copy, whatever the environment says
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    try:
        chosen = [["tests"] if options.all else tests_for(plant.file) for plant in plants]
        if options.tests:
            chosen = [[test for test in tests if test in options.tests] for tests in chosen]
        if not options.list:
            _prepare(tree, sorted({test for tests in chosen for test in tests}))
        for number, (plant, tests) in enumerate(zip(plants, chosen, strict=True), 1):
            if not options.list:
                plant.outcome = attempt(tree, plant, tests) if tests else "survived: no tests"
            print(_line(number, plant), flush=True)
            if options.write:
                text = yaml.safe_dump([asdict(plant) for plant in plants], sort_keys=False)
                options.write.write_text(text)
    finally:
        shutil.rmtree(tree)
    for room in sorted({plant.room for plant in plants if plant.outcome}):
        own = [plant.outcome.startswith("noticed") for plant in plants if plant.room == room]
        print(f"{room}: {sum(own)} of {len(own)} noticed")


def _prepare(tree, tests):
    """Load the libraries that trials share, and see that the tests pass without an error."""
    for library in LIBRARIES:
        importlib.import_module(library)
    assert not any(name.startswith("beltrepro") for name in sys.modules), "loaded too early"
    outcome = run(tree, tests, limit=LIMIT_WITHOUT)
    if outcome != "survived":
        raise SystemExit(f"the tests fail without any error planted: {outcome}")


def _line(number, plant):
    text = (ROOT / plant.file).read_bytes()
    place = text.find(plant.old.encode()) if plant.offset is None else plant.offset
    row = text[:place].count(b"\n") + 1
    change = " -> ".join(" ".join(part.split()) or "(nothing)" for part in (plant.old, plant.new))
    line = text.splitlines()[row - 1].decode().strip()
    place = f"{plant.file.removeprefix('src/beltrepro/')}:{row}"
    return f"{number:3} {place} {plant.operator}: {change}  [{line}]\n      {plant.outcome}"


if __name__ == "__main__":
    main()
