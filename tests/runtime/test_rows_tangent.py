"""The tangent map of lattices by rows: that of Newton's matrix site by site, whatever the effects; its bits; and what it keeps."""
import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError
from smidgen.methods import METHODS
from smidgen.resources import runtime_header
from support.by_sites import by_sites
from support.strict import MODES, compile_all
from test_rows import DM, EXCHANGE, lattice
from test_rows_by_site import KINDS, drawn
from test_rows_held import ABSENT, PINNED
from test_rows_in_time import by_rows

TANGENT, CLASSICAL, COMPOSED = ("tangent",), "classical-midpoint", "spherical-midpoint-4"
QUARTIC = '[effects.quartic]\nover = "site(i) of w"\nenergy = "-0.1*(w[i].x^4 + w[i].y^4 + w[i].z^4)"\n[effects.square]\nover = "bond(i, j) of {over}"\nenergy = "-0.1*dot(w[i], w[j])^2"\n'
DRAWN = '[effects.drawn]\nover = "bond(i, j) of {over}"\nenergy = "0.2*normal(1, i, j)*w[i].x*w[j].y*cos(t)"\n'
DAMPED = '[effects.damping]\nover = "site(i) of w"\ndamping = "0.1 + 0.05*mod(i, 2)"\n'
PUSHED = '[effects.torque]\nover = "site(i) of w"\ntorque = "0.2*w[i].z*cross(w[i], vec(0, 1, 0))"\n'
TORQUE = '[effects.torque]\nover = "site(i) of w"\ntorque = "0.2*cross(w[i], cross(w[i], vec(0, 1, 0)))"\n'
CASES = {       # (place, effects over bonds and sites in place of exchange and Dzyaloshinskii-Moriya, energies of sites, method)
    "plain": ("blocks", "", ()), "in time by site": ("three colours", DAMPED, ("in time",)), "anisotropy": ("odd square", DRAWN, ("anisotropy",)), "quartic": ("ladder", QUARTIC, ()),
    "held": ("honeycomb", PINNED + ABSENT + DAMPED, ("field",)), "torque": ("odd cubic", TORQUE + DAMPED, ()), "pushed": ("open chain", PUSHED + QUARTIC, ("a part",)), "far": ("far", DRAWN, ("phases",)),
    "classical": ("pieces", DRAWN, ("anisotropy",), CLASSICAL), "composed": ("odd square", DRAWN + DAMPED, ("in time",), COMPOSED), "composed blocks": ("blocks", QUARTIC, (), COMPOSED)}
QUICK = ("plain", "in time by site", "quartic", "composed")
marks = [pytest.param(name, marks=() if name in QUICK else pytest.mark.long) for name in CASES]


def case(name):
    """(spec, method)."""
    place, effects, kinds, method = (*CASES[name], "spherical-midpoint")[:4]
    return drawn(place, *(KINDS[k] for k in kinds), bonds=EXCHANGE + DM + effects), method


def vectors(model, count=2):
    return np.random.default_rng(2).standard_normal((count, *model.w.shape))


def mapped(model, steps=3, h=0.07):
    model.start("random", h=h, t0=0.2).steps(steps)
    return model.tangent(vectors(model))


@pytest.mark.parametrize("name", marks)
def test_the_map_is_that_of_newtons_matrix(name):
    """Of any vectors, those across the spheres too; each stage rounds."""
    spec, method = case(name)
    assert by_rows(spec, method) and "site by site" not in generate(spec, method, features=TANGENT).notes["reason"]
    rows, sites = (mapped(build(spec, method=method, features=TANGENT)) for build in (smidgen.build, by_sites))
    assert np.abs(rows - sites).max() <= 3e-15 * METHODS[method].stages * np.abs(sites).max()


@pytest.mark.parametrize("name", ["quartic", pytest.param("held", marks=pytest.mark.long), pytest.param("composed", marks=pytest.mark.long)])
def test_the_map_is_the_derivative_of_the_step(name):
    """By central differences of the step of a build without it."""
    spec, method = case(name)
    (one, other), size = (smidgen.build(spec, method=method, features=f) for f in (TANGENT, ())), 1e-5
    w = one.start("random", h=0.07, t0=0.2).w.copy()
    v = np.cross(w, vectors(one, 1)[0])
    found, radius = one.step().tangent(v.copy()), np.linalg.norm(w, axis=1)[:, None]
    ends = [other.start((x := w + s * size * v) * radius / np.linalg.norm(x, axis=1)[:, None], h=0.07, t0=0.2).step().w.copy() for s in (1, -1)]
    there = np.abs(ends[0] - ends[1]).sum(axis=1) > 0
    assert there.sum() > 5 and np.abs(found - (ends[0] - ends[1]) / (2 * size))[there].max() <= 1e-8


UNITS = """[model]
name = "units"
[space]
w = { sphere = "n*8", radius = "r" }
[parameters]
n = { default = 16, fixed = true }
r = 1.0
[effects.exchange]
over = "bond(i, j) of square(n, 8, periodic)"
energy = "(-dot(w[i], w[j]) - 0.2*(w[i].x*w[j].y - w[i].y*w[j].x))/r"
[effects.axis]
over = "site(i) of w"
energy = "0.3*w[i].z^2/r"
[starts.random]
random = 1
"""


@pytest.mark.parametrize("r", [2.0**-27, pytest.param(2.0**27, marks=pytest.mark.long)])
def test_the_map_does_not_depend_on_the_unit_of_length(r):
    """A power of two changes no bit of it: nothing in it is compared with an absolute number."""
    spec = smidgen.load_text(UNITS)
    assert by_rows(spec)
    assert np.array_equal(*(mapped(smidgen.build(spec, features=TANGENT, parameters={"r": radius})) for radius in (1.0, r)))


def test_steps_keep_their_bits():
    spec, _ = case("in time by site")
    assert np.array_equal(*(smidgen.build(spec, features=f).start("random", h=0.07).steps(9).w for f in ((), TANGENT)))


@pytest.mark.parametrize("tolerance, off", [(1e-6, 1e-5), (1e-10, 1e-9)])
def test_a_tolerance_is_that_of_the_map_too(tolerance, off):
    spec, _ = case("plain")
    exact, loose = (smidgen.build(spec, features=TANGENT).start("random", h=0.07, tolerance=t).step() for t in (None, tolerance))
    apart = np.abs(exact.tangent(vectors(exact)) - loose.tangent(vectors(loose))).max()
    assert 1e-15 < apart <= off


@pytest.mark.parametrize("name", [pytest.param(name, marks=() if name == "composed" else pytest.mark.long) for name in ("plain", "in time by site", "held", "composed")])
def test_the_same_bits_for_any_number_of_lanes(name, monkeypatch):
    spec, method = case(name)

    def of(lanes):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        return mapped(smidgen.build(spec, method=method, features=TANGENT))
    wanted = of(1)
    assert all(np.array_equal(of(n), wanted) for n in (2, 4, 8))


@pytest.mark.long
@pytest.mark.parametrize("method", ["spherical-midpoint", COMPOSED])
def test_the_same_bits_for_two_threads(method):
    spec = smidgen.load("cubic_lattice")
    sizes = {p.name: 20 for p in spec.parameters if p.kind == "int"}
    found = []
    for n in (1, 2):
        model = smidgen.build(spec, method=method, features=TANGENT, threads=n, parameters=sizes).start(h=0.02).steps(2)
        found.append(model.tangent(vectors(model)))
    assert np.array_equal(*found)


def test_a_restored_state_has_the_map_of_its_last_step():
    spec, _ = case("in time by site")
    one, other = (smidgen.build(spec, features=TANGENT).start("random", h=0.07) for _ in "ab")
    saved = one.steps(4).save()
    assert np.array_equal(other.restore(saved).tangent(vectors(one)), one.tangent(vectors(one)))
    assert np.array_equal(other.steps(3).save(), one.steps(3).save())


@pytest.mark.parametrize("method", ["spherical-midpoint", COMPOSED])
def test_a_step_that_fails_leaves_the_map_of_the_one_before(method, monkeypatch):
    """With eight passes of colours allowed, too few for a pulse: the increments of the first colour, which the map and a saved state have, are those of the last step."""
    monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_ROW_PASSES=8")
    pulse = EXCHANGE.replace("-0.7*", "-(0.0001 + 2.5*exp(-((t - 0.55)/0.03)^2))*")
    model = smidgen.build(lattice("late", "chain(n, periodic)", 16, "n", pulse), method=method, features=TANGENT).start("random", h=0.1).steps(5)
    before, v = model.save(), vectors(model)
    wanted = model.tangent(v.copy())
    assert model.advance(1) == 0 and np.array_equal(model.save(), before)
    if method == COMPOSED:
        with pytest.raises(RunError):
            model.tangent(v)
    else:
        assert np.array_equal(model.tangent(v), wanted)


def test_a_map_that_does_not_settle_is_an_error(monkeypatch):
    """The state after a step is restored where only four passes of colours are allowed: too few for the map."""
    spec, h = lattice("hurried", "chain(n, periodic)", 16, "n", EXCHANGE), 0.1
    saved = smidgen.build(spec, features=TANGENT).start("random", h=h).steps(8).save()
    monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_ROW_PASSES=4")
    model = smidgen.build(spec, features=TANGENT).start("random", h=h).restore(saved)
    with pytest.raises(RunError, match="converge"):
        model.tangent(vectors(model))
    assert np.array_equal(model.save(), saved)


@pytest.mark.parametrize("method", ["spherical-midpoint", pytest.param(COMPOSED, marks=pytest.mark.long)])
def test_the_map_is_symplectic(method):
    """K(W) = M K(w) M^T in double precision, K the blocks [w]_x."""
    model = smidgen.build(drawn("odd square", KINDS["anisotropy"]), method=method, features=TANGENT).start("random", h=0.07, t0=0.2)

    def blocks(w):
        K = np.zeros((w.size, w.size))
        for i, (x, y, z) in enumerate(w):
            K[3 * i:3 * i + 3, 3 * i:3 * i + 3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
        return K
    before = blocks(model.w)
    model.step()
    left = model.tangent(before.reshape(-1, *model.w.shape).copy()).reshape(len(before), -1)
    found = model.tangent(left.T.copy().reshape(-1, *model.w.shape)).reshape(len(before), -1)
    assert np.abs(found.T - blocks(model.w)).max() <= 1e-14


def test_the_exponents_of_a_lattice_add_up_to_0():
    model = smidgen.build(drawn("odd square", KINDS["anisotropy"]), features=TANGENT)
    found = smidgen.lyapunov.exponents(model, "random", h=0.07, steps=60, every=3)
    assert found.values[0] > 0.05 and abs(found.growth.sum()) <= 1e-11


def test_vectors_may_have_any_size():
    spec, _ = case("plain")
    model = smidgen.build(spec, features=TANGENT).start("random", h=0.07).step()
    v = vectors(model, 1)
    for scale in (1e-290, 1e290):
        assert np.abs(model.tangent(v * scale) / scale - model.tangent(v.copy())).max() <= 1e-14
    assert not model.tangent(0 * v).any()


def test_a_vector_that_is_not_finite_ends_the_map():
    spec, _ = case("plain")
    model = smidgen.build(spec, features=TANGENT).start("random", h=0.07).step()
    v, w = vectors(model), model.w.copy()
    v[0, 5, 1] = np.inf
    with pytest.raises(RunError, match="finite"):
        model.tangent(v)
    assert np.array_equal(model.w, w) and np.isfinite(model.tangent(vectors(model))).all()


@pytest.mark.parametrize("name", [pytest.param(name, marks=() if name == "held" else pytest.mark.long) for name in ("held", "quartic", "classical", "composed")])
@pytest.mark.parametrize("compiler, how", MODES)
def test_compiles_without_a_warning(name, compiler, how, tmp_path):
    spec, method = case(name)
    files = generate(spec, method, features=TANGENT)
    for file, text in files.items():
        (tmp_path / file).write_text(text)
    assert compile_all(tmp_path, [f for f in files if f.endswith(".c")], compiler, how=how) == ""


FAULTS = (("ab[k] / square", "ab[2] / square"), ("- ab[1] * dm[k]", "+ ab[1] * dm[k]"), ("go.weights[0] = -1;", "go.weights[0] = 1;"))


@pytest.mark.parametrize("right, wrong", FAULTS[:1] + tuple(pytest.param(*one, marks=pytest.mark.long) for one in FAULTS[1:]))
def test_a_planted_fault_is_noticed(right, wrong, tmp_path, monkeypatch):
    """In the copy of the header that this build finds first. A step may also say that sweeps do not come to rest."""
    text = runtime_header("smg_row_tangent.h").read_text()
    assert right in text
    (tmp_path / "smg_row_tangent.h").write_text(text.replace(right, wrong))
    spec, _ = case("anisotropy")
    wanted = mapped(by_sites(spec, features=TANGENT))
    monkeypatch.setenv("CC", f"gcc -I{tmp_path}")
    try:
        apart = np.abs(mapped(smidgen.build(spec, features=TANGENT)) - wanted).max()
    except smidgen.RunError:
        apart = np.inf
    assert apart > 1e-6
