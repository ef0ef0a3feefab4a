r"""Rigid bodies: the unstable axis, chaos

*The unstable axis.* Near w = e_y the equations of the free body are x' = (1/I_2 - 1/I_3)(-z), z' = (1/I_2 - 1/I_1) x, up to the sign of y. For
I = (1, 2, 4) this is x' = -z/4, z' = -x/2, with the growth rate s = 1/sqrt(8) along (1, 0, -sqrt 2). At an equilibrium m = mbar to first
order, so the step is the Cayley map, and the growing component is multiplied by (1 + h s/2)/(1 - h s/2) in each step. The equation is linear,
so this holds from 1e-300 up, provided that no threshold is absolute.

*Chaos.* The largest Lyapunov exponent of the forced body on one orbit is computed by the generated tangent map, and by a neighbouring
trajectory that is moved back repeatedly (Benettin, Galgani, Giorgilli, Strelcyn 1980). The tangent is also computed from the equation
of the step with the interpreter's derivatives of the field, with D = (h/2) DX(m) DP(mbar):

    (1 - D) dW = (1 + D) dw.

A chaotic orbit may stay near islands for a long time, so averages over two orbits agree slowly. On one orbit, the methods agree
to the accuracy with which a separation of 1e-8 is a tangent. On a regular orbit, in action-angle variables, a tangent is (dI, d theta + omega' t dI). Its
length is t times a bounded function of the phase, and the exponent over a time T decreases like ln(T)/T. In the slope of ln(length) as a
function of ln(t), fitted to every period from T/10 to T, the phase averages out.
"""
from math import log, pi, sqrt

import numpy as np
from support.systems import begin, model

from smidgen.analyse.lyapunov import OFFSET, Exponents, exponents, nearby, on_leaves, orthonormal, tangent_vectors
from smidgen.check.witness import Witness

from .case import below, between, case, near, ratio, same_bits

RATE = sqrt(1 / 8)
GROWING = np.array([1.0, 0.0, -sqrt(2)]) / sqrt(3)


@case("on the unstable axis of the free body")
def stationary():
    """A thousand steps on each axis, in both directions, do not change a bit."""
    # broken by: any part of a step that is not exactly odd or even in zero components; a noisy solver
    for w in (*np.eye(3), *(0.0 - np.eye(3))):
        for h in (0.3, -3.0):
            one = model(begin("free_rigid_body")).start(w[None].copy(), h=h).steps(1000)
            yield same_bits(f"w = {w.tolist()}, h = {h}", one.w, w[None])


@case("off the unstable axis of the free body")
def escape():
    """For starts from 1e-300 off the axis upward, both components grow by the Cayley factor in every step, to six digits of its logarithm."""
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
            yield below(f"start {off:g} off, h = {h}: lowest w_y later, far from the axis", lowest, -0.999)


# -- chaos ------------------------------------------------------------------------------------------

PERIOD, PER_PERIOD = 2 * pi, 20
H = PERIOD / PER_PERIOD
CHAOTIC, REGULAR = "eps = 0.07, near the separatrix", "eps = 0.01, regular orbit nearby"
ORBITS = {CHAOTIC: (0.07, 0.02), REGULAR: (0.01, 0.8)}


def start(off):
    """A point of the equator, `off` from the unstable axis."""
    return np.array([[np.sin(off), np.cos(off), 0.0]])


def from_the_equation(one, witness, w, periods):
    """ln of the growth in each period of the tangent that `exponents` starts from."""
    one.start(w.copy(), h=H)
    v, grown = tangent_vectors(one, 1)[0, 0], np.empty(periods)
    for n in range(periods):
        for k in range(PER_PERIOD):
            before = one.w.copy()
            mbar = (before + one.step().w)[0] / 2
            size = np.linalg.norm(mbar)
            m = mbar / size
            D = H / 2 * witness.jacobian(m[None], (n * PER_PERIOD + k + 0.5) * H)[0] @ (np.eye(3) - np.outer(m, m)) / size
            v = np.linalg.solve(np.eye(3) - D, v + D @ v)
        grown[n] = log(np.linalg.norm(v))
        v = v / np.linalg.norm(v)
    return grown


def two(name, periods):
    """The exponent of an orbit by the tangent map, and by a neighbouring trajectory."""
    eps, off = ORBITS[name]
    case, steps = begin("forced_rigid_body", eps=eps), periods * PER_PERIOD
    return (exponents(model(case, features=("tangent",)), start(off), H, steps, columns=1, every=PER_PERIOD),
            nearby(model(case), start(off), H, steps, every=PER_PERIOD))


def power(found):
    """Slope of ln(length of the tangent) over ln(t), from T/10 to T."""
    late = len(found.times) // 10
    return np.polyfit(np.log(found.times[late:]), np.cumsum(found.growth[:, 0])[late:], 1)[0]


def regular_rows(periods):
    """Both exponents go to 0 like ln(T)/T."""
    name, time = REGULAR, periods * PERIOD
    for method, found in zip(("tangent map", "neighbouring trajectory"), two(name, periods)):
        yield near(f"{name}: {method}, exponent of its growth as a power of t", power(found), 1, 0.05)
        yield below(f"{name}: {method}, exponent over {periods} periods", found.values[0], 1.5 * log(time) / time, "1.5 ln(T)/T")


@case("chaos of the forced body: two Lyapunov exponents")
def chaos():
    """The two exponents agree with each other, and with the equation of the tangent, as long as round-off has not changed the orbit. On a regular orbit nearby they are 0."""
    # broken by: a tangent that is not that of the step; a solver that returns noise (an exponent on the regular orbit)
    periods, (eps, off) = 60, ORBITS[CHAOTIC]      # exp(0.04*60*2 pi) 1e-16 is still small
    own, beside = (found.values[0] for found in two(CHAOTIC, periods))
    case = begin("forced_rigid_body", eps=eps)
    equation = from_the_equation(model(case), Witness(case.spec, case.values), start(off), periods).sum() / (periods * PERIOD)
    yield ratio(f"{CHAOTIC}: tangent map compared with a neighbouring trajectory, {periods} periods", own, beside, 1e-5)
    yield ratio(f"{CHAOTIC}: tangent map compared with the equation of the step", own, equation, 1e-6)
    yield from regular_rows(2000)


def along_one(one, w, periods):
    """Growth (periods, 2) of a tangent, and of the separation of a neighbouring trajectory, which both begin each period at the
    same state; every period of the loading is the first."""
    here, v = one.start(w.copy(), h=H).state(), tangent_vectors(one, 1)
    apart, grown = v[0].copy(), np.empty((periods, 2))
    for k in range(periods):
        beside = here + OFFSET * apart
        beside /= np.linalg.norm(beside)
        begun, ended = np.linalg.norm(beside - here), one.start(beside, h=H).steps(PER_PERIOD).state()
        one.start(here.copy(), h=H)
        one.push_forward(v, PER_PERIOD)
        v, (grown[k, 0],) = orthonormal(on_leaves(one, v))
        here = one.state()
        apart = (ended - here) / np.linalg.norm(ended - here)
        grown[k, 1] = log(np.linalg.norm(ended - here) / begun)
    return grown


@case("chaos of the forced body: two Lyapunov exponents, long run", tier="long")
def chaos_long():
    """Long after round-off has changed the orbit, the exponents still agree. They are far from 0 and from those of a regular orbit."""
    # broken by: a tangent that is not put back on the sphere (it outgrows what decays), a wrong time after a restart
    periods, (eps, off) = 20_000, ORBITS[CHAOTIC]
    grown = along_one(model(begin("forced_rigid_body", eps=eps), features=("tangent",)), start(off), periods)
    times = PERIOD * np.arange(1, periods + 1)
    own, beside = grown.sum(axis=0) / times[-1]
    spread = Exponents(grown.sum(axis=0), grown, times, grown).error()[0]
    yield ratio(f"{CHAOTIC}: tangent map compared with a neighbouring trajectory, {periods} periods", own, beside, 1e-5)
    yield between(f"{CHAOTIC}: exponent over its standard error", own / spread, 5, np.inf)
    yield between(f"{CHAOTIC}: exponent over 1.5 ln(T)/T, that of a regular orbit", own / (1.5 * log(times[-1]) / times[-1]), 50, np.inf)
    yield from regular_rows(periods)
