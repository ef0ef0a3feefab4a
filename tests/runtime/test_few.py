"""Few sites that all feel each other, by fixed-point iteration in lanes (runtime/lattice/smg_few.h): the step that Newton finds, with the
same bits at every width, and no drift of its own."""
import numpy as np
import pytest
import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate

HEAD = """
[model]
name = "few"
[space]
w = {{ sphere = "n"{more} }}
[parameters]
n = {n}
k = {{ default = 1.0, size = "n" }}
{effects}
[starts.random]
random = 3
"""
VORTICES = """[effects.vortices]
over = "pair(i, j) of w"
energy = "-k[i]*k[j]*log(2 - 2*dot(w[i], w[j]))/(4*pi)"
"""
SPINS = """[effects.exchange]
over = "pair(i, j) of w"
energy = "-0.3*dot(w[i], w[j])/n + 0.2*w[i].z*w[j].z/n"
"""
FIELD = """[effects.field]
over = "site(i) of w"
energy = "0.3*k[i]*w[i].x - 0.2*w[i].z^2"
"""
UNLIKE = """[effects.unlike]
over = "pair(i, j) of w"
energy = "0.1*(w[i].x*w[j].y - w[i].y*w[j].x)"
"""
JUMPS = """[effects.jumps]
over = "pair(i, j) of w"
energy = "0.1*max(w[i].z*w[j].z, 0)"
"""
BENT = """[effects.bent]
over = "pair(i, j) of w"
energy = "0.1*(w[i].z*w[j].z)^2"
"""
NUMBERED = """[effects.numbered]
over = "site(i) of w"
energy = "0.1*mod(i, 2)*w[i].z"
"""
SPIRAL = """[starts.spiral]
theta = "acos(1 - (2*i + 1)/n)"
phi = "2.399963229728653*i"
"""


def few(effects, n, more=""):
    return smidgen.load_text(HEAD.format(n=n, effects=effects, more=more))


SPECS = {
    **{f"{n} vortices": few(VORTICES, n, ', kappa = "k[i]"') for n in (2, 3, 4, 5)},
    **{f"{n} spins": few(SPINS + FIELD, n) for n in (1, 7, 8, 9, 16)},
    "other spheres": few(VORTICES + FIELD, 6, ', kappa = "0.5 - 0.2*i", radius = "0.4 + 0.1*i"'),
}
LAW = {"2 vortices": 0.02, "3 vortices": 0.02, "5 vortices": 0.01, "other spheres": 0.002}


def values(spec):
    n = next(p.default for p in spec.parameters if p.name == "n")
    return {"k": [1 + 0.1 * i * (-1) ** i for i in range(n)]}


def started(spec, h, **how):
    return smidgen.build(spec, parameters=values(spec), **how).start("random", h=h)


@pytest.mark.parametrize("name", SPECS)
def test_the_steps_of_newton(name):
    """Over a thousand steps, and against the witness, who knows no lanes."""
    spec, h = SPECS[name], LAW.get(name, 0.05)
    assert "SMG_FEW_IN_LANES" in generate(spec)["few.c"] and "SMG_FEW_IN_LANES" not in generate(spec, solver="newton")["few.c"]
    model, newton = started(spec, h), started(spec, h, solver="newton")
    witness, w = Witness(spec, parameters=values(spec)), model.w.copy()
    after = model.steps(1).w.copy()
    assert witness.residual(w, after, 0.0, h) <= 4e-15
    model.steps(999), newton.steps(1000)
    assert np.abs(model.w - newton.w).max() <= 1e-11


EVERY_WIDTH = (1, 2, 4, 8)


@pytest.mark.parametrize("name, widths", [("5 vortices", (1, 4)), ("9 spins", EVERY_WIDTH), ("other spheres", (1, 8)),
                                          *(pytest.param(n, EVERY_WIDTH, marks=pytest.mark.long) for n in ("5 vortices", "other spheres"))])
def test_the_same_bits_for_any_number_of_lanes(monkeypatch, name, widths):
    found = []
    for lanes in widths:
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        found.append(started(SPECS[name], 0.01).steps(12).save())
    assert all(np.array_equal(found[0], one) for one in found[1:])


@pytest.mark.quick
@pytest.mark.parametrize("effects, lanes", [(SPINS, True), (SPINS + FIELD, True), (VORTICES, True), (SPINS + UNLIKE, False), (SPINS + JUMPS, False),
                                            (SPINS + BENT, False), (SPINS + NUMBERED, False)])
def test_what_lanes_serve(effects, lanes):
    """Both sites of a pair enter alike, without a jump; a Hessian that is constant, or of a function of their product."""
    files = generate(few(effects, 6))
    assert files.notes["solver"] == "dense"
    assert ("fixed-point iteration in lanes" in files.notes["reason"]) == ("SMG_FEW_IN_LANES" in files["few.c"]) == lanes
    assert files.notes["reason"].endswith("dense Newton")


@pytest.mark.usefixtures("optimised_here")
def test_lengths_do_not_drift():
    """|w|^2 of sixteen spins after 2e5 steps: round-off, of both signs."""
    spec = few(SPINS.replace("0.2*", "0*"), 16)
    model = started(spec, 0.1).steps(200_000)
    off = (model.w ** 2).sum(axis=1) - 1
    assert np.abs(off).max() <= 1.5e-14 and abs(off.mean()) <= 0.5 * np.sqrt((off ** 2).mean()) + 2**-53


def test_a_small_sphere_that_moves_faster_keeps_its_length():
    """Changes of its increments are no round-off because they are one of the others; taken for that, it is off by 5e-5."""
    spec = few(SPINS + FIELD, 3, ', kappa = "0.05 + 0.95*(i - 1)^2", radius = "10^(-12*(1 - (i - 1)^2))"')
    model = started(spec, 0.1)
    assert "SMG_FEW_IN_LANES" in generate(spec)["few.c"] and np.linalg.norm(model.w[1]) < 2e-12
    lengths = np.linalg.norm(model.w, axis=1)
    assert np.abs(np.linalg.norm(model.steps(5000).w, axis=1) / lengths - 1).max() <= 1e-14


def test_a_large_step_is_left_to_newton_with_its_bits():
    """Rows of J - I above 1/2."""
    spec = few(SPINS, 9)
    lanes, newton = (started(spec, 12.0, **how) for how in ({}, {"solver": "newton"}))
    assert np.array_equal(lanes.steps(3).w, newton.steps(3).w)


def test_a_tolerance_is_kept():
    spec = SPECS["9 spins"]
    model = smidgen.build(spec, parameters=values(spec)).start("random", h=0.05, tolerance=1e-9)
    witness, w = Witness(spec, parameters=values(spec)), model.w.copy()
    for _ in range(6):
        after = model.steps(1).w.copy()
        assert witness.residual(w, after, 0.0, 0.05) <= 1e-9
        w = after


def test_restored_it_goes_on_with_the_same_bits():
    model = started(SPECS["4 vortices"], 0.05)
    saved, whole = model.steps(7).save(), model.steps(9).save()
    assert np.array_equal(model.start("random", h=0.03).restore(saved).steps(9).save(), whole)


@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
@pytest.mark.parametrize("n", [2, 3, 5])
def test_a_field_that_is_no_number_is_refused(monkeypatch, n, lanes):
    """Also where it is one in the lanes that no site fills; the state stays."""
    monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
    w = np.random.default_rng(1).normal(size=(n, 3))
    w /= np.linalg.norm(w, axis=1)[:, None]
    w[0] = w[1] = 0, 0, 1
    model = smidgen.build(SPECS[f"{n} vortices"]).start(w.copy(), h=0.01)
    with pytest.raises(smidgen.RunError, match="not finite"):
        model.steps(1)
    assert np.array_equal(model.w, w) and model.count == 0


MANY = few(SPINS, 301)


@pytest.mark.parametrize("h, same", [(0.05, False), pytest.param(12.0, True, marks=pytest.mark.long)])
def test_more_sites_than_a_matrix_is_for_go_in_lanes_too(h, same):
    """Where steps are large they are left to sweeps, with their bits."""
    assert generate(MANY).notes["reason"].startswith("all pairs: fixed-point iteration in lanes")
    lanes, sweeps = (started(MANY, h, **how) for how in ({}, {"solver": "rotation"}))
    assert np.abs(lanes.steps(3).w - sweeps.steps(3).w).max() <= (0 if same else 1e-14)


@pytest.mark.long
@pytest.mark.parametrize("start, effects, h", [("spiral", VORTICES, 0.004), ("random", VORTICES.replace("(4*pi)", "(4*pi*n)"), 0.01)], ids=["spiral", "random"])
def test_many_vortices_stay_in_lanes(start, effects, h):
    """Row sums of J - I between 1/2 and 3/4, where changes shrink to 1/50; and changes that are round-off of the field of close vortices, and do not shrink."""
    spec = few(effects + SPIRAL, 301)
    lanes, sweeps = (smidgen.build(spec, **how).start(start, h=h).steps(2) for how in ({}, {"solver": "rotation"}))
    assert 0 < np.abs(lanes.w - sweeps.w).max() <= 1e-14


@pytest.mark.long
def test_many_sites_have_the_same_bits_for_any_number_of_lanes_and_restored(monkeypatch):
    found = []
    for lanes in EVERY_WIDTH:
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        model = started(MANY, 0.05)
        saved, whole = model.steps(3).save(), model.steps(5).save()
        assert np.array_equal(model.start("random", h=0.03).restore(saved).steps(5).save(), whole)
        found.append(whole)
    assert all(np.array_equal(found[0], one) for one in found[1:])
