"""The kinds of picture that one result can give: name -> function of a Result.

Each takes a Result (`meta`, `t`, `w`, `values`) and returns a figure; `player` returns HTML.
"""
from __future__ import annotations

import dataclasses
from functools import partial

import numpy as np

from ...errors import UsageError
from . import cells, chain, cloud, curves, film, lattice, player, portraits, surfaces
from .colours import of_sites
from .extras import Extras
from .facts import conserved_energy
from .text import of_all, printable
from .units import behind, kinds_of, unit_of

TANGLED = 1500.0    # radii travelled from which on paths on one sphere cannot be told apart
SMALLEST, LARGEST = 1e-100, 1e100      # coordinates whose squares are still numbers
CLOUD = 1000        # sites from which on, where neighbours by number are far apart, they are a cloud of points
MANY = 12           # sites from which on a family is drawn as a chain
CURVES, LEAVES = 7, 9       # most sites of a picture of components, most leaves of one picture


def first_line(result) -> str:
    """Title of the result: the spec's own title and the run."""
    meta = result.meta
    return f"{meta.get('title') or meta.get('spec', 'Result')}: {meta.get('run') or 'run'}"


def facts(result) -> str:
    """Method, step, orientation: what a picture must say about where it comes from."""
    meta = result.meta
    said = [str(meta.get("method", "")), f"h = {meta['h']:g}{behind(kinds_of(result)['time'])}" if "h" in meta else "",
            f"{meta['done']} steps" if "done" in meta else "",
            "orientation -1" if meta.get("orientation") == -1 else ""]
    return ", ".join(part for part in said if part)


def states_of(result) -> dict:
    """family -> (k, count, 3). Raises UsageError when the result holds no states."""
    if not result.w:
        raise UsageError("this result contains no states: run with --what states,energy "
                         "(or draw another kind: energy, invariants, observables)")
    return {name: np.asarray(w, float) for name, w in result.w.items()}


def drawable(result):
    """The result without outputs that are not finite.

    Raises UsageError when none is left, and for states too large or too small to draw.
    """
    if not result.w:
        return result
    states = states_of(result)
    good = np.all([np.isfinite(w).all(axis=(1, 2)) for w in states.values()], axis=0)
    if not good.any():
        raise UsageError("no output of this result is finite: there is nothing to draw")
    size = max(float(np.abs(w[good]).max(initial=0)) for w in states.values())
    if not SMALLEST < size < LARGEST:
        raise UsageError(f"the largest coordinate of this result is {size:.3g}: "
                         f"pictures can only be drawn if it is between {SMALLEST:g} and {LARGEST:g}")
    return dataclasses.replace(
        result, step=result.step[good], t=result.t[good],
        w={n: w[good] for n, w in states.items()},
        values={n: np.asarray(v)[good] for n, v in result.values.items()})


def on_spheres(result) -> bool:
    """Does every site keep its length, so that it moves on a sphere?"""
    return all(np.allclose(np.linalg.norm(w, axis=2), np.linalg.norm(w[:1], axis=2), rtol=1e-6)
               for w in states_of(result).values())


def labelled(states):
    """[(name of one site, its colour, w (k, 3))] of all families."""
    colors = of_sites({name: w.shape[1] for name, w in states.items()})
    return [(portraits.site_name(name, i, w.shape[1]), colors[name][i], w[:, i])
            for name, w in states.items() for i in range(w.shape[1])]


def some(sites: list, most: int):
    """(at most `most` of `labelled` sites, evenly chosen; what to say of the others)."""
    picks = chain.thinned(len(sites), most)
    return [sites[i] for i in picks], of_all(len(picks), len(sites))


def draw_sphere(result):
    """Paths of all sites on the sphere (bodies of different radius on one picture)."""
    spheres_only(result)
    return portraits.several(states_of(result), first_line(result))


def spheres_only(result) -> None:
    if not on_spheres(result):
        raise UsageError("the sites of this result do not move on spheres: use the kind 'leaf'")


def draw_section(result):
    """The outputs as points on the sphere: a Poincare section of a stroboscopic run."""
    spheres_only(result)
    return portraits.several(states_of(result), first_line(result), points=True)


def draw_leaf(result):
    """Each site on its own leaf: the quadric with the Casimir that the spec declares."""
    matrices = casimirs_of(result)
    states = states_of(result)
    sites, note = some(labelled(states), LEAVES)
    cases = [{"title": first_line(result) if len(sites) == 1 else label, "color": color, "curves": [w],
              "casimir": matrices.get(label.split("[")[0], np.eye(3))} for label, color, w in sites]
    return surfaces.leaves(cases, note=note)


def casimirs_of(result) -> dict:
    """family -> matrix A of C = w.(A w)/2, of the families that are no spheres.

    Taken from the spec that the result carries; a family of which it says nothing and that
    leaves its sphere gets the quadric that fits its trajectory.
    """
    found = dict(result.meta.get("casimirs") or {})
    for name, w in states_of(result).items():
        length = np.linalg.norm(w, axis=2)
        if name not in found and not np.allclose(length, length[:1], rtol=1e-6):
            found[name] = fitted_quadric(w[:, 0])
    return {name: np.asarray(A, float) for name, A in found.items()}


def fitted_quadric(w) -> np.ndarray:
    """The symmetric A with w.(A w) constant along w (k, 3), as the null vector of least size.

    Two such forms may exist (a quadratic energy is the other): then the flattest is taken.
    """
    x, y, z = w.T
    products = np.stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z], axis=1)
    *_, v = np.linalg.svd(products - products.mean(axis=0), full_matrices=True)
    a = v[-1]
    return np.array([[a[0], a[3], a[4]], [a[3], a[1], a[5]], [a[4], a[5], a[2]]])


def by_column(result):
    """Column -> its unit."""
    return partial(unit_of, result)


def draw_energy(result):
    """Energy error over time, linear and symlog; where the energy is not conserved, its change."""
    energy, note = conserved_energy(result)
    if energy is None:
        raise UsageError("this result contains no energy: run with --what energy")
    series = [(str(result.meta.get("method", "energy")), result.t, energy - energy[0])]
    return curves.energy_errors(series, first_line(result) + f" ({note})" * bool(note), by_column(result), not result.meta.get("driven"))


def draw_effects(result):
    """Energy of each effect over time."""
    parts = {n.removeprefix("energy."): v for n, v in result.values.items()
             if n.startswith("energy.")}
    if not parts:
        raise UsageError("this result contains no energies: run with --what energy")
    return curves.against_time(result.t, {f"energy {n}": v for n, v in parts.items()},
                               first_line(result), unit=lambda name: unit_of(result, name.replace("energy ", "energy.")))


def draw_invariants(result):
    """Errors of energy, momenta and Casimirs over time."""
    values = result.values
    momenta = {n.removeprefix("momentum."): v for n, v in values.items()
               if n.startswith("momentum.")}
    energy, _ = conserved_energy(result)
    if energy is None and "casimirs" not in values and not momenta:
        raise UsageError("this result contains no invariants: run with "
                         "--what energy,momentum,casimirs")
    return curves.invariant_errors(result.t, energy, momenta,
                                   values.get("casimirs"), first_line(result), by_column(result))


def draw_observables(result):
    """The spec's own observables, magnetisations and topological charges, over time."""
    own = {n: v for n, v in result.values.items()
           if n not in ("energy", "casimirs") and ("." not in n or n.startswith("charge."))}
    own |= {f"{n}.{x}": v[:, k] for n, v in result.values.items() if n.startswith("magnetisation.") for k, x in enumerate("xyz")}
    if not own:
        raise UsageError("this result contains no observables: request some with --what")
    return curves.against_time(result.t, own, first_line(result), unit=lambda name: unit_of(result, name.removesuffix(".x").removesuffix(".y").removesuffix(".z")))


def draw_components(result):
    """The x, y and z components of all sites (or seven, evenly chosen) over time."""
    sites, note = some(labelled(states_of(result)), CURVES)
    panels = {f"component {x}": {label: (color, w[:, k]) for label, color, w in sites}
              for k, x in enumerate("xyz")}
    return curves.against_time(result.t, panels, first_line(result), note, lambda name: unit_of(result, next(iter(result.w)) if name.startswith("component") else name))


def draw_chain(result):
    """theta, phi and w_z of the largest family, over site and time."""
    name, w = largest(result)
    if len(result.t) < 2:
        raise UsageError("a picture over time needs two outputs; this result contains one")
    return chain.chain_image(result.t, w, first_line(result), others(result, name), by_column(result))


def draw_lattice(result):
    """The largest family on a lattice of two directions, at up to six times; of several layers the lowest."""
    name, size, sites = film_of(result)
    if not name:
        raise UsageError("this result has no lattice of two or three directions: use the kind 'chain'")
    w, (across, up, *above) = states_of(result)[name], wide(size)
    cells = w.reshape(len(w), *size[::-1], sites, 3)
    picked = [slice(None) if d in (across, up) else 0 for d in reversed(range(len(size)))]
    said = [f"the lowest of {size[d]} layers" for d in above]
    return lattice.lattice_images(result.t, cells[(slice(None), *picked)], first_line(result), "; ".join(filter(None, [others(result, name), *said])), (across, up), by_column(result), placed(result) is not None, names_of(result, name))


def names_of(result, name: str) -> tuple:
    """Of the sites of a cell, where the lattice of a family names them."""
    return ((result.meta.get("standing") or {}).get(name) or {}).get("names", ())


def placed(result):
    """(name, {"places", "links"}) of the largest family whose sites have places, in two directions or more; None where there is none."""
    counts = {name: w.shape[1] for name, w in states_of(result).items()}
    found = [name for name, one in (result.meta.get("standing") or {}).items()
             if counts.get(name) == len(one["places"]) and np.linalg.matrix_rank(one["places"] - one["places"][0], tol=1e-6 * np.ptp(one["places"])) > 1]
    best = max(found, key=counts.get, default=None)
    return best and (best, result.meta["standing"][best])


def stage_of(result, part: dict):
    """(name of a family, where its sites stand in the picture, units). Raises UsageError where none has places."""
    found = placed(result)
    if found is None:
        raise UsageError("no family of this result has positions in two or three dimensions: its lattice has neither `vectors` nor a name")
    name, one = found
    _, sites = (result.meta.get("grids") or {}).get(name, ((), 0))
    return name, cells.stage_of(one["places"], one["links"], part, sites), {**kinds_of(result), "length": one["unit"]}


def draw_places(result, part: dict | None = None):
    """The largest family with places: a cell and an arrow for each site, at up to six times."""
    name, stage, units = stage_of(result, part or {})
    return cells.place_images(result.t, states_of(result)[name], stage, first_line(result), others(result, name), units)


def film_parts(result, part: dict):
    """(figure, draw_frame, frames) of a film: at places where there are any, else on spheres."""
    if placed(result) is None and not part:
        spheres_only(result)
        return film.sphere_film(result.t, states_of(result), first_line(result), units=kinds_of(result))
    name, stage, units = stage_of(result, part)
    return film.lattice_film(result.t, states_of(result)[name], stage, first_line(result), others(result, name), units)


def wide(size) -> list:
    """The directions of more than one cell."""
    return [d for d, n in enumerate(size) if n > 1]


def film_of(result):
    """(name, cells in each direction, sites of a cell) of the largest family on a lattice with two directions or more; no name where there is none."""
    counts = {name: w.shape[1] for name, w in states_of(result).items()}
    found = [(counts[name], name, size, sites) for name, (size, sites) in (result.meta.get("grids") or {}).items() if name in counts and len(wide(size)) > 1]
    return max(found)[1:] if found else (None, (), 1)


def draw_curves(result):
    """The largest family at six times, its bonds as arcs on the sphere; all in a ring where none are known."""
    spheres_only(result)
    name, w = largest(result)
    joined = bonds_of(result, name) if "bonds" in result.meta else None
    return chain.chain_curves(result.t, w, title=first_line(result), bonds=joined,
                              note=others(result, name), told=by_column(result))


def draw_cloud(result):
    """The largest family at six times, a point a site."""
    spheres_only(result)
    name, w = largest(result)
    return cloud.cloud(result.t, w, title=first_line(result), note=others(result, name), told=by_column(result))


def others(result, name: str) -> str:
    """What to say of the sites of other families, where `name` alone is drawn."""
    counts = {n: w.shape[1] for n, w in states_of(result).items()}
    said = of_all(counts[name], sum(counts.values()))
    return said and f"family {name}: {said}"


def bonds_of(result, name: str):
    """(m, 2) numbers of the sites of a family that its lattice or graph joins; empty where none are known."""
    return np.asarray((result.meta.get("bonds") or {}).get(name, ()), int).reshape(-1, 2)


def largest(result):
    """(name, w) of the family with the most sites."""
    return max(states_of(result).items(), key=lambda item: item[1].shape[1])


def draw_player(result, start: float = 0.0) -> str:
    """HTML text: the trajectory to turn and play; start: the first frame, as a share of all."""
    states = states_of(result)
    matrices = casimirs_of(result)
    for name in states if matrices else ():
        matrices.setdefault(name, np.eye(3))
    bonds = {n: bonds_of(result, n) for n in states}
    bonds = {n: b for n, b in bonds.items() if len(b) and smooth(states[n][0], b) and smooth(states[n][-1], b)}
    energy, note = conserved_energy(result)
    return player.player_page(result.t, states, energy, first_line(result), facts(result), matrices, bonds,
                              start=start, note=note, method=result.meta.get("method", ""), more=Extras(result, states))


def smooth(spins, bonds=None) -> bool:
    """Are joined sites of (n, 3), by default neighbours by number, closer than sites drawn at random?"""
    steps = np.diff(spins, axis=0) if bonds is None else spins[bonds[:, 0]] - spins[bonds[:, 1]]
    return bool(np.linalg.norm(steps, axis=1).max() < 0.5 * np.linalg.norm(spins, axis=1).max())


KINDS = {
    "sphere": (draw_sphere, "paths of all sites on the sphere"),
    "section": (draw_section, "outputs as points on the sphere (Poincare section)"),
    "leaf": (draw_leaf, "paths on the level sets of C (Nambu and Lie-Poisson factors)"),
    "energy": (draw_energy, "energy error, linear and symmetric logarithm"),
    "effects": (draw_effects, "energy of each effect"),
    "invariants": (draw_invariants, "errors of energy, momenta and Casimirs"),
    "observables": (draw_observables, "the spec's observables over time"),
    "components": (draw_components, "x, y, z of the sites over time"),
    "chain": (draw_chain, "angles and w_z over site and time"),
    "lattice": (draw_lattice, "a lattice seen from above at up to six times, with w_z as colour and w_x, w_y as arrows"),
    "places": (draw_places, "a lattice with its sites at their positions, at up to six times; --part selects a part"),
    "curves": (draw_curves, "a chain or lattice on the sphere at six times, its bonds as arcs"),
    "cloud": (draw_cloud, "thousands of sites as points on the sphere at six times"),
    "player": (draw_player, "an HTML page with the trajectory as an animation"),
}


def kinds() -> dict[str, str]:
    """name -> one line, of every kind that `plot` draws; `auto` chooses among them."""
    return {"auto": "one that suits the result", **{n: printable(s) for n, (_, s) in KINDS.items()}}


def suitable(result, html: bool) -> str:
    """The kind that `auto` means for this result."""
    if html:
        return "player"
    if not result.w:
        return "invariants" if any(n == "casimirs" or n.startswith(("energy", "momentum."))
                                   for n in result.values) else "observables"
    if not on_spheres(result):
        return "leaf"
    flat, (_, w) = film_of(result)[0], largest(result)
    if result.meta.get("period") and (w.shape[1] <= MANY or not result.meta.get("grids")):
        return "section"
    if flat and result.w[flat].shape[1] > MANY:
        return "lattice" if on_squares(result, flat) else "places"
    if w.shape[1] > CLOUD and not smooth(w[0]):
        return "cloud"
    many = w.shape[1] > MANY
    return "chain" if many and (smooth(w[0]) or travelled(w) > TANGLED) else "sphere"


def on_squares(result, name: str) -> bool:
    """Are the places of a family, where it has any, those of its cells?"""
    one, (size, sites) = (result.meta.get("standing") or {}).get(name), result.meta["grids"][name]
    cell = np.indices(size[::-1]).reshape(len(size), -1)[::-1].T
    return one is None or sites == 1 and len(size) <= 3 and np.allclose(one["places"][:, :len(size)], cell) and np.allclose(one["places"][:, len(size):], 0)


def travelled(w) -> float:
    """Length of all paths together (k, n, 3), in radii of their spheres."""
    steps = np.linalg.norm(np.diff(w, axis=0), axis=2)
    return float(np.sum(steps / np.maximum(np.linalg.norm(w[0], axis=1), 1e-300)))
