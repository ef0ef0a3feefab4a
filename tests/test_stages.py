"""The shape of the sources: no room imports one that lies above it, a method's name stands in one place, functions are short."""
import ast
import fnmatch
import io
import re
import tokenize
from pathlib import Path

import pytest
from smidgen.build.binary import GENERATOR
from smidgen.methods import NAMES
from support import file_index, imports

ROOT = Path(__file__).parent.parent
GEN = ROOT / "gen"
STAGES = {room.partition("/")[0] for room in imports.FLOOR} - {"shared", imports.TOP}
LONGEST = 40        # lines of a function

pytestmark = pytest.mark.quick


def modules():
    return sorted(p for p in GEN.rglob("*.py") if "__pycache__" not in p.parts)


@pytest.fixture(scope="module")
def arrows():
    return imports.imports(imports.modules())


def test_no_room_imports_one_that_lies_above_it(arrows):
    """FLOORS of tests/support/imports.py; a room that it does not have is named."""
    assert imports.upward(imports.rooms(arrows)) == []


def test_there_is_no_circle_of_imports(arrows):
    """Of rooms, and of modules; those inside functions count, which Python would forgive."""
    assert imports.circle(imports.rooms(arrows)) == [] and imports.circle(arrows) == []


def test_the_picture_of_imports_is_that_of_the_sources(arrows):
    """`make imports` draws it anew."""
    text = imports.DOCUMENT.read_text()
    assert imports.written(text, imports.picture(imports.rooms(arrows))) == text


def test_a_library_is_found_again_only_by_the_compiler_that_made_it(arrows):
    """Its digest is of all that the emitter imports, directly or not, but words of errors, where files lie, and old names."""
    wanted, seen = [m for m in arrows if m[0] == "compile"], set()
    while wanted:
        seen.add(module := wanted.pop())
        wanted += arrows[module] - seen
    beside = {module[0] if len(module) > 1 else f"{module[0]}.py" for module in seen} - set(GENERATOR)
    assert beside == {"errors.py", "public.py", "renamed.py", "resources.py"}


def test_every_source_file_says_what_it_is_and_the_page_of_files_has_it():
    """`make files` writes it anew."""
    assert file_index.without_comment() == []
    page = file_index.page()
    assert file_index.PAGE.read_text() == page and ", |" not in page        # a sentence ends


def test_the_first_sentence_of_a_file(tmp_path):
    """Of a docstring, of comments of C, JavaScript and templates; full stops within parentheses do not end it."""
    def of(name, text):
        (tmp_path / name).write_text(text)
        return file_index.sentence_of(tmp_path / name)
    assert of("a.py", '"""Steps (A. Author, J. Phys. (2009)) of order 2. And more.\n\nMore."""') == "Steps (A. Author, J. Phys. (2009)) of order 2"
    assert of("a.h", "/* smidgen runtime: arrays of\n * n numbers.\n *\n * More. */") == "Arrays of n numbers"
    assert of("a.mjs", "// Lines,\n// drawn. More.\n") == "Lines, drawn"
    assert of("a.j2", "{# The source of {{ M }}. -#}\n#include <a.h>\n/* no */") == "The source of <model>"
    assert of("b.h", "#include <a.h>\n/* Of a function. */") == of("b.py", "x = 1\n") == ""


def test_all_imports_of_modules_are_relative():
    """The picture shows those alone."""
    named = {(path, getattr(node, "module", None) or node.names[0].name) for path in modules() for node in ast.walk(ast.parse(path.read_text()))
             if isinstance(node, (ast.Import, ast.ImportFrom)) and not getattr(node, "level", 0)}
    assert {path for path, module in named if module.split(".")[0] == "smidgen"} == set()


def test_an_arrow_upward_and_a_circle_are_seen():
    assert imports.upward({"read": {"run"}, "run": {"read"}, "attic": set()}) == ["no floor for attic: FLOORS of tests/support/imports.py", "read -> run"]
    assert set(imports.circle({"a": {"b"}, "b": {"c"}, "c": {"a"}})) == {"a", "b", "c"}
    assert imports.reduced({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == {"a": {"b"}, "b": {"c"}, "c": set()}


def test_files_of_tests_have_names_of_their_own():
    """pytest imports them by name alone."""
    names = [path.name for path in (ROOT / "tests").rglob("test_*.py")]
    assert {name for name in names if names.count(name) > 1} == set()


def test_no_folder_of_tests_is_left_out(request):
    """pytest passes by folders of some names, `build` among them, unless it is told otherwise."""
    left_out = request.config.getini("norecursedirs")
    folders = {part for path in (ROOT / "tests").rglob("test_*.py") for part in path.relative_to(ROOT).parts[:-1]}
    assert {name for name in folders if any(fnmatch.fnmatch(name, pattern) for pattern in left_out)} == set()


def test_the_name_of_a_method_stands_in_the_registry_alone():
    """Beside it: the witness, which knows its own, its tests, documents, and an example in the help of a command."""
    spared = {"methods.py", "cli/gen.py", "show/plot/figures.py"}
    files = [p for p in [*modules(), *(ROOT / "templates").glob("*")] if "witness" not in p.parts]
    found = {str(p.relative_to(ROOT)) for p in files for name in NAMES
             if name in p.read_text() and str(p.relative_to(GEN if p.is_relative_to(GEN) else ROOT)) not in spared}
    assert found == set()


def lines_of_code(function) -> int:
    """The lines of a function but for its docstring, in which a public function lists its arguments."""
    first = function.body[0]
    said = first.end_lineno - first.lineno + 1 if ast.get_docstring(function, clean=False) is not None else 0
    return function.end_lineno - function.lineno + 1 - said


def long_functions():
    for path in modules():
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and lines_of_code(node) > LONGEST:
                yield f"{path.relative_to(ROOT)}: {node.name}, {lines_of_code(node)} lines"
    for path in (ROOT / "runtime").rglob("*.h"):
        for match in re.finditer(r"^(?:static|SMG_\w+)[^;{]*?(\w+)\([^;{]*\) \{\n(?:.*\n)*?\}\n", path.read_text(), re.MULTILINE):
            if match[0].count("\n") > LONGEST:
                yield f"{path.relative_to(ROOT)}: {match[1]}, {match[0].count(chr(10))} lines"


def test_functions_are_short():
    assert list(long_functions()) == []


def test_no_header_defines_a_function_that_other_files_see():
    """Two models are linked into one program: what headers define is static, has the model's name (smg_interface.h), or is static where SMG_LINKED says so (smg_defaults.h)."""
    found = [f"{path.name}: {line}" for path in (ROOT / "runtime").rglob("*.h") for line in path.read_text().splitlines()
             if "SMG_PUBLIC(" not in line and not line.startswith("SMG_LINKED ") and re.match(r"(?!static|SMG_INLINE|(?:SMG_COLD |SMG_RARE |SMG_APART )+static|typedef|#|/|\s|return|extern)\w[\w *]*\w+\([^;]*\) \{", line)]
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
    assert folders - STAGES == {"runtime", "method", "laws", "linking", "fuzz", "frozen", "hard", "mutants", "covered"} and STAGES <= folders
    assert [path.name for path in (ROOT / "tests").glob("test_*.py")] == ["test_stages.py"]


# A path from the root, or the name of a header or of a file of tests
FILE = re.compile(r"(?<![\w./-])((?:gen|runtime|templates|tests|docs|specs)/[\w./-]*\w\.[a-z]\w*)|\b((?:smg|test)_\w+\.(?:h|py))\b")
DATED = {"docs/mutants.md"}       # a record: it names files as they were when the faults were planted


def explained(path: Path) -> str:
    """What a file says to its readers: comments and docstrings; of a document or a template all of it."""
    text = path.read_text()
    if path.suffix == ".h":
        return "\n".join(re.findall(r"/\*.*?\*/", text, re.DOTALL))
    if path.suffix != ".py":
        return text
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return "\n".join(k.string for k in tokens if k.type == tokenize.COMMENT or k.type == tokenize.STRING and '"""' in k.string[:4])


def missing(text: str, names: set) -> list:
    """The files that it names and that are not there; `names`: of all that are."""
    return [path or name for path, name in FILE.findall(text) if not (name in names if name else (ROOT / path).exists())]


def test_files_that_comments_and_documents_name_are_there():
    folders = [ROOT / name for name in ("gen", "runtime", "templates", "tests", "docs")]
    names = {path.name for folder in folders for path in folder.rglob("*.*")}
    told = [*modules(), *(ROOT / "runtime").rglob("*.h"), *(ROOT / "templates").rglob("*.j2"), *(ROOT / "docs").rglob("*.md"), ROOT / "README.md"]
    found = {str(path.relative_to(ROOT)): missing(explained(path), names) for path in told}
    assert len(told) > 200 and {path: files for path, files in found.items() if files and path not in DATED} == {}
    assert missing("as gen/attic/old.py and smg_gone.h say, not smg_step.h of runtime/core", names) == ["gen/attic/old.py", "smg_gone.h"]


def unused(text: str) -> list:
    """Names that a module imports and does not use; those of `# noqa` are for others."""
    tree, lines = ast.parse(text), text.splitlines()
    told = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)}       # annotations, __all__
    used = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)} | {word for text in told for word in re.findall(r"\w+", text) if len(text) < 80}
    named = [(node, (alias.asname or alias.name).split(".")[0]) for node in ast.walk(tree) if isinstance(node, (ast.Import, ast.ImportFrom))
             and getattr(node, "module", None) != "__future__" for alias in node.names]
    return [name for node, name in named if name not in used and not any("noqa" in line for line in lines[node.lineno - 1:node.end_lineno])]


def test_what_is_imported_is_used():
    found = {str(path.relative_to(ROOT)): unused(path.read_text()) for path in modules() if path.name != "__init__.py"}
    assert {path: names for path, names in found.items() if names} == {}
    assert unused("import ast\nimport re\nfrom a import b, c as d\nre.match(d)") == ["ast", "b"]
