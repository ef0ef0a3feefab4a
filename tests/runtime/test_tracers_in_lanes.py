"""Tracers several at once, a site in each lane: the steps that Newton finds site by site, the same bits however many go at once."""
import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from support.going_on import one_by_one, restored
from support.strict import COMPILERS
from support.widths import same_by_clang, same_in_lanes

TEXT = """[model]
name = "carried"
[space]
w = {{ sphere = 3, kappa = "gamma[i]" }}
p = {{ sphere = "m", tracer = true{space} }}
[parameters]
m = {m}
gamma = {{ default = [1.0, -0.7, 0.8], size = 3 }}
[effects.vortices]
over = "pair(i, j) of w"
energy = "-gamma[i]*gamma[j]/(4*pi)*log(1 - dot(w[i], w[j]))"
[effects.carried]
over = "each(j of w, i of p)"
energy = "-gamma[j]/(4*pi)*log({far} - dot(w[j], p[i]))"
{more}
[starts.random.w]
random = 1
[starts.random.p]
random = 2
"""
WAVE = '[effects.wave]\nover = "site(i) of p"\nenergy = "0.3*p[i].z*(p[i].x*cos(2*t) + p[i].y*sin(2*t))^2 - 0.2*p[i].z"'
BY_NUMBER = '[effects.wave]\nover = "site(i) of p"\nenergy = "-0.2*cos(i)*p[i].z"'


def spec(m=70, more="", space="", far="1"):
    return smidgen.load_text(TEXT.format(m=m, more=more, space=space, far=far))


def in_lanes(one, **how) -> bool:
    return "define SMG_ALONE_IN_LANES" in "".join(generate(one, **how).values())


def apart(one, h=0.05, steps=6, start="random") -> float:
    """From what Newton finds, one tracer after the other."""
    ends = []
    for solver in ("auto", "newton"):
        model = smidgen.build(one, solver=solver)
        ends.append(model.start(start if isinstance(start, str) else start.copy(), h=h, t0=0.2).steps(steps).w.copy())
    return np.abs(ends[0] - ends[1]).max()


def test_which_models():
    assert in_lanes(spec()) and in_lanes(spec(more=WAVE))
    assert not in_lanes(spec(), solver="newton") and not in_lanes(spec(more=BY_NUMBER)) and not in_lanes(spec(), method="gauss-4") and not in_lanes(spec(), method="classical-midpoint") and not in_lanes(spec(), method="spherical-midpoint-4")


@pytest.mark.parametrize("m", [1, 7, 64, pytest.param(65, marks=pytest.mark.long), 130])
def test_steps_are_those_of_newton(m):
    assert apart(spec(m, WAVE)) <= 1e-13


@pytest.mark.parametrize("space, far", [pytest.param(", radius = 2", "2.1", marks=pytest.mark.long), pytest.param(", radius = 0.001", "1.1", marks=pytest.mark.long), (", kappa = -0.5", "1")])
def test_families(space, far):
    """Other spheres, and small ones."""
    assert in_lanes(spec(space=space, far=far)) and apart(spec(space=space, far=far)) <= 1e-13


@pytest.mark.parametrize("h", [0.3, pytest.param(0.6, marks=pytest.mark.long), pytest.param(1.0, marks=pytest.mark.long)])
def test_large_steps(h):
    """Where the equations of some tracers, or of all, are no contraction."""
    assert apart(spec(200, WAVE, far="1.05"), h, 2) <= 1e-12


def test_near_a_vortex_newton_takes_over():
    """Of those tracers alone: the step of the others has the same bits as without them."""
    one = spec(70)
    far = np.array(smidgen.build(one).start("random", h=0.05).w)
    near = far.copy()
    for n, off in enumerate((0.03, 0.02, 0.012)):
        near[3 + n] = far[n] + off * np.cross(far[n], [0.6, 0.0, 0.8])
        near[3 + n] /= np.linalg.norm(near[3 + n])
    assert apart(one, 0.0005, 4, near) <= 1e-12
    ends = [smidgen.build(one).start(w.copy(), h=0.0005).step().w.copy() for w in (far, near)]
    assert np.abs(ends[0][6:] - ends[1][6:]).max() <= 4e-16


@pytest.mark.long
def test_the_same_bits_for_any_number_of_lanes(monkeypatch):
    def built(lanes, compiler="gcc"):
        monkeypatch.setenv("CC", f"{compiler} -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(spec(75, WAVE, far="1.02"))
    assert same_in_lanes(built, (2, 4, 8))
    if "clang" in COMPILERS:
        assert same_by_clang(built)


def test_restored_it_goes_on():
    model = smidgen.build(spec(75, WAVE, far="1.02"))
    assert restored(model) and one_by_one(model)


def test_a_tolerance_is_met():
    one = spec(75, WAVE)
    exact = smidgen.build(one).start("random", h=0.1).step().w.copy()
    found = smidgen.build(one).start("random", h=0.1, tolerance=1e-8).step()
    assert 0 < np.abs(found.w - exact).max() <= 1e-8 and found.report()["iterations"] < 9
