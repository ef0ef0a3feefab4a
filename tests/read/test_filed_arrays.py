"""Arrays from files and lists of vectors: numbers and vectors, of sites and of edges, in specs and in Python; by the one rule for files."""
import pickle

import numpy as np
import pytest

import smidgen

pytestmark = pytest.mark.quick
SPEC = """[model]
name = "filed"
[space]
w = {{ sphere = "n" }}
[parameters]
n = 6
{}
[effects.axis]
over = "site(i) of w"
energy = "-{}"
[effects.bonds]
over = "bond(i, j) of chain(n, open)"
energy = "-dot(w[i], w[j])"
[starts.a]
random = 1
[runs.demo]
start = "a"
h = 0.1
steps = 10
"""
K = 0.25 * np.arange(6)
AXES = np.arange(18.0).reshape(6, 3) / 7


@pytest.fixture
def home(tmp_path):
    np.save(tmp_path / "k.npy", K)
    np.save(tmp_path / "column.npy", K[:, None])
    np.save(tmp_path / "whole.npy", np.arange(6))
    np.save(tmp_path / "axes.npy", AXES)
    (tmp_path / "k.csv").write_text("K\n" + "".join(f"{x!r}\n" for x in K.tolist()))
    (tmp_path / "axes.csv").write_text("# axes\n" + "".join(",".join(map(repr, row)) + "\n" for row in AXES.tolist()))
    return tmp_path


def read(home, parameter, energy, library=()):
    (home / "spec.toml").write_text(SPEC.format(parameter, energy))
    return smidgen.load(home / "spec.toml", library=library)


@pytest.mark.parametrize("file", ["k.csv", "k.npy", "column.npy"])
def test_numbers_of_sites(home, file):
    spec = read(home, f'K = {{ file = "{file}", size = "n" }}', "K[i]*w[i].z^2")
    one = smidgen.build(spec).start("a", h=0.1)
    assert spec.parameters[1].default == tuple(K)
    assert dict(zip(one.columns, one.values()))["energy.axis"] == pytest.approx(-np.sum(K * one.w[:, 2] ** 2), abs=1e-14)
    assert smidgen.validate(spec).passed


@pytest.mark.parametrize("given", ['file = "axes.csv"', 'file = "axes.npy"', f"default = {AXES.tolist()}"])
def test_vectors_of_sites(home, given):
    spec = read(home, f'a = {{ {given}, size = "n", vector = true }}', "(dot(w[i], a[i])^2 - dot(a[2], w[i]))")
    one = smidgen.build(spec).start("a", h=0.1)
    energy = -np.sum(np.sum(one.w * AXES, axis=1) ** 2 - one.w @ AXES[2])
    assert dict(zip(one.columns, one.values()))["energy.axis"] == pytest.approx(energy, abs=1e-12)
    other = smidgen.build(spec, parameters={"a": AXES[::-1]}).start("a", h=0.1)
    assert dict(zip(other.columns, other.values()))["energy.axis"] == pytest.approx(-np.sum(np.sum(one.w * AXES[::-1], axis=1) ** 2 - one.w @ AXES[3]), abs=1e-12)


def test_numbers_by_other_sizes(home):
    spec = read(home, 'K = { file = "k.csv", size = "n" }', "K[i]*w[i].z")
    one = smidgen.build(spec, parameters={"n": 3, "K": [1.0, 2, 3]}).start(np.eye(3), h=0.1)
    assert one.sites == 3 and dict(zip(one.columns, one.values()))["energy.axis"] == -3


def test_the_digest_knows_the_numbers(home):
    first = read(home, 'K = { file = "k.npy", size = "n" }', "K[i]*w[i].z")
    np.save(home / "k.npy", K + 1)
    assert read(home, 'K = { file = "k.npy", size = "n" }', "K[i]*w[i].z").digest != first.digest


def test_files_of_the_library(home, tmp_path_factory):
    other = tmp_path_factory.mktemp("library")
    (home / "k.csv").rename(other / "far.csv")
    assert read(home, 'K = { file = "far.csv", size = "n" }', "K[i]*w[i].z", library=[other]).parameters[1].default == tuple(K)


class Trap:
    def __reduce__(self):
        return print, ("a pickle was opened",)


@pytest.mark.parametrize("name, write, given, said", [
    ("short.csv", lambda p: p.write_text("1\n2\n"), "", "`K` has 2 entries, but its size is 6"),
    ("nan.csv", lambda p: p.write_text("1\nnan\n"), "", "line 2: a cell is not a number"),
    ("wide.csv", lambda p: p.write_text("1,2\n" * 6), "", "2 columns"),
    ("ragged.csv", lambda p: p.write_text("1\n2,3\n"), "", "line 2"),
    ("empty.csv", lambda p: p.write_text(""), "", "contains no numbers"),
    ("nan.npy", lambda p: np.save(p, [1, np.nan, 3, 4, 5, 6]), "", "row 2: nan is out of range"),
    ("huge.npy", lambda p: np.save(p, [1, 2, 3, 1e200, 5, 6]), "", "row 4: 1e\\+200 is out of range"),
    ("complex.npy", lambda p: np.save(p, 1j * K), "", "type complex128"),
    ("flat.npy", lambda p: np.save(p, np.ones(18)), ", vector = true", "shape \\(18,\\)"),
    ("cube.npy", lambda p: np.save(p, np.ones((2, 3, 1))), "", "shape \\(2, 3, 1\\)"),
    ("square.npy", lambda p: np.save(p, np.ones((2, 3))), "", "`a.ravel\\(\\)` has"),
    ("rows.csv", lambda p: p.write_text("1,2,3\n" * 6), "", "with `vector = true` rows"),
    ("objects.npy", lambda p: np.save(p, np.array([Trap()], dtype=object), allow_pickle=True), "", "not a .npy file of numbers"),
    ("pickle.npy", lambda p: p.write_bytes(pickle.dumps(Trap())), "", "not a .npy file of numbers"),
    ("torn.npy", lambda p: (np.save(p, K), p.write_bytes(p.read_bytes()[:-8])), "", "not a .npy file of numbers"),
    ("none.npy", lambda p: None, "", "cannot be read"),
    ("../k.csv", lambda p: None, "", "is outside the folder of the spec"),
    ("both.csv", lambda p: p.write_text("1\n"), ", default = 1.0", "has both a file and a default"),
])
def test_what_is_no_array(home, capfd, name, write, given, said):
    write(home / name)
    with pytest.raises(smidgen.SpecError, match=said) as found:
        read(home, f'K = {{ file = "{name}", size = "n"{given} }}', "K[i].x" if "vector" in given else "K[i]*w[i].z")
    assert "spec.toml:7" in str(found.value) and "pickle" not in capfd.readouterr().out


def test_a_size_is_needed_and_entries_are_vectors(home):
    for parameter, energy, said in (('K = { file = "k.csv" }', "K[i]*w[i].z", "has no `size`"), ('a = { file = "axes.csv", size = "n", vector = true }', "a[i]*w[i].z", "a number is needed"),
                                    ('a = { file = "axes.csv", size = "n", vector = true }', "dot(a, w[i])", "is an array"),
                                    ('a = { default = [[0, 0, 1], [1, 0]], size = 2, vector = true }', "dot(a[0], w[i])", "three components")):
        with pytest.raises(smidgen.SpecError, match=said):
            read(home, parameter, energy)


MEASURED = """[model]
name = "measured"
[units]
energy = "meV"
time = "ps"
[space]
w = {{ r3 = 5 }}
[parameters]
K = {{ {}, size = 5, unit = "K" }}
[effects.axis]
over = "site(i) of w"
energy = "-K[i]*dot(w[i], w[i])/(1 meV ps)^2"
[starts.a]
w = {{ {}, unit = "hbar" }}
"""


def test_numbers_with_units_are_rounded_once(tmp_path):
    """Those of a file as those of a list: as they are written, times the exact unit."""
    dice = np.random.default_rng(4)
    k, w = dice.uniform(0.1, 9, 5).round(3), dice.uniform(-9, 9, (5, 3)).round(2)
    k[0], w[0] = 0, (0, -1, 2)
    np.save(tmp_path / "k.npy", k)
    (tmp_path / "k.csv").write_text("".join(f"{x}\n" for x in k.tolist()))
    (tmp_path / "w.csv").write_text("".join(f"{x},{y},{z}\n" for x, y, z in w.tolist()))
    found = []
    for numbers, vectors in [(f"default = {k.tolist()}", f"vectors = {w.tolist()}"), ('file = "k.csv"', 'file = "w.csv"'), ('file = "k.npy"', 'file = "w.csv"')]:
        (tmp_path / "spec.toml").write_text(MEASURED.format(numbers, vectors))
        spec = smidgen.load(tmp_path / "spec.toml")
        found.append((spec.parameters[0].default, spec.starts[0].families[0].value))
    assert found[0] == found[1] == found[2]


def test_a_number_of_a_file_that_is_out_of_range_in_the_units_of_the_model(tmp_path):
    (tmp_path / "k.csv").write_text("1\n2\n3\n4\n1e150\n")
    text = MEASURED.format('file = "k.csv"', "random = 1")
    for unit in ("QJ", "J^9/meV^8"):
        (tmp_path / "spec.toml").write_text(text.replace('"K" }', f'"{unit}" }}').replace(', unit = "hbar"', ""))
        with pytest.raises(smidgen.SpecError, match="in the units of this spec this is not between"):
            smidgen.load(tmp_path / "spec.toml")
