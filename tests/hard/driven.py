"""Damping, noise and torques

*Damping.* With b = -B e_z and kappa = s |kappa|, a damped spin has artanh w_z = artanh w_z(0) + alpha B t/|kappa| and rotates by s B t/|kappa|. For
Gilbert's form, both are divided by 1 + alpha^2.

*Noise.* In each half of a step, noise makes n rotations, whose components have the variance sigma^2 = 2 (y - y^2/6) with y = D h/(2 n). Without any other motion,
a step multiplies the mean vector by ((1 + 2 (1 - sigma^2) e^{-sigma^2/2})/3)^{2 n}.

*Torques.* Under the torque tau w x (w x p), artanh(w.p) = artanh(w.p)(0) - tau t. The torque is 0 at w = p and w = -p.
"""
import math

import numpy as np

import smidgen
from smidgen.check.witness import Witness
from smidgen.errors import RunError

from .case import EPS, NO_CONVERGENCE, NO_SOLUTION, WRONG_BRANCH, Row, below, case, near, ratio
from .geometry import largest, polar, turns

TEXT = """[model]
name = "driven_spins"
[space]
w = {{ sphere = {sites}, kappa = "kappa" }}
[parameters]
B = {B}
kT = 0.0
kappa = 1.0
alpha = 0.1
tau = 0.7
[effects.field]
over = "site(i) of w"
energy = "-B*w[i].z"
{more}
[starts.a]
random = 4
"""
BATH = '[effects.bath]\nover = "site(i) of w"\ndamping = "alpha"\nform = "{form}"\n{kT}'
PUSH = '[effects.push]\nover = "site(i) of w"\ntorque = "{torque}"\n'
CURRENT = "tau*cross(w[i], cross(w[i], vec(0, 0, 1)))"
METHODS = ("spherical-midpoint", "gauss-4", "dop853", "heun")
PRECISE = "gauss-12"


def spins(more, sites=3, B=1.0):
    return smidgen.load_text(TEXT.format(sites=sites, B=B, more=more))


def bath(form="gilbert", kT=""):
    return BATH.format(form=form, kT=kT)


def bits(what: str, one, other) -> Row:
    equal = np.array_equal(one, other)
    return Row(what, "the same bits", "the same bits" if equal else f"others, by {largest(one - other):.1e}", equal)


def damped(alpha, form, kappa=1.0):
    """(largest error of artanh w_z, of the angle) at t = |kappa| of spins at several heights."""
    w = polar([0.4, 1.3, 2.5], [0.0, 1.0, 2.0])
    one = smidgen.build(spins(bath(form)), method=PRECISE, parameters={"alpha": alpha, "kappa": kappa}).start(w.copy(), h=abs(kappa) / 64)
    W, share = one.steps(64).w, 1 + alpha ** 2 if form == "gilbert" else 1.0
    rise = np.arctanh(W[:, 2]) - np.arctanh(w[:, 2]) - alpha / share
    return largest(rise * np.cosh(np.arctanh(W[:, 2])) ** -2), largest(np.sin(turns(w, W) - math.copysign(1, kappa) / share))


@case("damping from 1e-8 to 10")
def damping():
    """The height and the angle of a damped spin in a field are compared with the exact solution, for both forms of damping. Midpoint steps conserve |w| and lower the energy for every damping."""
    for form in ("gilbert", "ll"):
        for alpha in (1e-8, 1e-4, 0.1, 1.0, 10.0):
            height, angle = damped(alpha, form)
            yield below(f"{form}, alpha = {alpha:g}: error of w_z at t = 1", height, 4e-14)
            yield below(f"{form}, alpha = {alpha:g}: error of the angle at t = 1", angle, 4e-14)
            one = smidgen.build(spins(bath(form)), parameters={"alpha": alpha}).start("a", h=0.1)
            energies = [one.energy()] + [one.step().energy() for _ in range(100)]
            yield below(f"{form}, alpha = {alpha:g}: largest rise of the energy in a midpoint step of 0.1", max(np.diff(energies)), 2e-15)
            yield below(f"{form}, alpha = {alpha:g}: change of |w| in 100 of them", largest(np.linalg.norm(one.w, axis=1) - 1), 2e-15)


@case("damping with strengths over 24 decades, both signs")
def strengths():
    """kappa scales time, and its sign reverses the precession but not the damping."""
    for kappa in (1e-12, -1e-12, 1.0, -1.0, 1e12, -1e12):
        height, angle = damped(0.3, "gilbert", kappa)
        yield below(f"kappa = {kappa:g}: error of w_z at t = |kappa|", height, 4e-14)
        yield below(f"kappa = {kappa:g}: error of the angle", angle, 4e-14)


@case("noise so strong that a half step forgets the direction")
def noise():
    """The mean of thirty thousand free spins after one step is compared with the exact value, for x = D h/2 below, at and above 1. |w| of each spin is conserved."""
    sites = 30_000
    model = smidgen.build(spins(bath("ll", 'kT = "kT"\n'), sites, B=1e-30), parameters={"alpha": 1.0})
    for x in (0.01, 0.25, 0.999, 1.0, 1.001, 3.7, 40.0):
        model.set_parameters({"kT": x})
        w = model.start(np.tile([0.0, 0.0, 1.0], (sites, 1)), h=2.0, seed=7).step().w
        n = int(min(x, 31.5)) + 1
        y = min(x, 31.5) / n
        s = 2 * (y - y * y / 6)
        yield near(f"x = {x:g}: mean w_z", w[:, 2].mean(), ((1 + 2 * (1 - s) * math.exp(-s / 2)) / 3) ** (2 * n), 4 / math.sqrt(3 * sites))
        yield below(f"x = {x:g}: change of |w|", largest(np.linalg.norm(w, axis=1) - 1), 8 * n * EPS, "4 units in the last place per rotation")


@case("a temperature of zero")
def cold():
    """A run with kT = 0 has the same bits as a run without noise, and kT = 1e-300 has no visible effect."""
    for method in METHODS:
        ends = {}
        for said, kT in (("0", 0.0), ("1e-300", 1e-300), ("none", None)):
            spec = spins(bath("gilbert", "" if kT is None else 'kT = "kT"\n'))
            model = smidgen.build(spec, method=method, parameters={} if kT is None else {"kT": kT})
            ends[said] = model.start("a", h=0.1).steps(100).w.copy()
        yield bits(f"{method}: kT = 0 compared with no kT, 100 steps", ends["0"], ends["none"])
        yield below(f"{method}: kT = 1e-300 compared with no kT", largest(ends["1e-300"] - ends["none"]), 1e-13)


@case("a spin along and against the polarisation")
def polarised():
    """Where the torque is 0, the spin does not move, bit for bit. Near this point, the tangent of half its angle changes by the factor exp(tau t)."""
    for end in (1.0, -1.0):
        for method in METHODS:
            w = np.array([[0.0, 0.0, end]])
            W = smidgen.build(spins(PUSH.format(torque=CURRENT), 1, B=0.0), method=method).start(w.copy(), h=0.1).steps(100).w
            yield bits(f"w = {end:+g} p, {method}: after 100 steps", W, w)
    for tau in (0.7, -0.7):
        for angle in (1e-3, 1e-8, 1e-12):
            w = np.array([[angle, 0.0, -math.sqrt(1 - angle ** 2)]])
            W = smidgen.build(spins(PUSH.format(torque=CURRENT), 1, B=0.0), method=PRECISE, parameters={"tau": tau}).start(w.copy(), h=0.1).steps(100).w
            measured, before = (math.hypot(*v[0, :2]) / (1 - v[0, 2]) for v in (W, w))
            yield ratio(f"tau = {tau:g}, {angle:g} from -p: tan of half the angle at t = 10", measured, before * math.exp(-10 * tau), 4e-12)


@case("a torque without closed form, up to its fold and beyond")
def fold():
    """For steps of every size, an accepted step solves the equation, and a refused step gives the reason and leaves the state unchanged."""
    spec = spins(PUSH.format(torque="w[i].z*cross(w[i], vec(1, 0.2, 0)) + cross(w[i], w[i].x*w[i].y*vec(0, 1, 1))"), 4)
    model, witness = smidgen.build(spec), Witness(spec)
    solved, refused, residual, moved, strange = 0, 0, 0.0, 0, 0
    for h in np.geomspace(0.05, 500, 25):
        model.start("a", h=float(h))
        w = model.w.copy()
        try:
            residual = max(residual, witness.residual(w, model.step().w, 0.0, float(h)) / (1 + h))
            solved += 1
        except RunError as error:
            refused += 1
            strange += error.status not in (NO_CONVERGENCE, NO_SOLUTION, WRONG_BRANCH)
            moved += not np.array_equal(model.w, w)
    yield Row("steps of 0.05 to 500: solved and refused", "both kinds", f"{solved} and {refused}", solved > 5 and refused > 0)
    yield below("residual of the solved steps, by the witness, relative to 1 + h", residual, 2e-15)
    yield Row("refused for a reason other than convergence, a fold or a branch", "0", str(strange), strange == 0)
    yield Row("refused, but with a changed state", "0", str(moved), moved == 0)
