"""Waves of lattices with several sites a cell: their frequencies at wave vectors that have names, and where sites stand."""
import numpy as np
import pytest

import smidgen
from smidgen.analyse.waves import name_of, waves
from smidgen.errors import UsageError

SPEC = """
[model]
name = "m"
[space]
w = {{ sphere = "{sites}*{cells}" }}
[parameters]
n = {n}
[effects.exchange]
over = "bond(i, j) of {lattice}"
energy = "-dot(w[i], w[j])"
"""


H = 0.05


def magnet(name: str, sites: int, n: int, dimension: int):
    size = ", ".join(["n"] * dimension)
    return smidgen.load_text(SPEC.format(lattice=f"{name}({size}, periodic)", sites=sites, cells="*".join(["n"] * dimension), n=n))


def lowest_modes(spec, q, count: int, seed: int = 1):
    """Frequencies of the ferromagnet at a wave, from a run near the z axis: the strongest lines of x, above 0.02 of the strongest."""
    w = np.array([0, 0, 1.0]) + 0.01 * np.random.default_rng(seed).standard_normal((count, 3)) * [1, 1, 0]
    w /= np.linalg.norm(w, axis=1)[:, None]
    found = smidgen.spectrum(spec, start=w, h=H, time=120, every=4, q=q, window="hann", method="spherical-midpoint")
    power = found.s[:, :, 0]
    step = found.omega[1] - found.omega[0]
    at = [found.omega[[k for k in range(1, len(row) - 1) if row[k] > 0.01 * row.max() and row[k] >= row[k - 1] and row[k] >= row[k + 1]]] for row in power]
    return found, [np.unique(np.round(np.abs(x) / step).astype(int)) * step for x in at], step


def everywhere(spec, name: str, count: int):
    """(frequencies of a corner of the zone, in this zone and in others, where structure factors differ; the step of frequencies)."""
    corner, = waves(smidgen.lattice.of(spec), name) / np.array(smidgen.lattice.of(spec).size)
    shifts = np.indices((2,) * len(corner)).reshape(len(corner), -1).T
    _, lines, step = lowest_modes(spec, corner + shifts, count)
    return np.unique(np.concatenate(lines)), step


def near(lines, wanted, step) -> bool:
    """Is each line at one of the frequencies, and each frequency among the lines?"""
    return all(min(abs(x - y) for y in wanted) <= step for x in lines) and all(min(abs(x - y) for x in lines) <= step for y in wanted)


@pytest.mark.parametrize("name, sites, n, corner, wanted", [
    ("honeycomb", 2, 6, "Gamma", [0, 6]), ("honeycomb", 2, 6, "K", [3]), ("honeycomb", 2, 6, "M", [2, 4]),
    ("kagome", 3, 6, "K", [3, 6]), ("kagome", 3, 6, "M", [2, 4, 6]),
    pytest.param("pyrochlore", 4, 4, "X", [4, 8], marks=pytest.mark.long), pytest.param("pyrochlore", 4, 4, "L", [2, 6, 8], marks=pytest.mark.long)])
def test_waves_of_ferromagnets_are_at_the_right_q(name, sites, n, corner, wanted):
    """omega = 3 -+ |1 + exp(i q.a_1) + exp(i q.(a_1 + a_2))| on the honeycomb; on kagome 6 everywhere, beside 3 -+ sqrt(1 + 8 c_1 c_2 c_3) with c_k = cos(q.d_k),
    d_k the three vectors to neighbours; on pyrochlore 8 twice, beside 4 -+ 2 sqrt(1 + c_xy + c_yz + c_zx), c_xy = cos(Q_x/2) cos(Q_y/2).
    A step h of the midpoint method turns by 2 atan(h omega/2)."""
    dimension = 3 if name == "pyrochlore" else 2
    lines, step = everywhere(magnet(name, sites, n, dimension), corner, sites * n ** dimension)
    assert near(lines, [2 / H * np.arctan(H * omega / 2) for omega in wanted], step), lines


def test_waves_in_space_are_multiples_of_reciprocal_vectors():
    """The corner K of the honeycomb is at 4 pi/3 from Gamma, M at 2 pi/sqrt(3)."""
    found, _, _ = lowest_modes(magnet("honeycomb", 2, 6, 2), "K Gamma M", 72)
    length = dict(zip(found.names, np.linalg.norm(found.wave_vectors, axis=1)))
    assert length["K"] == pytest.approx(4 * np.pi / 3) and length["M"] == pytest.approx(2 * np.pi / np.sqrt(3))


def test_components_see_where_sites_stand():
    """A wave over all sites by their places is at its q alone, whatever lattice they are on."""
    from smidgen.analyse.waves import Components
    spec = magnet("kagome", 3, 6, 2)
    grid = smidgen.lattice.of(spec)
    r = grid.where() @ grid.reciprocal().T / (2 * np.pi)
    m = waves(grid, "all")
    w = np.zeros((108, 3))
    w[:, 0] = np.cos(2 * np.pi * r @ [1 / 3, 1 / 6])
    power = np.abs(Components(grid, m).of(w)[:, 0]) ** 2
    strongest = m[np.argsort(power)[-2:]]
    assert sorted(map(tuple, strongest.tolist())) == [(-2, -1), (2, 1)]
    assert power.max() == pytest.approx(108 / 4)


def test_corners_that_are_refused():
    grid = smidgen.lattice.of(magnet("honeycomb", 2, 4, 2))
    with pytest.raises(UsageError, match="has no point 'R'; it has: .*Gamma, M, K"):
        waves(grid, "Gamma R")
    with pytest.raises(UsageError, match="is not a wave vector of 4 cells"):
        waves(grid, "Gamma K")
    assert name_of(grid, [2, 0]) == "M"


def test_a_spectrum_keeps_its_zone_in_files(tmp_path):
    found, _, _ = lowest_modes(magnet("honeycomb", 2, 3, 2), "Gamma K", 18)
    again = smidgen.load_spectrum(found.save(tmp_path / "waves.npz"))
    assert again.names == found.names == ["Gamma", "K"]
    np.testing.assert_array_equal(again.wave_vectors, found.wave_vectors)
