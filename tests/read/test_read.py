"""The reader: the language of docs/spec.md, and what each construct becomes."""
import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from smidgen.check.witness import Witness
from smidgen.language import limits
from smidgen.errors import SpecError, UsageError
from smidgen.language.evaluate import evaluate
from smidgen.language.expr import Elem, Idx, Num, Op, Par, Spin, Time, Weight, kind_of, walk
from smidgen.read import load, load_text
from smidgen.language.codes import CODES
from smidgen.read.marks import Marks
from smidgen.read.names import FUNCTIONS
from smidgen.compile.select import select
from smidgen.language.spec import Each, Lattice, Once, Pairs, Sites
from smidgen.run.step.evaluated import parameter_values

pytestmark = pytest.mark.quick
ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "spec.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```toml\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
SPECS = sorted((ROOT / "specs").glob("*.toml"))

AROUND = {"model": '[model]\nname = "m"\n', "space": '[space]\nw = { sphere = "n" }\n',
          "parameters": "[parameters]\nn = 4\n",
          "effects": '[effects.e]\nover = "site(i) of w"\nenergy = "w[i].z"\n'}


def spec_of(text: str, **sections) -> str:
    """`text` with what a spec needs besides; `sections` replace the defaults."""
    given_here = tomllib.loads(text)
    parts = {**AROUND, **sections}
    return text + "".join("\n" + part for name, part in parts.items() if name not in given_here)


def energy(formula: str, **sections):
    """The one energy of a spec with that formula, over site(i) of w."""
    text = f"[effects.e]\nover = 'site(i) of w'\nenergy = '{formula}'\n"
    return load_text(spec_of(text, **sections)).effects[0].value


def refused(text: str, path: str = "") -> list[str]:
    """The codes of the errors of a spec."""
    with pytest.raises(SpecError) as caught:
        load_text(text, path)
    return [d.code for d in caught.value.diagnostics]


# The reference page

@pytest.mark.parametrize("block", BLOCKS, ids=lambda b: str(PAGE[:PAGE.index(b)].count("\n") + 1))
def test_every_example_of_the_page_is_a_spec(block, tmp_path):
    rows = re.findall(r"^# (\d+,.*)$", block, re.MULTILINE)
    (tmp_path / "edges.csv").write_text("\n".join(rows))
    spec = load_text(spec_of(block), str(tmp_path / "example.toml"))
    assert spec.effects and spec.families


def test_the_page_names_every_function_limit_and_code():
    assert len(BLOCKS) > 15
    for function in FUNCTIONS:
        assert re.search(rf"`{function}[`(]", PAGE), function
    for name, meaning in limits.LIMITS.items():
        assert f"| `{name}` | {getattr(limits, name)!r} | {meaning} |" in PAGE
    for code, meaning in CODES.items():
        assert f"| {code} | {meaning} |" in PAGE


def test_every_code_has_a_broken_spec():
    golden = "".join(p.read_text(encoding="utf-8") for p in (ROOT / "tests" / "bad").glob("*.txt"))
    assert set(re.findall(r"error\[(E\d+)\]", golden)) | {"E101"} == set(CODES)


# Shipped specs

@pytest.mark.parametrize("path", SPECS, ids=lambda p: p.stem)
def test_shipped_spec(path):
    spec = load(path)
    assert spec.name == path.stem and spec.title and spec.runs
    assert path.read_text(encoding="utf-8").startswith("# ")
    assert all(p.meaning for p in spec.parameters)
    assert any(r.name == "demo" for r in spec.runs)


# Formulas

I1, W = Spin("w", "i"), Spin("w", 0)


@pytest.mark.parametrize("formula, expected", [
    ("2 + 3*4", 14), ("(2 + 3)*4", 20), ("2 - 3 - 4", -5), ("24/4/2", 3), ("2^3^2", 512),
    ("-2^2", -4), ("2^-1", 0.5), ("2**3", 8), ("--2", 2), ("+2", 2), ("1/2", 0.5), (".5", 0.5),
    ("1e-3", 0.001), ("2*pi", 2 * math.pi), ("mod(-1, 3)", 2), ("floor(-0.5)", -1),
    ("min(2, 3)", 2), ("max(2, 3)", 3), ("atan2(1, -1)", 3 * math.pi / 4), ("abs(-2)", 2),
    ("if(1 < 2, 5, 6)", 5), ("if(1 < 2 and not 2 < 1, 5, 6)", 5), ("if(1 > 2 or 1 == 1, 5, 6)", 5),
    ("if(not 1 < 2 or 3 != 3, 5, 6)", 6), ("dot(vec(1, 2, 3), vec(4, 5, 6))", 32),
    ("cross(vec(1, 0, 0), vec(0, 1, 0)).z", 1), ("norm(vec(3, 4, 0))", 5), ("(2*vec(1, 2, 3)).y", 4),
    ("triple(vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 2))", 2), ("(vec(1, 2, 3)/2).z", 1.5),
    ("(-vec(1, 2, 3) + vec(1, 1, 1)).x", 0), ("log(exp(2))", 2), ("sqrt(16)", 4)])
def test_value(formula, expected):
    assert evaluate(energy(formula), {}) == pytest.approx(expected, rel=1e-15)


def test_nodes():
    assert energy("w[i].z") == Op("z", (I1,))
    assert energy("t*i") == Op("*", (Time(), Idx("i")))
    assert energy("n*w[i].x") == Op("*", (Par("n"), Op("x", (I1,))))
    assert energy("2") == Num(2) and isinstance(energy("2").value, int)
    assert energy("2.0") == Num(2.0) and isinstance(energy("2.0").value, float)


def test_arrays_and_vectors():
    parameters = ('[parameters]\nn = 4\ng = { default = 1.0, size = "n + 1" }\n'
                  'B = { default = [1.0, 2.0, 3.0], vector = true }\n')
    assert energy("g[i + 1]", parameters=parameters) == Elem("g", Op("+", (Idx("i"), Num(1))))
    vector = Op("vec", tuple(Elem("B", Num(k)) for k in range(3)))
    assert energy("dot(B, w[i])", parameters=parameters) == Op("dot", (vector, I1))
    assert energy("B[2]", parameters=parameters) == Elem("B", Num(2))


def test_named_formulas_are_expanded():
    formulas = ('[formulas]\nhalf = "1/2"\n"sq(u)" = "u*u"\n"z(k)" = "w[k].z"\n'
                '"energy(k)" = "half*sq(z(k))"\n')
    z = Op("z", (I1,))
    assert energy("energy(i)", formulas=formulas) == Op("*", (Op("/", (Num(1), Num(2))),
                                                              Op("*", (z, z))))


def test_a_formula_does_not_see_the_indices_of_its_user():
    text = spec_of('[formulas]\nf = "w[i].z"\n[effects.e]\nover = "site(i) of w"\nenergy = "f"\n')
    assert refused(text) == ["E302"]


# Index families

def over(text: str, **sections):
    words = f'[effects.e]\nover = "{text}"\nenergy = "1"\n'
    return load_text(spec_of(words, **sections)).effects[0].over


def test_families_of_indices():
    assert over("site(i) of w") == over("site(i)") == Sites("i", "w")
    assert over("pair(a, b) of w") == Pairs("a", "b", "w")
    two = {"space": '[space]\nw = { sphere = "n" }\np = { sphere = 2 }\n'}
    assert over("each(i of p, j of w)", **two) == Each(("i", "j"), ("p", "w"))
    assert over("bond(i, j) of chain(n, open) on w", **two).family == "w"


def test_lattices():
    n = Par("n")
    step = ((0, (0,)), (0, (1,)))
    assert over("bond(i, j) of chain(n, periodic)") == Lattice(
        ("i", "j"), (n,), (True,), 1, (step,), "w")
    assert over("bond(i, j) of chain(n, open, 3)").bonds == (((0, (0,)), (0, (3,))),)
    square = over("bond(i, j) of square(2, n, open, periodic)",
                  space='[space]\nw = { sphere = "2*n" }\n')
    assert square.size == (Num(2), n) and square.periodic == (False, True)
    assert square.bonds == (((0, (0, 0)), (0, (1, 0))), ((0, (0, 0)), (0, (0, 1))))
    cubic = over("bond(i, j) of cubic(n, 1, 1, open)")
    assert len(cubic.bonds) == 3 and cubic.periodic == (False,) * 3


def test_declared_lattice():
    lattice = ('[lattices.l]\nsize = ["n"]\nboundary = "open"\nsites = 2\n'
               'bonds.a = [{ from = 1, to = 0, offset = [1] }]\n'
               'bonds.b = [{ at = [[0, 0], [1, 0], [0, 1]] }]\n')
    space = '[space]\nw = { sphere = "2*n" }\n'
    assert over("bond(i, j) of l.a", lattices=lattice, space=space).bonds == \
        (((1, (0,)), (0, (1,))),)
    assert over("bond(i, j, k) of l.b", lattices=lattice, space=space).bonds == \
        (((0, (0,)), (1, (0,)), (0, (1,))),)


def test_graph(tmp_path):
    (tmp_path / "g.csv").write_bytes(b"i,j,K\r\n0,1,0.5 # first\r\n\r\n3,2,-2e0\r\n")
    text = spec_of('[graphs.g]\nfile = "g.csv"\n[effects.e]\nover = "edge(i, j, K) of g"\n'
                   'energy = "K*dot(w[i], w[j])"\n')
    effect = load_text(text, str(tmp_path / "s.toml")).effects[0]
    assert effect.over.edges == ((0, 1), (3, 2)) and effect.over.columns == (("K", (0.5, -2.0)),)
    assert Weight("K") in walk(effect.value)


def test_a_single_vector_joins_a_sum():
    space = '[space]\ns = { sphere = 1 }\nw = { sphere = "n" }\n'
    text = '[effects.e]\nover = "site(i) of w"\nenergy = "dot(s, w[i])"\n'
    effect = load_text(spec_of(text, space=space)).effects[0]
    assert effect.over.families == ("w", "s")
    assert effect.value == Op("dot", (Spin("s", effect.over.indices[1]), I1))


def test_once():
    effect = load_text(spec_of('[space]\nw = { sphere = 1 }\n[effects.e]\nenergy = "w.z"\n')).effects[0]
    assert effect.over == Once() and effect.value == Op("z", (W,))


# The space

def family(line: str, **sections):
    text = f'[space]\n{line}\n[effects.e]\nover = "site(i) of w"\nenergy = "w[i].z"\n'
    return load_text(spec_of(text, **sections))


def test_families():
    assert family("w = { sphere = 3 }").families[0].kappa == Num(1)
    assert family("w = { sphere = 3, radius = 2 }").families[0].radius == Num(2)
    spec = family("w = { sphere = 3, kappa = [1, -2, 3] }")
    assert spec.families[0].kappa == Elem("w_kappa", Idx("i"))
    assert spec.tables == (("w_kappa", (1.0, -2.0, 3.0)),)
    assert family("w = { r3 = 2, tracer = true }").families[0].tracer


@pytest.mark.parametrize("c, expected", [
    ("(w.x^2 - w.y^2)/2", [[1, 0, 0], [0, -1, 0], [0, 0, 0]]),
    ("w.x*w.y", [[0, 1, 0], [1, 0, 0], [0, 0, 0]]),
    ("w.y^2 + w.x*w.z", [[0, 0, 1], [0, 2, 0], [1, 0, 0]]),
    ("dot(w, w)", [[2, 0, 0], [0, 2, 0], [0, 0, 2]]),
    ("dot(w, w/2) - w.z*(w.z - 3*w.x)", [[1, 0, 3], [0, 1, 0], [3, 0, -1]]),
    ("triple(w, vec(1, 0, 0), vec(0, 1, 0))*w.z" , None),
    ("-cross(w, vec(0, 0, 1)).x*w.y", [[0, 0, 0], [0, -2, 0], [0, 0, 0]]),
    ("(w.x + w.y)^2", [[2, 2, 0], [2, 2, 0], [0, 0, 0]]),
    ("n*w.x^2/2", [[4, 0, 0], [0, 0, 0], [0, 0, 0]])])
def test_casimir(c, expected):
    text = f"[space]\nw = {{ nambu = 1, C = '{c}' }}\n"
    if expected is None:
        assert refused(spec_of(text)) == ["E401"]
        return
    matrix = load_text(spec_of(text)).families[0].casimir
    assert [[evaluate(e, {"n": 4}) for e in row] for row in matrix] == expected


# Starts and runs

def test_starts():
    spec = load_text(spec_of('[starts.a]\ntheta = 0.5\nphi = "i"\n[starts.b]\nrandom = 3\n'
                             '[starts.c]\nx = 0\ny = 0\nz = 1\n'
                             '[starts.d]\ntheta = [0, 1, 2, 3]\nphi = [0, 0, 1, 1]\n'))
    a, b, c, d = (s.families[0] for s in spec.starts)
    point = [evaluate(e, {"i": 1}) for e in a.value]
    assert point == pytest.approx([math.sin(0.5) * math.cos(1), math.sin(0.5) * math.sin(1),
                                   math.cos(0.5)])
    assert (b.kind, b.value, c.kind, d.kind) == ("random", 3, "formula", "vectors")
    assert d.value[3] == pytest.approx((math.sin(3) * math.cos(1), math.sin(3) * math.sin(1),
                                        math.cos(3)))


def test_a_single_number_is_no_vector():
    """Neither (2, 2, 2) nor three of them."""
    text = spec_of("[parameters]\nn = 2\nB = { default = [0, 0, 1], vector = true }\nA = { default = [[0, 0, 1], [1, 0, 0]], size = 2, vector = true }\nK = { default = [1, 2, 3], size = 3 }\n"
                   "[effects.e]\nover = 'site(i) of w'\nenergy = 'dot(B + A[i], w[i])*K[i]'\n[starts.a]\nrandom = 3\n")
    spec = load_text(text)
    for given, said in (({"B": 2}, "'B' is a vector"), ({"B": [2.0]}, "'B' is a vector"), ({"A": 1.0}, "'A' is an array of vectors")):
        for refused in (lambda: parameter_values(spec, given), lambda: select(spec, None, given)):
            with pytest.raises(UsageError, match=said):
                refused()
    assert parameter_values(spec, {"K": 2, "B": [1, 2, 3]})["K"].tolist() == [2, 2, 2]
    with pytest.raises(SpecError, match="`B` is a vector"):
        load_text(text + "[runs.r]\nstart = 'a'\nh = 0.1\nsteps = 1\nset = { B = 2 }\n")


def test_the_index_of_a_single_vector_is_no_other_index():
    spec = load_text(spec_of("[space]\ns = { sphere = 1 }\nw = { sphere = 3 }\n[parameters]\ns_site2 = 0.5\n"
                             "[effects.e]\nover = 'site(s_site) of w'\nenergy = 's_site2*dot(s, w[s_site])'\n"))
    over = spec.effects[0].over
    assert isinstance(over, Each) and len({*over.indices, "s_site2"}) == 3
    w = np.arange(12.0).reshape(4, 3)
    assert Witness(spec).energy(w) == 0.5 * np.sum(w[1:] @ w[0])


def test_a_family_may_be_named_like_an_axis():
    """The table of a family x is no x coordinate; in a space of one family both forms are there."""
    effect, starts = '[effects.e]\nenergy = "dot(x, z)"\n', "[starts.a.x]\nrandom = 1\n[starts.a.z]\ntheta = 0\nphi = 0\n"
    two = load_text(spec_of("[space]\nx = { sphere = 1 }\nz = { sphere = 1 }\n" + effect, starts=starts))
    assert [(f.family, f.kind) for f in two.starts[0].families] == [("x", "random"), ("z", "formula")]
    for keys in ("[starts.a]\nx = 0\ny = 0\nz = 1\n", "[starts.a.x]\nx = 0\ny = 0\nz = 1\n"):
        one = load_text(spec_of('[space]\nx = { sphere = 1 }\n[effects.e]\nenergy = "x.z"\n', starts=keys))
        assert one.starts[0].families[0].kind == "formula"


def test_angles_are_scaled_by_the_radius():
    spec = family("w = { sphere = 3, radius = 'i + 2' }", starts="[starts.a]\ntheta = 0\nphi = 0\n")
    z = spec.starts[0].families[0].value[2]
    assert evaluate(z, {"i": 1}) == 3


def test_start_file(tmp_path):
    (tmp_path / "w.csv").write_text("x,y,z\n0,0,1\n1,0,0\n0,-1,0\n0.6,0.8,0\n")
    text = spec_of('[starts.a]\nfile = "w.csv"\n')
    spec = load_text(text, str(tmp_path / "s.toml"))
    assert spec.starts[0].families[0].value[3] == (0.6, 0.8, 0.0)
    (tmp_path / "w.csv").write_text("0,0,1\n1,0,0\n0,1,0\n0.6,0.8,0\n")
    assert load_text(text, str(tmp_path / "s.toml")).digest != spec.digest


@pytest.mark.parametrize("h, duration, good", [
    ("0.1", "time = 1000", True), ("'2*pi/20'", "time = '2*pi*50'", True), ("-0.1", "time = 10", True),
    ("-0.1", "time = -10", True), ("0.1", "time = -10", False), ("0.3", "time = 10", False),
    ("0.3", "steps = 'n*2'", True), ("0.1", "time = 1.00000000001", False)])
def test_durations(h, duration, good):
    text = spec_of(f'[starts.a]\nrandom = 1\n[runs.r]\nstart = "a"\nh = {h}\n{duration}\n')
    if good:
        assert load_text(text).runs[0].h is not None
    else:
        assert refused(text) in (["E604"], ["E605"])


def test_the_two_nearest_durations_are_named():
    text = spec_of('[starts.a]\nrandom = 1\n[runs.r]\nstart = "a"\nh = 0.3\ntime = 10\n')
    with pytest.raises(SpecError, match=r"9\.9 \(33 steps\) and 10\.2 \(34 steps\)"):
        load_text(text)


# The file

def test_windows_files_read_the_same():
    text = SPECS[0].read_text(encoding="utf-8")
    plain, windows = load_text(text), load_text("\ufeff" + text.replace("\n", "\r\n"))
    assert plain == windows


def test_digest_follows_the_text():
    text = spec_of("")
    assert load_text(text).digest == load_text(text).digest != load_text(text + "\n").digest


def test_missing_file(tmp_path):
    with pytest.raises(SpecError) as caught:
        load(tmp_path / "none.toml")
    assert caught.value.diagnostics[0].code == "E101"
    assert str(caught.value) == f"{tmp_path / 'none.toml'}: error[E101]: no such file or directory\n   = give the path of a spec, a TOML file"
    with pytest.raises(SpecError):
        load(tmp_path)


KEYS = st.text("ab-_ ./\"\\\u00e9\n'#[]=", min_size=1, max_size=4)
STRINGS = st.text("ab'\"\\\n\t #[]{}=,\u00e9\u4e2d", max_size=12)


def basic(s: str) -> str:
    """`s` as a basic string."""
    return '"' + "".join(f"\\u{ord(c):04x}" if c in '"\\\n\t' else c for c in s) + '"'


def multiline(s: str) -> str:
    """`s` as a multi-line basic string, with a continued line in front."""
    return '"""\\\n   ' + "".join(f"\\u{ord(c):04x}" if c in '"\\\t' or c == " " else c
                                  for c in s.replace("\n", "\\n")) .replace("\\u005cn", "\n") + '"""'


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(KEYS, STRINGS, st.sampled_from([basic, multiline])), max_size=6,
                unique_by=lambda item: item[0]), STRINGS)
def test_marks_agree_with_tomllib(items, inner):
    lines = [f"{basic(k)} = [ {style(v)}, # comment ]\n 1.5,\n {{ a.b = {basic(inner)} }} ]"
             for k, v, style in items]
    text = "[t.'x y']\n" + "\n".join(lines) + "\n[[list]]\nk = 'v'\n[[list]]\nk = '''\nv'v'''\n"
    values, marks = tomllib.loads(text), Marks(text).at
    for k, v in values["t"]["x y"].items():
        path = ("t", "x y", k)
        assert marks[path + (0,)].text.value == v[0]
        assert marks[path + (2, "a", "b")].text.value == v[2]["a"]["b"]
        span = marks[path + (1,)].value
        assert text[span.start:span.end] == "1.5"
    assert marks["list", 1, "k"].text.value == values["list"][1]["k"] == "v'v"


# select

def two_effects():
    return load_text(spec_of(
        '[parameters]\nn = 4\nJ = 1.0\nK = 0.5\ng = { default = 1.0, size = "n" }\n'
        'c = { default = 2.0, fixed = true }\n'
        '[space]\nw = { sphere = "n", kappa = "g[i]" }\n'
        '[effects.e]\nover = "bond(i, j) of chain(n, periodic)"\nenergy = "-J*dot(w[i], w[j])"\n'
        '[effects.a]\nover = "site(i) of w"\nenergy = "-K*c*w[i].z^2"\n'))


def test_select_drops_what_is_not_called_for():
    scene = select(two_effects(), ["e"])
    assert [e.name for e in scene.effects] == ["e"]
    assert [p.name for p in scene.parameters] == ["n", "J", "g"]
    assert select(two_effects()).parameters == two_effects().parameters


def test_select_puts_values_into_the_defaults():
    scene = select(two_effects(), values={"n": 6, "J": 2, "g": [1, 2, 3, 4, 5, 6]})
    assert [p.default for p in scene.parameters[:2]] == [6, 2.0]
    assert select(two_effects(), values={"n": 6}).parameters[3].default == (1.0,) * 6


@pytest.mark.parametrize("entries, follows", [([1, 2, 3, 4], False), ([2], True), (2, True)])
def test_only_one_repeated_number_follows_the_size(entries, follows):
    scene = select(two_effects(), values={"g": entries})
    assert scene.parameters[3].default == tuple(parameter_values(scene)["g"]) == tuple(np.resize(entries, 4))
    if follows:
        assert select(scene, values={"n": 5}).parameters[3].default == (2.0,) * 5
    else:
        with pytest.raises(UsageError, match="entries"):
            select(scene, values={"n": 5})


@pytest.mark.parametrize("effects, values, word", [
    (["f"], {}, "effect"), (None, {"j": 1}, "`J`"), (None, {"J": math.nan}, "finite"),
    (None, {"J": math.inf}, "finite"), (None, {"g": 0}, "strength"), (None, {"n": 0}, "sites"),
    (None, {"n": -1}, "sites"), (None, {"n": 2.5}, "integer"), (None, {"n": 5, "g": [1, 2]}, "entries"),
    (None, {"J": "1"}, "number"), (None, {"J": [1]}, "list"), (None, {"n": 1}, "itself"),
    (None, {"g": [1, 1, 0, 1]}, "w[2]"), (None, {"J": True}, "number")])
def test_select_refuses(effects, values, word):
    with pytest.raises(UsageError, match=re.escape(word)):
        select(two_effects(), effects, values)


def test_selecting_nothing_is_an_error():
    with pytest.raises(UsageError):
        select(two_effects(), [])


def test_kinds_are_consistent():
    for path in SPECS:
        for term in load(path).effects:
            assert kind_of(term.value) == "s"
