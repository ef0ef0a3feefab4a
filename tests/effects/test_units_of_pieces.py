"""The units that the pieces of the library give their arguments are those with which their formulas have the right dimension."""
import tomllib

import numpy as np
import pytest
import smidgen

from smidgen.errors import SpecError
from smidgen.read import load_text
from smidgen.resources import folder

pytestmark = pytest.mark.quick
PIECES = sorted((folder("specs") / "pieces").glob("*/*.toml"))
UNITS = {"energy": "meV", "1/time": "ps^-1", "field": "T", "energy/field": "mu_B", "mass*length^2": "meV ps^2", "mass*length^2/time": "meV ps", "sites/time": "ps^-1",
         "1/|w|": "meV^-1 ps^-1", "energy/|w|^2": "meV^-1 ps^-2"}
HEAD = '[model]\nname = "m"\n[units]\nenergy = "meV"\ntime = "ps"\nfield = "T"\n'


def measured(value, unit: str):
    """The same argument with its unit; a name or a formula as it is."""
    if isinstance(value, list):
        return [measured(x, unit) for x in value]
    return f"{value}*(1 {unit})" if isinstance(value, str) else f"{value} {unit}" if value else value


def toml(value) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(x)}" for key, x in value.items()) + " }"
    return "[" + ", ".join(map(toml, value)) + "]" if isinstance(value, list) else repr(value).lower() if isinstance(value, bool) else f'"{value}"' if isinstance(value, str) else repr(value)


def spec_of(path, wrong: bool = False) -> str:
    """A spec that uses a piece as its own test does, in units; wrong: with the first unit left out."""
    piece = tomllib.loads(path.read_text())
    test, said = piece["test"], piece["piece"]["arguments"]
    given = {name: measured(value, UNITS[said[name]["unit"]]) if "unit" in said.get(name, {}) and isinstance(value, (int, float, list)) else value for name, value in test["arguments"].items()}
    if wrong:
        first = next(name for name in given if "unit" in said[name])
        given[first] = test["arguments"][first]
    if path.stem == "zeeman":
        given["mu"] = "2 mu_B"
    space = test.get("space", {"w": {"sphere" if path.parent.stem == "spins" else "r3": 2}})
    families = "".join(f"{name} = {toml({**family, **({'kappa': '1.7 hbar'} if 'sphere' in family else {})})}\n" for name, family in space.items())
    lattices = "".join(f"[lattices.{name}]\n" + "".join(f"{key} = {toml(x)}\n" for key, x in lattice.items()) for name, lattice in test.get("lattices", {}).items())
    return HEAD + f"[space]\n{families}{lattices}[effects.it]\nuse = \"{path.parent.stem}/{path.stem}\"\n" + "".join(f"{key} = {toml(x)}\n" for key, x in given.items()) + \
        f'[effects.moves]\nover = "site(i) of {next(iter(space))}"\nenergy = "t*0 meV/(1 ps)"\n'


@pytest.mark.parametrize("path", [p for p in PIECES if p.parent.stem in ("spins", "bodies")], ids=lambda p: f"{p.parent.stem}/{p.stem}")
def test_a_piece_has_its_dimension(path):
    assert load_text(spec_of(path)).units
    if any("unit" in said for name, said in tomllib.loads(path.read_text())["piece"]["arguments"].items() if name in tomllib.loads(path.read_text())["test"]["arguments"]):
        with pytest.raises(SpecError, match="E32[12]"):
            load_text(spec_of(path, wrong=True))


SATELLITE = """
[model]
name = "satellite"

[space]
w = { r3 = 1 }

[parameters]
spin = 0.3

[effects]
gyrostat = { use = "bodies/gyrostat", Ixx = 1, Iyy = 2, Izz = 4, Ixy = 0.1, rotor = ["spin", 0, 0] }
slosh = { use = "bodies/damping", alpha = 0.05 }

[starts.tumbling]
vectors = [[0.05, 1, 0.1]]

[runs.demo]
start = "tumbling"
h = 0.0625
time = 5
"""


def test_a_satellite_in_si_is_the_satellite_in_bare_numbers():
    text = SATELLITE.replace("[space]", '[units]\nangular_momentum = "N m s"\ntime = "s"\n\n[space]')
    for old, new in (("spin = 0.3", 'spin = { default = 300, unit = "g m^2/s" }'), ("Ixx = 1, Iyy = 2, Izz = 4, Ixy = 0.1", 'Ixx = "1 kg m^2", Iyy = "2 J s^2", Izz = "4 kg m^2", Ixy = "1000 kg cm^2"'),
                     ("alpha = 0.05", 'alpha = "0.05 N^-1 m^-1 s^-1"'), ("0.1]]", '0.1]]\nunit = "N m s"'), ("h = 0.0625", 'h = "62.5 ms"'), ("time = 5", 'time = "5 s"')):
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    bare, measured_ = (smidgen.run(load_text(one), "demo") for one in (SATELLITE, text))
    assert np.array_equal(bare.final, measured_.final) and measured_.meta["units"]["columns"]["energy"] == "J"
