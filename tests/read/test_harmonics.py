"""Spherical harmonics of formulas beside those of SciPy."""
import numpy as np
import pytest
from scipy.special import sph_harm_y

import smidgen
from smidgen.errors import SpecError
from smidgen.check.witness import Witness
from smidgen.language import codes, limits

TEXT = """
[model]
name = "flow"

[space]
p = {{ sphere = 4 }}

[parameters]
a = {{ default = {a}, size = {size} }}

[effects.flow]
over = "site(i) of p"
energy = "{energy}"
"""
# what SciPy's orthonormal harmonics are multiplied by, at degree l
FACTORS = {"orthonormal_harmonics": lambda l: 1, "geodesy_harmonics": lambda l: np.sqrt(4 * np.pi), "schmidt_harmonics": lambda l: np.sqrt(4 * np.pi / (2 * l + 1))}


def spec_of(a, energy: str, size=None):
    return smidgen.load_text(TEXT.format(a=list(map(float, a)), energy=energy, size=size or len(a)))


def expected(function: str, a, w) -> np.ndarray:
    """At each w: the real harmonics without (-1)^m."""
    theta, phi = np.arccos(w[:, 2]), np.arctan2(w[:, 1], w[:, 0])
    total, degree = np.zeros(len(w)), int(np.sqrt(len(a))) - 1
    for l in range(degree + 1):
        for m in range(-l, l + 1):
            Y = (-1) ** m * sph_harm_y(l, abs(m), theta, phi) * (np.sqrt(2) if m else 1) * FACTORS[function](l)
            total += a[l * l + l + m] * (Y.imag if m < 0 else Y.real)
    return total


def sites(seed: int, count: int = 4) -> np.ndarray:
    w = np.random.default_rng(seed).standard_normal((count, 3))
    return w / np.linalg.norm(w, axis=1)[:, None]


@pytest.mark.quick
@pytest.mark.parametrize("function", FACTORS)
@pytest.mark.parametrize("degree", (0, 1, 5))
def test_they_are_those_of_scipy(function, degree):
    a, w = np.random.default_rng(degree).standard_normal((degree + 1) ** 2), sites(3)
    found = Witness(spec_of(a, f"{function}(a, p[i])")).energy(w, 0)
    assert found == pytest.approx(expected(function, a, w).sum(), rel=0, abs=1e-13)


def test_each_entry_is_one_harmonic_to_the_largest_degree():
    size, w = (limits.HARMONICS + 1) ** 2, sites(4)
    for k in range(size):
        a = np.eye(size)[k]
        found = Witness(spec_of(a, "orthonormal_harmonics(a, p[i])")).energy(w, 0)
        assert found == pytest.approx(expected("orthonormal_harmonics", a, w).sum(), rel=0, abs=1e-11)


def test_the_c_has_their_slopes_and_takes_other_coefficients():
    a, w, step = np.random.default_rng(1).standard_normal(16), sites(5), 1e-6
    spec = spec_of(a, "cos(t)*orthonormal_harmonics(a, p[i])")
    model = smidgen.build(spec).start(w, h=0.1)
    assert model.energy() == pytest.approx(expected("orthonormal_harmonics", a, w).sum(), rel=0, abs=1e-13)
    slopes = [[(Witness(spec).energy(w + step * e, 0) - Witness(spec).energy(w - step * e, 0)) / (2 * step)
               for e in np.eye(12)[3 * k:3 * k + 3].reshape(3, 4, 3)] for k in range(4)]
    assert np.cross(w, model.field()) == pytest.approx(np.cross(w, slopes), rel=0, abs=1e-8)
    other = smidgen.build(spec, parameters={"a": 2 * a}).start(w, h=0.1)
    assert other.energy() == pytest.approx(2 * model.energy(), rel=1e-14)


@pytest.mark.quick
@pytest.mark.parametrize("energy, size, a, code", [
    ("orthonormal_harmonics(a, p[i])", 3, [1] * 3, codes.COUNT),
    ("orthonormal_harmonics(a, p[i])", (limits.HARMONICS + 2) ** 2, [0], codes.COUNT),
    ("orthonormal_harmonics(a)", 4, [1] * 4, codes.ARITY),
    ("orthonormal_harmonics(a, 2)", 4, [1] * 4, codes.KIND),
    ("orthonormal_harmonics(2, p[i])", 4, [1] * 4, codes.KIND),
    ("orthonormal_harmonics(b, p[i])", 4, [1] * 4, codes.UNKNOWN_NAME),
    ("orthonormal_harmonic(a, p[i])", 4, [1] * 4, codes.UNKNOWN_NAME),
], ids=("no square", "too many", "one argument", "no vector", "no array", "not declared", "misspelt"))
def test_what_they_refuse(energy, size, a, code):
    a = a * size if len(a) == 1 else a
    with pytest.raises(SpecError) as caught:
        spec_of(a, energy, size)
    assert [d.code for d in caught.value.diagnostics] == [code]


@pytest.mark.quick
def test_a_size_that_is_a_formula_is_refused():
    with pytest.raises(SpecError, match="16 for degrees 0 to 3"):
        smidgen.load_text(TEXT.format(a=1.0, size='"n"', energy="schmidt_harmonics(a, p[i])").replace("[effects", "n = 4\n\n[effects"))


@pytest.mark.quick
def test_their_names_stay_free():
    spec = smidgen.load_text(TEXT.format(a=[2.0], size=1, energy="schmidt_harmonics*a[0]*p[i].z").replace("[effects", "schmidt_harmonics = 3.0\n\n[effects"))
    assert Witness(spec).energy(sites(1), 0) == pytest.approx(6 * sites(1)[:, 2].sum())
