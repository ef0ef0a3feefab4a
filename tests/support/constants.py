"""Errors of methods of order 2 over ten Hamiltonians: the largest of a component on [0, 10], h = 2^-5."""
import numpy as np
import smidgen
from smidgen.check.witness import Witness, rattle
from smidgen.errors import RunError

H, STEPS = 2.0**-5, 320
SPEC = """
[model]
name = "constants"
[space]
w = {{ sphere = {sites} }}
[effects.h]
{over}energy = "{energy}"
{more}
[starts.a]
theta = "pi/2 - 1.1 + 0.7*i"
phi = "2.0*i"
"""
BODY = "w[0].x^2*(1/2 + {s}*w[0].x) + w[0].y^2*(1/4 + {s}*w[0].y/2) + w[0].z^2*(1/8 + {s}*w[0].z/4)"
# what the page calls it -> sites, index family, energy, more effects
HAMILTONIANS = {
    "body, I = (1, 2, 4)": (1, "", "w[0].x^2/2 + w[0].y^2/4 + w[0].z^2/8", ""),
    "body, I = (1, 4/3, 2)": (1, "", "w[0].x^2/2 + 3*w[0].y^2/8 + w[0].z^2/4", ""),
    "(x⁴ + y⁴ + z⁴)/4": (1, "", "(w[0].x^4 + w[0].y^4 + w[0].z^4)/4", ""),
    "xyz": (1, "", "w[0].x*w[0].y*w[0].z", ""),
    "x + z/2": (1, "", "w[0].x + w[0].z/2", ""),
    "x + z²/2": (1, "", "w[0].x + w[0].z^2/2", ""),
    "irreversible body, I = (1, 2, 4), σ = 2/3": (1, "", BODY.format(s="2/9"), ""),
    "exp(x + yz)": (1, "", "exp(w[0].x + w[0].y*w[0].z)", ""),
    "two spins, w₁·w₂ + (z₁² + z₂²)/2": (2, 'over = "pair(i, j) of w"\n', "dot(w[i], w[j])", '[effects.axis]\nover = "site(i) of w"\nenergy = "w[i].z^2/2"\n'),
    "three vortices, −Σ log(1 − wᵢ·wⱼ)/4π": (3, 'over = "pair(i, j) of w"\n', "-log(1 - dot(w[i], w[j]))/(4*pi)", "")}
METHODS = {"SM": "spherical-midpoint", "RATTLE": "rattle", "isospectral": "isospectral-midpoint", "exponential": "exponential-midpoint"}


def spec_of(name):
    sites, over, energy, more = HAMILTONIANS[name]
    return smidgen.load_text(SPEC.format(sites=sites, over=over, energy=energy, more=more))


def path(model, w=None):
    """The states after each step. Raises RunError where there is none."""
    model.start("a" if w is None else w.copy(), h=H)
    return np.array([model.step().w.copy() for _ in range(STEPS)])


def largest(one, exact) -> float:
    return float(np.abs(one - exact).max())


def errors(name, methods=METHODS) -> dict:
    spec = spec_of(name)
    exact = path(smidgen.build(spec, method="gauss-16"))
    return {short: largest(path(smidgen.build(spec, method=METHODS[short])), exact) for short in methods}


def with_c_1(name) -> float:
    """Of RATTLE with c = 1, by the witness."""
    spec = spec_of(name)
    witness, model = Witness(spec), smidgen.build(spec, method="gauss-16")
    exact, w, found = path(model), model.start("a", h=H).w.copy(), []
    for _ in range(STEPS):
        w = rattle.step(witness, w, 0.0, H, c=1.0)
        found.append(w)
    return largest(np.array(found), exact)


def larger_for_rattle(name, starts: int) -> tuple[int, int]:
    """(from how many random starts the error of RATTLE is larger than that of the spherical midpoint, of how many that both step from)."""
    spec, dice, found = spec_of(name), np.random.default_rng(11), []
    exact, *both = (smidgen.build(spec, method=m) for m in ("gauss-16", "rattle", "spherical-midpoint"))
    for _ in range(starts):
        w = dice.standard_normal((exact.sites, 3))
        w /= np.linalg.norm(w, axis=1)[:, None]
        try:
            curve = path(exact, w)
            other, sphere = (largest(path(one, w), curve) for one in both)
        except RunError:
            continue
        found.append(other > sphere)
    return sum(found), len(found)
