"""Plant small errors, one at a time, in a copy of the tree and see which the quick tests notice.

    python tests/support/planting.py --draw 40 --seed 7 --rooms stats,replication/studies
    python tests/support/planting.py --plants errors.yaml --all

Errors come from a list (YAML: entries with `file`, `old`, `new`, where `old` occurs once in the
file; paths from the root of the tree) or are drawn at random from the sources, without a look at
the tests: see `OPERATORS`. A room is a folder or file of src/beltrepro, or of the tree. By default
the test files run that name the changed module or its room; --all runs the rest of the quick suite
after them, which alone says that an error is not noticed. --write keeps the list with its outcome,
to be judged by hand: a change that leaves every result as it was is no error.

Mutation tools on the market rewrite functions in ways that Numba cannot compile. This one works in
a copy and leaves alone the time stamps of the other files, so that compiled kernels stay valid.
"""

import argparse
import ast
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
PACKAGE = Path("src/beltrepro")
NOT_COPIED = (".git", ".venv", ".snakemake", ".pytest_cache", "logs")
LIMIT = 600.0  # seconds for the tests of one planted error
TOO_LONG = ["takes too long"]
TESTS_OF_WORKFLOW = ["tests/plan"]


@dataclass
class Plant:
    """One error: `old`, at a byte offset of the file or where it occurs once, becomes `new`."""

    file: str
    old: str
    new: str
    operator: str = ""
    offset: int | None = None
    outcome: str = ""

    def place(self, text: bytes) -> int:
        """Offset in the text of the file."""
        if self.offset is not None:
            return self.offset
        if (count := text.count(self.old.encode())) != 1:
            raise SystemExit(f"{self.file}: {self.old!r} occurs {count} times, not once")
        return text.index(self.old.encode())

    def apply(self, text: bytes) -> bytes:
        """The text of the file with the error."""
        start = self.place(text)
        return text[:start] + self.new.encode() + text[start + len(self.old.encode()) :]

    def __str__(self) -> str:
        text = (ROOT / self.file).read_bytes()
        row = text[: self.place(text)].count(b"\n")
        old, new = (" ".join(part.split()) or "(nothing)" for part in (self.old, self.new))
        line = text.splitlines()[row].decode().strip()
        return f"{self.file}:{row + 1} {self.operator}: {old} -> {new}  [{line}]"


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
    plants = []

    def span(node):
        begin = starts[node.lineno - 1] + node.col_offset
        return begin, starts[node.end_lineno - 1] + node.end_col_offset

    def plant(operator, begin, end, new):
        new = new if isinstance(new, str) else new.decode()
        plants.append(Plant(str(file), text[begin:end].decode(), new, operator, begin))

    tree = ast.parse(text)
    words = set(re.findall(rb"\w+", text))
    keys = sorted({node.slice.value for node in ast.walk(tree) if _has_key(node)})
    for node in _code(tree):
        for operator in OPERATORS:
            operator(node, text, span, plant, words=words, keys=keys)
    return plants


def _code(node):
    """Nodes that run: no docstrings, annotations, messages, imports or decorators."""
    skipped = (ast.JoinedStr, ast.Raise, ast.Import, ast.ImportFrom)
    for field, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            words = isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant)
            told = field in ("annotation", "returns", "decorator_list")
            if isinstance(child, ast.AST) and not (told or words or isinstance(child, skipped)):
                yield child
                yield from _code(child)


def _has_key(node):
    key = node.slice if isinstance(node, ast.Subscript) else None
    return isinstance(key, ast.Constant) and isinstance(key.value, str)


def _between(node):
    """(operator, left, right) of a comparison, a sum or product, or a logical expression."""
    if isinstance(node, ast.BinOp):
        yield node.op, node.left, node.right
    elif isinstance(node, ast.Compare):
        yield from zip(node.ops, [node.left, *node.comparators], node.comparators, strict=False)
    elif isinstance(node, ast.AugAssign):
        yield node.op, node.target, node.value
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
        word = node.id if isinstance(node, ast.Name) else node.attr
        parts = word.split("_")
        for index, part in enumerate(parts):
            other = "_".join([*parts[:index], OPPOSITE.get(part, part), *parts[index + 1 :]])
            attribute = word in OPPOSITE and isinstance(node, ast.Attribute)
            if other != word and (attribute or other.encode() in words):
                end = span(node)[1]
                plant("name", end - len(word), end, other)


OPERATORS = (sign, constant, function, arguments, name)


def draw(count: int, seed: int, rooms: list[str]) -> list[Plant]:
    """Errors at random: rooms in turn, then files by their size, then an operator, then a place."""
    choose = random.Random(seed)
    places = {room: [plant for file in files(room) for plant in sites(file)] for room in rooms}
    plants = []
    while len(plants) < count and any(places.values()):
        room = rooms[len(plants) % len(rooms)]
        file = choose.choice(places[room]).file
        in_file = [plant for plant in places[room] if plant.file == file]
        operator = choose.choice(sorted({plant.operator for plant in in_file}))
        chosen = choose.choice([plant for plant in in_file if plant.operator == operator])
        places[room].remove(chosen)
        plants.append(chosen)
    return plants


def all_rooms() -> list[str]:
    """Folders of the package, those of the replication each by itself."""
    top = ROOT / PACKAGE
    places = [*top.iterdir(), *(top / "replication").iterdir()]
    rooms = [str(place.relative_to(top)) for place in sorted(places) if any(place.glob("*.py"))]
    return [room for room in rooms if room != "replication"]


def files(room: str) -> list[Path]:
    """Python files of a room, paths from the root."""
    place = next((top / room for top in (ROOT / PACKAGE, ROOT) if (top / room).exists()), None)
    if place is None:
        raise SystemExit(f"{room}: no such room; there are {', '.join(all_rooms())}")
    paths = [place] if place.is_file() else sorted(place.rglob("*.py"))
    return [path.relative_to(ROOT) for path in paths if path.name != "__init__.py"]


# --- trials ---------------------------------------------------------------------------------------


def tests_for(file: str) -> list[str]:
    """Test files that name a module, then those that name its room; the workflow's for the rest."""
    if not Path(file).is_relative_to(PACKAGE):
        return TESTS_OF_WORKFLOW
    *above, stem = Path(file).with_suffix("").relative_to("src").parts
    room = r"\.".join(above)
    names = re.compile(rf"{room}(\.{stem}\b| import [^)]*?\b{stem}\b)"), re.compile(rf"{room}\b")
    texts = {path: path.read_text() for path in sorted((ROOT / "tests").rglob("test_*.py"))}
    paths = [path for name in names for path, text in texts.items() if name.search(text)]
    return [str(path.relative_to(ROOT)) for path in dict.fromkeys(paths)]


def attempt(tree: Path, plant: Plant, tests: list[str], options: list[str]) -> str:
    """Outcome of the tests with one error: the first that fails, "survived", or none in time."""
    path = tree / plant.file
    right, stamp = path.read_bytes(), path.stat()
    path.write_bytes(plant.apply(right))
    failed = run(tree, tests, [*options, "-x"], LIMIT)
    path.write_bytes(right)
    os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    if failed == TOO_LONG:  # an endless loop, or a slow machine: to be judged by hand
        return f"no answer in {LIMIT:.0f} s"
    return f"noticed: {failed[0]}" if failed else "survived"


def run(tree: Path, tests: list[str], options: list[str], limit: float | None = None) -> list[str]:
    """Run tests in a process of their own: those that fail, or why there is no answer."""
    environment = os.environ | {"PYTHONPATH": str(tree / "src")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # compiled once, whatever the outside says
    command = [sys.executable, "-m", "pytest", "-q", "-rfE", "-p", "no:cacheprovider"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    how = {"cwd": tree, "env": environment, "start_new_session": True}
    process = subprocess.Popen([*command, *options, *tests], **pipes, **how)
    try:
        text, _ = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        return TOO_LONG
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)  # with all that the tests have started
            process.wait()
    failed = re.findall(r"^(?:FAILED|ERROR) (\S+)", text, re.M)
    return failed or ([f"exit status {process.returncode}"] if process.returncode else [])


def main():
    """Command line; see the top of the file."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    add = parser.add_argument
    add("--plants", type=Path, help="YAML list of errors: file, old, new")
    add("--draw", type=int, default=0, help="number of errors drawn at random")
    add("--seed", type=int, default=0)
    add("--rooms", help="some rooms, with commas; default: every folder of src/beltrepro")
    add("--all", action="store_true", help="run the rest of the quick suite, too")
    add("--workers", type=int, default=1, help="processes that run the tests (1)")
    add("--list", action="store_true", help="only show the errors, and which tests would run")
    add("--write", type=Path, help="YAML list of the errors with their outcome")
    options = parser.parse_args()

    listed = yaml.safe_load(options.plants.read_text()) if options.plants else []
    names = [field.name for field in fields(Plant)]  # a list may say more, for its reader
    plants = [Plant(**{name: entry[name] for name in names if name in entry}) for entry in listed]
    rooms = options.rooms.split(",") if options.rooms else all_rooms()
    plants += draw(options.draw, options.seed, rooms)
    chosen = [tests_for(plant.file) for plant in plants]
    if options.list:
        for number, (plant, tests) in enumerate(zip(plants, chosen, strict=True), 1):
            print(f"{number:3} {plant}\n      {len(tests)} files: {' '.join(tests[:6])}")
        return
    tree = Path(tempfile.mkdtemp(prefix="planting-"))
    try:
        shutil.copytree(ROOT, tree, ignore=_not_copied, dirs_exist_ok=True)
        before = ["tests"] if options.all else sorted({test for tests in chosen for test in tests})
        settings = ["-n", str(options.workers)] if options.workers > 1 else []
        for failed in run(tree, before, settings):
            print(f"fails without any error planted, and is left out: {failed}", flush=True)
            settings += ["--deselect", failed]
        for number, (plant, tests) in enumerate(zip(plants, chosen, strict=True), 1):
            begin = time.perf_counter()
            plant.outcome = attempt(tree, plant, tests, settings) if tests else "survived"
            if options.all and plant.outcome == "survived":
                plant.outcome = attempt(tree, plant, ["tests"], settings)
            spent = time.perf_counter() - begin
            print(f"{number:3} {plant}\n      {plant.outcome} ({spent:.0f} s)", flush=True)
            if options.write:
                text = yaml.safe_dump([asdict(plant) for plant in plants], sort_keys=False)
                options.write.write_text(text)
    finally:
        shutil.rmtree(tree)
    _print_sums(plants)


def _not_copied(folder, names):
    if Path(folder) == ROOT / "results":  # runs may be there
        return [name for name in names if name != "README.md"]
    return [name for name in names if Path(folder) == ROOT and name in NOT_COPIED]


def _print_sums(plants):
    """How many errors were noticed, by folder."""
    folders = [str(Path(plant.file).parent).removeprefix(f"{PACKAGE}/") for plant in plants]
    of_folder = Counter(folders + ["all"] * len(plants))
    noticed = Counter()
    for folder, plant in zip(folders, plants, strict=True):
        noticed.update(dict.fromkeys((folder, "all"), plant.outcome.startswith("noticed")))
    for folder, count in of_folder.items():
        print(f"{folder}: {noticed[folder]} of {count} noticed")


if __name__ == "__main__":
    main()
