"""Poincare sections in numbers: how thin a curve is, and which orbits are chaotic.

A section is the states of one orbit at multiples of the period of H. Whatever makes it is a
function `orbit(w, periods)` from a state of shape (3,) to points of shape (periods + 1, 3),
the first of them w: `stroboscope` makes one of a compiled model, `flow_stroboscope` one of
the witness. Both begin at the phase t = 0, so that an orbit can be taken up again at any of
its own points.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import UsageError

DEGREES = (4, 8, 16, 32, 64, 128)
GAP = 0.5           # radians: a curve closes when no more than this of the circle is bare
OFFSET = 1e-8       # length of a nearby orbit's separation: about the root of the round-off
BLOCK = 5           # periods before a separation is measured and put back to OFFSET
REGULAR, UNDECIDED, CHAOTIC = 0, 1, 2


# -- orbits -------------------------------------------------------------------------------------

def stroboscope(model, period: float, steps: int):
    """orbit(w, periods) of a compiled model of one site: every `steps` steps of period/steps.

    The orbit raises RunError where a step fails.
    """
    def orbit(w, periods: int) -> np.ndarray:
        points = np.empty((periods + 1, 3))
        points[0] = w
        model.start(points[:1].copy(), h=period / steps)
        for k in range(1, periods + 1):
            if model.advance(steps) < steps:
                raise model.failure()
            model.state(points[k:k + 1])
        return points
    return orbit


def flow_stroboscope(witness, period: float, integrator: str = "rk8pd", tol: float = 1e-13):
    """orbit(w, periods) of the exact solution, by the witness's flow to tolerance `tol`."""
    def orbit(w, periods: int) -> np.ndarray:
        start = np.reshape(w, (1, 3)).astype(float)
        times = period * np.arange(1, periods + 1)
        return np.concatenate([start, witness.flow(start, 0.0, times, integrator, tol)[:, 0]])
    return orbit


# -- the thickness of a curve -------------------------------------------------------------------

@dataclass(frozen=True)
class Chart:
    """Polar coordinates on the sphere in which a curve is close to the unit circle.

    Lambert's equal-area projection about `axes[0]`,

        u = sqrt(2/(1 + p.c)) (p.a, p.b),    (c, a, b) = axes,

    then v = shape^-1 (u - middle), v = rho (cos phi, sin phi). J. P. Snyder, Map
    Projections: A Working Manual (1987), chapter 24.
    """
    axes: np.ndarray        # (3, 3): the centre and two tangents, in rows
    middle: np.ndarray      # (2,)
    shape: np.ndarray       # (2, 2): root of twice the covariance of u

    def polar(self, points):
        """(phi, rho), each of shape (k,), of points (k, 3)."""
        v = np.linalg.solve(self.shape, (project(points, self.axes) - self.middle).T)
        return np.arctan2(v[1], v[0]), np.hypot(v[0], v[1])

    def point(self, phi, rho) -> np.ndarray:
        """The points (k, 3) of the unit sphere at polar coordinates phi, rho (k,)."""
        u = self.middle + (rho * np.array([np.cos(phi), np.sin(phi)])).T @ self.shape.T
        u = u / np.maximum(1, np.linalg.norm(u, axis=1) / 2)[:, None]   # |u| = 2: the antipode
        square = np.sum(u * u, axis=1)[:, None]
        a, b = np.sqrt(np.maximum(0, 1 - square / 4)) * u @ self.axes[1:], (1 - square / 2) * self.axes[0]
        return a + b


def project(points, axes) -> np.ndarray:
    """Lambert's equal-area projection (k, 2) of points (k, 3) about axes[0]."""
    along = points @ axes.T
    return np.sqrt(2 / (1 + along[:, :1])) * along[:, 1:]


def chart_of(points) -> Chart:
    """The chart about the mean of the points, scaled by their covariance.

    Raises UsageError for points without a mean direction (a great circle has no inside) and
    for points on one line of the chart.
    """
    mean = np.mean(points, axis=0)
    if np.linalg.norm(mean) < 1e-3:
        raise UsageError("the points have no centre on the sphere: their mean is near 0")
    c = mean / np.linalg.norm(mean)
    a = np.cross(c, np.eye(3)[np.argmin(np.abs(c))])
    a /= np.linalg.norm(a)
    axes = np.array([c, a, np.cross(c, a)])
    u = project(points, axes)
    if np.linalg.matrix_rank(u - u.mean(axis=0), tol=1e-12) < 2:
        raise UsageError("the points do not form a closed curve: they lie on a line or coincide")
    return Chart(axes, u.mean(axis=0), np.linalg.cholesky(2 * np.cov(u.T)))


@dataclass(frozen=True)
class Curve:
    """A closed curve rho(phi) = a_0 + sum_{k<=degree} a_k cos k phi + b_k sin k phi."""
    chart: Chart
    coefficients: np.ndarray    # (2 degree + 1,): a_0, a_1 .. a_degree, b_1 .. b_degree
    thickness: float            # rms distance of the points that the fit has not seen
    largest: float              # the largest of those distances

    @property
    def degree(self) -> int:
        return len(self.coefficients) // 2

    def distances(self, points) -> np.ndarray:
        """Distance in R^3 of points (k, 3) from the curve's point at the same angle, (k,).

        It is at least the distance from the curve, and the same times a bounded factor.
        """
        phi, _ = self.chart.polar(points)
        nearby = self.chart.point(phi, harmonics(phi, self.degree) @ self.coefficients)
        return np.linalg.norm(points - nearby, axis=1)


def harmonics(phi, degree: int) -> np.ndarray:
    """(k, 2 degree + 1): 1, cos phi .. cos degree phi, sin phi .. sin degree phi."""
    angles = np.outer(phi, np.arange(1, degree + 1))
    return np.hstack([np.ones((len(phi), 1)), np.cos(angles), np.sin(angles)])


def fit_curve(points, degrees=DEGREES) -> Curve:
    """The closed curve on which the points (k, 3) of a section lie, and how thick it is.

    Every other point is fitted, by least squares in the radius rho over the angle phi, with
    a trigonometric series of growing degree; the rest is kept to judge the fit, so that a
    series of many terms gains nothing by following scatter. The degree doubles while that
    halves the distance of the kept points. The section of a quasi-periodic orbit of an area-preserving analytic map
    is an analytic curve (V. I. Arnold, Mathematical Methods of Classical Mechanics, appendix
    8; for maps of the plane: J. Moser, Nachr. Akad. Wiss. Goettingen 1962), its coefficients
    fall geometrically, and the thickness falls to the errors of the points themselves. A
    chaotic orbit, and an orbit of a method that drifts, keep the width of what they fill.

    Raises UsageError when the points leave more than GAP radians bare (islands, a resonance:
    give the points of one island, every p-th) or are too few.
    """
    points = np.asarray(points, float)
    if len(points) < 8 * degrees[0]:
        raise UsageError(f"{len(points)} points are too few for a curve: at least {8 * degrees[0]} are needed")
    chart = chart_of(points)
    phi, rho = chart.polar(points)
    bare = widest_gap(phi)
    if bare > GAP:
        raise UsageError(f"the points do not form a closed curve: they leave a gap of {bare:.3g} radians")
    best = fit_degree(chart, points, phi, rho, degrees[0])
    for degree in (d for d in degrees[1:] if 8 * d <= len(points)):
        last, more = best, fit_degree(chart, points, phi, rho, degree)
        best = min(last, more, key=lambda curve: curve.thickness)
        if more.thickness > last.thickness / 2:
            break
    return best


def fit_degree(chart: Chart, points, phi, rho, degree: int) -> Curve:
    """The least-squares series of one degree through every other point, judged by the rest."""
    found = least_squares(harmonics(phi[::2], degree), rho[::2])
    away = Curve(chart, found, np.nan, np.nan).distances(points[1::2])
    return Curve(chart, found, float(np.sqrt(np.mean(away**2))), float(away.max()))


def least_squares(matrix, values) -> np.ndarray:
    """x of min |matrix x - values| by QR. Raises UsageError when the columns are dependent."""
    q, r = np.linalg.qr(matrix)
    try:
        return np.linalg.solve(r, values @ q)
    except np.linalg.LinAlgError:
        raise UsageError("the points have fewer distinct angles than the curve has terms: "
                         "the orbit is periodic and traces no curve") from None


def widest_gap(phi) -> float:
    """The widest arc (radians) of the circle without one of the angles phi."""
    angles = np.sort(np.mod(phi, 2 * np.pi))
    return float(np.max(np.diff(angles, append=angles[0] + 2 * np.pi)))


# -- chaotic or regular -------------------------------------------------------------------------

def growth(orbit, points, block: int = BLOCK, offset: float = OFFSET) -> np.ndarray:
    """ln(d_{j+1}/d_j) of a small separation over each block of periods, shape (blocks,).

    Two nearby orbits, the separation put back to `offset` after each block: G. Benettin,
    L. Galgani, J.-M. Strelcyn, Phys. Rev. A 14 (1976) 2338. `points` (k, 3) are the orbit.
    """
    points = np.asarray(points, float)
    direction, logs = tangent(points[0]), []
    for k in range(0, len(points) - block, block):
        beside = points[k] + offset * direction
        beside *= np.linalg.norm(points[k]) / np.linalg.norm(beside)
        start = np.linalg.norm(beside - points[k])
        apart = orbit(beside, block)[-1] - points[k + block]
        end = np.linalg.norm(apart)
        logs.append(np.log(end / start))
        direction = apart / end
    return np.array(logs)


def tangent(w) -> np.ndarray:
    """A unit vector across w that is parallel to no coordinate axis in general."""
    t = np.cross(w, [0.36, 0.48, 0.8])
    return t / np.linalg.norm(t)


def exponent(logs, block: int = BLOCK) -> float:
    """Finite-time Lyapunov exponent of a period, lambda_T = (1/T) sum_j ln(d_{j+1}/d_j).

    For a regular orbit d grows in proportion to T and lambda_T falls as ln(T)/T; for a
    chaotic one lambda_T tends to a positive number.
    """
    return float(np.sum(logs)) / (block * len(logs))


def birkhoff_average(values) -> np.ndarray:
    """Weighted average of values (k, ...) of a function along an orbit.

        WB = sum_k g(k/T) f(w_k) / sum_k g(k/T),    g(s) = exp(-1/(s(1 - s)))

    S. Das, Y. Saiki, E. Sander, J. A. Yorke, Nonlinearity 30 (2017) 4111. On a
    quasi-periodic orbit it converges faster than any power of 1/T, on a chaotic one as
    slowly as a plain average, 1/sqrt(T).
    """
    s = np.arange(1, len(values) + 1) / (len(values) + 1)
    weight = np.exp(-1 / (s * (1 - s)))
    return np.tensordot(weight / weight.sum(), np.asarray(values), axes=1)


def birkhoff_digits(points) -> float:
    """Digits to which the two halves of an orbit agree in their averages.

        dig = -log10 |WB(first half) - WB(second half)|

    of f = (w_x, w_y, w_z, w_x^2, w_y^2, w_x w_y, w_y w_z, w_z w_x), the largest difference.
    E. Sander, J. D. Meiss, Physica D 411 (2020) 132569, section 2.
    """
    points = np.asarray(points, float)
    x, y, z = points.T
    values = np.stack([x, y, z, x * x, y * y, x * y, y * z, z * x], axis=1)
    half = len(values) // 2
    apart = birkhoff_average(values[:half]) - birkhoff_average(values[half:2 * half])
    return float(-np.log10(np.max(np.abs(apart)) + 1e-17))


def judge_exponent(value: float, periods: int) -> int:
    """REGULAR, UNDECIDED or CHAOTIC by the exponent over `periods` periods T.

    A separation grows in proportion to T on a regular orbit, for a time faster beside a
    separatrix. Regular: less than T^2, chaotic: more than T^4.
    """
    power = value * periods / np.log(periods)
    return REGULAR if power < 2 else CHAOTIC if power > 4 else UNDECIDED


def judge_digits(digits: float, periods: int) -> int:
    """REGULAR, UNDECIDED or CHAOTIC by the digits of the averages over `periods` periods T.

    A plain average of a quasi-periodic function has an error of 1/T, of a chaotic one of
    1/sqrt(T). Regular: nearer than 1/T, chaotic: farther than 1/sqrt(T).
    """
    power = digits / np.log10(periods)
    return REGULAR if power > 1 else CHAOTIC if power < 0.5 else UNDECIDED


@dataclass(frozen=True)
class Census:
    """The verdicts of both indicators on a set of starts; arrays of shape (starts,)."""
    exponents: np.ndarray   # finite-time Lyapunov exponent of a period
    digits: np.ndarray      # digits of the weighted Birkhoff averages
    periods: int

    @property
    def judged(self) -> np.ndarray:
        """(2, starts): verdicts by the exponent and by the averages."""
        return np.array([[judge_exponent(x, self.periods) for x in self.exponents],
                         [judge_digits(d, self.periods) for d in self.digits]], dtype=int)

    @property
    def verdicts(self) -> np.ndarray:
        """(starts,): what both say, or what one says where the other is undecided; two that
        contradict each other are undecided."""
        return 1 + np.sign(self.judged.sum(axis=0) - 2)

    @property
    def contradictions(self) -> int:
        """Starts that one indicator calls regular and the other chaotic."""
        return int(np.sum(np.abs(np.diff(self.judged, axis=0)) == 2))

    @property
    def clear(self) -> int:
        """Starts on which both indicators decide."""
        return int(np.sum(np.all(self.judged != UNDECIDED, axis=0)))

    def count(self, verdict: int) -> int:
        """Starts with this verdict."""
        return int(np.sum(self.verdicts == verdict))

    @property
    def fraction(self) -> float:
        """The chaotic part of the starts."""
        return self.count(CHAOTIC) / len(self.digits)

    @property
    def interval(self) -> tuple[float, float]:
        """95% interval of the chaotic part of the sphere, undecided starts either way."""
        least, total = self.count(CHAOTIC), len(self.digits)
        return (wilson(least, total)[0], wilson(least + self.count(UNDECIDED), total)[1])


def wilson(hits: int, total: int, z: float = 1.959964) -> tuple[float, float]:
    """The 95% score interval of a binomial proportion.

    (p + z^2/2n +- z sqrt(p(1-p)/n + z^2/4n^2))/(1 + z^2/n): E. B. Wilson, J. Am. Stat. Assoc.
    22 (1927) 209. Starts spread evenly over the sphere scatter less than random ones do.
    """
    p, square = hits / total, z * z / total
    width = z * np.sqrt(p * (1 - p) / total + square / (4 * total))
    return (p + square / 2 - width) / (1 + square), (p + square / 2 + width) / (1 + square)


def census(orbit, starts, periods: int) -> Census:
    """Both indicators of the orbits of `periods` periods from starts (count, 3)."""
    found = np.array([indicators(orbit, orbit(w, periods)) for w in starts])
    return Census(found[:, 0], found[:, 1], periods)


def indicators(orbit, points) -> tuple[float, float]:
    """(exponent, digits) of the orbit with these points."""
    return exponent(growth(orbit, points)), birkhoff_digits(points)
