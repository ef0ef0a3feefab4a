r"""Vortices: a close pair, and three that collapse

*A pair.* Let S = kappa_1 w_1 + kappa_2 w_2, let vortex i lie at the angle a_i from S, on opposite sides of it, and let
gap = a_1 + a_2. Both increments W_i - w_i are along m_1 x m_2, so they are at right angles to both midpoints and to
S = kappa_1 mbar_1 + kappa_2 mbar_2, which a step conserves. Hence every solution rotates both vortices about S by the same angle phi. Then the
midpoints lie at a_i' with tan a_i' = cos(phi/2) tan a_i, and the length of an increment gives

    h = 8 pi (sin gap/|S|) sin(phi/2) tan((a_1' + a_2')/2).

For an equal pair at half-angle a this is sin(phi) = h kappa/(4 pi sin a tan a). The largest value of the right side over
(0, pi) is the fold: beyond it there is no solution, before it there are two, and the smaller phi is the one connected to
h = 0. For strengths kappa and -kappa the right side is 8 pi sin(gap/2) tan(phi/2). There is no fold, and a step of every size exists.

*Collapse.* With l_ij^2 = 2 - 2 w_i.w_j and V = w_1.(w_2 x w_3), for i, j, k in cyclic order,

    d(l_ij^2)/dt = kappa_k (V/pi) (1/l_ik^2 - 1/l_jk^2).

If sum kappa_i kappa_j = 0 and sum kappa_i kappa_j l_ij^2 = 0 (this sum is conserved because |S| is), energy and momentum fix the ratios
of the l_ij^2: l_ij^2 = c_ij f(t) with the initial values c_ij. Hence A = kappa_k (1/c_ik - 1/c_jk)/c_ij is the same for all
three pairs, and f f' = A V/pi. Gram's determinant of the three unit vectors is V^2 = f^2 (alpha - beta f) with
4 alpha = 2 (c_12 c_23 + c_23 c_31 + c_31 c_12) - c_12^2 - c_23^2 - c_31^2 and 4 beta = c_12 c_23 c_31. Hence g = V/f has
g^2 = alpha - beta f and g' = -beta A/(2 pi): g is linear in t, and the squared distances are quadratic,

    f(t) = 1 + (A g_0/pi) t - (beta A^2/(4 pi^2)) t^2,      collapse at t = 2 pi (sqrt(alpha) - |g_0|)/(beta |A|)

(beta = 0 is the plane, where f is linear).

*The fold of a collapse.* For a small triangle the midpoint is that of the plane. A self-similar triangle that is rotated and
scaled by the complex number Z obeys Z' = Gamma/conj(Z). The remaining time is tau = |Z|^2/(2 |Re Gamma|), the triangle rotates at the
rate omega, and q = omega tau is constant. The step Z_1 - Z_0 = h Gamma/conj((Z_0 + Z_1)/2) decreases tau by exactly h (|Z|^2 is
linear in time, in the step as in the flow). Its midpoint solves a quadratic equation, which has a solution if and only if

    h/tau + q^2 (h/tau)^2 <= 1,    that is    tau/h >= (1 + sqrt(1 + 4 q^2))/2.
"""
import tempfile
from itertools import product
from math import asin, ceil, pi, sin, sqrt, tan
from pathlib import Path

import mpmath as mp
import numpy as np
from scipy.optimize import minimize_scalar
from support.systems import load as shipped
from test_branch import ask

import smidgen
from smidgen.run.step.status import STATUS

from .case import EPS, NO_SOLUTION, WRONG_BRANCH, Row, attempt, below, case, near, ratio, refused, same
from .geometry import largest, turns

PARTS = (0.5, 0.9, 0.99, 0.9999)      # of the fold
PAIRS = {"equal": (1.0, 1.0, 0.3), "1 : 3": (1.0, 3.0, 0.2), "-1 : -1e-3": (-1.0, -1e-3, 0.5), "2 : -1": (2.0, -1.0, 0.1)}


# -- a close pair -----------------------------------------------------------------------------------

def angles(k1, k2, gap):
    """(a_1, a_2) from S, and |S|."""
    S = k1 + k2 * mp.expj(gap)
    return mp.arg(S), gap - mp.arg(S), abs(S)


def step_of(phi, k1, k2, gap):
    """h of a turn by phi."""
    a1, a2, S = angles(k1, k2, gap)
    b1, b2 = (mp.atan2(mp.cos(phi / 2) * mp.sin(a), mp.cos(a)) for a in (a1, a2))
    return 8 * mp.pi * mp.sin(gap) / S * mp.sin(phi / 2) * mp.tan((b1 + b2) / 2)


def fold(k1, k2, gap):
    """(phi, h) at the fold, the largest h."""
    found = minimize_scalar(lambda p: -float(step_of(mp.mpf(p), k1, k2, gap)), bounds=(0.1, 3.1), method="bounded",
                            options={"xatol": 1e-9})
    return mp.mpf(found.x), -found.fun


def turn_of(h, k1, k2, gap):
    """The smaller angle with this h."""
    top, limit = fold(k1, k2, gap)
    return mp.findroot(lambda p: step_of(p, k1, k2, gap) - h, (mp.mpf(0), top), solver="anderson", tol=1e-20)


def places(k1, k2, gap):
    """The pair in the plane y = 0, S along z."""
    a1, a2, _ = angles(k1, k2, gap)
    return np.array([[float(mp.sin(a1)), 0, float(mp.cos(a1))], [-float(mp.sin(a2)), 0, float(mp.cos(a2))]])


def turned(w, angle):
    """w turned about z."""
    c, s = np.cos(angle), np.sin(angle)
    return w @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


SOLVERS = ("auto", "rotation", "plain")        # `auto` takes rotation from 301 vortices on


def vortices(strengths, solver="auto"):
    """The compiled vortices of these strengths."""
    return smidgen.build(shipped("point_vortices"), parameters={"n": len(strengths), "gamma": list(strengths)}, solver=solver)


def by(solver):
    """What a row says of its solver."""
    return "" if solver == "auto" else f" ({solver})"


@case("close vortex pair, up to the fold")
def up_to_the_fold():
    """The angle of a step is the exact angle on the connected branch."""
    # broken by: a wrong field or projection (the angle), the second branch (phi beyond the fold's), a loose stop
    for (name, (k1, k2, gap)), solver in product(PAIRS.items(), SOLVERS):
        model, w = vortices((k1, k2), solver), places(k1, k2, gap)
        _, limit = fold(k1, k2, gap)
        for part in PARTS:
            h = float(part * limit)
            exact = turn_of(h, k1, k2, gap)
            error = attempt(model.start(w.copy(), h=h))
            off = largest(model.w - turned(w, -float(exact))) if error is None else float("nan")
            # 1 - w_1.w_2 has the relative error eps/gap^2, which phi takes over, 1/sqrt(1 - part) times near the fold
            tolerance = 8 * EPS * largest(w[:, 0]) / gap**2 / (1 - part)**0.5
            yield below(f"{name}, {part} of the fold{by(solver)}: distance from the exact position at phi = {float(exact):.12f}", off, tolerance)


@case("close vortex pair, beyond the fold")
def beyond_the_fold():
    """There is no solution. One call of the step detects this, names the pair, and leaves the state unchanged."""
    # broken by: an accepted non-solution, an untyped failure, a write to the state before the step is known to hold
    for (name, (k1, k2, gap)), solver in product(PAIRS.items(), SOLVERS):
        _, limit = fold(k1, k2, gap)
        for factor in (1.0001, 1.5, 100.0):
            model = vortices((k1, k2), solver).start(places(k1, k2, gap), h=float(factor * limit))
            yield from refused(f"{name}, {factor} of the fold{by(solver)}", model, NO_SOLUTION, {0, 1})


@case("a close pair among others, beyond its fold")
def pair_among_others():
    """Of five sites, the report names the two that are close to each other."""
    # broken by: a report that names the first site, or the site where the iteration happened to end
    w = np.array([[1, 0, 0], [0, 0, -1], [0.15, 0, 1], [0, 1, -0.3], [-0.15, 0, 1.0]])
    w /= np.linalg.norm(w, axis=1)[:, None]
    a = asin(w[2, 0])
    model = vortices(np.ones(5)).start(w, h=2 * 4 * pi * sin(a) * tan(a))
    yield from refused("2 of the fold", model, NO_SOLUTION, {2, 4})


@case("vortices of opposite strength")
def dipole():
    """There is no fold: tan(phi/2) = h/(8 pi sin(gap/2)) at every h."""
    # broken by: a solver that needs a contraction, a branch check that refuses what is connected
    gap, model = mp.mpf("0.3"), vortices((1.0, -1.0))
    w = places(1, -1, gap)
    for h in (1.0, 30.0, 1e3):
        exact = 2 * mp.atan(h / (8 * mp.pi * mp.sin(gap / 2)))
        error = attempt(model.start(w.copy(), h=h))
        found = largest(turns(w, model.w)) if error is None else float("nan")
        yield near(f"h = {h:g}: angle", found, exact, 64 * EPS)


@case("two vortex pairs on their wrong branches")
def wrong_branches():
    """Both pairs start at their second solution, where det J > 0 again. The step is refused, although the equation is satisfied."""
    # broken by: a branch check by the sign of the determinant, or none (both would return ok)
    a, h = 0.15, 0.15
    for pairs, solver in product((1, 2), SOLVERS):
        with tempfile.TemporaryDirectory() as folder:
            status, residual, moved, *_ = ask(Path(folder), pairs, a, h, wrong=True, solver=solver)
        yield Row(f"{pairs} pair(s){by(solver)}", "wrong branch", STATUS.get(status, ("ok",))[0], status == WRONG_BRANCH)
        yield below(f"{pairs} pair(s){by(solver)}: residual there", residual, 1e-14)
        yield near(f"{pairs} pair(s){by(solver)}: change of the state", moved, 0, 0)


# -- collapse ---------------------------------------------------------------------------------------

STRENGTHS = np.array([2.0, 2.0, -1.0])      # 2*2 - 2 - 2 = 0
CYCLIC = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


def triangle(a, x):
    """w_1, w_2 at angles a from z, w_3 where 4 l_12^2 = 2 (l_13^2 + l_23^2)."""
    w1, w2 = np.array([np.sin(a), 0, np.cos(a)]), np.array([-np.sin(a), 0, np.cos(a)])
    z = (2 - 4 * np.sin(a)**2) / (2 * np.cos(a))      # w_3.(w_1 + w_2) = 2 - l_12^2
    return np.array([w1, w2, [x, np.sqrt(1 - z * z - x * x), z]])


def squares(w):
    """l_ij^2 of the sides 01, 12, 20."""
    return np.array([np.sum((w[i] - w[j])**2) for i, j, _ in CYCLIC])


class Collapse:
    """The law of one start: f(t) and the time of collapse."""

    def __init__(self, w):
        c = squares(w)
        each = [STRENGTHS[k] * (1 / np.sum((w[i] - w[k])**2) - 1 / np.sum((w[j] - w[k])**2)) / c[n]
                for n, (i, j, k) in enumerate(CYCLIC)]
        self.spread, self.A = np.ptp(each), np.mean(each)
        self.alpha = (2 * (c[0] * c[1] + c[1] * c[2] + c[2] * c[0]) - np.sum(c * c)) / 4
        self.beta, self.g0 = np.prod(c) / 4, np.linalg.det(w)
        self.end = 2 * pi * (np.sqrt(self.alpha) - abs(self.g0)) / (self.beta * abs(self.A))

    def factor(self, t):
        """f(t)."""
        return 1 + self.A * self.g0 / pi * t - self.beta * self.A**2 / (4 * pi**2) * t * t


def inward(a):
    """The orientation of the triangle that shrinks, and its law."""
    for x in (0.4 * a, -0.4 * a):
        w = triangle(a, x)
        law = Collapse(w)
        if law.A * law.g0 < 0:
            return w, law
    raise AssertionError("one of two mirror images shrinks")


def sides_at(model, w, t, count):
    """l_ij^2(t)/l_ij^2(0) after `count` steps to t."""
    return squares(model.start(w.copy(), h=t / count).steps(count).w) / squares(w)


@case("collapse of three vortices: the law")
def collapse_law():
    """Half way to the collapse and near it, all three squared distances, extrapolated to h = 0, follow f(t)."""
    # broken by: a wrong field; the law of the plane (f linear) differs in the second digit here
    w, law = inward(0.5)
    model = vortices(STRENGTHS)
    yield below("spread of A over the three sides", law.spread / abs(law.A), 1e-12)
    for part in (0.5, 0.9):
        t = part * law.end
        once, twice, four = (sides_at(model, w, t, n) for n in (2000, 4000, 8000))
        better = (4 * twice - once) / 3, (4 * four - twice) / 3
        limit = (16 * better[1] - better[0]) / 15
        exact = law.factor(t)
        plane = 1 + law.A * law.g0 / pi * t
        for side in range(3):
            yield ratio(f"side {side}, {part} of the way (the plane's law: {plane:.4f})", limit[side], exact, 1e-8)
        yield near(f"{part} of the way: error at h divided by error at h/2", np.mean((once - exact) / (twice - exact)), 4, 0.05)


def motion(w):
    """X(w): sum_j kappa_j w_i x w_j/(2 pi l_ij^2)."""
    return np.array([sum(STRENGTHS[j] * np.cross(w[i], w[j]) / (2 * pi * np.sum((w[i] - w[j])**2)) for j in range(3) if j != i)
                     for i in range(3)])


def fold_of_collapse(w, end):
    """(time to the collapse)/h at the fold of the step: (1 + sqrt(1 + 4 q^2))/2, q = omega end."""
    side, change = w[0] - w[1], (lambda X: X[0] - X[1])(motion(w))
    q = end * np.linalg.norm(np.cross(side, change)) / (side @ side)
    return (1 + sqrt(1 + 4 * q * q)) / 2


@case("collapse of three vortices: the end")
def collapse_end():
    """Steps exist up to the fold that the law predicts, and not beyond it. The failure names the sites, and the momentum is conserved."""
    # broken by: steps that pass the fold on another branch, an early end, an Inf, a lost momentum
    w, law = inward(0.05)
    model, momentum, last = vortices(STRENGTHS), STRENGTHS @ w, fold_of_collapse(w, law.end)
    for total in (30.5, 40.5, 60.25, 60.5, 200.5):
        h, what = law.end / total, f"h = end/{total}"
        model.start(w.copy(), h=h)
        attempt(model, 2 * int(total))
        yield same(f"{what}: steps (the fold: {last:.3f} h before the end)", model.count, ceil(total - last))
        yield from refused(f"{what}: next step", model, NO_SOLUTION, {0, 1, 2})
        yield ratio(f"{what}: fraction of h for which a step exists", model.report()["reached"], (total - model.count) / last, 0.01)
        yield below(f"{what}: change of the momentum", largest(STRENGTHS @ model.w - momentum), 4 * EPS * sqrt(total) + 8 * EPS)
