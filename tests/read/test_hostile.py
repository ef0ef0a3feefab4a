"""Input that means harm, or no sense at all: an error of its own, never a traceback."""
import ast
import os
import random
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from smidgen.errors import SpecError
from smidgen.read import load, load_text
from smidgen.language.spec import Spec
from test_limits import codes, energy
from test_read import spec_of

pytestmark = pytest.mark.quick
ROOT = Path(__file__).parents[2]
SHIPPED = [p.read_text(encoding="utf-8") for p in sorted((ROOT / "specs").glob("*.toml"))]


def judged(text: str):
    """A Spec, or a SpecError whose message can be printed; any other exception is a failure."""
    try:
        spec = load_text(text)
        assert isinstance(spec, Spec)
    except SpecError as error:
        assert str(error).isprintable() or "\n" in str(error)
        str(error).encode("utf-8")


# Fuzzing

@settings(max_examples=300, deadline=None)
@given(st.text(max_size=300))
def test_any_text(text):
    judged(text)


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=300))
def test_any_bytes(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("bytes") / "s.toml"
    path.write_bytes(data)
    with pytest.raises(SpecError):
        load(path)


WORDS = ("w w[i] w[0] w[ ] i j n J t pi x .x .z . .. 1 2.5 1e9 9999999999999999999 + - * / ^ ** ( ) "
         ", < <= == != and or not if( dot( cross( vec( norm( sin( log( f( f g( h [ ' \\ \" \n "
         "__class__ lambda import \u00b2 \u0301 \u202e \uff11 inf nan True None").split(" ")


@settings(max_examples=500, deadline=None)
@given(st.lists(st.sampled_from(WORDS), max_size=30))
def test_any_tokens(words):
    formula = "".join(words).replace("\\", "\\\\").replace('"', '\\"')
    judged(energy(formula, '[formulas]\n"f(u)" = "u*u"\n"g(u, k)" = "u + w[k].z"\nh = "f(f(2))"\n'))


@settings(max_examples=200, deadline=None)
@given(st.lists(st.sampled_from("site( pair( each( bond( edge( i , j n ) of on w g l l.a chain( "
                                "square( cubic( periodic open 2 - . [ (".split()), max_size=14))
def test_any_index_family(words):
    judged(spec_of('[lattices.l]\nsize = ["n"]\nboundary = "open"\nbonds.a = [{ offset = [1] }]\n'
                   f'[effects.e]\nover = "{" ".join(words)}"\nenergy = "1"\n'))


@pytest.mark.parametrize("seed", range(20))
def test_damaged_specs(seed):
    """Shipped specs with pieces cut out, doubled, exchanged or overwritten."""
    chance = random.Random(seed)
    for _ in range(20):
        text = list(chance.choice(SHIPPED))
        for _ in range(chance.randint(1, 4)):
            a, b = sorted(chance.randrange(len(text)) for _ in range(2))
            b = min(b, a + 40)
            damage = chance.choice(("cut", "double", "overwrite", "move"))
            piece = text[a:b]
            if damage == "double":
                text[b:b] = piece
            elif damage == "overwrite":
                text[a:b] = [chance.choice("[]{}\"'=.,#\\\n 0w(") for _ in piece]
            else:
                text[a:b] = []
                if damage == "move":
                    text[chance.randrange(len(text) + 1):0] = piece
        judged("".join(text))


# Files

def graph_codes(folder: Path, name: str) -> list[str]:
    text = spec_of(f'[graphs.g]\nfile = "{name}"\n[effects.e]\nover = "edge(i, j) of g"\n'
                   'energy = "dot(w[i], w[j])"\n')
    return codes(text, str(folder / "s.toml"))


@pytest.fixture
def folder(tmp_path):
    """A folder `home` for a spec, with a table; and a table outside of it."""
    home = tmp_path / "home"
    (home / "inner").mkdir(parents=True)
    for place in (home, home / "inner", tmp_path):
        (place / "table.csv").write_text("0,1\n")
    return home


def test_good_names(folder):
    assert graph_codes(folder, "table.csv") == graph_codes(folder, "inner/table.csv") == []
    (folder / "link.csv").symlink_to("table.csv")
    assert graph_codes(folder, "link.csv") == []


@pytest.mark.parametrize("name", [
    "../table.csv", "inner/../table.csv", "inner/../../table.csv", "./table.csv", "/etc/passwd",
    "inner//table.csv", "inner/", "", ".", "..", "~/table.csv", "$HOME/table.csv", "C:table.csv",
    "C:/table.csv", "table.csv\\u0000", "table.csv\\n", "tab le.csv", "http://x/table.csv", "-table.csv",
    "inner\\\\table.csv", "t\\u00e4ble.csv", "a" * 300 + ".csv", "table.csv/x", "|ls", "`ls`", "*.csv"])
def test_bad_names(folder, name):
    assert graph_codes(folder, name) == ["E504"]


@pytest.mark.parametrize("target", ["../table.csv", "/dev/zero", "/etc/passwd", "loop.csv", "..", "inner",
                                    "nowhere.csv"])
def test_links_and_devices(folder, target):
    (folder / "loop.csv").symlink_to("loop.csv")
    if target != "loop.csv":
        (folder / "link.csv").symlink_to(target)
    assert graph_codes(folder, "loop.csv" if target == "loop.csv" else "link.csv") == ["E504"]


def test_a_linked_folder_that_leads_out(folder):
    (folder / "out").symlink_to("..")
    assert graph_codes(folder, "out/table.csv") == ["E504"]


def test_a_pipe_is_not_waited_for(folder):
    os.mkfifo(folder / "pipe.csv")
    assert graph_codes(folder, "pipe.csv") == ["E504"]


@pytest.mark.parametrize("content", [b"0,1\n\xff\xfe", b"0,1\n1;DROP", b"\x00", b"0x1,2\n", b"1_0,2\n",
                                     b"0,1e400\n", b"0,\xc2\xb2\n", b"0.5,1\n", b"0,1\n" + b"9" * 50 + b",1"])
def test_bad_tables(folder, content):
    (folder / "table.csv").write_bytes(content)
    assert graph_codes(folder, "table.csv") == ["E505"]


def test_a_text_without_a_file_names_no_files():
    assert codes(spec_of('[starts.s]\nfile = "table.csv"\n')) == ["E504"]


# Cost

@pytest.mark.parametrize("text", [
    "[\n" * 100_000, "a = [\n" + "[\n" * 3000, "a." * 2000 + "b = 1\n", "[[a]]\n" * 50_000,
    "a" * 4000 + "=1\n", "x = '''" + "\n" * 500_000, "#\n" * 500_000,
    spec_of("".join(f"a{k}.b = 1\n" for k in range(30_000))),
    energy("(" * 2000), energy("-" * 4000 + "1"), energy("1" + "^1" * 2000), energy("w[" * 1000),
    energy("sin(" * 900), energy("1+" * 2000 + "1"), energy("x" * 4000), energy("not " * 1000),
    energy("f39(w[i].z)", "[formulas]\n\"f0(u)\" = \"u*u*u*u\"\n" + "".join(
        f'"f{k}(u)" = "f{k - 1}(f{k - 1}(u))*f{k - 1}(u)"\n' for k in range(1, 40))),
    energy("f199", "[formulas]\nf0 = '1'\n" + "".join(
        f"f{k} = 'f{k - 1} + f{k - 1}'\n" for k in range(1, 200)))])
def test_no_input_is_slow(text):
    """Well under a second each; the bound leaves room for a busy machine."""
    begin = time.process_time()
    judged(text)
    assert time.process_time() - begin < 5


# The code of the reader itself

def test_spec_text_is_never_handed_to_an_evaluator():
    """No call of eval, exec, compile, sympify, parse_expr, os.system, subprocess in the stages
    that see the text; and sympy is no part of the reader."""
    forbidden = {"eval", "exec", "compile", "sympify", "S", "parse_expr", "system", "popen", "Popen",
                 "__import__", "import_module", "loads_unsafe", "literal_eval", "lambdify"}
    for path in sorted((ROOT / "gen" / "read").glob("*.py")) + sorted((ROOT / "gen" / "compile" / "derive").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call):
                name = getattr(node.func, "id", getattr(node.func, "attr", ""))
                plain_re = isinstance(node.func, ast.Attribute) and \
                    getattr(node.func.value, "id", "") == "re"
                assert name not in forbidden or plain_re, (path.name, node.lineno, name)
            if isinstance(node, (ast.Import, ast.ImportFrom)) and path.parent.name == "read":
                names = [a.name for a in node.names] + [getattr(node, "module", "") or ""]
                assert not any(n.split(".")[0] in ("sympy", "subprocess", "pickle") for n in names)
