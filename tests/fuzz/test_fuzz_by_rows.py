"""Random lattices that must go by rows: what is drawn, and what is a fault."""
import random
import re

import pytest
import smidgen
from fuzz.by_rows import BY_ROWS, CLOCK, OF_BONDS, OF_NUMBERS, OF_SITES, PHASES, row_text
from fuzz.drawn import features_of
from fuzz.through import Fault, through
from support.strict import COMPILERS, compile_all

from smidgen.build.binary import write_files
from smidgen.compile.assemble.model import Model
from smidgen.compile.emit.amalgamate import inline_runtime
from smidgen.compile.emit.emit import generate
from smidgen.compile.plan.plan import choose
from smidgen.errors import UsageError
from smidgen.methods import METHODS

HEAD = """# goes: by rows
[model]
name = "random_model"
[space]
%s
[parameters]
n = 12
A = { default = 0.3, size = "n" }
"""
RUN = """[starts.s%s]
random = 1
[runs.fuzz]
start = "s"
h = 0.01
steps = 10
method = "%s"
"""
BOND = '[effects.e0]\nover = "bond(i, j) of chain(n, periodic)"\nenergy = "%s"\n'
RING = HEAD % 'w = { sphere = "n" }' + BOND + RUN % ("", "spherical-midpoint")
SAME = HEAD % 'v = { sphere = "n" }\nw = { sphere = "n" }' + "".join(
    f'[effects.of_{name}]\nover = "bond(i, j, b) of chain(n, periodic) on {name}"\nenergy = "(1 + 0.2*mod(b, 3))*dot({name}[i], {name}[j])"\n' for name in "vw")
PUSHED = HEAD % 'w = { sphere = "n" }' + BOND % "-dot(w[i], w[j])" + '[effects.push]\nover = "site(k) of w"\ntorque = "A[k]*cross(w[k], vec(1, 0.4, 0.5))"\n'
DRAWN = {"features": r"# features:.*\b(tangent|ensemble|distributed|plain-sums)\b", "two families": r"bond\(i of w, j of v\)", "several shells": r"\.second|, 2\)", "three ends": r"bond\(i, j, k\)",
         "four ends": r"bond\(i, j, k, l\)", "damping": r"\ndamping", "noise": r"\nkT", "torque": r"\ntorque", "torque of a neighbour": r"torque = .*\[j\]", "pinned": r"\npinned", "absent": r"\nabsent",
         "radii": r'radius = "1 ', "strengths": r'kappa = ".*[iA]\b', "anisotropy of any formula": r"\^4|exp\(-w|\^3", "any bond": r"dot\(w\[i\], w\[j\]\)\^2|exp\(0.3", "growing": r'= "(t|\(0.3 \+ t\)|t\^2/4)\*',
         "one end": r'energy = "[^i\n]*w\[j\][^i\n]*"', "ends far apart on a short ring": r"n = \{ default = 3[^}]*\}(\n.*)*reaching", "a field at one end": r"0\.7\*\(1 \+ uniform\(2, i\)",
         "wavefronts": r"SMG_WAVE", "threads": r"-fopenmp"}


@pytest.mark.quick
def test_methods_by_rows_are_those_of_the_compiler():
    """Each of the registry, on a chain with nothing else."""
    spec = smidgen.load_text(RING % "-dot(w[i], w[j])")
    found = {m.name for m in METHODS.values() if not m.free_body and not Model(spec, choose(spec, m.name, "auto")).by_site}
    assert found == {m.name for m in BY_ROWS}


@pytest.mark.quick
def test_every_method_and_every_way_is_drawn():
    texts = [row_text(random.Random(seed)) for seed in range(600)]
    assert {re.search('method = "(.*)"', t)[1] for t in texts} == {m.name for m in BY_ROWS}
    assert [name for name, pattern in DRAWN.items() if sum(bool(re.search(pattern, t)) for t in texts) < 3] == []
    factors = [f for some in (CLOCK, OF_SITES, PHASES, OF_BONDS, OF_NUMBERS) for f in some]
    assert [f for f in factors if not any(f in t for t in texts)] == []
    assert row_text(random.Random(3)) == row_text(random.Random(3))


@pytest.mark.parametrize("seeds", [range(4), pytest.param(range(4, 60), marks=pytest.mark.long)])
def test_random_lattices_go_by_rows(seeds):
    for seed in seeds:
        text = row_text(random.Random(seed))
        spec, (method, solver) = smidgen.load_text(text), re.search('method = "(.*)"\nsolver = "(.*)"', text).groups()
        assert Model(spec, choose(spec, method, solver), features_of(text)).by_site == "", seed


# Seeds that once showed a fault: two families with bonds of one formula of their number, and torques by site in the field of DOP853, which clang warned of

@pytest.mark.parametrize("text, method", [(SAME, "spherical-midpoint"), (PUSHED, "dop853")])
@pytest.mark.skipif("clang" not in COMPILERS, reason="no clang")
def test_it_compiles_without_a_warning(tmp_path, text, method):
    starts = "".join(f"[starts.s.{name}]\nrandom = 1\n" for name in ("v", "w")) if "v = " in text else "[starts.s]\nrandom = 1\n"
    made = generate(smidgen.load_text(text + starts), method=method)
    write_files(made, tmp_path)
    assert compile_all(tmp_path, sorted(f for f in made if f.endswith(".c")), "clang") == ""


APART = (HEAD % 'v = { sphere = "n" }\nw = { sphere = "n" }').replace("# goes", "#") + "".join(
    f'[effects.{name}]\nover = "{over}"\n{what}\n' for name, over, what in (
        ("one", "bond(i, j) of chain(n, open) on w", 'energy = "normal(3, i, j)*w[i].y*w[j].z"'), ("two", "bond(i, j) of chain(n, open) on v", 'energy = "-0.5*dot(v[i], v[j])"'),
        ("pulse", "bond(i, j) of chain(n, open) on v", 'energy = "cos(t)*(w_ + dot(v[i], v[j])/3)"'.replace("w_", "v[i].x*v[j].x")), ("field", "site(k) of v", 'energy = "v[k].z"'),
        ("own", "site(k) of w", 'energy = "w[k].x^2"'), ("gone", "site(k) of v", 'absent = "k == 1"')))


def test_terms_on_the_same_bonds_beside_absent_sites():
    """They are sums where all sites are there, and each for itself where some are not."""
    spec = smidgen.load_text(APART + "[starts.s.v]\nrandom = 1\n[starts.s.w]\nrandom = 2\n")
    model = Model(spec, choose(spec, "spherical-midpoint", "auto"))
    assert model.by_site == "" and all(len(whole.slots) == len(t.slots) for t, whole in ((t, model.in_rows.whole[t.prefix]) for t in model.fields))


PULSE = "exp(-(t - 1)^2)*%s"


@pytest.mark.parametrize("method, energy", [("pair-rotations", "dot(w[i], w[j])"), ("spherical-midpoint-4", "dot(w[i], w[j])^2"), ("sublattice-rotations", "dot(w[i], w[j])")])
def test_a_pulse_has_a_bound_at_all_times(method, energy):
    """exp(-(t - 1)^2) is not multiplied out: exp(2 t) has none."""
    spec = smidgen.load_text(RING % (PULSE % energy))
    assert Model(spec, choose(spec, method, "auto")).by_site == ""


# What is a fault

def test_one_that_goes_site_by_site_is_a_fault():
    stages = []
    with pytest.raises(Fault, match="it goes site by site, because the field of `e0` has branches|`e0` has branches"):
        through(RING % "abs(w[i].z)*w[j].z", stages.append)
    assert stages[-1] == "generate"


@pytest.mark.long
def test_one_whose_steps_do_is_a_fault(monkeypatch):
    """Planted: rows are never taken."""
    def change(files):
        files = inline_runtime(files, "random_model")
        right = "s->rows = s->row_bound <= SMG_ROW_BOUND;"
        assert right in files["random_model.c"]
        return {**files, "random_model.c": files["random_model.c"].replace(right, "s->rows = 0;")}
    assert through(RING % "-dot(w[i], w[j])")["layout"] == "rows"
    with pytest.raises(Fault, match="however small h is"):
        through(RING % "-dot(w[i], w[j])", change=change)


def test_a_feature_that_does_not_go_by_rows_is_not_drawn():
    with pytest.raises(UsageError):
        generate(smidgen.load_text(RING % "-dot(w[i], w[j])"), method="sublattice-rotations", features=("distributed",))
    assert not any("features" in t for t in (row_text(random.Random(k)) for k in range(200)) if 'method = "sublattice' in t or 'method = "pair' in t)
