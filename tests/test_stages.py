"""The shape of the sources: no stage imports one that comes after it, a method's name stands in one place, functions are short."""
import ast
import re
from pathlib import Path

import pytest
from smidgen.methods import NAMES

ROOT = Path(__file__).parent.parent
GEN = ROOT / "gen"
STAGES = ("language", "read", "compile", "build", "run", "analyse", "check", "cost", "show", "cli")
COMPILE = ("select", "program", "features", "derive", "lower", "plan", "assemble", "emit")
# Functions that a public object offers and a later stage carries out; they import it when they are called.
FORWARDED = {("build/export.py", "check"), ("run/files/output.py", "show")}
LONGEST = 40        # lines of a function

pytestmark = pytest.mark.quick


def modules():
    return sorted(p for p in GEN.rglob("*.py") if "__pycache__" not in p.parts)


def imported(path: Path):
    """(the module's parts below gen, the same of what it imports) of every relative import."""
    here = path.relative_to(GEN).with_suffix("").parts
    package = here[:-1]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = package[:len(package) - node.level + 1]
            target = (*base, *(node.module.split(".") if node.module else ()))
            for name in node.names:
                yield here, (*target, name.name)


def upward(path: Path, order, depth: int):
    for here, target in imported(path):
        if len(here) > depth and len(target) > depth and here[:depth] == target[:depth] and here[depth] in order and target[depth] in order:
            if order.index(target[depth]) > order.index(here[depth]):
                yield "/".join(target)


@pytest.mark.parametrize("path", modules(), ids=lambda p: str(p.relative_to(GEN)))
def test_no_stage_imports_a_later_one(path):
    name = str(path.relative_to(GEN))
    found = [t for t in upward(path, STAGES, 0) if (name, t.split("/")[0]) not in FORWARDED]
    found += list(upward(path, COMPILE, 1)) if name.startswith("compile/") else []
    assert found == []


def test_the_name_of_a_method_stands_in_the_registry_alone():
    """Beside it: the witness, which knows its own, its tests, documents, and an example in the help of a command."""
    spared = {"methods.py", "cli/gen.py", "show/plot/figures.py"}
    files = [p for p in [*modules(), *(ROOT / "templates").glob("*")] if "witness" not in p.parts]
    found = {str(p.relative_to(ROOT)) for p in files for name in NAMES
             if name in p.read_text() and str(p.relative_to(GEN if p.is_relative_to(GEN) else ROOT)) not in spared}
    assert found == set()


def long_functions():
    for path in modules():
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and node.end_lineno - node.lineno >= LONGEST:
                yield f"{path.relative_to(ROOT)}: {node.name}, {node.end_lineno - node.lineno + 1} lines"
    for path in (ROOT / "runtime").rglob("*.h"):
        for match in re.finditer(r"^(?:static|SMG_\w+)[^;{]*?(\w+)\([^;{]*\) \{\n(?:.*\n)*?\}\n", path.read_text(), re.MULTILINE):
            if match[0].count("\n") > LONGEST:
                yield f"{path.relative_to(ROOT)}: {match[1]}, {match[0].count(chr(10))} lines"


def test_functions_are_short():
    assert list(long_functions()) == []


def test_no_header_defines_a_function_that_other_files_see():
    """Two models are linked into one program: what headers define is static."""
    found = [f"{path.name}: {line}" for path in (ROOT / "runtime").rglob("*.h") for line in path.read_text().splitlines()
             if re.match(r"(?!static|SMG_INLINE|SMG_COLD static|typedef|#|/|\s|return|extern)\w[\w *]*\w+\([^;]*\) \{", line)]
    assert found == []


def test_templates_are_shells():
    assert sum(len(p.read_text().splitlines()) for p in (ROOT / "templates").glob("*")) < 700


def test_slow_tests_are_tests():
    """A name that no longer is one would leave its test in `make test` unseen."""
    names = [line for line in (ROOT / "tests/slow.txt").read_text().splitlines() if not line.startswith("#")]
    assert names == sorted(set(names)) and len(names) > 100
    for name in names:
        file, _, test = name.partition("::")
        assert f"def {test.partition('[')[0]}(" in (ROOT / file).read_text(), name


def test_tests_stand_in_the_order_of_the_sources():
    """A folder for each stage, of its name; beside them the runtime and its methods, laws, and what has a command of its own."""
    folders = {path.parent.name for path in (ROOT / "tests").glob("*/test_*.py")}
    assert folders - set(STAGES) == {"runtime", "method", "laws", "linking", "fuzz", "frozen", "hard", "mutants"} and set(STAGES) <= folders
    assert [path.name for path in (ROOT / "tests").glob("test_*.py")] == ["test_stages.py"]
