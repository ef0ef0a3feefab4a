"""The runs behind the figures: name -> function that returns (arguments of the figure, caption).

The captions carry the numbers that were measured, so that a page cannot claim what its own
run did not show.
"""
from __future__ import annotations

import numpy as np

from ...analyse.sections import (CHAOTIC, UNDECIDED, census, exponent, fit_curve, flow_stroboscope, growth,
                                 judge_exponent, stroboscope)
from ...chance import generator
from ...check.witness import Witness
from ...cost import cost
from ...cost.frontier import first, seconds_for
from ...cost.peers import PEERS
from ...cost.report import duration
from ...errors import RunError
from ...extremes import largest
from ...read.shipped import load_spec, shipped
from ...methods import METHODS, MIDPOINTS
from ...run.step.integrator import build
from ...run.run import run
from ...run.settings import settle
from ...run.step.evaluated import casimir_matrices
from ...run.step.start import initial_state
from ..plot.equilibria import equilibria
from ..plot.facts import with_facts
from ..plot.portraits import on_manifold
from ..plot.text import of_all
from . import moving, paths
from .exact import free_body

ANGLE = 1.1                                     # the start (cos 1.1, 0, sin 1.1)
TENSORS = {"(1, 2, 4)": (1.0, 2.0, 4.0), "(1, 4/3, 2)": (1.0, 4 / 3, 2.0)}
STEPS = [2.0 ** -k for k in range(1, 10)]
SPHERICAL, CLASSICAL, VESELOV = MIDPOINTS
PERIOD = 2 * np.pi
COSTED, COST_SECONDS, AIM = 20.0, 3.0, 1e-6     # time of the runs, seconds that may be spent on timing, the error of which words speak: that of the long runs
COMPARED = [name for name, m in METHODS.items()      # the midpoint, and of high order Gauss and explicit methods
            if name == SPHERICAL or not (m.variant or m.scheme) and m.order in (8, 12, 16)]
BESIDE = next(iter(PEERS))
CENSUS, CENSUS_PERIODS = 60, 300                # starts and periods of the chaotic fraction


def moving_body():
    """Both midpoint methods on the irreversible body, point by point."""
    states, _ = irreversible_trajectories()
    series = energy_series(2000)
    worst = {m: np.abs(error).max() for m, _, error in series}
    return ({"layers": moving.body_layers(**states), "backdrop": [], "view": (130, 38)},
            f"An irreversible rigid body: the same start, the same step h = 1/2, {len(states['spherical']) - 1} steps. The classical midpoint "
            f"leaves its curve, its energy error grows to {worst[CLASSICAL]:.2g}. The spherical midpoint is symplectic: it stays on one "
            f"closed curve, and its error never exceeds {worst[SPHERICAL]:.2g}.")


def moving_section():
    """The Poincare section at eps = 0.07, period by period."""
    orbit = stroboscope(build(load_spec("forced_rigid_body"), parameters={"eps": 0.07}), PERIOD, 20)
    layers = moving.section_layers(orbit, section_starts(), is_chaotic)
    return ({"layers": layers, "backdrop": [], "view": (68, 24)},
            "A periodically forced rigid body (\u03b5 = 0.07), observed once per period: a Poincar\u00e9 section. Regular orbits trace curves; chaotic ones fill a "
            f"band around the unstable equilibria. Spherical midpoint, {moving.PERIODS} periods of 20 steps.")


def moving_vortices():
    """Four vortices over one period of their motion on the invariant manifold."""
    layers, backdrop, missed = moving.vortices()
    return ({"layers": layers, "backdrop": backdrop, "view": (28, 24)},
            "Four equal point vortices on the invariant manifold that the authors found with this method, on which every motion is periodic. "
            f"Computed with h = 0.02; after one period all four have returned to within {missed:.0e}. Behind them, paths from other starts.")


def accuracy_cost():
    """The irreversible body: end error against time, and the energy along a run a hundred times as long, measured now."""
    table = cost(load_spec("irreversible_rigid_body"), time=COSTED, methods=COMPARED, seconds=COST_SECONDS, peers=[BESIDE])
    return {"table": table}, cost_words(table)


def cost_words(table) -> str:
    """The lesson, with what was measured."""
    explicit = best_of(table, lambda name: not METHODS[name].symplectic)
    own = best_of(table, lambda name: METHODS[name].symplectic)
    if not (explicit and own):
        return "No method reached the requested error in the time allotted to the demo."
    plain = seconds_for([r for r in table.rows if r.method == SPHERICAL], "end_error", AIM)
    times = [f"{duration(seconds)} by {METHODS[name].label}" for name, seconds in (explicit, own)]
    times += [f"{duration(plain)} by the spherical midpoint"] * (plain == plain)
    drifts = [f"{growth_of(table, name):.0e} by {'the ' * (name == SPHERICAL)}{METHODS[name].label}" for name in (explicit[0], own[0], SPHERICAL)]
    return (f"Short runs: take the explicit method. To t = {COSTED:g} a final error of {AIM:.0e} costs {', '.join(times)}. "
            f"Long runs: take a symplectic method, whose energy error does not grow. With steps for the same final error it is, up to t = {100 * COSTED:g}, "
            f"{', '.join(drifts)}. The spherical midpoint is the simplest of them: for many cheap steps that keep what matters. "
            "Irreversible body, processor time, measured as this page was made.")


def best_of(table, serves) -> tuple[str, float] | None:
    """(method, seconds) of the fastest for an end error of AIM; None where none gets there."""
    name, seconds = first(table.rows, "end_error", AIM, lambda name: name in METHODS and serves(name))
    return (name, seconds) if name else None


def growth_of(table, name: str) -> float:
    """The largest energy error along the long run; nan without one."""
    return max((error for method, _, _, error in table.long if method == name), default=np.nan)


def every_system():
    """The first run of every shipped spec, as far as a small picture shows it."""
    found = []
    for name in shipped():
        spec = load_spec(name)
        s = settle(spec)
        steps = min(s.steps, 2000)
        found.append(with_facts(run(spec, s.run, steps=steps, every=max(1, steps // 1000),
                                    what=["states"])))
    return {"results": found}, ("A trajectory of each, by the spherical midpoint method: whole paths of "
                                "one or two sites, the last part where there are more (a disc: "
                                "its end; shades: the number of the site), smooth chains at five "
                                "times, and level sets of C for the Nambu systems.")


def coadjoint_orbits():
    """The coupled bodies without their coupling: each moves on its own sphere of R^3."""
    model = build(load_spec("two_bodies"), effects=["rotation"])
    curves = []
    angles = np.array([0.25, 0.6, 0.9, 1.05, 1.25, 1.45, -0.3, -0.7])
    starts = np.stack([np.cos(angles), 0 * angles, np.sin(angles)], axis=1)
    for radius in (0.4, 0.7, 1.0):
        for pair in radius * starts.reshape(-1, 2, 3):
            states = paths.path(model, pair, 0.05 / radius, 900)
            curves += [paths.closed(states[:, i], 0.02 * radius) for i in (0, 1)]
    return {"curves": curves}, ("R\u00b3 with the Lie\u2013Poisson bracket is foliated by spheres of "
                                "radius \u03bb = |w|; the trajectories are of the extended "
                                "spherical midpoint method, which keeps each on its sphere.")


def one_body(name: str, h: float, steps: int, gap: float):
    """(paths, marks) of a portrait of a single body."""
    model = build(load_spec(name)).start(h=h)
    marks = equilibria(lambda w: model.field(w[None], 0.0)[0])
    trace = lambda w: paths.closed(paths.path(model, w[None], h, steps)[:, 0])
    return {"paths": paths.covering(trace, gap, paths.beside(marks)), "marks": marks}


def counted(marks) -> str:
    """How many equilibria of each kind were found."""
    kinds = [k for _, k in marks]
    return ", ".join(f"{kinds.count(k)} {k}" for k in ("stable", "unstable", "degenerate")
                     if k in kinds)


def free_body_portrait():
    """Trajectories of the spherical midpoint method with the equilibria of the field."""
    found = one_body("free_rigid_body", 0.1, 900, 0.2)
    return found, (f"Spherical midpoint, h = 0.1. Equilibria found from the field: "
                   f"{counted(found['marks'])}.")


def free_body_errors():
    """The error table: both tensors, three methods, nine steps."""
    panels = [(f"I = {name}", {m: (np.array(STEPS), errors_of(m, I)) for m in MIDPOINTS})
              for name, I in TENSORS.items()]
    ratios = [ratio_words(methods) for _, methods in panels]
    return {"panels": panels}, (
        "Start (cos 1.1, 0, sin 1.1), t from 0 to 10, against the exact solution in Jacobi's "
        "functions. Errors at h = 1/32 in units of the spherical midpoint's: for I = (1, 2, 4) "
        f"{ratios[0]}; for I = (1, 4/3, 2) {ratios[1]}. The factors of 400 and 30 in the paper's "
        "caption belong to the second tensor, while its text names the first.")


def ratio_words(methods) -> str:
    """The errors at h = 1/32 over that of the spherical midpoint."""
    at = {m: errors[STEPS.index(1 / 32)] for m, (_, errors) in methods.items()}
    return (f"{at[VESELOV] / at[SPHERICAL]:.4g} (discrete Moser\u2013Veselov) and "
            f"{at[CLASSICAL] / at[SPHERICAL]:.4g} (classical midpoint)")


def errors_of(method: str, moments) -> np.ndarray:
    """max_k |w_k - w(h k)| over 0 <= h k <= 10 for each of STEPS."""
    values = dict(zip(("I1", "I2", "I3"), moments))
    model = build(load_spec("free_rigid_body"), method=method, parameters=values)
    return np.array([error_of(model, moments, h) for h in STEPS])


def error_of(model, moments, h: float) -> float:
    start = np.array([[np.cos(ANGLE), 0.0, np.sin(ANGLE)]])
    found = paths.path(model, start, h, round(10 / h))[:, 0]
    exact = free_body(moments, ANGLE, h * np.arange(len(found)))
    return float(np.linalg.norm(found - exact, axis=1).max())


def irreversible_portrait():
    """The portrait, with every equilibrium that the field has."""
    found = one_body("irreversible_rigid_body", 0.1, 1500, 0.17)
    return found, (f"Spherical midpoint, h = 0.1, \u03c3 = 2/3. Equilibria found from the field: "
                   f"{counted(found['marks'])}. Besides the six poles of the principal axes "
                   "there are others, where w is parallel to the gradient of H off the axes.")


def irreversible(method: str, time: float, every: int = 1):
    """A Result of the irreversible body from the paper's start, h = 1/2."""
    return run(load_spec("irreversible_rigid_body"), "demo", method=method, h=0.5, time=time,
               every=every, what=["states", "energy"])


def irreversible_trajectories():
    """Both midpoint methods over t = 0 .. 2000."""
    states = {m: irreversible(m, 2000).w["w"][:, 0] for m in (CLASSICAL, SPHERICAL)}
    return ({"classical": states[CLASSICAL], "spherical": states[SPHERICAL]},
            "4000 steps from (0, 0.7248, -0.6889), put on the sphere. The spherical midpoint "
            "stays on one closed curve; the classical midpoint leaves it.")


def energy_series(time: float, every: int = 1):
    """[(method, t, H - H_0)] of both midpoint methods."""
    results = [(m, irreversible(m, time, every)) for m in (CLASSICAL, SPHERICAL)]
    return [(m, r.t, r.values["energy"] - r.values["energy"][0]) for m, r in results]


def irreversible_energy():
    """Energy errors to t = 2000."""
    series = energy_series(2000)
    (_, t, drift), (_, _, bounded) = series
    return {"series": series}, (
        f"Classical midpoint: {drift[t == 1000][0]:+.3e} at t = 1000, {drift[-1]:+.4e} at "
        f"t = 2000. Spherical midpoint: between {bounded.min():+.3e} and {bounded.max():+.3e}.")


def irreversible_energy_long():
    """Energy errors to t = 20000."""
    series = energy_series(20000, 4)
    (_, t, drift), (_, _, bounded) = series
    return {"series": series}, (
        f"Classical midpoint: {drift[t == 5000][0]:+.3e} at t = 5000, {drift[-1]:+.3e} at "
        f"t = 20000. Spherical midpoint: between {bounded.min():+.3e} and {bounded.max():+.3e}.")


def forced_sections():
    """Sections at eps = 0.01 and 0.07 by the compiled spherical midpoint, h = 2 pi/20."""
    def orbit(eps):
        return stroboscope(build(load_spec("forced_rigid_body"), parameters={"eps": eps}), PERIOD, 20)
    return section_figure(orbit, "Spherical midpoint, generated code, h = 2\u03c0/20", 1000)


def forced_sections_flow():
    """The same sections by the witness's flow, which shares no line with the compiler."""
    def orbit(eps):
        witness = Witness(load_spec("forced_rigid_body"), {"eps": eps})
        return flow_stroboscope(witness, PERIOD, tol=1e-10)
    return section_figure(orbit, "The witness's flow, tolerance 1e-10", 300)


def section_figure(orbit_of, source: str, periods: int):
    """(arguments, caption); orbit_of: eps -> orbit(w, periods). The same starts for every source."""
    panels, words = [], []
    for eps in (0.01, 0.07):
        orbit = orbit_of(eps)
        drawn = [(orbit(w, periods), w) for w in section_starts()]
        chaotic = [is_chaotic(orbit, points) for points, _ in drawn]
        panels.append((f"\u03b5 = {eps:g}",
                       [p for (p, _), bad in zip(drawn, chaotic) if not bad],
                       [orbit(w, 4 * periods) for (_, w), bad in zip(drawn, chaotic) if bad]))
        words.append(section_words(orbit, eps))
    return {"panels": panels}, (
        f"{source}: states at the multiples of 2\u03c0, {periods} periods, chaotic orbits four times as "
        f"many. {' '.join(words)}")


def section_words(orbit, eps: float) -> str:
    """The thickness of a curve, and how many starts spread over the sphere are chaotic."""
    start = np.array([np.cos(0.3), 0.0, np.sin(0.3)])
    found = census(orbit, paths.spiral(CENSUS), CENSUS_PERIODS)
    return (f"\u03b5 = {eps:g}: the curve through (cos 0.3, 0, sin 0.3) is thin to "
            f"{fit_curve(orbit(start, 600)).thickness:.1e}; chaotic are {found.count(CHAOTIC)} of "
            f"{CENSUS} starts spread over the sphere ({found.count(UNDECIDED)} undecided).")


def section_starts():
    """Starts along two arcs through the stable axes, on both sides, and beside the saddles."""
    arc = np.linspace(0.04, np.pi / 2 - 0.04, 12)
    front = np.stack([np.cos(arc), 0 * arc, np.sin(arc)], axis=1)
    saddles = np.array([[np.sin(0.02), s * np.cos(0.02), 0.0] for s in (1, -1)])
    return np.concatenate([front, front * [1, 1, -1], front * [-1, 1, 1], saddles])


def is_chaotic(orbit, points) -> bool:
    """Does a separation along the orbit grow faster than any regular one?"""
    periods = len(points) - 1
    return judge_exponent(exponent(growth(orbit, points)), periods) == CHAOTIC


def vortex_illustration():
    """Nothing is run for the drawing of C(theta, phi)."""
    return {}, ("Four points C(\u03b8, \u03c6): two pairs, each opened by 2\u03b8 over a pole, their "
                "half-planes 2\u03c6 apart.")


def vortex_manifold():
    """Orbits on the manifold, by the path of the first vortex; the rest follows by symmetry."""
    model = build(load_spec("vortex_manifold"))
    defects = []

    def trace(w):
        if np.max(np.abs(w)) > 0.985:           # close pairs turn too fast for the step
            return None
        states = paths.path(model, on_manifold(np.arccos(w[2]), np.arctan2(w[1], w[0])), 0.02, 3000, 2)
        mirrored = states[:, 0, None] * np.array([[1, 1, 1], [-1, -1, 1], [1, -1, -1], [-1, 1, -1]])
        defects.append(float(np.abs(states - mirrored).max()))
        return paths.closed(states[:, 0], 0.012)

    marks = manifold_marks()
    curves = paths.covering(trace, 0.12, paths.beside(marks, 5e-3), most=80)
    return {"paths": curves, "marks": marks}, (
        "Path of the first vortex for many starts C(\u03b8, \u03c6), spherical midpoint, h = 0.02; the "
        f"three others keep their mirror images to {largest(*defects):.1e}. Crosses: two vortices "
        "coincide. Diamonds: squares (unstable). Discs: tetrahedra (stable).")


def manifold_marks():
    """Places of the first vortex: tetrahedra are stable, squares are not, axes are singular."""
    cube = [np.array([x, y, z]) / np.sqrt(3) for x in (1, -1) for y in (1, -1) for z in (1, -1)]
    edges = [np.roll([a, b, 0.0], k) / np.sqrt(2) for k in range(3) for a in (1, -1) for b in (1, -1)]
    axes = [s * e for e in np.eye(3) for s in (1, -1)]
    return [*((w, "stable") for w in cube), *((w, "unstable") for w in edges),
            *((w, "singular") for w in axes)]


def chain(time: float, every: int):
    """A Result of the smooth chain of 100 spins."""
    return run(load_spec("heisenberg_chain"), "demo", time=time, every=every,
               what=["states", "energy", "momentum", "casimirs"])


def chain_curves():
    """Six times of the smooth chain."""
    r = chain(200, 10)
    return ({"t": r.t, "w": r.w["w"], "times": [0, 20, 50, 100, 150, 200]},
            "Spherical midpoint, h = 0.1, from \u03b8 = 0.7 + 0.3 sin 3s + 0.05 cos 9s, \u03c6 = s, "
            "s = 2\u03c0i/100.")


def chain_evolution():
    """Angles over site and time."""
    r = chain(400, 10)
    height = r.w["w"][:, :, 2]
    away = np.sqrt(np.mean((height - height[0]) ** 2, axis=1))
    late = np.flatnonzero(r.t >= 50)
    back = late[np.argmin(away[late])]
    return {"t": r.t, "w": r.w["w"]}, (
        f"The same run, t = 0 .. 400. The profile of w_z differs from its start by at most "
        f"{away.max():.3f} (root mean square) and by {away[back]:.3f} at t = {r.t[back]:g}, where it "
        "comes nearest again.")


def chain_invariants():
    """Errors of the invariants over t = 0 .. 1000."""
    r = chain(1000, 10)
    energy, momentum = r.values["energy"], r.values["momentum.w"]
    return ({"t": r.t, "energy": energy, "momentum": momentum, "casimirs": r.values["casimirs"]},
            f"Energy error within {np.abs(energy - energy[0]).max():.2e}; total momentum and "
            f"lengths are kept to round-off ({np.abs(momentum - momentum[0]).max():.1e} and "
            f"{np.abs(r.values['casimirs'] - 1).max():.1e}).")


def test_particles():
    """Paths in the frame that turns with the wave, where they follow the stream lines."""
    r = run(load_spec("test_particles"), "demo", time=200, every=4, h=0.05, what=["states"])
    values = r.meta["parameters"]
    speed = (28 * values["omega"] - 2 * values["Omega"]) / 30
    seen = turned(r.w["w"], -speed * r.t)
    stream = wave_stream(seen, values, speed)
    return ({"paths": list(np.moveaxis(seen, 1, 0))},
            f"{seen.shape[1]} particles for t = 0 .. 200, h = 0.05, turned back with the wave's speed "
            f"c = {speed:.4g}: in this frame the flow is steady and the paths follow its stream "
            f"lines; the stream function changes by at most {np.ptp(stream, axis=0).max():.1e} "
            "along them. Shades tell the particles apart, in the order of their numbers.")


def turned(w, angle) -> np.ndarray:
    """States w (k, n, 3) turned about z by the angles (k,)."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x, y, z = np.moveaxis(w, 2, 0)
    return np.stack([c * x - s * y, s * x + c * y, z], axis=2)


def wave_stream(w, values, speed: float) -> np.ndarray:
    """Stream function of the wave in its own frame: psi + c w_z, constant along paths."""
    x, y, z = np.moveaxis(w, 2, 0)
    wave = x**4 - 6 * x**2 * y**2 + y**4
    return (speed - values["omega"]) * z + values["K"] * z * wave


LEAVES = {"nambu_a31": "A3,1: C = w.x\u00b2", "nambu_a34": "A3,4: C = w.x w.y",
          "nambu_a36": "A3,6: C = w.x\u00b2 + w.y\u00b2", "nambu_a38": "A3,8: C = w.y\u00b2 + w.x w.z",
          "nambu_a39": "A3,9: C = |w|\u00b2", "lagrange": "Lagrange: C = (w.x\u00b2 \u2212 w.y\u00b2)/2"}


def nambu_leaves():
    """The shipped start of every Nambu spec and three more on the same leaf."""
    found = [leaf_case(name, title) for name, title in LEAVES.items()]
    worst = largest(*(defect for _, defect in found))
    return {"cases": [case for case, _ in found]}, (
        "Trajectories of the Nambu form of the spherical midpoint method on the level sets of "
        f"C; C changes by at most {worst:.1e} along them. A start that is not shown runs off to "
        "where no step exists.")


def leaf_case(name: str, title: str):
    """(case of `surfaces.leaves`, largest change of C)."""
    spec = load_spec(name)
    s, A = settle(spec), casimir_matrices(spec)[0]
    model, curves = build(spec), []
    starts = starts_on_leaf(A, initial_state(spec)[0])
    for w in starts:
        try:
            curves.append(paths.path(model, w[None], s.h, min(s.steps, 1200))[:, 0])
        except RunError:
            continue                            # left the leaf's part where the flow exists
    level = [0.5 * np.einsum("ki,ij,kj->k", w, A, w) for w in curves]
    said = of_all(len(curves), len(starts), "starts")
    return ({"title": title + f" ({said})" * bool(said), "casimir": A, "curves": curves},
            largest(*(np.abs(c - c[0]).max() for c in level)))


def starts_on_leaf(A, w, more: int = 3):
    """w and `more` points of its leaf around it: C is homogeneous, so scaling reaches C = c."""
    dice, c, found = generator("points of a leaf"), w @ A @ w, [w]
    while len(found) <= more:
        v = w + np.linalg.norm(w) * 0.7 * dice.standard_normal(3)
        share = c / (v @ A @ v)
        if 0.3 < share < 3 and v @ A @ w * c > 0:
            found.append(v * np.sqrt(share))
    return found


EXPERIMENTS = {f.__name__: f for f in (
    moving_body, moving_section, moving_vortices, accuracy_cost, every_system, coadjoint_orbits, free_body_portrait, free_body_errors, irreversible_portrait,
    irreversible_trajectories, irreversible_energy, irreversible_energy_long, forced_sections,
    forced_sections_flow,
    vortex_illustration, vortex_manifold, chain_curves, chain_evolution, chain_invariants,
    test_particles, nambu_leaves)}
