r"""Nambu systems: blow-up in finite time, small leaves

The Lagrange system x' = y z, y' = z x, z' = x y conserves C = (x^2 - y^2)/2 and H = (x^2 - z^2)/2. On H = 0, where z = x, and with
2 C = k^2 > 0, this gives y' = y^2 + k^2, so

    y = k tan(k t + d),  x = z = k sec(k t + d),      infinite at t = (pi/2 - d)/k.

The method conserves C and H, and hence x = z and the hyperbola x = k cosh(u), y = k sinh(u). The mean of the points u and u + 2 s is
k cosh(s) (cosh, sinh)(u + s), and its projection is the point u + s. The equation of y is 2 sinh(s) = h k cosh(u + s), or

    tanh(s) = cosh(u)/(2/(h k) - sinh(u)).

Hence a step exists if and only if exp(u) < 2/(h k), which gives the exact number of steps before the failure.
"""
from math import atan, cos, pi, tan

import mpmath as mp
import numpy as np
from support.systems import begin, model

import smidgen

from .case import EPS, NO_SOLUTION, OFF_MANIFOLD, attempt, below, case, ends, near, ratio, refused, same
from .geometry import largest


def on_the_line(k, d):
    """w = k (sec d, tan d, sec d)."""
    return np.array([[k / cos(d), k * tan(d), k / cos(d)]])


def place(k, u):
    """k (cosh u, sinh u, cosh u)."""
    return k * np.array([[float(f(u)) for f in (mp.cosh, mp.sinh, mp.cosh)]])


def orbit(k, u, h):
    """The u of every step, as long as steps exist."""
    seen = [u]
    while mp.e**u < 2 / (h * k):
        u = u + 2 * mp.atanh(mp.cosh(u) / (2 / (h * k) - mp.sinh(u)))
        seen.append(u)
    return seen


@case("Lagrange: blow-up in finite time")
def blow_up():
    """The discrete orbit follows its hyperbola, step by step. The first step without a solution is the exact one, and no Inf occurs before it."""
    # broken by: a projection left out (another orbit), a midpoint with c C(mbar) <= 0 accepted, an Inf, an end too early
    for k, d, h in ((1.0, -0.4, 0.02), (1.0, -1.2, 0.1), (0.1, -1.0, 0.3)):
        w = on_the_line(k, d)
        law = orbit(mp.mpf(k), mp.asinh(mp.tan(mp.mpf(d))), mp.mpf(h))
        one, what = model(begin("lagrange")).start(w.copy(), h=h), f"k = {k}, d = {d}, h = {h}"
        attempt(one, 10 * len(law))
        yield same(f"{what}: steps", one.count, len(law) - 1)
        yield from refused(f"{what}: next step", one, NO_SOLUTION, {0})
        yield below(f"{what}: largest component before the failure", largest(one.w), 1e6)
        half = one.start(w.copy(), h=h).steps(len(law) // 2).w
        exact = place(k, law[len(law) // 2])
        yield below(f"{what}: half way, error relative to the largest component", largest(half - exact) / largest(exact), 4 * EPS * len(law))


@case("outside the domain of a Nambu step")
def outside():
    """The first step is taken on both sides of exp(u) = 2/(h k). It is solved if there is a solution, and refused otherwise.
    At 0.95 of the limit on h, one step makes the state twenty times as large."""
    # broken by: a solution on the other sheet (c C(mbar) < 0), a limit on h instead of the state, a write to the state
    for k, u in ((1.0, 0.5), (0.1, 2.0), (30.0, -1.0)):
        w, limit = place(k, mp.mpf(u)), float(2 / (k * mp.e**u))
        for part in (0.5, 0.9, 0.95):
            one = model(begin("lagrange")).start(w.copy(), h=part * limit)
            error = attempt(one)
            exact = place(k, orbit(mp.mpf(k), mp.mpf(u), mp.mpf(part * limit))[1])
            # u to round-off: the coefficient of h, 1 - part, is known to eps cosh(u)^2
            off = largest(one.w - exact) / largest(exact) if error is None else float("nan")
            yield below(f"k = {k}, u = {u}: {part} of the limit, error", off, 32 * EPS * float(mp.cosh(u))**2 / (1 - part))
        for part in (1.001, 2.0, 100.0):
            yield from refused(f"k = {k}, u = {u}: {part} of the limit", model(begin("lagrange")).start(w.copy(), h=part * limit), NO_SOLUTION, {0})


@case("Lagrange: the time of the blow-up")
def when():
    """The flow is y(t) = k tan(k t + d). Steps extrapolated to h = 0 give its blow-up time, and halving h divides the error by 4."""
    # broken by: a wrong sign or factor in the bracket of the Nambu case
    k, d, t = 1.0, -0.4, 1.5
    w = on_the_line(k, d)
    one, exact = model(begin("lagrange")), on_the_line(k, k * t + d)
    found = [one.start(w.copy(), h=t / n).steps(n).w.copy() for n in (400, 800, 1600)]
    yield near("error at h divided by error at h/2", largest(found[0] - exact) / largest(found[1] - exact), 4, 0.02)
    better = [(4 * b - a) / 3 for a, b in zip(found, found[1:])]
    limit = (16 * better[1] - better[0]) / 15
    yield ratio("pole of the orbit, t + (pi/2 - atan(y/k))/k", t + (pi / 2 - atan(limit[0, 1] / k)) / k, (pi / 2 - d) / k, 1e-10)


@case("leaves near C = 0")
def small_leaves():
    """C = 0 is refused. On a leaf of size k^2, the law holds up to the round-off of C itself, eps cosh(u)^2."""
    # broken by: c/C(mbar) from an absolute threshold, 0/0 on the cone
    for w in ([0.3, 0.3, 1.0], [0.0, 0.0, 1.0], [0.3, -0.3, 1e-200]):
        error = None
        try:
            model(begin("lagrange")).start(np.array([w]), h=0.1)
        except smidgen.errors.RunError as found:
            error = found
        yield ends(f"w = {w}, C = 0", error, OFF_MANIFOLD)
    for k in (1e-3, 1e-6, 1e-100):
        d, h = 0.7, 0.1 / k
        w = on_the_line(k, d)
        law = orbit(mp.mpf(k), mp.asinh(mp.tan(mp.mpf(d))), mp.mpf(h))
        one = model(begin("lagrange")).start(w.copy(), h=h)
        one.steps(len(law) // 2)
        exact = place(k, law[len(law) // 2])
        yield below(f"k = {k:g}: error relative to the largest component", largest(one.w - exact) / largest(exact), 8 * EPS * len(law) * float(mp.cosh(law[len(law) // 2]))**2)


@case("Nambu leaves: their C over long runs")
def casimirs():
    """On hyperboloids of two sheets and one sheet, and on a cylinder, C is conserved to round-off over 10000 steps."""
    # broken by: the classical midpoint on these leaves (C drifts at order h^2), a projection that is not iterated to the end
    for name in ("nambu_a34", "nambu_a36", "nambu_a38", "nambu_a39"):
        start = begin(name)
        one = model(start).start(start.w.copy(), h=start.h)
        before = one.casimirs()
        one.steps(10_000)
        scale = max(largest(before), largest(one.w)**2)
        yield below(f"{name}: change of C, of |w|^2", largest(one.casimirs() - before) / scale, 16 * EPS)
