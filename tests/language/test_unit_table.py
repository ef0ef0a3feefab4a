"""The table of units against pint, SciPy's CODATA and the constants of the literature; the grammar of units and its limits."""
import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.constants import physical_constants

from smidgen.errors import SpecError
from smidgen.language import codes, limits
from smidgen.language.unit_table import CODATA, PLAIN, PREFIXED, PREFIXES, size_of
from smidgen.language.units import ACTION, ENERGY, FIELD, LENGTH, MOMENT, NONE, TIME, Scale, Units, coherent, quotient, spelt_of, unit
from smidgen.read.problems import Bad, Problems
from smidgen.read.source import Source, Text
from smidgen.read.units import unit_of

pytestmark = pytest.mark.quick

# where pint has another name, or, for temperatures and the oersted, another quantity
IN_PINT = {"K": "(kelvin * boltzmann_constant)", "Oe": "(oersted_in_tesla)", "G": "(1e-4 tesla)", "emu": "(1e-3 ampere * meter^2)", "mu_B": "bohr_magneton", "mu_N": "nuclear_magneton",
           "a_0": "bohr", "m_e": "electron_mass", "u": "unified_atomic_mass_unit", "k_B": "(kelvin/kelvin)", "c": "speed_of_light", "mu_0": "vacuum_permeability", "d": "day",
           "h": "hour", "min": "minute", "gamma": "(2 * bohr_magneton/hbar)", "gamma_e": "(1.76085962784e11 /second/tesla)", "Ry": "(rydberg_constant * planck_constant * speed_of_light)",
           "Ha": "hartree", "rpm": "(pi/30 /second)", "turn": "(2 * pi)", "deg": "(pi/180)", "arcmin": "(pi/10800)", "arcsec": "(pi/648000)", "rad": "(meter/meter)",
           "g": "gram", "m": "meter", "s": "second", "T": "tesla", "J": "joule", "A": "ampere", "Hz": "hertz", "N": "newton", "Pa": "pascal", "W": "watt", "C": "coulomb",
           "V": "volt", "Wb": "weber", "H": "henry", "dyn": "dyne", "hbar": "hbar"}
NAMES = sorted({*PLAIN, *PREFIXED})


@pytest.fixture(scope="module")
def pint_units():
    registry = pytest.importorskip("pint").UnitRegistry()
    registry.define("oersted_in_tesla = 1e-4 * tesla")
    return registry


def read(text: str):
    """A unit from its text; SpecError where it is none."""
    problems = Problems(Source(text, "unit"))
    try:
        found = unit_of(Text(text, tuple(range(len(text) + 1))), problems)
    except Bad:
        problems.finish()
    return found


def in_pint(registry, name: str):
    """The same unit, in SI."""
    prefix = next((p for p in PREFIXES if name.startswith(p) and name[len(p):] in PREFIXED), "") if name not in {*PLAIN, *PREFIXED} else ""
    stem = name[len(prefix):]
    return (float(PREFIXES.get(prefix, 1)) * registry(IN_PINT.get(stem, stem))).to_base_units()


def agree(mine, theirs) -> None:
    """Size and dimension: J^a s^b m^c T^d is kg^a m^(2a) .., T = kg/(A s^2)."""
    a, b, c, d = mine.dimension
    powers = {"[mass]": a + d, "[length]": 2 * a + c, "[time]": -2 * a + b - 2 * d, "[current]": -d}
    assert {k: v for k, v in powers.items() if v} == {k: Fraction(v).limit_denominator(100) for k, v in theirs.dimensionality.items()}
    assert float(mine.factor) == pytest.approx(float(theirs.magnitude), rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_every_name_is_what_pint_says(pint_units, name):
    agree(unit(name), in_pint(pint_units, name))


FACTORS = st.lists(st.tuples(st.sampled_from(NAMES), st.sampled_from(["", *PREFIXES]), st.integers(-3, 3).filter(bool)), min_size=1, max_size=5)


@settings(max_examples=100, deadline=None)
@given(FACTORS)
def test_compound_units_are_what_pint_says(pint_units, factors):
    factors = [((prefix if name in PREFIXED and prefix + name not in PLAIN else "") + name, k) for name, prefix, k in factors]
    theirs = math.prod((in_pint(pint_units, name)**k for name, k in factors), start=pint_units("meter/meter"))
    if 1e-250 < abs(theirs.magnitude) < 1e250:
        agree(read(" ".join(f"{name}^{k}" for name, k in factors)), theirs)
        agree(read(f"meV*{factors[0][0]}^{-factors[0][1]}/meV").__pow__(-1), in_pint(pint_units, factors[0][0])**factors[0][1])


MEASURED = {"mu_B": "Bohr magneton", "mu_N": "nuclear magneton", "mu_0": "vacuum mag. permeability", "m_e": "electron mass", "u": "atomic mass constant", "a_0": "Bohr radius",
            "gamma_e": "electron gyromag. ratio", "Ry": "Rydberg constant times hc in J", "Ha": "Hartree energy", "hbar": "reduced Planck constant", "K": "Boltzmann constant", "eV": "electron volt"}


@pytest.mark.parametrize("name", MEASURED)
def test_constants_are_those_of_codata_2022(name):
    assert CODATA == "2022" and float(size_of(name)[0]) == pytest.approx(physical_constants[MEASURED[name]][0], rel=1e-15)


def test_no_two_units_have_one_name():
    prefixed = [prefix + name for prefix in PREFIXES for name in PREFIXED]
    assert len(set(prefixed)) == len(prefixed) and {*prefixed} & {*PLAIN, *PREFIXED} == {"hbar"}       # hecto-bar is given up
    assert not {*prefixed, *NAMES} & {"x", "y", "z", "t", "pi", "and", "or", "not", "of", "on"}


@pytest.mark.parametrize("left, right, value", [     # hbar/meV in ps, mu_B in meV/T, k_B in meV/K, gamma(g = 2) in 1/(ps T), kappa of 1 mu_B in meV ps
    ("hbar/meV", "ps", 0.6582119569509), ("mu_B T", "meV", 0.05788381798194), ("K", "meV", 0.08617333262145),
    ("gamma", "ps^-1 T^-1", 0.175882000838), ("mu_B/gamma", "meV ps", 0.3291059784755)])
def test_constants_of_spin_dynamics(left, right, value):
    a, b = read(left), read(right)
    assert a.dimension == b.dimension and float(a.factor / b.factor) == pytest.approx(value, rel=1.5e-12)


def scale(text: str) -> Scale:
    return Scale(text, read(text))


def test_the_coherent_set():
    """What follows from what is named."""
    energy, time, length, field = coherent({"energy": scale("meV")})
    assert (time.text, field.text, length.text) == ("hbar/meV", "meV/mu_B", "m")
    assert Units((energy, time, length, field)).spelt(ACTION) == "hbar" and Units((energy, time, length, field)).spelt(MOMENT) == "mu_B"
    body = coherent({"angular_momentum": scale("N m s"), "time": scale("s")})
    assert body[0].text == "J" and body[0].unit == read("J")
    spin = coherent({"moment": scale("mu_B"), "field": scale("T")})
    assert spin[0].unit == read("mu_B T") and coherent({"length": scale("nm")}) is None


def test_dimensions_are_spelt_as_they_are_read():
    named = {kind: scale(text) for kind, text in (("energy", "meV"), ("time", "ps"), ("length", "nm"), ("field", "T"))}
    units = Units(coherent(named), tuple(named.items()))
    for dimension, text in ((ENERGY, "meV"), (ACTION, "meV ps"), (MOMENT, "meV/T"), (NONE, "1"), (quotient(NONE, TIME), "1/ps"),
                            (quotient(quotient(ENERGY, LENGTH), FIELD), "meV/nm/T"), (quotient(ENERGY, quotient(LENGTH, TIME)), "meV ps/nm")):
        assert units.spelt(dimension) == text and read(text).dimension == dimension
        assert read(text).factor == units.size(dimension)
    assert spelt_of((("meV", Fraction(1, 2)),)) == "meV^(1/2)"


@pytest.mark.parametrize("text, code", [
    ("", codes.SYNTAX), ("mev", codes.UNIT), ("qqq", codes.UNIT), ("meV)", codes.SYNTAX), ("meV^x", codes.SYNTAX), ("meV^1.5", codes.SYNTAX), ("meV/", codes.SYNTAX), ("2 3 meV", codes.SYNTAX),
    ("meV;", codes.CHARACTER), ("\u00b5T", codes.CHARACTER), ("\u00c5", codes.CHARACTER), ("__import__", codes.UNIT), ("0 meV", codes.NUMBER), ("-2 meV", codes.SYNTAX), ("1e999 meV", codes.NUMBER), ("(meV)", codes.SYNTAX), ("meV(s)", codes.SYNTAX)])
def test_what_is_no_unit_is_refused(text, code):
    with pytest.raises(SpecError) as caught:
        read(text)
    one, = caught.value.diagnostics
    assert one.code == code and one.cause and one.hint


@pytest.mark.parametrize("good, bad", [
    (f"m^{limits.UNIT_EXPONENT}", f"m^{limits.UNIT_EXPONENT + 1}"), ("m^12", "m^" + "9" * 60), (" ".join(["m"] * limits.UNIT_FACTORS), " ".join(["m"] * (limits.UNIT_FACTORS + 1))),
    ("m" + " " * (limits.UNIT - 1), "m" + " " * limits.UNIT)])
def test_units_are_bounded(good, bad):
    assert read(good)
    with pytest.raises(SpecError) as caught:
        read(bad)
    assert [one.code for one in caught.value.diagnostics] == [codes.LIMIT]
