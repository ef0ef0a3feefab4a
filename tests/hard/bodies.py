r"""Rigid bodies: the unstable axis, chaos

*The unstable axis.* Near w = e_y the free body is x' = (1/I_2 - 1/I_3)(-z), z' = (1/I_2 - 1/I_1) x up to the sign of y; for
I = (1, 2, 4): x' = -z/4, z' = -x/2, growth s = 1/sqrt(8) along (1, 0, -sqrt 2). At an equilibrium m = mbar to first order:
the step is the Cayley map, and what grows is multiplied by (1 + h s/2)/(1 - h s/2) each time. That is linear: it holds from
1e-300 up, as long as no threshold is absolute.

*Chaos.* The largest Lyapunov exponent of the forced body's section map by two methods on the same orbit: the distance of a
nearby orbit, put back again and again (Benettin, Galgani, Giorgilli, Strelcyn 1980), and the tangent of the step, from its
equation with the interpreter's derivatives of the field. With D = (h/2) DX(m) DP(mbar):

    (1 - D) dW = (1 + D) dw.

On a regular orbit a tangent grows like t, so that the exponent over a time T falls like ln(T)/T.
"""
from math import log, pi, sqrt

import numpy as np
from support.systems import begin, load, model

from smidgen.witness import Witness

from .case import below, between, case, near, ratio, same_bits

RATE = sqrt(1 / 8)
GROWING = np.array([1.0, 0.0, -sqrt(2)]) / sqrt(3)


@case("on the unstable axis of the free body")
def stationary():
    """A thousand steps on each axis, both ways round: the same bits."""
    # broken by: any part of a step that is not exactly odd or even in zero components; a noisy solver
    for w in (*np.eye(3), *(0.0 - np.eye(3))):
        for h in (0.3, -3.0):
            one = model(begin("free_rigid_body")).start(w[None].copy(), h=h).steps(1000)
            yield same_bits(f"w = {w.tolist()}, h = {h}", one.w, w[None])


@case("off the unstable axis of the free body")
def escape():
    """From 1e-300 up, both components grow by the Cayley factor at every step, to six digits of its logarithm."""
    # broken by: an absolute tolerance or flushed denormals (nothing grows), an iteration stopped early (another rate);
    # the flow's own rate h s differs in the fourth digit at h = 0.1
    one = model(begin("free_rigid_body"))
    for off in (1e-300, 1e-200, 1e-100, 1e-15):
        for h in (0.1, 1.0):
            w, factor = np.array([[0.0, 1.0, 0.0]]) + off * GROWING, log((1 + h * RATE / 2) / (1 - h * RATE / 2))
            count = int(log(1e-4 / off) / factor)
            end = one.start(w.copy(), h=h).steps(count).w
            for axis, name in ((0, "x"), (2, "z")):
                yield ratio(f"start {off:g} off, h = {h}: growth of {name} in {count} steps", log(end[0, axis] / w[0, axis]) / count, factor, 1e-6)
            lowest = min(one.step().w[0, 1] for _ in range(int(30 / factor)))
            yield below(f"start {off:g} off, h = {h}: then far away, lowest w_y", lowest, -0.999)


# -- chaos ------------------------------------------------------------------------------------------

PERIOD, PER_PERIOD = 2 * pi, 20
H = PERIOD / PER_PERIOD
ORBITS = {"chaotic, eps = 0.07, near the separatrix": (0.07, 0.02), "regular, eps = 0.01": (0.01, 0.8)}


def start(off):
    """A point of the equator, `off` from the unstable axis."""
    return np.array([[np.sin(off), np.cos(off), 0.0]])


def benettin(one, w, periods, distance=1e-8):
    """ln of the whole stretching of a neighbour of the orbit, put back after every period."""
    total, gap = 0.0, distance * np.cross(w, [[0, 0, 1.0]])
    for _ in range(periods):
        near_by = w + gap
        near_by /= np.linalg.norm(near_by)
        gap0 = np.linalg.norm(near_by - w)
        end = one.start(w.copy(), h=H).steps(PER_PERIOD).w.copy()
        gap = one.start(near_by, h=H).steps(PER_PERIOD).w - end
        total += log(np.linalg.norm(gap) / gap0)
        gap *= distance / np.linalg.norm(gap)
        w = end
    return total


def tangent(one, witness, w, periods):
    """ln of the whole stretching of the tangent of the step, from its own equation."""
    total, v, project = 0.0, np.cross(w[0], [0, 0, 1.0]), np.eye(3)
    for _ in range(periods):
        v /= np.linalg.norm(v)
        one.start(w.copy(), h=H)
        for k in range(PER_PERIOD):
            before = one.w.copy()
            mbar = (before + one.step().w)[0] / 2
            size = np.linalg.norm(mbar)
            m = mbar / size
            D = H / 2 * witness.jacobian(m[None], (k + 0.5) * H)[0] @ (project - np.outer(m, m)) / size
            v = np.linalg.solve(project - D, v + D @ v)
        total += log(np.linalg.norm(v))
        w = one.w.copy()
    return total


def both(name, periods):
    """The exponents per unit of time of one orbit, by two methods."""
    eps, off = ORBITS[name]
    values = {"eps": eps}
    one, witness = model(begin("forced_rigid_body", **values)), Witness(load("forced_rigid_body"), values)
    return [f / (periods * PERIOD) for f in (benettin(one, start(off), periods), tangent(one, witness, start(off), periods))]


def lyapunov(periods):
    """Rows of both orbits."""
    chaotic, regular = ORBITS
    apart, own = both(chaotic, periods)
    yield ratio(f"{chaotic}: tangent against neighbour, {periods} periods", own, apart, 1e-4)
    yield between(f"{chaotic}: exponent", own, 0.02, 0.2)
    short, long = both(regular, periods // 10), both(regular, periods)
    for name, a, b in zip(("neighbour", "tangent"), short, long):
        power = (b - a / 10) * periods * PERIOD / log(10)       # ln of the growth between T/10 and T, over ln 10
        yield near(f"{regular}: {name}, its stretching grows like T to the power", power, 1, 0.2)
        yield below(f"{regular}: {name}, exponent over that of the chaotic orbit", b / own, 4 * log(periods * PERIOD) / (periods * PERIOD) / own, "4 ln(T)/T over it")


@case("chaos of the forced body: two Lyapunov exponents")
def chaos():
    """They agree near the separatrix and go to 0 on a regular orbit beside."""
    # broken by: a tangent that is not that of the step; a solver that returns noise (an exponent on the regular orbit)
    yield from lyapunov(200)


@case("chaos of the forced body: two Lyapunov exponents, long run", tier="long")
def chaos_long():
    """The same over ten times the time."""
    yield from lyapunov(2000)
