"""The number of a bond: bond(i, j, b) of a lattice. Energies against sums written out, states against the witness, from site to site and by rows, and the
same bonds as the edges of a graph."""
import itertools
import re

import numpy as np
import pytest

import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from smidgen.language import draws
from support.by_sites import by_sites
from support.strict import MODES, compile_all
from test_rows_in_time import by_rows

SPEC = """[model]
name = "numbered"
[space]
w = {{ sphere = "{places}*nx*ny" }}
[parameters]
nx = {nx}
ny = {ny}
seed = 3
J = {{ default = 0.0, size = "{size}" }}
D = {{ file = "d.npy", vector = true, size = "{size}" }}
[lattices.cells]
size = ["nx", "ny"]
boundary = {boundary}
sites = {places}
bonds.all = [{bonds}]
[effects.joined]
over = "bond(i, j, b) of cells"
energy = "{energy}"
[effects.field]
over = "site(i) of w"
energy = "-0.3*w[i].z"
[observables.sum]
over = "bond(i, j, b) of cells"
value = "J[b]*w[i].x*w[j].y"
[starts.random]
random = 1
[runs.demo]
start = "random"
h = 0.05
steps = 20
"""
ENERGY = "J[b]*dot(w[i], w[j]) + 0.2*triple(D[b], w[i], w[j]) + 0.3*uniform(seed, b)*w[i].x*w[j].x"
SQUARE = (1, ((0, 0, (1, 0)), (0, 0, (0, 1))))
HONEY = (2, ((0, 1, (0, 0)), (0, 1, (-1, 0)), (1, 0, (0, 1))))
PLACES = {      # (places, bonds (from, to, offset)), periodic, cells, size of J
    "ring by ring": (SQUARE, (True, True), (6, 4), "2*nx*ny"), "open": (SQUARE, (False, False), (5, 3), "(nx - 1)*ny + nx*(ny - 1)"),
    "half open": (SQUARE, (True, False), (6, 7), "nx*ny + nx*(ny - 1)"), "honeycomb": (HONEY, (False, False), (4, 5), "nx*ny + (nx - 1)*ny + nx*(ny - 1)"),
    "honeycomb on a ring": (HONEY, (True, True), (4, 4), "3*nx*ny"), "two cells": (SQUARE, (True, True), (2, 2), "2*nx*ny"),
}
SAID = {True: '"periodic"', False: '"open"'}


def written_out(place) -> np.ndarray:
    """The two sites of every bond, in the order of the manual: one of the list after the other, cells with the first direction fastest."""
    (places, bonds), rings, size, _ = PLACES[place]
    found = []
    for first, last, offset in bonds:
        for y, x in itertools.product(range(size[1]), range(size[0])):
            to = [x + offset[0], y + offset[1]]
            if all(ring or 0 <= t < n for t, n, ring in zip(to, size, rings)):
                to = [t % n for t, n in zip(to, size)]
                found.append(((x + size[0] * y) * places + first, (to[0] + size[0] * to[1]) * places + last))
    return np.array(found)


def spec_of(folder, place, energy=ENERGY, size=None):
    (places, bonds), rings, cells, said = PLACES[place]
    rows = ", ".join(f"{{ from = {a}, to = {b}, offset = [{x}, {y}] }}" for a, b, (x, y) in bonds)
    np.save(folder / "d.npy", np.random.default_rng(2).normal(size=(len(written_out(place)), 3)))
    (folder / "spec.toml").write_text(SPEC.format(places=places, nx=cells[0], ny=cells[1], size=size or said, boundary=f"[{', '.join(SAID[r] for r in rings)}]", bonds=rows, energy=energy))
    return smidgen.load(folder / "spec.toml")


def numbers(place) -> np.ndarray:
    return np.random.default_rng(1).normal(size=len(written_out(place)))


@pytest.mark.parametrize("place", PLACES)
def test_each_bond_has_its_number(tmp_path, place):
    """The energy, from Python with an array of NumPy, is the sum over the bonds in their order; so is the witness."""
    spec, J, ends = spec_of(tmp_path, place), numbers(place), written_out(place)
    model = smidgen.build(spec, parameters={"J": J}, effects=["joined"]).start("random", h=0.05)
    D, u = np.load(tmp_path / "d.npy"), draws.uniform(3, np.arange(len(ends)))
    v, w = model.w[ends[:, 0]], model.w[ends[:, 1]]
    expected = np.sum(J * (v * w).sum(1) + 0.2 * (D * np.cross(v, w)).sum(1) + 0.3 * u * v[:, 0] * w[:, 0])
    assert abs(model.energy() - expected) <= 1e-13 * len(ends)
    assert abs(Witness(spec, parameters={"J": J}).energies(model.w)["joined"] - expected) <= 1e-13 * len(ends)


QUICK = {("honeycomb", "spherical-midpoint"), ("open", "pair-rotations"), ("half open", "gauss-4")}


@pytest.mark.parametrize("place, method", [pytest.param(p, m, marks=() if (p, m) in QUICK else pytest.mark.long) for p in PLACES for m in (
    "spherical-midpoint", "gauss-4", "sublattice-rotations", "pair-rotations", "cf4")])
def test_steps_are_those_of_the_witness(tmp_path, place, method):
    exchange = "(J[b] + uniform(seed, b))*dot(w[i], w[j])"
    spec, J = spec_of(tmp_path, place, exchange if method == "pair-rotations" else ENERGY), numbers(place)
    called = ["joined"] if method == "pair-rotations" else None
    model = smidgen.build(spec, method=method, parameters={"J": J}, effects=called).start("random", h=0.05)
    found = Witness(spec, parameters={"J": J}, effects=called).steps(model.w.copy(), 0.0, 0.05, 5, method)[-1]
    assert np.abs(model.steps(5).w - found).max() <= 2e-14


@pytest.mark.parametrize("place", ["open", "honeycomb", "honeycomb on a ring"])
def test_rows_serve(tmp_path, place):
    """By rows as from site to site."""
    spec, J, ends = spec_of(tmp_path, place, "J[b]*dot(w[i], w[j]) + uniform(seed, b)*w[i].x*w[j].y"), numbers(place), []
    assert by_rows(spec)
    for build in (smidgen.build, by_sites):
        ends.append(build(spec, parameters={"J": J}).start("random", h=0.05).steps(12).w.copy())
    assert np.abs(ends[0] - ends[1]).max() <= 1e-13


def test_a_graph_with_these_edges_moves_alike(tmp_path):
    place = "half open"
    spec, J, ends = spec_of(tmp_path, place, "J[b]*dot(w[i], w[j])"), numbers(place), written_out(place)
    (tmp_path / "edges.csv").write_text("".join(f"{i}, {j}, {x!r}\n" for (i, j), x in zip(ends.tolist(), J.tolist())))
    text = (tmp_path / "spec.toml").read_text().replace("J[b]*dot", "K*dot").replace("bond(i, j, b) of cells", "edge(i, j, K) of g").replace("J[b]*w", "K*w")
    (tmp_path / "graph.toml").write_text(text + '[graphs.g]\nfile = "edges.csv"\n')
    pair = [smidgen.build(one, parameters=given).start("random", h=0.05).steps(10).w for one, given in ((spec, {"J": J}), (smidgen.load(tmp_path / "graph.toml"), {}))]
    assert np.abs(pair[0] - pair[1]).max() <= 1e-13


@pytest.mark.parametrize("compiler, how", MODES)
def test_no_compiler_warns(tmp_path, compiler, how):
    for place, energy in (("honeycomb", ENERGY), ("open", "J[b]*dot(w[i], w[j])")):
        files = generate(spec_of(tmp_path, place, energy))
        for name, text in files.items():
            (tmp_path / name).write_text(text)
        assert not compile_all(tmp_path, [f for f in files if f.endswith(".c")], compiler, how=how)


def refused(spec_text, folder, place="open", **how) -> str:
    with pytest.raises(smidgen.SpecError) as told:
        spec_of(folder, place, spec_text, **how)
    return str(told.value)


def test_what_does_not_fit_is_told(tmp_path):
    said = refused(ENERGY, tmp_path, size="2*nx*ny")
    assert "spec.toml" in said and "`J` has 30 numbers for 22 bonds" in said and 'size = "(nx - 1)*ny + nx*(ny - 1)"' in said
    assert "`D`" in said        # its file has 22 rows
    assert "`b` is the number of a bond, not of a site" in refused("dot(w[i], w[b])", tmp_path)
    assert "takes the values 1 to 22" in refused("J[b + 1]*dot(w[i], w[j])", tmp_path)
    text = (tmp_path / "spec.toml").read_text().replace("bond(i, j, b) of cells\"\nenergy = \"J[b + 1]", "bond(i, j, k, b) of cells\"\nenergy = \"J[b]")
    with pytest.raises(smidgen.SpecError, match="these bonds join 2 sites, but 4 indices are given"):
        smidgen.load_text(text, path=tmp_path / "spec.toml")
    spec = spec_of(tmp_path, "open", "J[b]*dot(w[i], w[j])", size="22 + 0*nx")
    with pytest.raises(smidgen.UsageError, match="22 numbers for 17 bonds"):
        smidgen.build(spec, parameters={"nx": 4, "D": np.zeros(66)})


def test_sizes_are_compared_in_c_too(tmp_path):
    text = generate(spec_of(tmp_path, "open", "J[b]*dot(w[i], w[j])", size="22 + 0*nx"))["numbered.c"]
    assert re.search(r"-1.0 \+ \(smg_real\)model->n1\*\(-1.0 \+ .* < \(double\)\(smg_real\)model->n3\)\) return SMG_BAD_PARAMETER", text)


def test_a_hole_takes_its_bonds_with_it_and_leaves_the_numbers(tmp_path):
    spec, J = spec_of(tmp_path, "open"), numbers("open")
    (tmp_path / "spec.toml").write_text((tmp_path / "spec.toml").read_text() + '[effects.holes]\nover = "site(i) of w"\nabsent = "i == 7"\n')
    spec, ends = smidgen.load(tmp_path / "spec.toml"), written_out("open")
    model = smidgen.build(spec, parameters={"J": J}).start("random", h=0.05)
    left = ~(ends == 7).any(1)
    v, w = model.w[ends[left, 0]], model.w[ends[left, 1]]
    assert abs(Witness(spec, parameters={"J": J}).observables(model.w)["sum"] - np.sum(J[left] * v[:, 0] * w[:, 1])) <= 1e-13
    assert abs(model.values()[-1] - np.sum(J[left] * v[:, 0] * w[:, 1])) <= 1e-13
    found = Witness(spec, parameters={"J": J}).steps(model.w.copy(), 0.0, 0.05, 5)[-1]
    assert np.abs(model.steps(5).w - found).max() <= 2e-14


def test_a_torque_on_bonds_has_their_numbers(tmp_path):
    spec = spec_of(tmp_path, "half open")
    (tmp_path / "spec.toml").write_text((tmp_path / "spec.toml").read_text() + '[effects.push]\nover = "bond(i, j, b) of cells"\ntorque = "0.1*(J[b] + normal(5, b))*cross(w[i], w[j])"\n')
    spec, J = smidgen.load(tmp_path / "spec.toml"), numbers("half open")
    model = smidgen.build(spec, parameters={"J": J}).start("random", h=0.05)
    found = Witness(spec, parameters={"J": J}).steps(model.w.copy(), 0.0, 0.05, 5)[-1]
    assert np.abs(model.steps(5).w - found).max() <= 2e-14
