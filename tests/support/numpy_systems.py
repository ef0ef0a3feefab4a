"""Every system of specs/ in about ten lines of plain numpy, as a third hand.

Written from McLachlan, Modin, Verdier, "A minimal-variable symplectic integrator on
spheres" (section 4 and the appendix), differentiated by hand: no spec, no sympy, no
automatic differentiation. Each function takes the parameters, the state w of shape
(sites, 3) and t, and returns (H, dH/dw of shape (sites, 3)); gradients of tracers are those
of their own Hamiltonian. SYSTEMS maps the name of a spec to its function; STRENGTHS and
CASIMIRS hold kappa and grad C where they are not 1 and w.
"""
import numpy as np


def body(moments, w):
    """H = w.(I^-1 w)/2, equation (free rigid body)."""
    inverse = 1 / np.array(moments)
    return 0.5 * np.sum(inverse * w * w), inverse * w


def free_rigid_body(p, w, t):
    return body([p["I1"], p["I2"], p["I3"]], w)


def irreversible_rigid_body(p, w, t):
    """I_k(w) = I_k/(1 + sigma w_k): H = sum w_k^2 (1 + sigma w_k)/(2 I_k)."""
    inverse, s = 1 / np.array([p["I1"], p["I2"], p["I3"]]), p["sigma"]
    return 0.5 * np.sum(inverse * (w**2 + s * w**3)), inverse * (w + 1.5 * s * w**2)


def forced_rigid_body(p, w, t):
    """H = w.(I^-1 w)/2 + eps sin(t) w_3."""
    energy, gradient = body([p["I1"], p["I2"], p["I3"]], w)
    push = p["eps"] * np.sin(t)
    return energy + push * w[0, 2], gradient + np.array([0, 0, push])


def vortices(strengths, w):
    """H = -(1/4 pi) sum_{i<j} kappa_i kappa_j ln(2 - 2 w_i.w_j)."""
    energy, gradient = 0.0, np.zeros_like(w)
    for i in range(len(w)):
        for j in range(i):
            product, gap = strengths[i] * strengths[j], 2 - 2 * w[i] @ w[j]
            energy -= product * np.log(gap) / (4 * np.pi)
            gradient[i] += product * w[j] / (2 * np.pi * gap)
            gradient[j] += product * w[i] / (2 * np.pi * gap)
    return energy, gradient


def point_vortices(p, w, t):
    return vortices(p["gamma"], w)


def vortex_manifold(p, w, t):
    return vortices(np.ones(4), w)


def vortex_tracers(p, w, t):
    """Three vortices; psi = -(1/4 pi) sum_j kappa_j ln(2 - 2 x.w_j) moves a tracer x."""
    strengths, x = p["gamma"], w[3:]
    energy, gradient = vortices(strengths, w[:3])
    gap = 2 - 2 * x @ w[:3].T
    energy -= np.sum(strengths * np.log(gap)) / (4 * np.pi)
    return energy, np.concatenate([gradient, (strengths / gap) @ w[:3] / (2 * np.pi)])


def exchange(w, reach=1):
    """sum_i w_{i-reach}.w_i on a ring."""
    before, after = np.roll(w, reach, axis=0), np.roll(w, -reach, axis=0)
    return np.sum(before * w), before + after


def heisenberg_chain(p, w, t):
    return exchange(w)


def landau_lifshitz(p, w, t):
    """w' = w x w'' on a closed curve of length 2 pi."""
    ds = 2 * np.pi / len(w)
    energy, gradient = exchange(w)
    return energy / ds**2, gradient / ds**2


def j1j2_chain(p, w, t):
    (near, near_gradient), (far, far_gradient) = exchange(w, 1), exchange(w, 2)
    return (p["J1"] * near + p["J2"] * far,
            p["J1"] * near_gradient + p["J2"] * far_gradient)


def cubic_lattice(p, w, t):
    """-J sum over neighbours, open ends; the first direction runs fastest."""
    cube = w.reshape(p["nz"], p["ny"], p["nx"], 3)
    energy, gradient = 0.0, np.zeros_like(cube)
    for axis in range(3):
        low = tuple(slice(0, -1) if k == axis else slice(None) for k in range(3))
        high = tuple(slice(1, None) if k == axis else slice(None) for k in range(3))
        energy -= p["J"] * np.sum(cube[low] * cube[high])
        gradient[low] -= p["J"] * cube[high]
        gradient[high] -= p["J"] * cube[low]
    return energy, gradient.reshape(-1, 3)


def honeycomb(p, w, t):
    """Site a of a cell meets site b of the same cell, of the one before and the one below."""
    cells = w.reshape(p["ny"], p["nx"], 2, 3)
    a, b = cells[:, :, 0], cells[:, :, 1]
    at_a = b + np.roll(b, 1, axis=1) + np.roll(b, 1, axis=0)
    at_b = a + np.roll(a, -1, axis=1) + np.roll(a, -1, axis=0)
    return p["J"] * np.sum(a * at_a), p["J"] * np.stack([at_a, at_b], axis=2).reshape(-1, 3)


def test_particles(p, w, t):
    """psi = -omega sin(lat) + K cos(lat)^4 sin(lat) cos(4(lon - c t)), by complex numbers."""
    c = (28 * p["omega"] - 2 * p["Omega"]) / 30
    z, turned = w[:, 2], (w[:, 0] + 1j * w[:, 1]) * np.exp(-1j * c * t)
    wave, slope = (turned**4).real, 4 * turned**3 * np.exp(-1j * c * t)
    gradient = np.stack([p["K"] * z * slope.real, -p["K"] * z * slope.imag,
                         p["K"] * wave - p["omega"]], axis=1)
    return np.sum(-p["omega"] * z + p["K"] * z * wave), gradient


test_particles.__test__ = False


def two_bodies(p, w, t):
    energy, gradient = body([p["I1"], p["I2"], p["I3"]], w)
    return energy + p["J"] * w[0] @ w[1], gradient + p["J"] * w[::-1]


def lagrange(p, w, t):
    """H = (w_1^2 - w_3^2)/2, C = (w_1^2 - w_2^2)/2: w_1' = w_2 w_3 and so on round."""
    sign = np.array([1, 0, -1])
    return 0.5 * np.sum(sign * w**2), sign * w


def nambu_a31(p, w, t):
    x, y, z = w[0]
    return ((y**2 + z**2) / 2 + y**4 / 4 + 0.3 * x * z,
            np.array([[0.3 * z, y + y**3, z + 0.3 * x]]))


def nambu_a34(p, w, t):
    x, y, z = w[0]
    return (x**2 + y**2 + z**2) / 2 + z**4 / 4 + 0.3 * x, np.array([[x + 0.3, y, z + z**3]])


def nambu_a36(p, w, t):
    x, y, z = w[0]
    return (z**2 / 2 + z**4 / 8 + x - 0.3 * x * y,
            np.array([[1 - 0.3 * y, -0.3 * x, z + z**3 / 2]]))


def nambu_a38(p, w, t):
    x, y, z = w[0]
    return (x**2 + y**2 + z**2) / 2 + y**4 / 4 + 0.2 * x, np.array([[x + 0.2, y + y**3, z]])


def nambu_a39(p, w, t):
    x, y, z = w[0]
    return ((x**2 + y**2 / 2 + z**2 / 4) / 2 + 0.2 * x**3 + 0.1 * y,
            np.array([[x + 0.6 * x**2, y / 2 + 0.1, z / 4]]))


def product(p, w, t):
    """A free rigid body and a pendulum on e(2), coupled by J w.v."""
    spin, v = w
    energy, gradient = body([1, 2, 4], spin)
    return (energy + v[2]**2 / 2 + v[0] + p["J"] * spin @ v,
            np.array([gradient + p["J"] * v, np.array([1, 0, v[2]]) + p["J"] * spin]))


SYSTEMS = {f.__name__: f for f in (
    free_rigid_body, irreversible_rigid_body, forced_rigid_body, point_vortices,
    vortex_manifold, vortex_tracers, heisenberg_chain, landau_lifshitz, j1j2_chain,
    cubic_lattice, honeycomb, test_particles, two_bodies, lagrange, nambu_a31, nambu_a34,
    nambu_a36, nambu_a38, nambu_a39, product)}

STRENGTHS = {
    "point_vortices": lambda p: np.array(p["gamma"]),
    "vortex_tracers": lambda p: np.concatenate([p["gamma"], np.ones(p["m"])]),
}

CASIMIRS = {                                    # grad C of each site that is not grad C = w
    "lagrange": lambda w: np.stack([w[:, 0], -w[:, 1], 0 * w[:, 2]], 1),
    "nambu_a31": lambda w: np.stack([2 * w[:, 0], 0 * w[:, 1], 0 * w[:, 2]], 1),
    "nambu_a34": lambda w: np.stack([w[:, 1], w[:, 0], 0 * w[:, 2]], 1),
    "nambu_a36": lambda w: np.stack([2 * w[:, 0], 2 * w[:, 1], 0 * w[:, 2]], 1),
    "nambu_a38": lambda w: np.stack([w[:, 2], 2 * w[:, 1], w[:, 0]], 1),
    "nambu_a39": lambda w: 2 * w,
    "product": lambda w: np.array([w[0], [2 * w[1, 0], 2 * w[1, 1], 0]]),
}


def strengths(name, p):
    """kappa of every site, shape (sites, 1), or 1."""
    return STRENGTHS[name](p)[:, None] if name in STRENGTHS else 1.0


def vector_field(name, p, w, t):
    """w' = (1/kappa) grad C x grad H, shape (sites, 3)."""
    normal = CASIMIRS[name](w) if name in CASIMIRS else w
    return np.cross(normal, SYSTEMS[name](p, w, t)[1] / strengths(name, p))
