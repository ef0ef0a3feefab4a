"""The lattice of a family, and what a state on it tells: topological charge, magnetisation, correlation."""
import numpy as np
import pytest
import smidgen
from smidgen.run.step import block
from smidgen.run.fields.grid import Grid
from support.lattices import FILM, HONEY, random_spins

pytestmark = pytest.mark.quick


def test_the_lattice_of_a_family():
    film = smidgen.load_text(FILM)
    result = smidgen.run(film)
    assert smidgen.lattice.of(film) == smidgen.lattice.of(result) == Grid((5, 3), (True, False))
    assert smidgen.lattice.of(film, parameters={"nx": 7}).count == 21
    assert smidgen.lattice.of(smidgen.load_text(HONEY)) == Grid((5, 3), (True, True), 2)
    assert smidgen.lattice.of(smidgen.load("j1j2_chain")).size == (60,)
    with pytest.raises(smidgen.UsageError, match="no lattice joins the sites of"):
        smidgen.lattice.of(smidgen.load("point_vortices"))
    with pytest.raises(smidgen.UsageError, match="film has no family 'v'"):
        smidgen.lattice.of(film, "v")


def test_positions_are_cells_and_fractions_of_their_diagonal():
    assert Grid((2, 2), (True, True)).positions().tolist() == [[0, 0], [1, 0], [0, 1], [1, 1]]
    assert Grid((2, 1), (True, True), 2).positions().tolist() == [[0, 0], [.5, .5], [1, 0], [1.5, .5]]
    assert Grid((2,), (True,), 2).positions([[0], [0.25]]).tolist() == [[0], [.25], [1], [1.25]]


def skyrmion(n, radius, turns=1, inside=-1.0):
    """w = inside*z at the middle of n x n cells, -inside*z from `radius` on, turning around the middle."""
    c = np.arange(n) - n / 2 + 0.31     # no spin at the very middle
    y, x = np.meshgrid(c, c, indexing="ij")
    theta, phi = np.pi * np.clip(np.hypot(x, y) / radius, 0, 1), turns * np.arctan2(y, x)
    w = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), inside * np.cos(theta)], -1)
    return w.reshape(-1, 3)


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)


@pytest.mark.parametrize("turns, inside, q", [(1, -1.0, -1), (-1, -1.0, 1), (1, 1.0, 1), (2, -1.0, -2)])
@pytest.mark.parametrize("periodic", [True, False])
def test_the_charge_of_a_skyrmion_is_an_integer_in_every_frame(turns, inside, q, periodic):
    grid, w = Grid((24, 24), (periodic, periodic)), skyrmion(24, 9, turns, inside)
    states = np.stack([w] + [w @ rotation(seed).T for seed in range(5)])
    found = smidgen.lattice.charge(2.5 * states, grid)
    assert found.shape == (6,) and np.abs(found - q).max() < 1e-12
    assert np.array_equal(found, np.rint(found)) or not periodic


def test_the_charge_of_other_textures():
    grid = Grid((8, 5), (True, True))
    assert smidgen.lattice.charge(np.tile([0.0, 0, 1], (40, 1)), grid) == 0
    assert float(smidgen.lattice.charge(random_spins(40), grid)).is_integer()
    assert np.isnan(smidgen.lattice.charge(np.zeros((40, 3)), grid))
    octant = np.array([[1.0, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1]])     # corners x, y, z, x: an eighth of the sphere
    assert smidgen.lattice.charge(octant, Grid((2, 2), (False, False))) == pytest.approx(1 / 8, abs=1e-15)
    for bad in (Grid((40,), (True,)), Grid((2, 2, 10), (True,) * 3), Grid((4, 5), (True, True), 2)):
        with pytest.raises(smidgen.UsageError, match="two-dimensional"):
            smidgen.lattice.charge(random_spins(40), bad)
    with pytest.raises(smidgen.UsageError, match="shape"):
        smidgen.lattice.charge(random_spins(39), grid)


def test_the_correlation_is_the_sum_that_it_stands_for():
    grid, w = Grid((5, 3), (True, True)), random_spins(15)
    a = grid.cells(w)[..., 0, :]
    direct = [[np.mean(np.sum(a * np.roll(a, (-y, -x), (0, 1)), -1)) for x in range(5)] for y in range(3)]
    np.testing.assert_allclose(smidgen.lattice.correlation(np.stack([w, w]), grid), [direct, direct], atol=1e-14)
    np.testing.assert_allclose(smidgen.lattice.magnetisation(w), w.mean(axis=0), atol=1e-15)
    for wrong in (w[0], w[:, :2], w[:0], 3.0, "w"):
        with pytest.raises(smidgen.UsageError, match=r"states must have shape \(.., N, 3\), not"):
            smidgen.lattice.magnetisation(wrong)
    with pytest.raises(smidgen.UsageError, match="periodic"):
        smidgen.lattice.correlation(w, Grid((5, 3), (True, False)))


# As outputs of a run

@pytest.mark.parametrize("ending", [".csv", ".npz", ".h5"])
def test_outputs_that_a_run_names(tmp_path, ending):
    film = smidgen.load_text(FILM.replace("periodic, open", "periodic").replace('["states"]', '["charge", "magnetisation"]'))
    states = smidgen.run(film, what=["states"]).w["w"]
    smidgen.run(film, out=tmp_path / f"a{ending}", checkpoint=4)
    found = smidgen.load_result(tmp_path / f"a{ending}")
    assert sorted(found.values) == ["charge.w", "magnetisation.w"] and found.w is None
    assert np.array_equal(found.values["charge.w"], smidgen.lattice.charge(states, Grid((5, 3), (True, True))))
    assert np.array_equal(found.values["magnetisation.w"], states.mean(axis=1))


@pytest.mark.parametrize("ending", [".csv", ".npz", ".h5"])
def test_outputs_of_large_states_are_written_one_by_one(tmp_path, monkeypatch, ending):
    """Buffers that hold one output of them are empty at the end."""
    film = smidgen.load_text(FILM)
    wanted = smidgen.run(film, what=["magnetisation", "energy"])
    monkeypatch.setattr(block, "MOST", 1)
    smidgen.run(film, what=["magnetisation", "energy"], out=tmp_path / f"a{ending}")
    found = smidgen.load_result(tmp_path / f"a{ending}")
    assert sorted(found.values) == sorted(wanted.values) and all(np.array_equal(found.values[n], v) for n, v in wanted.values.items())


def test_magnetisations_are_drawn_among_the_observables(tmp_path):
    result = smidgen.run(smidgen.load_text(FILM), what=["magnetisation"])
    assert smidgen.plot(result, kind="observables", out=tmp_path / "a.png").exists()
    with pytest.raises(smidgen.UsageError, match="no observables"):
        smidgen.plot(smidgen.run(smidgen.load_text(FILM), what=["energy"]), kind="observables", out=tmp_path / "b.png")


def test_outputs_with_other_columns_and_in_extended_precision():
    film = smidgen.load_text(FILM)
    found = smidgen.run(film, what=["states", "charge", "energy"], real="long double")
    np.testing.assert_allclose(np.float64(found.values["charge.w"]), smidgen.lattice.charge(found.w["w"], Grid((5, 3), (True, False))), atol=1e-15)


def test_a_charge_needs_a_film_and_an_observable_of_its_name_goes_first():
    for text in (FILM.replace("square(nx, ny, periodic, open)", "chain(nx*ny, periodic)"), HONEY):
        with pytest.raises(smidgen.UsageError, match="film has no topological charge, which requires a family"):
            smidgen.run(smidgen.load_text(text), what=["charge"])
    own = smidgen.load_text(FILM + '[observables.charge]\nover = "site(i) of w"\nvalue = "1.0"\n')
    assert sorted(smidgen.run(own, what=["charge"]).values) == ["charge"]
    with pytest.raises(smidgen.SpecError, match="did you mean `charge`"):
        smidgen.load_text(FILM.replace('"states"', '"chrge"'))


def test_the_charge_over_time_is_drawn(tmp_path):
    result = smidgen.run(smidgen.load_text(FILM), what=["charge"])
    assert smidgen.plot(result, kind="observables", out=tmp_path / "a.png").exists()
