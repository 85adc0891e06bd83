"""What is public is documented in full, and nothing else has such sections."""

import ast
import dataclasses
import importlib
import inspect
import operator
import re
from pathlib import Path

import pytest
from numpydoc.docscrape import FunctionDoc
from numpydoc.validate import validate

import beltrepro
from beltrepro import Setup

# docstring, sections in order, parameters all there, in order, with types and descriptions, returns
RULES = {"GL06", "GL07", "GL08", "PR01", "PR02", "PR03", "PR04", "PR07", "PR10", "RT01", "RT03"}
SECTION = re.compile(r"^\s*(Parameters|Attributes|Returns|Yields|Raises)\n\s*---", re.M)


def members():
    """Dotted names of all that is public, without the properties: they return what they are."""
    for name in beltrepro.__all__:
        item = getattr(beltrepro, name)
        yield f"beltrepro.{name}"
        if inspect.isclass(item):
            for method, value in vars(item).items():
                if not method.startswith("_") and callable(getattr(value, "__func__", value)):
                    yield f"beltrepro.{name}.{method}"


@pytest.mark.parametrize("name", list(members()))
def test_public_docstrings_are_complete(name):
    errors = {code: words for code, words in validate(name)["errors"] if code in RULES}
    item = getattr(beltrepro, name.split(".")[1])
    if name.count(".") == 1 and (attributes := FunctionDoc(item)["Attributes"]):
        errors.pop("PR01", None)  # a value with fields, which functions make
        if dataclasses.is_dataclass(item):
            listed = [field for part in attributes for field in part.name.split(", ")]
            assert listed == [field.name for field in dataclasses.fields(item)]
    assert not errors
    item = operator.attrgetter(name.removeprefix("beltrepro."))(beltrepro)
    if hasattr(item, "__wrapped__"):  # by `names.checked`: an argument can be wrong
        assert FunctionDoc(item)["Raises"]


def test_functions_show_the_keywords_of_a_setup_with_their_words():
    keywords = list(inspect.signature(Setup).parameters.values())[1:]
    words = {one.name: one.desc for one in FunctionDoc(Setup)["Attributes"]}
    shown = []
    for name in beltrepro.__all__:
        function = getattr(beltrepro, name)
        if inspect.isfunction(function) and "workers" in inspect.signature(function).parameters:
            assert list(inspect.signature(function).parameters.values())[-9:] == keywords
            described = {one.name: one.desc for one in FunctionDoc(function)["Parameters"]}
            assert described.items() >= {w: words[w] for w in list(words)[1:-1]}.items()
            shown.append(name)
    assert len(shown) == 10 and {"simulate", "scan", "basins"} <= set(shown)


def test_nothing_else_has_such_sections():
    package = Path(beltrepro.__file__).parent
    public = {getattr(beltrepro, name).__qualname__ for name in beltrepro.__all__}
    wrong = []
    for path in sorted(package.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                for child in ast.iter_child_nodes(node):
                    child.owner = node.name
                owner = getattr(node, "owner", node.name)
                if owner not in public and SECTION.search(ast.get_docstring(node) or ""):
                    wrong.append(f"{path.relative_to(package)}: {owner}, {node.name}")
    assert not wrong


def test_every_name_can_be_imported_from_where_it_is_said_to_be():
    for name in beltrepro.__all__:
        item = getattr(beltrepro, name)
        assert getattr(importlib.import_module(item.__module__), name) is item
