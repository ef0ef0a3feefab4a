"""The figures of the paper and of the demo: a name, a function of arrays, words.

Numbers of figures are those of McLachlan, Modin, Verdier, "A minimal-variable symplectic
integrator on spheres". Every function returns a matplotlib figure; none runs a model.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

from . import chain, colours, cost, curves, orbits, overview, portraits, surfaces
from .view import View


@dataclass(frozen=True)
class Entry:
    """draw: arrays -> figure; number: of the figure in the paper; see: what a reader should look for; size: 'broad' takes the whole
    width of a page; ending: of the file; part: of the page; seconds: of a round of a sphere that moves."""
    draw: Callable
    title: str
    number: str = ""
    see: str = ""
    size: str = ""
    ending: str = "svg"
    part: str = "figures"
    seconds: float = 0.0


def free_body_portrait(paths, marks):
    """Phase portrait of the free rigid body, I = (1, 2, 4). paths: list of (k, 3)."""
    return portraits.phase_portrait(paths, marks, "Free rigid body, I = (1, 2, 4)", View(35, 22))


def free_body_errors(panels):
    """Largest error against h; panels: [(title, {method: (h, error)})]."""
    return curves.error_against_step(panels)


def irreversible_portrait(paths, marks):
    """Phase portrait of the irreversible rigid body."""
    return portraits.phase_portrait(paths, marks, "Irreversible rigid body", View(130, 38))


def irreversible_trajectories(classical, spherical):
    """Points (k, 3) of both midpoint methods from one start, h = 1/2."""
    return portraits.compared([("classical-midpoint", classical), ("spherical-midpoint", spherical)],
                              "Irreversible rigid body, h = 1/2", View(130, 38))


def irreversible_energy(series):
    """Energy errors of both midpoint methods over time."""
    return curves.energy_errors(series, "Irreversible rigid body, h = 1/2")


def forced_sections(panels):
    """Poincare sections; panels: [(title, regular orbits, chaotic orbits)]."""
    return portraits.sections(panels, View(68, 24))


def vortex_manifold(paths, marks):
    """First vortex of four on the invariant manifold; singular points are crossed."""
    return portraits.phase_portrait(paths, marks, "Four vortices on the invariant manifold",
                                    View(28, 24))


def chain_evolution(t, w):
    """theta, phi, w_z over site and time; w (k, n, 3)."""
    return chain.chain_image(t, w, "Heisenberg chain of 100 spins")


def chain_curves(t, w, times):
    """The chain as a closed curve at a few times."""
    return chain.chain_curves(t, w, times, title="Heisenberg chain of 100 spins")


def chain_invariants(t, energy, momentum, casimirs):
    """Errors of energy, momentum and lengths along the chain's run."""
    return curves.invariant_errors(t, energy, {"w": momentum}, casimirs,
                                   "Heisenberg chain of 100 spins, h = 0.1")


def test_particles(paths):
    """Particles in a Rossby-Haurwitz wave; paths: list of (k, 3) in the frame of the wave."""
    return portraits.phase_portrait(paths, (), "Particles, seen from the wave", View(20, 35),
                                    colours.of_sites({"w": len(paths)})["w"])


FIGURES = {
    "moving_body": Entry(portraits.layered, "One method drifts, one does not", "Figure 4(b)", part="opening", seconds=16),
    "moving_section": Entry(portraits.layered, "Order and chaos of a forced body", "Figure 5", part="opening", seconds=16),
    "moving_vortices": Entry(portraits.layered, "Four vortices that come back", "Figure 7", part="opening", seconds=12),
    "coadjoint_orbits": Entry(orbits.coadjoint_orbits, "Coadjoint orbits of so(3)*", "Figure 1",
                              "Nested spheres; every trajectory stays on its own."),
    "free_body_portrait": Entry(free_body_portrait, "Free rigid body", "Figure 2",
                                "Closed curves around the stable equilibria (discs), which meet in the unstable ones (diamonds)."),
    "free_body_errors": Entry(curves.error_against_step, "Errors against the step length", "Figure 3",
                              "Parallel lines of slope 2: three methods of order 2, of which the spherical midpoint has the smallest error.", "broad"),
    "irreversible_portrait": Entry(irreversible_portrait, "Irreversible rigid body", "Figure 4(a)",
                                   "Closed curves again, but no symmetry under w \u2192 \u2212w."),
    "irreversible_trajectories": Entry(irreversible_trajectories, "Two methods, one start", "Figure 4(b)",
                                       "One method leaves its curve, the other stays on it."),
    "irreversible_energy": Entry(irreversible_energy, "Energy drift", "Figure 4(c)", "One energy error grows, the other stays within its bounds."),
    "irreversible_energy_long": Entry(irreversible_energy, "Ten times longer", "Figure 4(c), continued",
                                      "The energy error of the spherical midpoint is still within the same bounds."),
    "forced_sections": Entry(forced_sections, "Poincar\u00e9 sections of the forced body", "Figure 5",
                             "Left: nearly all orbits lie on curves. Right: a band around the unstable equilibria is chaotic.", "broad"),
    "forced_sections_flow": Entry(forced_sections, "The same sections by another program", "Figure 5, checked",
                                  "The same curves and the same chaos, so that both belong to the equation and not to the method.", "broad"),
    "vortex_illustration": Entry(portraits.manifold_illustration, "The invariant manifold", "Figure 6",
                                 "Two pairs of vortices, one around each pole, and the two angles that describe them."),
    "vortex_manifold": Entry(vortex_manifold, "Vortices on the invariant manifold", "Figure 7",
                             "Closed curves everywhere: every motion on the manifold is periodic."),
    "chain_curves": Entry(chain_curves, "Heisenberg chain on the sphere", "Figure 8",
                          "A closed curve of 100 spins moves and stays smooth, as for an integrable equation.", "broad"),
    "chain_evolution": Entry(chain_evolution, "Heisenberg chain over site and time", "Figure 8, continued",
                             "Waves that pass through each other, and a profile that nearly returns.", "broad"),
    "chain_invariants": Entry(chain_invariants, "Invariants along the chain", "Figure 8, continued",
                              "The energy error stays bounded; momentum and lengths change by round-off alone."),
    "test_particles": Entry(test_particles, "Particles in a Rossby\u2013Haurwitz wave", "",
                            "Seen from the wave, each particle follows a stream line."),
    "nambu_leaves": Entry(surfaces.leaves, "Nambu systems on their leaves", "Appendix", "Each trajectory stays on its level set of C.", "broad"),
    "accuracy_cost": Entry(cost.accuracy_cost, "Short runs and long runs", "",
                           "Left, curves further to the left are cheaper for the same error. Right, what becomes of the energy along a run a hundred "
                           "times as long.", "broad", part="cost"),
    "every_system": Entry(overview.overview, "A trajectory of each", size="broad", ending="png", part="systems"),
}
