r"""Rings of vortices

N evenly spaced vortices of strength kappa at height z = cos(theta), with r = sin(theta), rotate with the angular velocity

    Omega = (N - 1) kappa z/(4 pi r^2)

(clockwise for kappa > 0 with this sign of the bracket). A step rotates the ring by phi. Its midpoint is a ring at tan(theta') =
cos(phi/2) tan(theta), and the length of the increment gives sin(phi) = h Omega. Hence the step exists up to h Omega = 1.

*Stability.* In the coordinates azimuth and height, (alpha, zeta), the Hessian of H has no mixed part. For the mode exp(2 pi i p k/N) it is

    H_aa = (kappa^2/4 pi) p (N - p),    H_zz = (kappa^2/4 pi) ((N - 1)(1 + z^2) - p (N - p))/r^4

(the sum over k of sin^2(pi p k/N)/sin^2(pi k/N) is p (N - p)). Hence the flow is unstable if and only if
p (N - p) > (N - 1)(1 + z^2). This means z^2 < 1/3, 1/2, 4/5 for N = 4, 5, 6. It is never the case for N = 3, and always for N >= 7
(Polvani and Dritschel 1993).

*The step.* Let eta be half the angle of the step, with its sign, and q = r cos(eta). R^2 = q^2 + z^2 is the
square of the length of mbar, and r_m = q/R and z_m = z/R describe the ring of midpoints. P = H_aa/kappa and Q = H_zz/kappa are taken at (r_m, z_m).
Linearising W - w = h X(m) about the rotating ring gives

    zeta' - zeta = F (alpha + alpha')/2,    F = h P/(1 + h P T/2),    T = (z/r^2) tan(eta),
    alpha' - alpha = E (zeta + zeta')/2,    E = (2 z sin(eta) - Y cos(eta))/(r^2 (cos(eta) + Y z sin(eta)/2)),
    Y = 2 z tan(eta)/R^2 + h q^2 Q/R^4,

which is a Cayley map. A step multiplies a mode by exp(2 atanh(sqrt(E F)/2)), or rotates it by 2 atan(sqrt(-E F)/2) if E F < 0. At
p (N - p) = (N - 1)(1 + z^2) the two terms of E cancel for every eta, so the method has the thresholds of the flow at every h.
"""
from math import asin, atan, atanh, cos, pi, sin, sqrt, tan

import numpy as np
from scipy.optimize import brentq
from support.systems import load as shipped

import smidgen

from .case import EPS, NO_SOLUTION, attempt, below, case, near, ratio, refused
from .geometry import largest, polar, turns

KAPPA = 1.0


def vortices(N):
    """N compiled vortices of equal strength."""
    return smidgen.build(shipped("point_vortices"), parameters={"n": N, "gamma": [KAPPA] * N})


def rate(N, z):
    """Omega."""
    return (N - 1) * KAPPA * z / (4 * pi * (1 - z * z))


def ring(N, z, alpha=0.0, zeta=0.0):
    """The ring at height z with azimuths and heights moved."""
    height, azimuth = z + zeta * np.ones(N), 2 * pi * np.arange(N) / N + alpha
    r = np.sqrt(1 - height * height)
    return np.stack([r * np.cos(azimuth), r * np.sin(azimuth), height], axis=1)


@case("a ring of vortices turns rigidly")
def rigid():
    """In a thousand steps each vortex of a stable ring rotates by asin(h Omega) per step and stays at its height."""
    # broken by: any wrong sum over pairs, a wrong midpoint (CM turns by another angle), a drift
    count = 1000
    for N, theta in ((3, 1.0), (5, 0.4), (6, 0.3)):
        model, w, z = vortices(N), polar(theta, 2 * pi * np.arange(N) / N), cos(theta)
        for part in (0.1, 0.7):
            h = part / rate(N, z)
            model.start(w.copy(), h=h).steps(count)
            gap = np.angle(np.exp(1j * (turns(w, model.w) + count * asin(part))))
            height = count * EPS / 2                # half a last bit a step, at worst
            slope = part / sqrt(1 - part * part) * (1 / z + 2 * z / (1 - z * z))      # d asin(h Omega)/dz
            yield below(f"N = {N}, h Omega = {part}: error of the height", largest(model.w[:, 2] - z), height)
            yield below(f"N = {N}, h Omega = {part}: error of the angle after {count} steps", largest(gap), count * slope * height)


@case("a ring of vortices, up to its fold and beyond")
def ring_fold():
    """sin(phi) = h Omega has a solution for h Omega up to 1."""
    # broken by: a wrong branch before the fold, an accepted non-solution after it
    N, theta = 5, 0.4
    model, w, z = vortices(N), polar(theta, 2 * pi * np.arange(N) / N), cos(theta)
    for part in (0.9, 0.999):
        error = attempt(model.start(w.copy(), h=part / rate(N, z)))
        found = -turns(w, model.w).mean() if error is None else float("nan")
        yield near(f"h Omega = {part}: angle", found, asin(part), 64 * EPS / sqrt(1 - part))
    yield from refused("h Omega = 1.01", model.start(w.copy(), h=1.01 / rate(N, z)), NO_SOLUTION, set(range(N)))


def modes(N, p, z, h):
    """(E, F) of the step's linearisation."""
    r2, G = 1 - z * z, KAPPA / (4 * pi)
    eta = -asin(h * rate(N, z)) / 2
    q2 = r2 * cos(eta)**2
    R2 = q2 + z * z
    Q = G * ((N - 1) * (1 + z * z / R2) - p * (N - p)) / (q2 / R2)**2
    F = h * G * p * (N - p) / (1 + h * G * p * (N - p) * z / r2 * tan(eta) / 2)
    Y = 2 * z * tan(eta) / R2 + h * q2 * Q / R2**2
    E = (2 * z * sin(eta) - Y * cos(eta)) / (r2 * (cos(eta) + Y * z * sin(eta) / 2))
    return E, F


def moved(N, p, z, alpha, zeta):
    """The ring with the mode p of these amplitudes."""
    wave = np.cos(2 * pi * p * np.arange(N) / N)
    return ring(N, z, alpha * wave, zeta * wave)


def amplitude(N, p, z, w, angle):
    """(alpha, zeta) of mode p in a state that the ring has reached by `angle`."""
    wave = np.cos(2 * pi * p * np.arange(N) / N)
    off = np.angle(np.exp(1j * (turns(ring(N, z), w) - angle)))
    return off @ wave / (wave @ wave), (w[:, 2] - z) @ wave / (wave @ wave)


def growth(N, p, z, h, small=1e-9, factor=1e4):
    """The measured growth of a step: the growing mode from `small` over `factor`."""
    E, F = modes(N, p, z, h)
    count = int(np.log(factor) / (2 * atanh(sqrt(E * F) / 2)))
    alpha, zeta = small * sqrt(E / (E + F)), small * sqrt(F / (E + F))
    model = vortices(N).start(moved(N, p, z, alpha, zeta), h=h).steps(count)
    a, b = amplitude(N, p, z, model.w, -count * asin(h * rate(N, z)))
    return np.log((a * sqrt(F) + b * sqrt(E)) / (alpha * sqrt(F) + zeta * sqrt(E))) / count


@case("a ring of vortices grows at the rate of the linearised step")
def unstable_rings():
    """Rings of N = 4, 5, 6 are unstable below their thresholds, and rings of N = 7 at every height."""
    # broken by: a wrong second derivative of the pair energy in the dynamics; the flow's own rate differs in the third digit
    for N, z in ((4, 0.3), (5, 0.5), (6, 0.7), (7, 0.8), (9, 0.9)):
        p, h = N // 2, 0.4 / rate(N, z)
        E, F = modes(N, p, z, h)
        yield ratio(f"N = {N}, z = {z}: growth per step", growth(N, p, z, h), 2 * atanh(sqrt(E * F) / 2), 1e-5)


def stable_frequency(N, p, z, h, count=64, small=1e-6):
    """The measured angle per step of a mode that turns: its first amplitude is cos(n angle)."""
    model = vortices(N).start(moved(N, p, z, small, 0.0), h=h)
    base = asin(h * rate(N, z))
    seen = [amplitude(N, p, z, model.step().w, -(n + 1) * base)[0] / small for n in range(count)]
    x = np.array([1.0, *seen])      # x_{n+1} + x_{n-1} = 2 cos(angle) x_n
    return np.arccos(np.clip((x[2:] + x[:-2]) @ x[1:-1] / (2 * x[1:-1] @ x[1:-1]), -1, 1))


@case("stability thresholds of rings")
def thresholds():
    """The thresholds are z^2 = 1/3, 1/2, 4/5 at every h. If z is 1 % below the threshold, a mode grows at the exact rate; if z is 1 % above, it rotates at the exact rate."""
    # broken by: a wrong second derivative, another method (its threshold moves with h), damping on the stable side
    for N, limit in ((4, 1 / 3), (5, 1 / 2), (6, 4 / 5)):
        p, low, high = N // 2, 0.99 * sqrt(limit), 1.01 * sqrt(limit)
        for part in (1e-4, 0.4, 0.9):
            root = brentq(lambda z: modes(N, p, z, part / rate(N, z))[0], 0.3, 0.999)
            yield near(f"N = {N}, h Omega = {part}: threshold of z^2 in the linearised step", root**2, limit, 1e-9)
        E, F = modes(N, p, low, 0.4 / rate(N, low))
        yield ratio(f"N = {N}, 1 % below: growth per step", growth(N, p, low, 0.4 / rate(N, low), factor=1e3),
                    2 * atanh(sqrt(E * F) / 2), 1e-5)
        E, F = modes(N, p, high, 0.4 / rate(N, high))
        yield ratio(f"N = {N}, 1 % above: angle per step", stable_frequency(N, p, high, 0.4 / rate(N, high)),
                    2 * atan(sqrt(-E * F) / 2), 1e-5)


@case("a ring of three vortices is stable at every height")
def three():
    """Modes rotate by 2 atan(sqrt(-E F)/2) per step, also next to the equator and the pole."""
    # broken by: a growth or a damping that the method must not have
    for z, part in ((0.01, 0.3), (0.3, 0.9), (0.99, 0.5)):
        h = part / rate(3, z)
        E, F = modes(3, 1, z, h)
        small = 1e-6 * (1 - z * z)
        yield ratio(f"z = {z}, h Omega = {part}: angle per step", stable_frequency(3, 1, z, h, small=small), 2 * atan(sqrt(-E * F) / 2), 1e-4)
