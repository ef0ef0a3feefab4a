r"""Single spins and pairs of spins

*A spin in a field.* The equation is w' = w x lambda e_z. Let r be the sine of the angle between w and the field. A step rotates w about z by
phi. The length rho of its midpoint is given by rho^2 = 1 - r^2 sin^2(phi/2), and the length of the increment gives
tan(phi/2) = lambda h/(2 rho). With a = (lambda h)^2 and s = sin^2(phi/2) this is 4 r^2 s^2 - (4 + a) s + a = 0, hence

    sin^2(phi/2) = [(4 + a) - sqrt((4 + a)^2 - 16 r^2 a)]/(8 r^2) = 2 a/[(4 + a) + sqrt((4 + a)^2 - 16 r^2 a)],
    cos^2(phi/2) = 8 (1 - r^2)/[b + sqrt(b^2 + 64 r^2 (1 - r^2))],    b = 4 + a - 8 r^2:

The rotation angle depends on the angle between w and the axis; the formula acos(1 - a/2) and the limit lambda h < 2 apply only to r = 1.
If the spin is exactly perpendicular to the field, r = 1, then sin^2(phi/2) = a/4, and there is no solution for lambda h > 2. At every other
angle a solution exists for every h. At the equilibrium, r -> 0, the step is the Cayley map, tan(phi/2) = lambda h/2, which is stable for every h.

*Anisotropy.* H = -K w_z^2 corresponds to a field -2 K w_z. Hence tan(phi/2) = -(h K z)/rho^2, with z = w_z.

*Two spins.* For H = J w_1.w_2 with strengths k_1, k_2, the flow rotates both spins about S = k_1 w_1 + k_2 w_2 at the rate
J |S|/(k_1 k_2). As for vortices, a step rotates them by phi about S, with tan a_i' = cos(phi/2) tan a_i and

    h = 2 (k_1 k_2/(J |S|)) (sin gap/sin(a_1' + a_2')) sin(phi/2).

*A rotating field*, B e_z + A (cos(f t) e_x + sin(f t) e_y). In the frame that rotates with it, the field is constant,
(A, 0, B + f). Hence w(t) = R_z(f t) R(-t (A, 0, B + f)) w(0), where R is the rotation by a vector.
"""
from math import cos, pi, sin

import mpmath as mp
import numpy as np
from scipy.spatial.transform import Rotation

import smidgen
from smidgen.run.step.block import NEAR

from .case import EPS, NO_SOLUTION, attempt, below, case, near, ratio, refused, same
from .geometry import build, largest, load, polar, turns

RATES = (1e-8, 0.1, 1.0, 1.99, 2.0, 2.5, 10.0, 1e3, 1e6)       # lambda h
ANGLES = (1e-8, 0.1, 0.7, 1.5, pi / 2 - 1e-4, 3.0)


def exact_turn(rate, w):
    """phi of lambda h = rate for the spin w, to 30 digits."""
    a, r2 = mp.mpf(rate)**2, 1 - mp.mpf(float(w[2]))**2
    root, b = mp.sqrt((4 + a)**2 - 16 * r2 * a), 4 + a - 8 * r2
    sine2, cosine2 = 2 * a / (4 + a + root), 8 * (1 - r2) / (b + mp.sqrt(b * b + 64 * r2 * (1 - r2)))
    return 2 * mp.atan2(mp.sqrt(sine2), mp.sqrt(cosine2))


def sensitivity(rate, w):
    """|d phi/d(log rate)| + |d phi/d w_z|: what the last bits of the data and of a step are worth."""
    near_by = [exact_turn(rate * (1 + 1e-9), w), exact_turn(rate, [0, 0, w[2] - np.sign(w[2]) * 1e-9]), exact_turn(rate, w)]
    return float(abs(near_by[0] - near_by[2]) + abs(near_by[1] - near_by[2])) / 1e-9


@case("one spin in a field, any lambda h, any angle")
def any_angle():
    """The angle of one step is exact from lambda h = 1e-8 to 1e6, for a spin alone and among others."""
    # broken by: a midpoint off its sphere, a bound lambda h < 2, another branch, a solver that contracts only for small h
    for theta in ANGLES:
        worst = {"alone": 0.0, "among others": 0.0}
        w = polar([theta], [0.0])
        for rate in RATES:
            tolerance = EPS * (4 + 4 * sensitivity(rate, w[0]))
            for name, model, start in (("alone", build("spin_in_field"), w), ("among others", build("spins_in_field", n=3), np.tile(w, (3, 1)))):
                error = attempt(model.start(start.copy(), h=rate))
                off = abs(-turns(start, model.w)[0] - float(exact_turn(rate, w[0]))) if error is None else np.inf
                worst[name] = max(worst[name], off / tolerance)
        for name, value in worst.items():
            yield below(f"theta = {theta:.5g}, {name}: error of the angle, in units of round-off", value, 1)


@case("one spin in a field: the midpoint near the centre")
def near_the_centre():
    """If the spin is nearly perpendicular to the field and lambda h is far beyond 2, W is close to -w. The step is still exact."""
    # broken by: a formula through 1 - rho^2 (cancels), a normalisation by a small rho without care
    for off in (1e-3, 1e-6):
        w = np.array([[np.sqrt(1 - off * off), 0.0, off]])
        for rate in (2.5, 10.0, 1e3):
            model = build("spin_in_field")
            error = attempt(model.start(w.copy(), h=rate))
            found = -turns(w, model.w)[0] % (2 * pi) if error is None else float("nan")
            yield near(f"w_z = {off:g}, lambda h = {rate!r}: angle", found, exact_turn(rate, w[0]), EPS * (4 + 4 * sensitivity(rate, w[0])))


@case("one spin in a field: a warning near the centre")
def warning():
    """A run warns if a midpoint comes within 0.1 of the centre, and gives its distance: rho^2 = 1 - r^2 sin^2(phi/2)."""
    # broken by: no warning, one by h alone (at other angles the same h is harmless), a distance taken from w
    for off, rate in ((1e-3, 1.99999), (1e-3, 2.5), (1e-6, 10.0), (0.5, 10.0), (0.02, 1.99), (0.02, 1.0)):
        w = np.array([[np.sqrt(1 - off * off), 0.0, off]])
        rho = mp.sqrt(1 - (1 - mp.mpf(off)**2) * mp.sin(exact_turn(rate, w[0]) / 2)**2)
        said = smidgen.run(load("spin_in_field"), start=w, h=rate, steps=1).summary["nearest"]
        yield same(f"w_z = {off:g}, lambda h = {rate}, rho = {float(rho):.3g}: warning", said is not None, bool(rho < NEAR))
        if said:
            yield ratio(f"w_z = {off:g}, lambda h = {rate}: distance in the warning", said["rho"], rho, 1e-12)


@case("one spin exactly perpendicular to its field")
def perpendicular():
    """The angle is phi = 2 asin(lambda h/2) for lambda h up to 2. Beyond it there is no solution, for a spin alone and among others, and the state is unchanged."""
    # broken by: accepting W = -w (which is no solution: the midpoint has no direction), a late or untyped failure
    w = np.array([[1.0, 0.0, 0.0]])
    for rate in (1e-8, 1.0, 1.9, 1.999999):
        model = build("spin_in_field").start(w.copy(), h=rate).step()
        yield near(f"lambda h = {rate!r}: angle", -turns(w, model.w)[0], 2 * mp.asin(mp.mpf(rate) / 2), 4 * EPS / np.sqrt(1 - rate * rate / 4))
    for rate in (2.000001, 2.1, 10.0, 1e6, -2.1):
        yield from refused(f"lambda h = {rate!r}, alone", build("spin_in_field").start(w.copy(), h=rate), NO_SOLUTION, {0})
    others = polar([0.3, pi / 2, 1.0], [0.0, 0.0, 2.0])
    others[1] = [0.0, 1.0, 0.0]
    yield from refused("lambda h = 3, the second of three", build("spins_in_field", n=3).start(others, h=3.0), NO_SOLUTION, {1})


@case("Cayley at the equilibrium, stable for every h")
def cayley():
    """A spin at a distance of 1e-9 from the axis rotates by 2 atan(lambda h/2) per step, and its distance does not change in 1000 steps."""
    # broken by: damping or growth at large lambda h (backward Euler, explicit methods), the formula of Theorem 1 (vi) taken at r = 0
    for rate in (0.1, 2.0, 100.0, 1e6):
        w = np.array([[1e-9, 0.0, 1.0]])
        model = build("spin_in_field").start(w.copy(), h=rate)
        yield near(f"lambda h = {rate!r}: angle of a step", -turns(w, model.step().w)[0], 2 * np.arctan(rate / 2), 8 * EPS)
        model.steps(1000)
        yield ratio(f"lambda h = {rate!r}: distance from the axis", np.hypot(*model.w[0, :2]), 1e-9, 1e-12)


@case("stiff easy axis, one spin")
def stiff_axis():
    """The angle satisfies tan(phi/2) = h K z/rho^2 for K from 1 to 1e4."""
    # broken by: a Jacobian without the anisotropy's own block (Newton fails), the neighbour's branch
    for K in (1.0, 100.0, 1e4):
        for theta in (0.2, 0.8):
            model = smidgen.build(load("easy_axis"), parameters={"K": K})
            w = polar([theta], [0.0])
            z, r2 = cos(theta), sin(theta)**2
            law = lambda phi: mp.tan(phi / 2) * (1 - r2 * mp.sin(phi / 2)**2) - mp.mpf("0.1") * K * z
            exact = mp.findroot(law, (0, mp.pi - mp.mpf(10)**-12), solver="anderson", tol=1e-20)
            error = attempt(model.start(w.copy(), h=0.1))
            found = turns(w, model.w)[0] if error is None else float("nan")
            yield near(f"h K = {0.1 * K:g}, theta = {theta}: angle", found, exact, 64 * EPS)


# -- two spins --------------------------------------------------------------------------------------

def step_of(phi, J, k1, k2, gap):
    """h of a turn by phi about S."""
    S = k1 + k2 * mp.expj(gap)
    a1, a2 = mp.arg(S), gap - mp.arg(S)
    b1, b2 = (mp.atan2(mp.cos(phi / 2) * mp.sin(a), mp.cos(a)) for a in (a1, a2))
    return 2 * k1 * k2 / (J * abs(S)) * mp.sin(gap) / mp.sin(b1 + b2) * mp.sin(phi / 2)


def turn_of(h, J, k1, k2, gap):
    """phi of a step h: the smallest positive root."""
    return mp.findroot(lambda p: mp.log(step_of(p, J, k1, k2, gap) / h), (mp.mpf(10)**-12, mp.pi - mp.mpf(10)**-12), solver="anderson", tol=1e-20)


def coupled(k1, k2, gap):
    """The two spins in a plane with S along z."""
    S = k1 + k2 * mp.expj(gap)
    a1, a2 = float(mp.arg(S)), float(gap - mp.arg(S))
    return np.array([[sin(a1), 0, cos(a1)], [-sin(a2), 0, cos(a2)]])


@case("two coupled spins turn about their sum")
def about_their_sum():
    """The angle of a step is exact for small to very large steps, also for unequal strengths. Its rate agrees with the flow to second order."""
    # broken by: a frozen partner, strengths left out on one side, sublattice rotations (energy exact, another angle)
    for k1, k2, gap in ((1.0, 1.0, 1.2), (1.0, 2.5, 0.9)):
        w = coupled(k1, k2, gap)
        model = build("two_spins", k=[k1, k2])
        S = abs(k1 + k2 * mp.expj(gap))
        for h in (0.1, 1.0, 10.0, 1e3):
            error = attempt(model.start(w.copy(), h=h))
            found = np.abs(turns(w, model.w)) if error is None else [float("nan")]
            yield near(f"strengths {k1:g}, {k2:g}, h = {h:g}: angle", found[0], turn_of(h, 1.0, k1, k2, gap), 32 * EPS)
        off = [abs(np.abs(turns(w, model.start(w.copy(), h=1 / n).steps(n).w)[0]) - float(S / (k1 * k2))) for n in (64, 128)]
        yield near(f"strengths {k1:g}, {k2:g}: error of the rate at h, divided by that at h/2", off[0] / off[1], 4, 0.05)


# -- fields that change in time ---------------------------------------------------------------------

@case("a field that changes in time along z")
def pulsed():
    """Every step rotates the spin by the exact angle for the field at t + h/2."""
    # broken by: a time frozen at the start of the run or of the step, or t + h
    h, count = 0.25, 40
    model, w = build("pulsed_spin"), polar([1.1], [0.0])
    model.start(w.copy(), t0=0.7, h=h).steps(count)
    exact = sum(exact_turn(h * abs(f), w[0]) * np.sign(f)
                for f in (1.0 + 0.5 * np.sin(3.0 * (0.7 + (k + 0.5) * h)) for k in range(count)))
    yield near("angle after 40 steps", np.angle(np.exp(1j * (float(exact) + turns(w, model.w)[0]))), 0, count * 4 * EPS)


def rabi(t, w):
    """w(t) in the field that turns: B = 1, A = 0.4, f = 1.7."""
    return Rotation.from_rotvec([0, 0, 1.7 * t]).apply(Rotation.from_rotvec(-t * np.array([0.4, 0, 2.7])).apply(w))


@case("a field that turns: the order is kept")
def turning():
    """From h to h/2 to h/4, the error decreases by factors of 4. With a frozen time the factors would be 2 or 1."""
    # broken by: a frozen time (order 0), time at an end of the step (order 1)
    model, w, t = build("rabi"), polar([0.4], [0.3]), 10.0
    off = [largest(model.start(w.copy(), h=t / n).steps(n).w - rabi(t, w)) for n in (200, 400, 800)]
    yield near("error at h divided by error at h/2", off[0] / off[1], 4, 0.05)
    yield near("error at h/2 divided by error at h/4", off[1] / off[2], 4, 0.02)
    limit = [model.start(w.copy(), h=t / n).steps(n).w.copy() for n in (400, 800, 1600)]
    better = [(4 * b - a) / 3 for a, b in zip(limit, limit[1:])]
    yield below("difference from the exact solution after extrapolation to h = 0", largest((16 * better[1] - better[0]) / 15 - rabi(t, w)), 1e-9)
