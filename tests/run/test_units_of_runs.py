"""A run with units is the run in the numbers that follow from them."""
import re
from string import Template

import h5py
import numpy as np
import pytest
import smidgen
from scipy.constants import physical_constants

from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate

SCALED = """
[model]
name = "twos"

[space]
w = { sphere = "n", kappa = 2.0 }

[parameters]
n = 6
J = 1.25
B = { default = [0.5, 0.0, 2.0], vector = true }
tau = 8.0
mu = 0.5
gone = { default = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], size = "n" }

[effects.exchange]
over = "bond(i, j) of chain(n, periodic)"
energy = "-J*dot(w[i], w[j])"

[effects.field]
over = "site(i) of w"
energy = "-mu*dot(B, w[i])*exp(-((t - 4.0)/tau)^2) + gone[i]*w[i].x^2"

[effects.bath]
over = "site(i) of w"
damping = 0.1
kT = 0.25

[effects.drive]
over = "site(i) of w"
torque = "cross(w[i], cross(w[i], vec(0, 0, 0.125)))"

[observables.m]
over = "site(i) of w"
value = "mu*w[i].z"

[starts.up]
theta = 0.5
phi = "0.25*i"

[runs.demo]
start = "up"
h = 0.0625
time = 2.5
output = { period = 0.125, what = ["states", "energy", "momentum", "m"] }
"""

# the unit of energy is 4 meV, of time 0.5 ps, of field 8 T: every value is 2^k times what stands above
MEASURED = SCALED.replace("[space]", '[units]\nenergy = "4 meV"\ntime = "0.5 ps"\nfield = "8 T"\n\n[space]')
for old, new in (("kappa = 2.0", 'kappa = "4 meV ps"'), ("J = 1.25", 'J = "5 meV"'), ("default = [0.5, 0.0, 2.0], vector = true", 'default = [4, 0, "16 T"], unit = "T", vector = true'),
                 ("tau = 8.0", 'tau = "4000 fs"'), ("mu = 0.5", 'mu = "0.25 meV/T"'), ("[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]", '[4, 8, "0.012 eV", 16, 20, 24], unit = "meV"'),
                 ("t - 4.0", "t - 2 ps"), ("kT = 0.25", 'kT = "1 meV"'), ("0.125)))", "0.25 rad/ps)))"), ("h = 0.0625", 'h = "31.25 fs"'), ("time = 2.5", 'time = "1.25 ps"'),
                 ("period = 0.125", 'period = "62.5 fs"')):
    assert MEASURED.count(old) == 1, old
    MEASURED = MEASURED.replace(old, new)


@pytest.fixture(scope="module")
def both():
    return smidgen.load_text(SCALED), smidgen.load_text(MEASURED)


@pytest.mark.parametrize("method", ["spherical-midpoint", "gauss-4"])
def test_units_that_are_powers_of_two_apart_give_the_same_bits(both, method):
    plain, measured = (smidgen.run(spec, "demo", method=method, seed=3) for spec in both)
    for name in plain.values:
        assert np.array_equal(plain.values[name], measured.values[name]), name
    assert np.array_equal(plain.final, measured.final) and np.array_equal(plain.t, measured.t)
    assert not np.array_equal(plain.final, smidgen.run(both[0], "demo", method=method, seed=4).final)


def test_the_witness_takes_the_same_numbers(both):
    w = smidgen.run(both[0], "demo", steps=1).final
    plain, measured = (Witness(spec.calm) for spec in both)
    assert np.array_equal(plain.field(w, 0.5), measured.field(w, 0.5)) and plain.observables(w) == measured.observables(w)


def code(spec) -> str:
    """Without comments and the name of the spec."""
    return re.sub(r"/\*.*?\*/", "", "".join(text for name, text in generate(spec).items()), flags=re.DOTALL)


def test_the_c_is_that_of_the_scaled_numbers(both):
    assert code(both[0]) == code(both[1])


def test_the_header_names_the_units_of_all_arguments(both):
    plain, measured = (generate(spec)["twos.h"] for spec in both)
    assert "Units:" not in plain
    for line in (" * Units: t and h in 0.5 ps, energies in 4 meV; w in 1, its kappa in (4 meV) (0.5 ps), its momentum in (4 meV) (0.5 ps), its Casimirs in 1; m in (4 meV)/(8 T).",
                 "CODATA 2022: 4 meV = 6.408706536e-22 J, 0.5 ps = 5e-13 s, m = 1 m, 8 T = 8 T.", "double J; /* [4 meV] */", "const double *B; /* [8 T] */", "double tau; /* [0.5 ps] */"):
        assert line in measured


def test_results_have_the_units_of_their_columns(tmp_path, both):
    """Beside the numbers, in all formats."""
    what = ["states", "energy", "momentum", "casimirs", "m"]
    for name in ("a.h5", "a.csv", "a.npz"):
        smidgen.run(both[1], "demo", what=what, steps=2, every=1, out=tmp_path / name)
        units = smidgen.load_result(tmp_path / name).meta["units"]
        assert (units["codata"], units["energy"], units["field"]) == ("2022", "4 meV", "8 T")
        assert units["columns"] == {"t": "0.5 ps", "w": "1", "energy": "4 meV", "energy.exchange": "4 meV", "energy.field": "4 meV", "momentum.w": "(4 meV) (0.5 ps)", "casimirs": "1",
                                    "m": "(4 meV)/(8 T)"}
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["t"].attrs["units"] == "0.5 ps" and "units" not in file["final"].attrs
    pytest.importorskip("xarray")
    assert smidgen.load_result(tmp_path / "a.h5").to_xarray()["energy"].attrs["units"] == "4 meV"
    assert "# units: t 0.5 ps, w 1, energy 4 meV" in (tmp_path / "a.csv").read_text()
    assert smidgen.run(both[0], "demo", steps=2).meta["units"] is None


def test_means_are_told_in_their_units(tmp_path, both):
    """Also of what is no column, and of each component."""
    from smidgen.cli.run import mean_lines
    for what in ((), ["energy", "momentum", "m"]):
        meta = smidgen.run(both[1], "demo", what=what, steps=8, every=1, averages={"what": ["energy.field", "momentum.w.y", "m"]}, out=tmp_path / "a.h5").meta
        units = {"energy.field": "4 meV", "momentum.w.y": "(4 meV) (0.5 ps)", "m": "(4 meV)/(8 T)"}
        assert smidgen.load_result(tmp_path / "a.h5").meta["units"]["means"] == meta["units"]["means"] == units
        said = [*mean_lines(meta)]
        assert len(said) == 3 and all(f"{meta['means'][name]['mean']:.8g} {unit}, variance" in line.replace(f" ({unit})", f" {unit}") for line, (name, unit) in zip(said, units.items()))
    one = smidgen.run(both[1], "demo", steps=1, every=1, averages={"what": ["m"]}).meta
    assert one["means"]["m"]["variance"] is None and "variance" not in "".join(mean_lines(one))


# The film

FILM = Template("""
[model]
name = "film_bare"

[space]
w = { sphere = "n*n", $strength }

[parameters]
n = 8
J = $J
D = $D
K = $K
m = $m
B0 = $B0
t0 = $t0
tau = $tau
kT = $kT

[lattices.film]
size = ["n", "n"]
boundary = ["periodic", "open"]
bonds.x = [{ offset = [1, 0] }]
bonds.y = [{ offset = [0, 1] }]

[effects]
exchange = { use = "spins/exchange", J = "J", bonds = "square(n, n, periodic, open)" }
easy_axis = { use = "spins/uniaxial", K = "K" }
moriya_x = { use = "spins/dmi", D = [0, "D", 0], bonds = "film.x" }
moriya_y = { use = "spins/dmi", D = ["-D", 0, 0], bonds = "film.y" }
pulse = { use = "spins/zeeman", mu = "m", B = "vec(B0*exp(-((t - t0)/tau)^2), 0, 0)" }
bath = { use = "spins/bath", alpha = 0.1, kT = "kT" }

[starts.tilted]
theta = "pi/7 + 0.1*i/n"
phi = 0.3

[runs.demo]
start = "tilted"
h = $h
steps = 10
""")

NAMES = ("J", "D", "K", "m", "B0", "t0", "tau", "kT", "h")
IN_UNITS = dict(zip(NAMES, ("5.7 meV", "1.5 meV", "0.4 meV", "1.72 mu_B", "2 T", "20 fs", "5 fs", "300 K", "1 fs")))


def by_hand() -> dict:
    """The same numbers in meV, ps and T, from CODATA as SciPy has it; kappa = m/gamma, gamma = 2 mu_B/hbar."""
    e, hbar, kB, mu_B = (physical_constants[name][0] for name in ("elementary charge", "reduced Planck constant", "Boltzmann constant", "Bohr magneton"))
    meV = e / 1000
    return dict(strength=f"kappa = {1.72 * hbar / 2 / meV * 1e12!r}", J=5.7, D=1.5, K=0.4, m=1.72 * mu_B / meV, B0=2.0, t0=0.02, tau=0.005, kT=300 * kB / meV, h=0.001)


@pytest.mark.parametrize("units", ['energy = "meV"\ntime = "ps"\nfield = "T"', 'energy = "meV"\nfield = "T"', 'energy = "eV"\ntime = "s"', 'moment = "mu_B"\nfield = "mT"', 'energy = "J"\ntime = "fs"'],
                         ids=["meV-ps-T", "meV-T", "eV-s", "mu_B-mT", "J-fs"])
def test_the_film_in_units_is_the_film_in_bare_numbers(units):
    """To 1e-12 after ten steps, with noise, in any units."""
    text = FILM.substitute({name: f'"{value}"' for name, value in IN_UNITS.items()}, strength='moment = "m"').replace("[space]", f"[units]\n{units}\n\n[space]")
    bare, measured = (smidgen.run(smidgen.load_text(one), "demo", seed=5) for one in (FILM.substitute(by_hand()), text))
    assert measured.meta["steps"] == 10
    assert np.abs(bare.final - measured.final).max() < 1e-12
    assert np.abs(bare.final - smidgen.run(smidgen.load_text(text), "demo", seed=6).final).max() > 1e-3
