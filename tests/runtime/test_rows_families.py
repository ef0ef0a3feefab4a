"""Lattices by rows with several families: places of one cell to the step, one family behind the other to everybody else."""
import numpy as np
import pytest
import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from smidgen.errors import UsageError
from support.going_on import one_by_one, restored
from support.widths import same_in_lanes
from test_rows_in_time import by_rows
from test_rows_laws import close

HEAD = """
[model]
name = "layers"
[space]
a = {{ sphere = "n*m*places"{} }}
b = {{ sphere = "n*m*places"{} }}
[parameters]
n = {}
m = {}
places = 1
[lattices.between]
size = ["n", "m"]
boundary = [{}]
bonds.near = [{{ offset = [0, 0] }}, {{ offset = [1, 0] }}]
[lattices.within]
size = ["n", "m"]
boundary = [{}]
bonds.near = [{{ offset = [1, 0] }}, {{ offset = [0, 1] }}]
bonds.far = [{{ offset = [2, 0] }}]
{}
[starts.random.a]
random = 1
[starts.random.b]
random = 2
"""
CLOSED, CUT = '"periodic", "periodic"', '"open", "periodic"'
NEAR = {name: (f"bond(i, j) of within.near on {name}", f"{-strength}*dot({name}[i], {name}[j])") for name, strength in (("a", 1), ("b", 0.7))}
BETWEEN = ("bond(i of a, j of b) of between.near", "0.5*dot(a[i], b[j]) + 0.1*triple(vec(0, 0, 1), a[i], b[j])")
BONDS = (NEAR["a"], NEAR["b"], BETWEEN)


def effect(k: int, over: str, value: str, word: str = "energy") -> str:
    return f'[effects.e{k}]\nover = "{over}"\n{word} = "{value}"\n'


def layers(*effects, a="", b="", n=8, m=6, boundary=CLOSED):
    return smidgen.load_text(HEAD.format(a, b, n, m, boundary, boundary, "".join(effect(k, *one) for k, one in enumerate(effects))))


SITED = (("site(i) of b", "0.3*sin(0.7*i)*b[i].z + 0.2*mod(i, 3)*b[i].x^2"), ("site(i) of a", "0.3*cos(t)*a[i].z"))
DAMPED = (("site(i) of b", "0.1", "damping"), ("site(i) of a", "0.2", "damping"), ("site(i) of a", "uniform(7, i) < 0.1", "pinned"))
SPECS = {
    "all": layers(*BONDS, *SITED, *DAMPED, a=', radius = "1 + mod(i, 2)"', b=', kappa = -2.5, radius = 1.7', n=7, m=5, boundary=CUT),
    "bond by bond": layers(NEAR["b"], ("bond(i of a, j of b, q) of between.near", "(1 + 0.2*normal(3, q) + 0.1*j)*dot(a[i], b[j])"), ("site(i) of b", "0.1*uniform(4, i)*b[i].y"), n=5, m=4, boundary=CUT),
    "both disordered": layers(*((over, f"(1 + 0.1*uniform({k}, i, j))*({energy})") for k, (over, energy) in enumerate((*BONDS[:2], (BETWEEN[0], "0.5*dot(a[i], b[j])")))), ("site(i) of a", "normal(8, i)*a[i].z/3"), ("site(i) of b", "uniform(9, i)*b[i].x/2"), n=5, m=4, boundary=CUT),
    "blocks": layers(*BONDS, n=16, m=8), "between alone": layers(BETWEEN, n=9), "apart": layers(NEAR["a"], NEAR["b"]), "far": layers(*BONDS, ("bond(i, j) of within.far on b", "0.3*dot(b[i], b[j])"), n=14),
    "bent": layers(*BONDS, ("site(i) of b", "0.2*b[i].x^4"), ("site(i) of a", "0.1*a[i].x^2"), b=", radius = 1.4"), "damped alike": layers(*BONDS, DAMPED[0], ("site(i) of a", "0.1", "damping")),
    "one damped": layers(*BONDS, ("site(i) of b", "0.1 + 0.05*mod(i, 2)", "damping")), "absent": layers(*BONDS, ("site(i) of b", "uniform(7, i) < 0.2", "absent")),
    "torque": layers(*BONDS, ("site(i) of b", "0.2*cross(b[i], cross(b[i], vec(0, 1, 0)))", "torque"), ("site(i) of a", "0.1*a[i].z*cross(a[i], vec(0, 1, 0))", "torque")),
    "growing": layers(*BONDS, ("site(i) of b", "0.2*t*b[i].z"), n=9)}
QUICK = ("all", "bond by bond", "both disordered")


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.long) for n in SPECS])
def test_rows_solve_the_step(name):
    """Against the witness, which knows no rows."""
    assert by_rows(SPECS[name]) and close(SPECS[name], 4) <= 2e-14


CELL = """
[model]
name = "cell"
[space]
w = { sphere = "2*n*m" }
[parameters]
n = 24
m = 12
[lattices.both]
size = ["n", "m"]
boundary = "periodic"
sites = 2
bonds.a = [{ from = 0, to = 0, offset = [1, 0] }, { from = 0, to = 0, offset = [0, 1] }]
bonds.b = [{ from = 1, to = 1, offset = [1, 0] }, { from = 1, to = 1, offset = [0, 1] }]
bonds.between = [{ from = 0, to = 1, offset = [0, 0] }, { from = 0, to = 1, offset = [1, 0] }]
"""


@pytest.mark.parametrize("h, method", [(0.1, "spherical-midpoint"), pytest.param(0.35, "spherical-midpoint", marks=pytest.mark.long), *(pytest.param(0.05, m, marks=pytest.mark.long) for m in ("gauss-4", "dop853", "spherical-midpoint-4", "classical-midpoint", "sublattice-rotations"))])
def test_they_have_the_bits_of_places_in_a_cell(h, method):
    """Of the same spins as one family, whose order alone is another one; the largest h is beyond the bound."""
    bonds = (NEAR["a"], (NEAR["b"][0], "-dot(b[i], b[j])"), BETWEEN)
    text = "".join(effect(k, f"bond(i, j) of both.{name}", energy.replace("a[", "w[").replace("b[", "w[")) for k, (name, (_, energy)) in enumerate(zip(("a", "b", "between"), bonds)))
    one = smidgen.load_text(CELL + text + "[starts.random]\nrandom = 1\n")
    cell, families = (smidgen.build(spec, method=method).start("random", h=h) for spec in (one, layers(*bonds, n=24, m=12)))
    w = families.w.reshape(2, -1, 3).transpose(1, 0, 2).reshape(-1, 3)
    found = cell.start(w.copy(), h=h).steps(7).w.reshape(-1, 2, 3).transpose(1, 0, 2).reshape(-1, 3)
    assert np.array_equal(families.steps(7).w, found)


def test_the_stronger_family_decides():
    """With its couplings no step of this h goes by rows, although with those of the first family each would."""
    strong = layers(*BONDS, (NEAR["b"][0], "-4*dot(b[i], b[j])"))
    assert by_rows(strong) and close(strong, 3, rows=False) <= 1e-11


@pytest.mark.long
@pytest.mark.parametrize("method, m", [(method, 6) for method in ("classical-midpoint", "spherical-midpoint-4", "gauss-4", "gauss-8", "dop853", "extrapolation-12", "sublattice-rotations", "sublattice-rotations-4")] + [("sublattice-rotations", 7)])
def test_other_methods(method, m):
    """A ring of seven does not fit the three colours, so that each site has one of its own."""
    spec = layers(*BONDS, *SITED[1:], n=9, m=m, boundary=CUT)
    model = smidgen.build(spec, method=method).start("random", h=0.05)
    found = Witness(spec).steps(model.w.copy(), 0.0, 0.05, 3, method)
    assert by_rows(spec) and np.abs(model.steps(3).w - (found if np.ndim(found) == 2 else found[-1])).max() <= 1e-13


@pytest.mark.long
@pytest.mark.parametrize("name", ["all", "blocks"])
def test_states_are_those_from_site_to_site(name):
    """A build with the tangent map goes from site to site."""
    ends = [smidgen.build(SPECS[name], features=f).start("random", h=0.05).steps(12).w.copy() for f in ((), ("tangent",))]
    assert np.abs(ends[0] - ends[1]).max() <= 2e-13


@pytest.mark.long
@pytest.mark.parametrize("name, widths", [("all", (2, 4, 8)), ("blocks", (4, 8))])
def test_the_same_bits_for_any_number_of_lanes(name, widths, monkeypatch):
    def built(lanes):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(SPECS[name])
    assert same_in_lanes(built, widths)


@pytest.mark.long
def test_the_same_bits_for_two_threads(monkeypatch):
    wanted = smidgen.build(SPECS["all"]).start("random", h=0.08).steps(9).save()
    monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_SHARE=8")
    assert np.array_equal(smidgen.build(SPECS["all"], threads=2).start("random", h=0.08).steps(9).save(), wanted)


def test_restored_it_goes_on():
    model = smidgen.build(SPECS["all"])
    assert restored(model) and one_by_one(model)


APART = layers(NEAR["a"], ("bond(i, j) of chain(n*m, periodic) on b", NEAR["b"][1]))
FIELD = layers(NEAR["a"], ("site(i) of b", "b[i].z"))
TRACERS = layers(NEAR["a"], BETWEEN, b=", tracer = true")


@pytest.mark.parametrize("spec, said", [(APART, "its bonds belong to several lattices"), (FIELD, "`b` has no bonds of the lattice"), (TRACERS, "`b` is a family of tracers")])
def test_what_prevents_it_is_said(spec, said):
    assert generate(spec, "spherical-midpoint").notes["reason"].endswith(said)


def test_radii_of_families_need_midpoints():
    spec = layers(*BONDS, b=", radius = 1.7")
    assert generate(spec, "gauss-4").notes["reason"].endswith("the radius of `b` differs from that of another family")


def test_memory_is_not_divided():
    with pytest.raises(UsageError, match="several families"):
        generate(SPECS["apart"], "spherical-midpoint", features=("distributed",))
