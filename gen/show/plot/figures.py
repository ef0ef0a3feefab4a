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
    """draw: arrays -> figure. size: 'broad' takes the whole width of a page. ending: of the file; part: of the page."""
    draw: Callable
    title: str
    size: str = ""
    ending: str = "svg"
    part: str = "figures"


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
    "accuracy_cost": Entry(cost.accuracy_cost, "What accuracy costs", size="broad", part="opening"),
    "every_system": Entry(overview.overview, "Every shipped system", size="broad"),
    "coadjoint_orbits": Entry(orbits.coadjoint_orbits, "Coadjoint orbits of so(3)*"),
    "free_body_portrait": Entry(free_body_portrait, "Free rigid body"),
    "free_body_errors": Entry(free_body_errors, "Errors against the step length", size="broad"),
    "irreversible_portrait": Entry(irreversible_portrait, "Irreversible rigid body"),
    "irreversible_trajectories": Entry(irreversible_trajectories, "Two methods, one start"),
    "irreversible_energy": Entry(irreversible_energy, "Energy drift"),
    "irreversible_energy_long": Entry(irreversible_energy, "Energy drift, ten times longer"),
    "forced_sections": Entry(forced_sections, "Poincar\u00e9 sections of the forced body", "broad"),
    "forced_sections_flow": Entry(forced_sections, "The same sections by the witness", "broad"),
    "vortex_illustration": Entry(portraits.manifold_illustration, "The invariant manifold"),
    "vortex_manifold": Entry(vortex_manifold, "Vortices on the invariant manifold"),
    "chain_curves": Entry(chain_curves, "Heisenberg chain on the sphere", size="broad"),
    "chain_evolution": Entry(chain_evolution, "Heisenberg chain over site and time", size="broad"),
    "chain_invariants": Entry(chain_invariants, "Invariants along the chain"),
    "test_particles": Entry(test_particles, "Particles in a Rossby\u2013Haurwitz wave"),
    "nambu_leaves": Entry(surfaces.leaves, "Nambu systems on their leaves", size="broad"),
}
