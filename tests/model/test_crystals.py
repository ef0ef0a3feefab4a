"""Couplings from arrays, sparse matrices and files; sites and bonds from atoms."""
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.io
import scipy.sparse

import smidgen
from smidgen.check.witness import Witness
from smidgen.errors import UsageError
from smidgen.language.places import bond_vectors, bonds, positions
from smidgen.model import Model
from smidgen.run.step.evaluated import Evaluated


def symmetric(n=7, seed=1):
    J = np.random.default_rng(seed).standard_normal((n, n)) * (np.random.default_rng(seed + 1).random((n, n)) < 0.5)
    return np.triu(J, 1) + np.triu(J, 1).T


def glass(couplings, n=7, **more):
    model = Model("glass")
    w = model.sphere("w", n)
    i, j = model.indices("i j")
    model.graph("g", couplings, **more)
    model.effect("exchange", over="edge(i, j, J) of g", energy="-J*dot(w[i], w[j])")
    model.start("random", random=1)
    return model


FORMS = {"dense": lambda J: J, "upper": np.triu, "csr": scipy.sparse.csr_matrix, "coo": lambda J: scipy.sparse.coo_array(np.tril(J)),
         "rows": lambda J: np.array([(i, j, J[i, j]) for i, j in np.argwhere(np.triu(J))])}


@pytest.mark.parametrize("form", FORMS)
def test_a_matrix_of_couplings_is_the_energy_that_it_says(form):
    J = symmetric()
    spec = glass(FORMS[form](J)).spec()
    w = smidgen.run(spec, start="random", h=0.1, steps=1).final
    assert Witness(spec).energy(w) == pytest.approx(-np.sum(np.triu(J) * (w @ w.T)), abs=1e-14)


@pytest.mark.parametrize("name", ["J.npz", "J.mtx", "J.npy"])
def test_a_matrix_may_come_from_a_file(tmp_path, name):
    J = symmetric()
    {".npz": lambda p: scipy.sparse.save_npz(p, scipy.sparse.csr_matrix(J)), ".mtx": lambda p: scipy.io.mmwrite(p, scipy.sparse.coo_matrix(J), precision=17),
     ".npy": lambda p: np.save(p, J)}[name[1:]](tmp_path / name)
    assert glass(tmp_path / name).to_toml() == glass(J).to_toml()


def test_large_matrices_go_to_a_file_beside_the_spec(tmp_path):
    J = symmetric(60)
    model = glass(scipy.sparse.csr_matrix(J), 60, positions=np.random.default_rng(3).random((60, 3)))
    with pytest.raises(UsageError, match="in a separate file"):
        model.to_toml()
    spec = smidgen.load(model.save(tmp_path / "glass.toml"))
    assert (tmp_path / "glass_g.csv").exists() and spec.effects == model.spec().effects
    assert len(spec.effects[0].over.edges) == np.count_nonzero(np.triu(J))
    assert positions(spec, "w", Evaluated(spec).values).shape == (60, 3)


@pytest.mark.parametrize("couplings, said", [
    (np.zeros((4, 4)), "all 0"), (np.eye(4), "site 0 to itself"), (np.ones((3, 4, 2)), "square matrix"), (scipy.sparse.csr_matrix(np.ones((2, 3))), "square matrix, not one of 2 x 3"),
    (np.array([[0, 1.0], [2.0, 0]]), "not symmetric: 1 and 2"), ("none.npz", "cannot read"), ("a.txt", "couplings must be in")])
def test_couplings_that_are_refused(couplings, said):
    with pytest.raises(UsageError, match=said):
        glass(couplings)


def atoms(cell, fractions, symbols, pbc=True):
    """As ASE has them."""
    return SimpleNamespace(cell=np.array(cell, float), pbc=pbc, get_scaled_positions=lambda wrap=True: np.array(fractions, float), get_chemical_symbols=lambda: list(symbols))


ROCK_SALT = atoms(4.2 * np.eye(3), [[0, 0, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 1], [0.5, 0.5, 0.5], [0.5, 0, 0], [0, 0.5, 0], [0, 0, 0.5]], ["Mn"] * 4 + ["O"] * 4)


def test_atoms_of_one_element_with_couplings_by_shell():
    """Manganese in MnO is a face-centred lattice: 12 neighbours at a/sqrt(2), 6 at a."""
    model = Model("mno")
    model.crystal("mno", ROCK_SALT, (3, 3, 3), [-0.4, -0.9], cutoff=4.3, elements="Mn")
    spec = model.spec()
    assert spec.effect_names == ("mno_first", "mno_second")
    values = Evaluated(spec).values
    assert positions(spec, "w", values).shape == (108, 3)
    assert np.bincount(bonds(spec, "w", values).ravel()).tolist() == [18] * 108
    lengths = np.linalg.norm(bond_vectors(spec, "w", values), axis=1)
    np.testing.assert_allclose(np.sort(lengths), [4.2 / np.sqrt(2)] * 648 + [4.2] * 324)
    up = np.tile([0, 0, 1.0], (108, 1))
    assert Witness(spec).energies(up) == {"mno_first": pytest.approx(0.4 * 648), "mno_second": pytest.approx(0.9 * 324)}


def test_directions_that_are_not_periodic_are_open():
    model = Model("film")
    model.crystal("film", atoms(np.diag([3, 3, 20]), [[0, 0, 0.5]], ["Co"], (True, False, False)), (4, 4, 1), [1.0])
    spec = model.spec()
    assert spec.effects[0].over.periodic == (True, False, False) and len(bonds(spec, "w", Evaluated(spec).values)) == 16 + 12


@pytest.mark.parametrize("given, said", [
    (dict(elements="Fe"), "no atoms of Fe; there are: Mn, O"), (dict(couplings=[1, 1], cutoff=4), "second shell of 'x' is at 4.2, beyond the cutoff 4"),
    (dict(couplings=[1] * 9), "9 couplings"), (dict(atoms=7), "not a int"), (dict(atoms="none.cif"), "cannot read|needs the package")])
def test_atoms_that_are_refused(given, said):
    says = {"atoms": ROCK_SALT, "couplings": [1.0], "elements": "Mn", **given}
    with pytest.raises((UsageError, smidgen.MissingTool), match=said):
        Model("m").crystal("x", says.pop("atoms"), (2, 2, 2), says.pop("couplings"), **says)


def test_ase_and_a_cif(tmp_path):
    build = pytest.importorskip("ase.build")
    iron = build.bulk("Fe", cubic=True)
    iron.write(tmp_path / "iron.cif")
    for source in (iron, tmp_path / "iron.cif"):
        model = Model("iron")
        model.crystal("fe", source, (3, 3, 3), [1.0, 0.5])
        assert np.bincount(bonds(model.spec(), "w", {}).ravel()).tolist() == [14] * 54


def slab(heights, pbc=(True, True, False)):
    """Atoms one above the other, at these heights in a cell of height 20."""
    found = np.array([(0, 0, z / 20) for z in heights])
    return SimpleNamespace(cell=np.diag([5.0, 5.0, 20.0]), pbc=pbc, get_scaled_positions=lambda wrap: found, get_chemical_symbols=lambda: ["Fe"] * len(found))


@pytest.mark.parametrize("heights", [(9.5, 10.5), (-0.5, 0.5), (19.5, 20.5), (-19.0, -20.0), (-10.5, -9.5)])
def test_atoms_keep_their_distances_along_an_open_direction(heights):
    model = Model("slab")
    model.crystal("c", slab(heights), (3, 3, 1), (1.0,))
    spec = model.spec()
    there = positions(spec, "w", Evaluated(spec).values)
    assert np.ptp(there[:, 2]) == pytest.approx(1, abs=1e-9)
    assert Witness(spec).energy(np.tile([0, 0, 1.0], (18, 1))) == -9


def test_a_shell_beyond_open_ends_is_refused():
    """Of a layer whose cell is lower than it is wide the nearest atoms are above and below, where there are none."""
    layer = SimpleNamespace(cell=np.diag([5.0, 5.0, 3.0]), pbc=(True, True, False), get_scaled_positions=lambda wrap: np.array([[0, 0, 0.5]]), get_chemical_symbols=lambda: ["Fe"])
    with pytest.raises(UsageError, match="the first shell of 'c', at 3, has no bonds"):
        Model("layer").crystal("c", layer, (3, 3, 1), (1.0,))
    for size in ((3, 3, 2), (3, 3, "n")):
        model = Model("layer")
        model.parameter("n", 2)
        model.crystal("c", layer, size, (1.0,))
        assert Witness(model.spec()).energy(np.tile([0, 0, 1.0], (18, 1))) == -9


def test_atoms_beyond_one_cell_of_an_open_direction_are_refused():
    with pytest.raises(UsageError, match="the atoms of 'c' extend beyond one cell along vector 3, which is not periodic"):
        Model("slab").crystal("c", slab((-1.0, 20.0)), (3, 3, 1), (1.0,))
