"""Every limit of the spec language at its edge: just inside passes, just outside does not."""
import math
import re

import numpy as np
import pytest
import smidgen

from smidgen.language import limits
from smidgen.errors import SpecError
from smidgen.read import load, load_text
from test_read import spec_of

pytestmark = pytest.mark.quick


def codes(text: str, path: str = "") -> list[str]:
    """The codes of a spec's errors; none when it is good."""
    try:
        load_text(text, path)
    except SpecError as error:
        return [d.code for d in error.diagnostics]
    return []


def energy(formula: str, more: str = "") -> str:
    return spec_of(f'{more}\n[effects.e]\nover = "site(i) of w"\nenergy = """{formula}"""\n')


def section(name: str, entry: str, count: int) -> str:
    """A section with `count` entries; `#` in `entry` is the number."""
    return f"[{name}]\n" + "".join(entry.replace("#", str(k)) for k in range(count))


def starts_and(text: str) -> str:
    return spec_of("[starts.s]\nrandom = 1\n" + text)


def run_line(line: str) -> str:
    return starts_and(f'[runs.r]\nstart = "s"\nh = 0.5\n{line}\n')


def balanced(leaves: int) -> str:
    if leaves == 1:
        return "1"
    return f"({balanced(leaves // 2)}+{balanced(leaves - leaves // 2)})"


def expanded(nodes: int) -> str:
    """A formula of exactly `nodes` nodes, about 4000: four times 999, three sums, signs."""
    signs = nodes - (4 * 999 + 3)
    return energy("-" * signs + "((a + a) + (a + a))", f'[formulas]\na = "{balanced(500)}"\n')


def derived(work: int) -> str:
    """An energy of eight vectors whose derivatives take exactly `work` operations: products, squares, a sum, numbers."""
    q = "*".join(f"w[{k}].x" for k in range(8))
    lines, each = [f'q = "{q}"', 'p = "(q*q)*(q*q)"', 'r = "(p*p)*(p*p)"', 's = "r*r"'], 1 + 24 + 24 * 25 // 2
    whole = 32 * sum(1 + d + d * (d + 1) // 2 for d in range(6, 25, 3)) + 31 * each
    squares, numbers = divmod(work - whole - 25, each)
    energy_ = "(" * squares + "s" + ")^2" * squares + " + " + balanced(numbers + 1)
    return spec_of("[space]\nw = { sphere = 8 }\n[formulas]\n" + "\n".join(lines) + f'\n[effects.e]\nenergy = "{energy_}"\n')


def padded_line(length: int) -> str:
    return "#" + "x" * (length - 1) + "\n" + spec_of("")


def padded_file(size: int) -> str:
    text, line = spec_of(""), "#" + "x" * 1022 + "\n"
    missing = size - len(text)
    return text + line * (missing // 1024) + "#" * (missing % 1024)


def lattice(dimensions=1, sites=1, bonds="[{ offset = [1] }]") -> str:
    size = ", ".join(["1"] * (dimensions - 1) + ["4"])
    return spec_of(f'[lattices.l]\nsize = [{size}]\nboundary = "open"\nsites = {sites}\n'
                   f"bonds.a = {bonds}\n")


def offset(dimensions: int) -> str:
    return f"[{{ offset = {[0] * (dimensions - 1) + [1]} }}]"


def ends(count: int) -> str:
    names = ", ".join(f"i{k}" for k in range(count))
    at = ", ".join(f"[0, {k}]" for k in range(count))
    return spec_of(f'[lattices.l]\nsize = [4]\nboundary = "open"\nbonds.a = [{{ at = [{at}] }}]\n'
                   f'[effects.e]\nover = "bond({names}) of l.a"\nenergy = "1"\n')


def nested(depth: int) -> str:
    return "x = " + "[" * depth + "]" * depth + "\n" + spec_of("")


def start_at(length: float) -> str:
    return spec_of(f"[space]\nw = {{ sphere = 1 }}\n[starts.s]\nvectors = [[0, 0, {length!r}]]\n")


E105, SECTION = ["E105"], ["E201"]
EDGES = {     # limit -> (text at a value of the limit, the error just beyond it)
    "FILE_BYTES": (padded_file, E105),
    "LINE": (padded_line, E105),
    "STRING": (lambda k: energy("1 +\n" * 100 + " " * (k - 402) + "\n1"), E105),
    "TEXT": (lambda k: f'model.name = "m"\nmodel.title = "{"x" * k}"\n' + spec_of("").replace(
        '[model]\nname = "m"\n', ""), E105),
    "NESTING": (nested, None),
    "DEPTH": (lambda k: energy("(" * k + "1" + ")" * k), E105),
    "TREE": (lambda k: energy(" + ".join(["1"] * k)), ["E311"]),
    "NODES": (expanded, ["E311"]),
    "DERIVATIVES": (derived, ["E311"]),
    "IDENTIFIER": (lambda k: spec_of(f"[parameters]\nn = 4\n{'a' * k} = 1.0\n"), E105),
    "ARGUMENTS": (lambda k: spec_of(
        f'[formulas]\n"f({", ".join(f"a{j}" for j in range(k))})" = "1"\n'), E105),
    "PARAMETERS": (lambda k: spec_of(section("parameters", "a# = 1\n", k - 1) + "n = 4\n"), E105),
    "FAMILIES": (lambda k: spec_of(section("space", "w# = { sphere = 1 }\n", k)
                                   + '[effects.e]\nenergy = "w0.z"\n'), E105),
    "FORMULAS": (lambda k: spec_of(section("formulas", 'f# = "1"\n', k)), E105),
    "EFFECTS": (lambda k: spec_of(section("effects", 'e#.energy = "1"\n', k)), E105),
    "OBSERVABLES": (lambda k: spec_of(section("observables", 'o#.value = "1"\n', k)), E105),
    "STARTS": (lambda k: spec_of(section("starts", "s#.random = 1\n", k)), E105),
    "RUNS": (lambda k: starts_and(section(
        "runs", 'r# = { start = "s", h = 1, steps = 1 }\n', k)), E105),
    "LATTICES": (lambda k: spec_of(section("lattices", 'l# = { size = [1], boundary = "open", '
                                           "bonds.a = [{ offset = [1] }] }\n", k)), E105),
    "DIMENSIONS": (lambda k: lattice(k, bonds=offset(k)), E105),
    "CELL": (lambda k: lattice(sites=k), E105),
    "BONDS": (lambda k: lattice(bonds="[" + "".join(
        f"{{ offset = [{j + 1}] }},\n" for j in range(k)) + "]"), E105),
    "REACH": (lambda k: lattice(bonds=f"[{{ offset = [{k}] }}]"), E105),
    "BOUND": (ends, E105),
    "SITES": (lambda k: spec_of(f"[space]\nw = {{ sphere = {k} }}\n"), E105),
    "LIST": (lambda k: spec_of("[parameters]\nn = 4\nline = { size = %d, default = [%s] }\n"
                               % (k, "1.0,\n" * k)), E105),
    "EXPONENT": (lambda k: energy(f"w[i].z^{k}"), ["E306"]),
    "INTEGER": (lambda k: spec_of(f"[parameters]\nn = 4\nk = {k}\n"), ["E204"]),
    "STEPS": (lambda k: run_line(f"steps = {k}"), ["E605"]),
    "EVERY": (lambda k: run_line(f"steps = 1\noutput = {{ every = {k} }}"), E105),
}


@pytest.mark.parametrize("name", EDGES)
def test_edge(name):
    make, expected = EDGES[name]
    value = getattr(limits, name)
    inside, outside = codes(make(value)), codes(make(value + 1))
    if name == "NESTING":           # the list itself means nothing to a spec
        assert inside == ["E201"] and outside == ["E105"]
    else:
        assert inside == [] and set(outside) == set(expected)


def test_errors():
    bad = section("effects", 'e#.energy = "u#"\n', limits.ERRORS)
    with pytest.raises(SpecError) as ten:
        load_text(spec_of(bad))
    with pytest.raises(SpecError) as eleven:
        load_text(spec_of(bad + 'f.energy = "v"\n'))
    assert len(ten.value.diagnostics) == len(eleven.value.diagnostics) == limits.ERRORS
    assert not ten.value.more and eleven.value.more
    assert "more errors" in str(eleven.value) and "more errors" not in str(ten.value)


@pytest.mark.parametrize("factor, expected", [(1 + 1e-9, ["E204"]), (1, []), (1 - 1e-9, [])])
def test_largest(factor, expected):
    assert codes(spec_of(f"[parameters]\nn = 4\na = {limits.LARGEST * factor!r}\n")) == expected
    assert codes(energy(f"{limits.LARGEST * factor!r}*w[i].z")) == expected


@pytest.mark.parametrize("factor, expected", [(1 - 1e-9, ["E204"]), (1, []), (0, [])])
def test_smallest(factor, expected):
    assert codes(spec_of(f"[parameters]\nn = 4\na = {limits.SMALLEST * factor!r}\n")) == expected
    assert codes(energy(f"{limits.SMALLEST * factor!r}*w[i].z")) == expected


R3 = """
[model]
name = "small"
[space]
w = { r3 = 1 }
[effects.axis]
energy = "w.z"
"""


def test_a_zero_vector_stands_still_and_no_number_is_named(tmp_path):
    """In a field that is not linear, so that Newton meets it; a start with NaN says where."""
    (tmp_path / "small.toml").write_text(R3.replace('"w.z"', '"w.x^2 + w.y"'))
    model = smidgen.build(smidgen.load(tmp_path / "small.toml"))
    assert not np.any(model.start(np.zeros((1, 3)), h=0.1).steps(3).w)
    with pytest.raises(smidgen.RunError, match="site 0 of the start"):
        model.start(np.array([[np.nan, 0, 0]]), h=0.1)


@pytest.mark.parametrize("size, starts", [(0.99 * limits.SHORTEST, False), (1.01 * limits.SHORTEST, True), (0.0, True),
                                          (0.99 * limits.LARGEST, True), (1.01 * limits.LARGEST, False)])
def test_shortest(size, starts, tmp_path):
    """The vector that cannot start is named with its size."""
    (tmp_path / "small.toml").write_text(R3)
    model = smidgen.build(smidgen.load(tmp_path / "small.toml"))
    if starts:
        model.start(np.array([[size, 0, 0]]), h=0.1).step()
        return
    with pytest.raises(smidgen.RunError, match=re.escape(f"site 0 of the start: its largest component is {size:.3g}")):
        model.start(np.array([[size, 0, 0]]), h=0.1)


@pytest.mark.parametrize("share, expected", [(0.99, []), (1.01, ["E601"]), (-0.99, []),
                                             (-1.01, ["E601"])])
def test_sphere(share, expected):
    assert codes(start_at(1 + share * limits.SPHERE)) == expected


@pytest.mark.parametrize("share, expected", [(0.99, []), (1.01, ["E604"]), (-0.99, []),
                                             (-1.01, ["E604"])])
def test_multiple(share, expected):
    assert codes(run_line(f"time = {8 * (1 + share * limits.MULTIPLE)!r}")) == expected


def graph(columns: int = 2) -> str:
    names = ", ".join(["i", "j"] + [f"c{k}" for k in range(columns - 2)])
    return spec_of(f'[graphs.g]\nfile = "g.csv"\n[effects.e]\nover = "edge({names}) of g"\n'
                   'energy = "dot(w[i], w[j])"\n')


def graph_codes(folder, rows, text) -> list[str]:
    (folder / "g.csv").write_text("\n".join(rows) + "\n")
    return codes(text, str(folder / "s.toml"))


def test_graphs(tmp_path):
    def text(count):
        return spec_of(section("graphs", 'g#.file = "g.csv"\n', count))
    assert graph_codes(tmp_path, ["0,1"], text(limits.GRAPHS)) == []
    assert graph_codes(tmp_path, ["0,1"], text(limits.GRAPHS + 1)) == E105


def test_columns(tmp_path):
    for more, expected in ((0, []), (1, E105)):
        columns = 2 + limits.COLUMNS + more
        row = ",".join(["0", "1"] + ["0.5"] * (columns - 2))
        assert graph_codes(tmp_path, [row], graph(2)) == expected
    full = ",".join(["0", "1"] + ["0.5"] * limits.COLUMNS)
    assert graph_codes(tmp_path, [full], graph(2 + limits.COLUMNS)) == []


@pytest.mark.parametrize("name, small", [("EDGES", 3), ("TABLE_BYTES", 12)])
def test_large_files_by_a_small_limit(name, small, tmp_path, monkeypatch):
    monkeypatch.setattr(limits, name, small)
    assert graph_codes(tmp_path, ["0,1", "1,2", "2,3"], graph()) == []
    assert graph_codes(tmp_path, ["0,1", "1,2", "2,3", "3,0"], graph()) == E105


def test_array_by_a_small_limit(monkeypatch):
    monkeypatch.setattr(limits, "ARRAY", 5)
    for size, expected in ((5, []), (6, E105)):
        text = f"[parameters]\nn = 4\ng = {{ default = 1.0, size = {size} }}\n"
        assert codes(spec_of(text)) == expected


def test_file_bytes_are_counted_before_reading_on(tmp_path):
    path = tmp_path / "s.toml"
    path.write_bytes(b"#" * (limits.FILE_BYTES + 1))
    with pytest.raises(SpecError) as caught:
        load(path)
    assert caught.value.diagnostics[0].code == "E105"


def test_every_limit_is_tested():
    tested = set(EDGES) | {"ERRORS", "LARGEST", "SMALLEST", "SHORTEST", "SPHERE", "MULTIPLE", "GRAPHS",
                           "COLUMNS", "EDGES", "TABLE_BYTES", "ARRAY", "MEMBERS", "CELLS",
                           "META", "CSV_COLUMNS", "BASES", "HARMONICS", "UNIT", "UNIT_FACTORS", "UNIT_EXPONENT", "LOOKED_AT"}     # UNIT ..: test_unit_table.py; META, CSV_COLUMNS: test_received.py; MEMBERS: test_ensemble.py, CELLS: test_sweep.py, BASES: test_scenes.py, HARMONICS: test_harmonics.py
    assert tested == set(limits.LIMITS)
    assert all(math.isfinite(getattr(limits, name)) for name in limits.LIMITS)


def test_pairs_that_are_looked_at_for_a_shell(monkeypatch):
    """Of a square lattice up to the length 1: nine cells, of one site each."""
    from smidgen.language.shells import Unclear, within
    square = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), ((0.0, 0.0),), 2, 1.0
    monkeypatch.setattr(limits, "LOOKED_AT", 9)
    assert len(within(*square)[1]) == 4
    monkeypatch.setattr(limits, "LOOKED_AT", 8)
    with pytest.raises(Unclear, match="too many cells lie within"):
        within(*square)
