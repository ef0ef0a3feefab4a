"""Explicit splittings: what they ask of H, order, what each keeps, the witness, the certificate, clean C."""
import functools
import json
import subprocess

import numpy as np
import pytest
import smidgen
from mpmath import log, mpf
from smidgen.check.witness import Witness, splittings
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError, UsageError
from smidgen.methods import METHODS, SCHEMES
from smidgen.resources import include_flags
from support.compositions import SPECS, STARTS, compile_model, run
from support.strict import COMMANDS, WARNINGS
from support.triples import apart, on_sphere

MODEL = """
[model]
name = "{name}"
[space]
{space}
[effects.first]
{first}
[effects.second]
{second}
{start}
[runs.r]
start = "a"
h = 0.1
steps = 20
"""


def model(name, first, second, space='w = { sphere = 6, kappa = [1, 1.5, -2, 1, 1.5, -2] }', start="[starts.a]\nrandom = 1"):
    return smidgen.load_text(MODEL.format(name=name, space=space, first=first, second=second, start=start))


BONDS = 'over = "bond(i, j) of chain(6, periodic)"\nenergy = '
SITES = 'over = "site(i) of w"\nenergy = '
CHAIN = model("xyz_chain", BONDS + '"w[i].x*w[j].x - 0.7*w[i].y*w[j].y + 0.4*w[i].z*w[j].z"', SITES + '"0.3*w[i].z^3 + 0.2*w[i].x*cos(t)"')
STILL = model("still_chain", BONDS + '"w[i].x*w[j].x - 0.7*w[i].y*w[j].y + 0.4*w[i].z*w[j].z"', SITES + '"0.3*w[i].z^3"')
BODIES = model("two_r3", SITES + '"w[i].x^2/2 + w[i].y^2/4 + w[i].z^3"', SITES + '"0.2*w[i].y*sin(t)"', "w = { r3 = 3, kappa = -2 }")
CARRIED = model("carried", 'over = "pair(i, j) of w"\nenergy = "dot(w[i], w[j])"', 'over = "each(k of p, j of w)"\nenergy = "p[k].x*w[j].x + p[k].z^2*w[j].z"',
                "w = { sphere = 3 }\np = { sphere = 2, tracer = true }", "[starts.a.w]\nrandom = 1\n[starts.a.p]\nrandom = 2")
BODY = SPECS["irreversible body"]
AXES = {"body": BODY, "chain": CHAIN, "r3": BODIES, "tracers": CARRIED}


# ---- axes: what H must be ----------------------------------------------------------------------

@pytest.mark.quick
@pytest.mark.parametrize("name, said", [
    ("point_vortices", r"effect 'interaction' joins w\[i\]\.x and w\[i\]\.y"), ("nambu_a31", "Nambu")])
def test_what_stands_in_the_way_of_the_axes_is_named(name, said):
    with pytest.raises(UsageError, match=said):
        generate(smidgen.load(name), method="axis-splitting")


@pytest.mark.quick
def test_the_term_is_quoted():
    spec = model("mixed", BONDS + '"dot(w[i], w[j])"', BONDS + '"0.5*w[i].x*w[j].x + 2*w[i].x*w[j].y"')
    with pytest.raises(UsageError, match=r"effect 'second' joins w\[i\]\.x and w\[j\]\.y in the term 2\*w\[i\]\.x\*w\[j\]\.y$"):
        generate(spec, method="axis-splitting")
    said = smidgen.explain(spec)
    assert "effect 'second' joins w[i].x and w[j].y" in said.splittings["axis-splitting"]
    assert any("Method axis-splitting cannot be used: effect 'second'" in line for line in said.words())
    assert smidgen.explain(spec, effects=["first"]).splittings["axis-splitting"] is None


@pytest.mark.quick
def test_what_cancels_does_not_stand_in_the_way():
    spec = model("cancels", SITES + '"(w[i].x + w[i].y)^2 - 2*w[i].x*w[i].y"', BONDS + '"dot(w[i], w[j])"')
    assert smidgen.explain(spec).splittings["axis-splitting"] is None


# ---- axes: the step -----------------------------------------------------------------------------

@pytest.mark.parametrize("name", AXES)
@pytest.mark.parametrize("method", ["axis-splitting", "axis-splitting-4", *(pytest.param(f"axis-splitting-{s}", marks=pytest.mark.long) for s in SCHEMES if s != "4")])
def test_the_witness_takes_the_same_steps(name, method):
    report = smidgen.validate(AXES[name], method=method, steps=20)
    assert report.passed, [line for line in report.lines if not line.passed]


@pytest.mark.parametrize("name", AXES)
@pytest.mark.usefixtures("few_states", "optimised_here")
def test_the_certificate(name):
    """Symplectic, reversible, of its order; nothing is claimed that a splitting does not keep."""
    rows = {row.name: row for row in smidgen.verify(AXES[name], method="axis-splitting", tier="quick").rows}
    assert not [row for row in rows.values() if row.verdict == "no"]
    for one in ("order", "reversible", "casimirs", "step", "symplectic"):
        assert rows[one].verdict == "yes" or name == "tracers" and one == "symplectic"
    for one in ("momentum", "quadratic integrals", "energy", "equivariant"):
        assert rows[one].verdict == "does not apply"


@pytest.mark.quick
def test_where_sites_are_joined_the_rotations_are_exact():
    """Half the angle for its tangent would be of order 2 there as well, but not symplectic: a chain turns by the exact angle."""
    spec = model("ising", BONDS + '"w[i].x*w[j].x"', SITES + '"0*w[i].x"')
    integrator = smidgen.build(spec, method="axis-splitting").start("a", h=0.7)
    w, kappa = integrator.w.copy(), np.array([1, 1.5, -2] * 2)
    angle = 0.7 * (np.roll(w[:, 0], 1) + np.roll(w[:, 0], -1)) / kappa
    turned = np.stack([w[:, 0], np.cos(angle) * w[:, 1] + np.sin(angle) * w[:, 2], np.cos(angle) * w[:, 2] - np.sin(angle) * w[:, 1]], 1)
    assert np.abs(integrator.step().w - turned).max() < 1e-15


@pytest.fixture(scope="session")
def quad(tmp_path_factory):
    to, known = tmp_path_factory.mktemp("splitting"), {}

    def made(spec, method):
        if (spec.name, method) not in known:
            known[spec.name, method] = compile_model(to / f"{spec.name}-{method}", spec, method)
        return known[spec.name, method]
    return made


CHAIN_START = [on_sphere(v) for v in ((1, 0.2, 0.3), (-0.5, 1, 0.1), (-0.4, -1, 0.5), (0.1, 0.3, -1), (0.7, 0.7, 0.2), (-1, 0.2, 0.6))]
STEPS = {2: 32, 4: 16, 6: 16, 8: 8, 10: 8}


@pytest.mark.parametrize("spec, start", [(BODY, STARTS["irreversible body"]), (CHAIN, CHAIN_START)], ids=["body", "chain"])
@pytest.mark.parametrize("scheme", ["", "4", "6", "8", "10", *(pytest.param(s, marks=pytest.mark.long) for s in ("ss13", "kl9a", "kl17a"))])
def test_the_order_in_quadruple_precision(quad, spec, start, scheme):
    """Of a chain with a drive, too, beside the spherical midpoint of order 10, which is right to 1e-25."""
    method = METHODS["axis-splitting" + (f"-{scheme}" if scheme else "")]
    exact, n = run(quad(spec, "spherical-midpoint-10"), start, 1 / 64, 64).w, STEPS[method.order]
    errors = [apart(run(quad(spec, method.name), start, 1 / k, k).w, exact) for k in (n, 2 * n)]
    assert errors[1] > mpf(10)**-21
    assert abs(log(errors[0] / errors[1], 2) - method.order) < 0.1


@pytest.mark.parametrize("spec, h", [(BODY, 0.5), (STILL, 0.1)], ids=["body", "chain"])
def test_the_energy_stays_near_what_it_was(spec, h):
    integrator = smidgen.build(spec, method="axis-splitting").start("a", h=h)
    first, found = integrator.values()[0], []
    for _ in range(40):
        found.append(integrator.steps(2500).values()[0] - first)
    found = np.array(found)
    assert np.abs(found).max() < 0.2 and abs(found[20:].mean() - found[:20].mean()) < 0.5 * np.ptp(found)
    assert np.abs(np.linalg.norm(integrator.w, axis=1) - 1).max() < 4e-16


@pytest.mark.quick
@pytest.mark.parametrize("scheme", ["", "-8"])
@pytest.mark.parametrize("spec, method", [*((spec, "axis-splitting") for spec in AXES.values()), (smidgen.load("honeycomb"), "sublattice-rotations"),
                                          (smidgen.load("point_vortices"), "pair-rotations")], ids=lambda x: getattr(x, "name", x))
def test_restored_it_goes_on_with_the_same_bits(spec, method, scheme):
    integrator = smidgen.build(spec, method=method + scheme)
    whole = integrator.start(spec.starts[0].name, h=0.1).steps(12).w.copy()
    saved = integrator.start(spec.starts[0].name, h=0.1).steps(5).save()
    assert np.array_equal(integrator.start(spec.starts[0].name, h=0.2).restore(saved).steps(7).w, whole)


@pytest.mark.quick
@pytest.mark.parametrize("first", [SITES + '"0.3*w[i].z"', BONDS + '"0.3*w[i].z*w[j].z"'], ids=["separate", "joined"])
def test_a_constant_angle_does_not_wear_a_sphere_down(first):
    """Rounded sines and cosines of one angle change |w| by the same little in every step; where that is not taken out, by 5e-13 here."""
    integrator = smidgen.build(model("constant", first, SITES + '"0.1*w[i].z"'), method="axis-splitting").start("a", h=0.3).steps(10**6)
    assert np.abs(np.linalg.norm(integrator.w, axis=1) - 1).max() < 5e-16


@pytest.mark.quick
@pytest.mark.parametrize("spec, h", [(BODY, 1e200), (BODIES, 1e200), (model("huge", BONDS + '"1e150*w[i].x*w[j].x"', SITES + '"w[i].y"'), 1e160)], ids=["body", "r3", "chain"])
def test_a_step_that_is_no_number_leaves_the_state(spec, h):
    integrator = smidgen.build(spec, method="axis-splitting").start("a", h=h)
    before = integrator.w.copy()
    with pytest.raises(RunError, match="not finite"):
        integrator.step()
    assert np.array_equal(integrator.w, before) and integrator.count == 0


# ---- sublattices ---------------------------------------------------------------------------------

RING = '''over = "bond(i, j) of chain({0}, {1})"
energy = '''
TRIPLE = "0.4*w[i].z + 0.2*w[i].x*cos(t)"


def ring(name, n, ends, field='"0.4*w[i].z"'):
    return model(name, RING.format(n, ends) + '"w[i].x*w[j].x + 0.6*w[i].y*w[j].z - 0.3*triple(w[i], w[j], vec(1, 0, 2))"', SITES + field,
                 f'w = {{ sphere = {n}, kappa = "1 + 0.1*i" }}')


LATTICES = {"even": ring("even", 6, "periodic"), "odd": ring("odd", 5, "periodic"), "open": ring("open_chain", 5, "open"),
            "driven": ring("driven", 6, "periodic", f'"{TRIPLE}"'),
            "pairs": model("pairs", 'over = "pair(i, j) of w"\nenergy = "dot(w[i], w[j])"', SITES + '"w[i].x"'),
            "two families": model("families", 'over = "each(i of w, j of b)"\nenergy = "w[i].x*b[j].y"', SITES + '"w[i].x"',
                                  "w = { sphere = 3 }\nb = { r3 = 2, kappa = -0.5 }", "[starts.a.w]\nrandom = 1\n[starts.a.b]\nrandom = 2"),
            "apart": model("apart", SITES + '"w[i].z"', SITES + '"0.5*w[i].x"')}


def lattice_model(name):
    return LATTICES[name] if name in LATTICES else smidgen.load(name)


@pytest.mark.quick
def test_what_stands_in_the_way_of_sublattices_is_named():
    spec = model("easy_axis", BONDS + '"dot(w[i], w[j])"', SITES + '"-0.3*w[i].z^2"')
    with pytest.raises(UsageError, match=r"effect 'second' is not linear in w\[i\] in the term -0\.3\d*\*w\[i\]\.z\^2"):
        generate(spec, method="sublattice-rotations")
    assert smidgen.explain(spec, effects=["first"]).splittings["sublattice-rotations"] is None


@pytest.mark.parametrize("name", [*LATTICES, "honeycomb", pytest.param("cubic_lattice", marks=pytest.mark.long), pytest.param("j1j2_chain", marks=pytest.mark.long)])
@pytest.mark.parametrize("method", ["sublattice-rotations", pytest.param("sublattice-rotations-6", marks=pytest.mark.long)])
def test_the_witness_turns_the_same_sublattices(name, method):
    report = smidgen.validate(lattice_model(name), method=method, steps=10)
    assert report.passed, [line for line in report.lines if not line.passed]


def test_the_witness_does_not_trust_the_colours():
    one = Witness(LATTICES["even"])
    good = splittings.proper(one, splittings.colours(one))
    bad = good.copy()
    bad[good == good.max()] -= 1
    with pytest.raises(RunError, match="two sites of the same colour"):
        splittings.proper(one, bad)


@pytest.mark.parametrize("name", [name for name in LATTICES if name != "apart"])
@pytest.mark.usefixtures("few_states", "optimised_here")
def test_the_certificate_says_that_sublattice_rotations_are_not_symplectic(name):
    """And that they keep the energy, where it does not depend on time."""
    rows = {row.name: row for row in smidgen.verify(LATTICES[name], method="sublattice-rotations", tier="quick").rows}
    assert [row.name for row in rows.values() if row.verdict == "no"] == ["symplectic"]
    assert rows["symplectic"].measured > 1e-8 and "not symplectic" in rows["symplectic"].note
    assert rows["energy"].verdict == ("does not apply" if name == "driven" else "yes")
    assert rows["order"].verdict == rows["reversible"].verdict == rows["casimirs"].verdict == rows["step"].verdict == "yes"


def volume(spec, h):
    """det of the step's derivative in an orthonormal frame of the spheres, by differences of order 4."""
    integrator = smidgen.build(spec, method="sublattice-rotations", real="long double")
    w = np.array(integrator.start("a", h=h).w, np.longdouble)
    frames = [np.linalg.qr(np.column_stack([x, np.eye(3)[[1, 2, 0][int(np.argmax(np.abs(x)))]], np.eye(3)[[2, 0, 1][int(np.argmax(np.abs(x)))]]]).astype(float))[0] for x in w]

    def step(x):
        return np.array(integrator.start(x.copy(), h=h).step().w, np.longdouble)

    end = [np.linalg.qr(np.column_stack([x, f[:, 1], f[:, 2]]).astype(float))[0] for x, f in zip(step(w), frames)]
    matrix, d = np.zeros((2 * len(w),) * 2), np.longdouble(1e-4)
    for k, f in enumerate(frames):
        for a in (1, 2):
            def at(s):
                x = w.copy()
                x[k] = np.cos(s * d) * w[k] + np.sin(s * d) * f[:, a]
                return step(x / np.sqrt(np.sum(x * x, axis=1))[:, None])
            slope = (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * d)
            matrix[:, 2 * k + a - 1] = [float(slope[j] @ e[:, b]) for j, e in enumerate(end) for b in (1, 2)]
    return abs(np.linalg.det(matrix))


@pytest.mark.parametrize("name", ["even", "odd", "pairs"])
def test_sublattice_rotations_keep_the_volume(name):
    assert abs(volume(LATTICES[name], 0.3) - 1) < 1e-10


@pytest.mark.parametrize("name", ["even", "odd", "pairs", "two families"])
@pytest.mark.parametrize("method", ["sublattice-rotations", "sublattice-rotations-8"])
def test_the_energy_is_kept_at_any_step(name, method):
    """To the walk of so many rounded turns, at most two of a site in a stage, whose energies are about 1: the median of nine starts, since in a
    regular motion the roundings of some starts repeat."""
    integrator, walked = smidgen.build(LATTICES[name], method=method), []
    for seed in range(9):
        first = integrator.start("a", h=1.7, seed=seed).values()[0]
        walked.append(abs(integrator.steps(10000).values()[0] - first))
    assert np.median(walked) < 1.5 * 2**-53 * (10000 * METHODS[method].stages * 2 * integrator.sites)**0.5


@pytest.mark.parametrize("scheme", ["4", "8"])
def test_compositions_of_sublattice_rotations_have_their_order(quad, scheme):
    method, spec = METHODS[f"sublattice-rotations-{scheme}"], LATTICES["driven"]
    exact = run(quad(spec, "spherical-midpoint-10"), CHAIN_START, 1 / 64, 64).w
    errors = [apart(run(quad(spec, method.name), CHAIN_START, 1 / k, k).w, exact) for k in (8, 16)]
    assert abs(log(errors[0] / errors[1], 2) - method.order) < 0.1


@pytest.mark.quick
def test_a_site_that_is_its_own_neighbour_is_refused():
    spec = model("tiny", RING.format("n", "periodic") + '"w[i].x*w[j].x"', SITES + '"w[i].z"', 'w = { sphere = "n" }', "[starts.a]\nrandom = 1\n[parameters]\nn = 4")
    with pytest.raises((RunError, UsageError)):
        smidgen.build(spec, method="sublattice-rotations", parameters={"n": 1}).start("a", h=0.1)


# ---- pairs -----------------------------------------------------------------------------------------

LOGS = model("logs", 'over = "pair(i, j) of w"\nenergy = "-g[i]*g[j]*log(2.5 - 2*dot(w[i], w[j]))*(1 + 0.3*sin(t))"', BONDS + '"dot(w[i], w[j])^3"',
             'w = { sphere = 6, kappa = "g[i]", radius = 1 }', "[starts.a]\nrandom = 1\n[parameters]\ng = { default = [1.0, -0.7, 1.5, 0.8, 1.2, -2.0], size = 6 }")
PAIRS = {"logs": LOGS, "chain": model("heisenberg", RING.format(5, "open") + '"dot(w[i], w[j])"', 'energy = "0.3*dot(w[0], w[4])^2"', "w = { sphere = 5, kappa = [1, 2, -3, 1, 0.5] }"),
         "two families": model("both", 'over = "each(i of w, j of b)"\nenergy = "dot(w[i], b[j])"', 'over = "pair(i, j) of w"\nenergy = "0.5*dot(w[i], w[j])"',
                               "w = { sphere = 3 }\nb = { r3 = 2, kappa = -0.5 }", "[starts.a.w]\nrandom = 1\n[starts.a.b]\nrandom = 2")}


@pytest.mark.quick
@pytest.mark.parametrize("energy, said", [
    ('"dot(w[i], w[j]) + w[i].z*w[j].z"', r"is not recognised as a function of dot\(w\[i\], w\[j\]\) alone"), ('"w[i].z"', "involves only a single site")])
def test_what_stands_in_the_way_of_pairs_is_named(energy, said):
    with pytest.raises(UsageError, match="effect 'second' " + said):
        generate(model("no_pairs", BONDS + '"dot(w[i], w[j])"', BONDS + energy), method="pair-rotations")
    with pytest.raises(UsageError, match="tracers"):
        generate(smidgen.load("vortex_tracers"), method="pair-rotations")


@pytest.mark.quick
@pytest.mark.parametrize("energy", ["dot(w[i], w[j])", "w[j].x*w[i].x + w[i].y*w[j].y + w[i].z*w[j].z", "exp(-(1 - dot(w[j], w[i]))^2)", "sqrt(2 - dot(w[i], w[j]))"])
def test_functions_of_the_product_are_known_however_they_are_written(energy):
    spec = model("known", BONDS + f'"{energy}"', BONDS + '"0.1*dot(w[i], w[j])"')
    assert smidgen.explain(spec).splittings["pair-rotations"] is None


@pytest.mark.parametrize("name", [*PAIRS, "point_vortices", "honeycomb"])
@pytest.mark.parametrize("method", ["pair-rotations", pytest.param("pair-rotations-6", marks=pytest.mark.long)])
def test_the_witness_turns_the_same_pairs(name, method):
    report = smidgen.validate(PAIRS[name] if name in PAIRS else smidgen.load(name), method=method, steps=10)
    assert report.passed, [line for line in report.lines if not line.passed]


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.usefixtures("few_states", "optimised_here")
def test_the_certificate_says_symplectic_and_momentum_exact(name):
    rows = {row.name: row for row in smidgen.verify(PAIRS[name], method="pair-rotations", tier="quick").rows}
    assert not [row for row in rows.values() if row.verdict == "no"]
    for one in ("symplectic", "momentum", "equivariant", "order", "reversible", "casimirs", "step"):
        assert rows[one].verdict == "yes"
    assert rows["energy"].verdict == "does not apply"


@pytest.mark.parametrize("scheme", ["", *(pytest.param(s, marks=pytest.mark.long) for s in ("4", "8"))])
def test_the_order_of_pair_rotations(quad, scheme):
    method, spec = METHODS["pair-rotations" + (f"-{scheme}" if scheme else "")], PAIRS["logs"]
    n = 256 if scheme else 64       # of order 10, beside order 2
    exact = run(quad(spec, "spherical-midpoint-10"), CHAIN_START, 1 / n, n).w
    errors = [apart(run(quad(spec, method.name), CHAIN_START, 1 / k, k).w, exact) for k in (64, 128)]
    assert abs(log(errors[0] / errors[1], 2) - method.order) < 0.1


# ---- all of them -----------------------------------------------------------------------------------

@pytest.mark.quick
def test_features_are_refused():
    with pytest.raises(UsageError, match="no feature 'tangent'"):
        smidgen.build(BODY, method="axis-splitting", features=["tangent"])


@pytest.mark.quick
def test_the_command(command):
    said = command("run", "irreversible_rigid_body", "--method", "axis-splitting-6", "--h", "0.5", "--steps", "20", "--json")
    assert said.returncode == 0 and json.loads(said.stdout)


EVERY = {"axis-splitting": AXES, "sublattice-rotations": LATTICES, "pair-rotations": PAIRS}


@functools.cache
def files_of(name, method, scheme, amalgamate):
    return generate(EVERY[method][name], method=method + scheme, amalgamate=amalgamate)


@pytest.mark.parametrize("name, method", [(name, method) for method, found in EVERY.items() for name in found])
@pytest.mark.parametrize("scheme", ["", pytest.param("-6", marks=pytest.mark.long)])
@pytest.mark.parametrize("compiler", COMMANDS[:4])
@pytest.mark.parametrize("amalgamate", [pytest.param(False, marks=pytest.mark.long), True])
def test_clean_c(tmp_path, name, method, scheme, compiler, amalgamate):
    spec = EVERY[method][name]
    for file, text in files_of(name, method, scheme, amalgamate).items():
        (tmp_path / file).write_text(text)
    subprocess.run([*compiler, *WARNINGS, *include_flags(), "-I.", "-fsyntax-only", f"{spec.name}.c"], cwd=tmp_path, check=True)
