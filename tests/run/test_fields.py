"""Spins on lattices as files: .ovf and .vtk, out and in."""
import numpy as np
import pytest
import smidgen
from smidgen import cli
from fuzz.judge import check_print
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from smidgen.run.fields import ovf, vtk
from smidgen.run.fields.field import Field, load_field, save_field
from smidgen.run.fields.grid import Grid
from support.lattices import FILM, HONEY, MEASURED, random_spins

pytestmark = pytest.mark.quick
ENDINGS, FORMS = (".ovf", ".vtk"), (True, False)


@pytest.fixture(scope="module")
def film():
    return smidgen.load_text(FILM)


@pytest.fixture(scope="module")
def result(film):
    return smidgen.run(film)


# Out and in

GRIDS = [Grid((5,), (True,)), Grid((5, 3), (True, True)), Grid((4, 3, 2), (True,) * 3), Grid((3, 2), (True, True), 2)]


@pytest.mark.parametrize("text", FORMS)
@pytest.mark.parametrize("ending, grid", [(ending, grid) for ending in ENDINGS for grid in GRIDS if ending == ".ovf" or grid.sites == 1])
def test_what_is_written_is_read_to_the_bit(tmp_path, ending, text, grid):
    w = random_spins(grid.count)
    path = save_field(tmp_path / f"a{ending}", w, grid, "w", "a title", text)
    found = load_field(path)
    assert np.array_equal(found.vectors, w) and found.size == (None if grid.sites > 1 else (*grid.size, 1, 1)[:3])


@pytest.mark.parametrize("ending, spec_text", [*((ending, FILM) for ending in ENDINGS), (".ovf", HONEY)])
def test_a_snapshot_starts_the_run_that_goes_on(tmp_path, spec_text, ending):
    spec = smidgen.load_text(spec_text)
    result = smidgen.run(spec)
    path = smidgen.snapshot(result, tmp_path / f"a{ending}", time=0.6)
    again = smidgen.run(spec, start=load_field(path), steps=0)
    assert np.array_equal(again.final, result.w["w"][3])
    assert np.array_equal(load_field(smidgen.snapshot(result, path)).vectors, result.final)
    assert np.array_equal(load_field(smidgen.snapshot(result, path, row=-2, text=True)).vectors, result.w["w"][-2])


def test_sites_without_positions_are_no_picture_in_space(tmp_path):
    """A honeycomb has two sites in a cell: .vtk is refused and writes nothing, .ovf says what its positions are."""
    found = smidgen.run(smidgen.load_text(HONEY))
    with pytest.raises(smidgen.UsageError, match="2 sites per cell, and the spec gives no positions"):
        smidgen.snapshot(found, tmp_path / "a.vtk")
    assert not list(tmp_path.iterdir())
    assert b"Desc: the sites of a cell are placed at fractions of its diagonal" in smidgen.snapshot(found, tmp_path / "a.ovf").read_bytes()


def test_states_that_there_are_not(tmp_path, film, result):
    for choice, said in [({"time": 0.5}, "nearest is at 0.[46]"), ({"row": 9}, "no row 9"), ({"row": 1, "time": 0.2}, "either")]:
        with pytest.raises(smidgen.UsageError, match=said):
            smidgen.snapshot(result, tmp_path / "a.ovf", **choice)
    with pytest.raises(smidgen.UsageError, match="end in .ovf, .vtk"):
        smidgen.snapshot(result, tmp_path / "a.txt")
    with pytest.raises(smidgen.OutputError, match="cannot write"):
        smidgen.snapshot(result, tmp_path / "none" / "a.ovf")
    without = smidgen.run(film, what=["energy"])
    assert np.array_equal(load_field(smidgen.snapshot(without, tmp_path / "a.ovf")).vectors, without.final)
    with pytest.raises(smidgen.UsageError, match="contains only the last state"):
        smidgen.snapshot(without, tmp_path / "a.ovf", row=0)


def test_cells_that_lie_otherwise_are_refused(film):
    w = random_spins(15)
    assert np.array_equal(Field(w, (5, 3, 1)).rows(film), w)
    with pytest.raises(smidgen.UsageError, match="3 x 5 x 1 cells, but film has 5 x 3"):
        smidgen.run(film, start=Field(w, (3, 5, 1)))
    with pytest.raises(smidgen.UsageError, match="12 vectors, but film has 15 sites"):
        Field(w[:12], (4, 3, 1)).rows(film)


def test_vectors_in_single_precision_are_put_on_their_spheres(tmp_path, film):
    w = random_spins(15)
    path = save_field(tmp_path / "a.ovf", w, Grid((5, 3), (True, False)), "m", "mumax writes binary 4", False)
    head, body = path.read_bytes().split(b"Binary 8\n", 1)
    numbers = np.concatenate([[1234567.0], w.ravel()]).astype("<f4").tobytes()
    path.write_bytes(head + b"Binary 4\n" + numbers + b"\n# End: Data Binary 4\n# End: Segment\n")
    found = load_field(path)
    assert np.abs(found.vectors - w).max() < 1e-7 and np.abs(np.linalg.norm(found.vectors, axis=1) - 1).max() > 1e-9
    assert np.abs(np.linalg.norm(found.rows(film), axis=1) - 1).max() < 1e-15
    with pytest.raises(smidgen.errors.RunError, match="off its sphere|off manifold"):
        smidgen.run(film, start=Field(1.001 * w, None))


OOMMF = """# OOMMF OVF 2.0
# Segment count: 1
## a comment
# Begin: Segment
# Begin: Header
# Title: m
# meshunit: nm
# meshtype: rectangular
# xbase: 0.5
# xnodes: 2
# ynodes: 1
# znodes: 1
# xstepsize: 1
# valuedim: 3   ## as Spirit writes it
# valuelabels: m_x m_y m_z
# valueunits: 1 1 1
# Desc: made by hand after the user's guide
# End: Header
# Begin: Data Text
0 0 1
 -1   0 0
# End: Data Text
# End: Segment
"""
PARAVIEW = """# vtk DataFile Version 2.0
by hand
ASCII
DATASET STRUCTURED_POINTS
DIMENSIONS 2 1 1
ORIGIN 0 0 0
SPACING 1 1 1

POINT_DATA 2
VECTORS m float
0 0 1 -1
0 0
"""


RECTILINEAR = """# vtk DataFile Version 3.0
as discretisedfield writes it
ASCII
DATASET RECTILINEAR_GRID
DIMENSIONS 2 1 1
X_COORDINATES 2 float
5e-10 1.5e-09
Y_COORDINATES 1 float
5e-10
Z_COORDINATES 1 float
5e-10
POINT_DATA 2
SCALARS x-component double
LOOKUP_TABLE default
0
-1
VECTORS field double
0 0 1
-1 0 0"""
VERSION_5 = b"""# vtk DataFile Version 5.1
as VTK 9 writes it
BINARY
DATASET UNSTRUCTURED_GRID
POINTS 2 float
""" + np.array([0, 0, 0, 1, 0, 0], ">f4").tobytes() + b"""
METADATA
INFORMATION 0

CELLS 3 2
OFFSETS vtktypeint64
""" + np.array([0, 1, 2], ">i8").tobytes() + b"\nCONNECTIVITY vtktypeint64\n" + np.array([0, 1], ">i8").tobytes() + b"""
CELL_TYPES 2
""" + np.array([1, 1], ">i4").tobytes() + b"""
POINT_DATA 2
SCALARS s float 2
LOOKUP_TABLE default
""" + np.arange(4).astype(">f4").tobytes() + b"\nVECTORS m double\n" + np.array([0, 0, 1, -1, 0, 0], ">f8").tobytes() + b"\n"


def read(tmp_path, ending, data):
    path = tmp_path / f"a{ending}"
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return load_field(path)


@pytest.mark.parametrize("ending, data", [(".ovf", OOMMF), (".vtk", PARAVIEW), (".vtk", PARAVIEW + "\nMETADATA\nINFORMATION 0\n"), (".ovf", OOMMF.replace("\n", "\r\n")),
                                          (".ovf", OOMMF.replace("1\n -1", "1 -1").replace("xnodes", "xnodes ")), (".vtk", RECTILINEAR), (".vtk", VERSION_5)])
def test_files_of_others(tmp_path, ending, data):
    found = read(tmp_path, ending, data)
    assert found.vectors.tolist() == [[0, 0, 1], [-1, 0, 0]] and found.size == (None if data == VERSION_5 else (2, 1, 1))


@pytest.mark.parametrize("ending, data, said", [
    (".ovf", OOMMF.replace("2.0", "1.0"), "not in the format OVF 2.0"),
    (".ovf", OOMMF.replace("xnodes: 2", "xnodes: 3"), "6 numbers, not 9"),
    (".ovf", OOMMF.replace("xnodes: 2", "xnodes: 1"), "6 numbers, not 3"),
    (".ovf", OOMMF.replace("xnodes: 2", "xnodes: 90000000"), "header implies"),
    (".ovf", OOMMF.replace("xnodes: 2", "xnodes: 999999999999"), "from 1 to 100000000 sites"),
    (".ovf", OOMMF.replace("xnodes: 2", "xnodes: -2"), "'xnodes' is missing"),
    (".ovf", OOMMF.replace("# xnodes: 2", "# xnodes: 2\n# xnodes: 3"), "'xnodes' twice"),
    (".ovf", OOMMF.replace("xnodes: 2", "xnodes: \u0662"), "'xnodes' is missing"),
    (".ovf", OOMMF.replace("dim: 3 ", "dim: 1 "), "does not contain vectors"),
    (".ovf", OOMMF.replace("count: 1", "count: 2"), "several segments"),
    (".ovf", OOMMF.replace("Text", "Binary 8"), "implies|byte order"),
    (".ovf", OOMMF.replace("-1   0 0", "-1   0"), "5 numbers, not 6"),
    (".ovf", OOMMF.replace("-1   0 0", "-1 x 0"), "damaged"),
    (".ovf", OOMMF.replace("rectangular", "irregular"), "'pointcount' is missing"),
    (".ovf", "# OOMMF OVF 2.0\n" + 300 * "# a: b\n", "no data"),
    (".ovf", b"", "not in the format"),
    (".vtk", PARAVIEW.replace("DIMENSIONS 2", "DIMENSIONS 3"), "different numbers of VECTORS and points"),
    (".vtk", PARAVIEW.replace("DIMENSIONS 2", "DIMENSIONS 90000000").replace("DATA 2", "DATA 90000000"), "header implies"),
    (".vtk", PARAVIEW.replace("-1\n0 0\n", "-1\n0     \n"), "have 5 numbers, not 6"),
    (".vtk", PARAVIEW.replace("VECTORS", "TENSORS"), "'TENSORS' cannot be read"),
    (".vtk", PARAVIEW.replace("STRUCTURED_POINTS", "STRUCTURED_GRID"), "'DATASET' cannot be read"),
    (".vtk", PARAVIEW.replace("ASCII", "BINARY"), "header implies"),
    (".vtk", PARAVIEW[:PARAVIEW.index("VECTORS")], "no VECTORS"),
    (".vtk", VERSION_5.replace(b"CELLS 3", b"CELLS 9000"), "header implies"),
    (".vtk", VERSION_5.replace(b"float 2", b"float 900"), "header implies"),
    (".vtk", b"\x00" * 100, "not in the legacy format"),
])
def test_what_is_no_such_file_is_refused_in_words(tmp_path, ending, data, said):
    with pytest.raises(smidgen.UsageError, match=said):
        read(tmp_path, ending, data)


def test_a_pipe_and_a_missing_file_are_refused(tmp_path):
    import os
    os.mkfifo(tmp_path / "a.ovf")
    for name in ("a.ovf", "b.vtk"):
        with pytest.raises(smidgen.UsageError, match="cannot read"):
            load_field(tmp_path / name)


FLAT = Grid((2, 4), (True, True))
GOOD = {(module, grid, text): module.written(random_spins(8), grid, (2, 4, 1), "w", "t", text)
        for module, grid in ((ovf, FLAT), (ovf, Grid((2, 2), (True, True), 2)), (vtk, FLAT)) for text in FORMS}
GOOD |= {(vtk, k, None): data.encode() if isinstance(data, str) else data for k, data in enumerate((RECTILINEAR, VERSION_5))}


@settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))
@given(which=st.sampled_from(list(GOOD)), at=st.integers(0, 2000), byte=st.integers(0, 255), cut=st.booleans())
def test_damaged_files_are_read_or_refused_in_words(tmp_path_factory, which, at, byte, cut):
    data = GOOD[which]
    at %= len(data)
    path = tmp_path_factory.getbasetemp() / ("a.ovf" if which[0] is ovf else "a.vtk")
    path.write_bytes(data[:at] if cut else data[:at] + bytes([byte]) + data[at + 1:])
    try:
        found = load_field(path)
        assert found.vectors.shape[1] == 3 and (not cut or len(found.vectors) == (2 if which[2] is None else 8))
    except smidgen.UsageError as refusal:
        check_print(str(refusal))


def test_what_a_lattice_does_not_have_hides_nothing_else(tmp_path, capsys):
    """A honeycomb has a magnetisation and no topological charge; asked for alone, that is an error."""
    smidgen.run(smidgen.load_text(HONEY), out=tmp_path / "a.npz")
    assert cli.main(["snapshot", str(tmp_path / "a.npz"), "--what", "magnetisation,charge"]) == 0
    said = capsys.readouterr()
    assert "magnetisation: [" in said.out and "charge" not in said.out and "no charge: a topological charge is defined only for" in said.err
    assert cli.main(["snapshot", str(tmp_path / "a.npz"), "--what", "charge"]) == 2


def test_the_command(command, tmp_path):
    (tmp_path / "film.toml").write_text(FILM)
    assert command("run", "film.toml", "--out", "a.npz").returncode == 0
    assert command("snapshot", "a.npz", "--time", "0.4", "--out", "b.ovf").stdout == "b.ovf\n"
    said = command("run", "film.toml", "--start", "b.ovf", "--steps", "0", "--out", "c.npz")
    assert said.returncode == 0, said.stderr
    a, c = (smidgen.load_result(tmp_path / name) for name in ("a.npz", "c.npz"))
    assert np.array_equal(c.final, a.w["w"][2])
    assert command("run", "film.toml", "--start", "b.ovf", "--set", "nx=3", "--set", "ny=5").returncode == 2
    assert "give a file" in command("snapshot", "a.npz").stderr
    assert "no 'mass'" in command("snapshot", "a.npz", "--what", "mass").stderr


def test_numbers_beyond_those_that_are_promised_are_refused(tmp_path):
    """Between the data and their end."""
    path = save_field(tmp_path / "a.ovf", random_spins(15), Grid((5, 3), (True, False)), "m", "a", False)
    whole = path.read_bytes()
    at = whole.index(b"# End: Data") - 1
    path.write_bytes(whole[:at] + np.ones(3).tobytes() + whole[at:])
    with pytest.raises(smidgen.UsageError, match="have the wrong length"):
        load_field(path)


@pytest.mark.parametrize("length, constant, unit, step", [('length = "nm"', 'constant = "3 angstrom"', "nm", 0.3), ("", 'constant = "3 angstrom"', "m", 3e-10),
                                                          ("", "", "1", 1)])
def test_a_mesh_has_the_unit_of_its_lengths(tmp_path, length, constant, unit, step):
    found = smidgen.run(smidgen.load_text(MEASURED.format(length=length, constant=constant, cell="vectors = [[1, 0], [0, 2]]")), start="random", h="1 fs", steps=0)
    lines = smidgen.snapshot(found, tmp_path / "a.ovf", text=True).read_text().splitlines()
    assert f"# meshunit: {unit}" in lines
    assert [float(line.split()[2]) for line in lines if "stepsize" in line] == pytest.approx([step, 2 * step, step], rel=1e-15)


@pytest.mark.parametrize("strength, one, unit", [('kappa = "1", radius = "2 hbar"', "1 hbar", "{meV fs}"), ('kappa = "1 meV fs/mu_B", radius = "2 mu_B"', "1 mu_B", "mu_B")])
def test_the_vectors_of_a_mesh_have_their_unit(tmp_path, strength, one, unit):
    text = MEASURED.format(length="", constant="", cell="vectors = [[1, 0], [0, 2]]").replace('moment = "1 mu_B"', strength)
    found = smidgen.run(smidgen.load_text(text.replace("dot(w[i], w[j])", f"dot(w[i], w[j])/({one})^2")), start="random", h="1 fs", steps=0, what=["states"])
    assert found.meta["units"]["columns"]["w"] == unit.strip("{}")
    lines = smidgen.snapshot(found, tmp_path / "a.ovf", text=True).read_text().splitlines()
    assert f"# valueunits: {unit} {unit} {unit}" in lines and len(load_field(tmp_path / "a.ovf").vectors) == 36
