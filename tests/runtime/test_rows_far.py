"""Lattices by rows with bonds of several shells: more colours, and more kinds of rows than the stack has room for."""
import subprocess

import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.methods import METHODS
from smidgen.resources import include_flags
from support.going_on import one_by_one, restored
from support.widths import same_in_lanes
from test_most import ASKED
from test_rows import EXCHANGE, lattice
from test_rows_by_site import close
from test_rows_in_time import by_rows

SHELLS = """[lattices.cube]
size = ["n", "n", 6]
boundary = "{}"
bonds.near = [{{ offset = [1, 0, 0] }}, {{ offset = [0, 1, 0] }}, {{ offset = [0, 0, 1] }}]
bonds.second = [{{ offset = [1, 1, 0] }}, {{ offset = [1, -1, 0] }}, {{ offset = [1, 0, 1] }}, {{ offset = [1, 0, -1] }}, {{ offset = [0, 1, 1] }}, {{ offset = [0, 1, -1] }}]
bonds.third = [{{ offset = [2, 0, 0] }}, {{ offset = [0, 2, 0] }}, {{ offset = [0, 0, 2] }}]
"""


def shells(name: str, n: int, boundary: str, shell: str):
    more = EXCHANGE.replace("exchange", "more").replace("{over}", f"cube.{shell}").replace("-0.7", "0.2")
    return lattice(name, "cube.near", n, "6*n*n", EXCHANGE + more, SHELLS.format(boundary))


SPECS = {"second": shells("second", 6, "periodic", "second"), "third": shells("third", 7, "open", "third"), "seam": shells("seam", 5, "periodic", "second"), "second, open": shells("open_second", 7, "open", "second")}


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n == "second" else pytest.mark.long) for n in SPECS])
def test_rows_solve_the_step(name):
    assert by_rows(SPECS[name]) and close(SPECS[name], steps=2) <= 2e-14


@pytest.mark.long
def test_restored_it_goes_on():
    model = smidgen.build(SPECS["second"])
    assert restored(model) and one_by_one(model)


@pytest.mark.long
def test_the_same_bits_for_any_number_of_lanes_and_threads(monkeypatch):
    def built(lanes):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(SPECS["second"])
    assert same_in_lanes(built, (2, 4, 8))
    monkeypatch.setenv("OMP_WAIT_POLICY", "passive")
    monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_SHARE=8")
    one, two = (smidgen.build(SPECS["second"], threads=n).start("random", h=0.05).steps(5).w for n in (1, 2))
    assert np.array_equal(one, two)


BY_FIELD = ("gauss-4", "dop853", "extrapolation-12")


@pytest.mark.parametrize("method", ["spherical-midpoint", *BY_FIELD])
def test_the_memory_of_a_state_has_what_stands_beside_rows(tmp_path, method):
    """Small, so that the rest of it is small too. Of one colour there are so few kinds of rows that they stand on the stack."""
    kinds = 9 if METHODS[method].by_field else 864
    files = generate(shells("second", 2, "open", "second"), method=method)
    for file, text in {**files, "main.c": ASKED.format(name="second")}.items():
        (tmp_path / file).write_text(text)
    subprocess.run(["gcc", "-std=gnu11", "-w", "-O0", *include_flags(), *map(str, (tmp_path / "main.c", tmp_path / "second.c")), "-o", str(tmp_path / "asked"), "-lm"], check=True)
    memory = int(subprocess.run([tmp_path / "asked"], check=True, capture_output=True, text=True).stdout)
    assert (40 * kinds * 18 if kinds * 18 > 400 else 0) < memory <= files.most["memory"] <= 1.1 * memory
    assert ("row_kinds" in files["second.h"]) == (kinds * 18 > 400) and "row_kinds" not in generate(lattice("near", "cube.near", 6, "6*n*n", EXCHANGE, SHELLS.format("periodic")))["near.h"]


@pytest.mark.parametrize("method", [pytest.param(m, marks=() if m == "gauss-4" else pytest.mark.long) for m in BY_FIELD])
def test_methods_that_ask_for_the_field_alone(method):
    assert by_rows(SPECS["second"], method) and close(SPECS["second"], method, steps=1) <= 2e-14
