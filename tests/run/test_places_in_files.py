"""Places in the files of results and of other programs: .h5, .npz, OVF, and VTK by a reader of its own for each shape."""
import base64
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import smidgen
from smidgen.errors import UsageError

SPEC = """
[model]
name = "m"
[lattices.own]
{lattice}
[space]
w = {{ sphere = "own" }}
[effects.e]
over = "bond(i, j) of own{shell}"
energy = "-dot(w[i], w[j])"
[starts.s]
random = 5
[runs.demo]
start = "s"
h = 0.05
steps = 4
output = {{ every = 2, what = ["states"] }}
"""
HONEYCOMB = 'name = "honeycomb"\nsize = [4, 3]\nboundary = ["periodic", "open"]\nconstant = 2'
BOXES = 'size = [4, 3, 2]\nboundary = "open"\nvectors = [[0.5, 0, 0], [0, 1, 0], [0, 0, 2]]'
FLAT = 'name = "square"\nsize = [4, 3]\nboundary = "periodic"\nconstant = 0.5'
KINDS = {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}


@pytest.fixture(scope="module")
def results():
    return {key: smidgen.run(smidgen.load_text(SPEC.format(lattice=text, shell=".first"))) for key, text in
            {"honeycomb": HONEYCOMB, "boxes": BOXES, "flat": FLAT}.items()}


def arrays(path) -> dict:
    """Name -> numbers of a VTK file in XML, and the pieces' attributes."""
    found, root = {}, ET.parse(path).getroot()
    for node in root.iter("DataArray"):
        kind = KINDS[node.get("type")]
        if node.get("format") == "ascii":
            data = np.array(node.text.split(), float).astype(kind)
        else:
            raw = base64.b64decode(node.text)
            assert len(raw) == 8 + np.frombuffer(raw[:8], "<u8")[0]
            data = np.frombuffer(raw[8:], kind)
        found[node.get("Name")] = data.reshape(-1, int(node.get("NumberOfComponents") or 1)) if node.get("NumberOfComponents") else data
    return {**found, "kind": root.get("type"), **{f"{node.tag}.{key}": value for node in root.iter() for key, value in node.attrib.items()}}


@pytest.mark.parametrize("text", [False, True])
def test_a_honeycomb_has_three_equal_bonds_at_120_degrees(tmp_path, results, text):
    result = results["honeycomb"]
    found = arrays(smidgen.snapshot(result, tmp_path / "a.vtu", row=1, text=text))
    np.testing.assert_array_equal(found["w"], result.w["w"][1])
    where, lines = found["points"], found["connectivity"][24:].reshape(-1, 2)
    assert (found["types"] == np.repeat([1, 3], [24, len(lines)])).all() and (found["offsets"][-len(lines):] == 24 + 2 * np.arange(1, len(lines) + 1)).all()
    assert found["Piece.NumberOfPoints"] == "24" and found["Piece.NumberOfCells"] == str(24 + len(lines))
    full = 0
    for site in range(24):
        ends = where[[b if a == site else a for a, b in lines.tolist() if site in (a, b)]] - where[site]
        np.testing.assert_allclose(np.linalg.norm(ends, axis=1), 2 / np.sqrt(3))
        cosines = (ends @ ends.T)[np.triu_indices(len(ends), 1)] * 3 / 4
        np.testing.assert_allclose(cosines, -0.5)
        full += len(ends) == 3
    assert full == 12       # away from the edges


@pytest.mark.parametrize("key, spacing, size", [("boxes", (0.5, 1, 2), (4, 3, 2)), ("flat", (0.5, 0.5, 0.5), (4, 3, 1))])
def test_meshes(tmp_path, results, key, spacing, size):
    """In each cell its vector, in the middle of the cell its site."""
    result = results[key]
    found = arrays(smidgen.snapshot(result, tmp_path / "a.vtr"))
    np.testing.assert_array_equal(found["w"], result.final)
    middles = [(found[axis][1:] + found[axis][:-1]) / 2 for axis in "xyz"]
    there = np.stack(np.meshgrid(*middles[::-1], indexing="ij")[::-1], axis=-1).reshape(-1, 3)
    np.testing.assert_allclose(there, result.positions, atol=1e-15)
    assert found["Piece.Extent"] == " ".join(f"0 {n}" for n in size)
    image = arrays(smidgen.snapshot(result, tmp_path / "a.vti", text=True))
    np.testing.assert_array_equal(image["w"], result.final)
    assert np.array(image["ImageData.Spacing"].split(), float).tolist() == list(spacing)
    assert np.array(image["ImageData.Origin"].split(), float).tolist() == [-a / 2 for a in spacing]


@pytest.mark.parametrize("key, ending", [("honeycomb", ".vtu"), ("flat", ".vtr")])
def test_a_series_has_all_outputs_at_their_times(tmp_path, results, key, ending):
    result = results[key]
    root = ET.parse(smidgen.snapshot(result, tmp_path / "film.pvd")).getroot()
    entries = [(float(node.get("timestep")), node.get("file")) for node in root.iter("DataSet")]
    assert [t for t, _ in entries] == result.t.tolist()
    for k, (_, name) in enumerate(entries):
        assert name.endswith(ending)
        np.testing.assert_array_equal(arrays(tmp_path / name)["w"], result.w["w"][k])


@pytest.mark.parametrize("key", ["honeycomb", "boxes", "flat"])
@pytest.mark.parametrize("ending", [".vtk", ".ovf"])
def test_files_with_places_are_read_again(tmp_path, results, key, ending):
    result = results[key]
    for text in (False, True):
        found = smidgen.load_field(smidgen.snapshot(result, tmp_path / f"a{ending}", text=text))
        np.testing.assert_array_equal(found.vectors, result.final)
        assert found.size == {"honeycomb": None, "boxes": (4, 3, 2), "flat": (4, 3, 1)}[key]


def test_ovf_has_the_places(tmp_path, results):
    mesh = smidgen.snapshot(results["boxes"], tmp_path / "a.ovf", text=True).read_text()
    assert "# xstepsize: 0.5\n" in mesh and "# zmax: 3\n" in mesh and "# ymin: -0.5\n" in mesh
    points = smidgen.snapshot(results["honeycomb"], tmp_path / "b.ovf", text=True).read_text()
    assert "fractions of its diagonal" not in points
    rows = np.array([line.split() for line in points.splitlines() if not line.startswith("#")], float)
    np.testing.assert_allclose(rows[:, :3], results["honeycomb"].positions, atol=1e-15)


@pytest.mark.parametrize("name", ["a.h5", "a.npz", "a.csv"])
def test_results_keep_the_places(tmp_path, results, name):
    spec = smidgen.load_text(SPEC.format(lattice=HONEYCOMB, shell=""))
    smidgen.run(spec, out=tmp_path / name)
    again = smidgen.load_result(tmp_path / name)
    if name == "a.csv":
        assert again.positions is None
    else:
        np.testing.assert_array_equal(again.positions, results["honeycomb"].positions)
        assert again.positions.shape == (24, 3) and "positions" not in again.values


def test_what_no_file_can_hold(tmp_path, results):
    for key, name, said in [("honeycomb", "a.vtr", "not boxes"), ("honeycomb", "a.vti", "not boxes"), ("flat", "a.vtx", "end in")]:
        with pytest.raises(UsageError, match=said):
            smidgen.snapshot(results[key], tmp_path / name)
    bare = smidgen.run(smidgen.load_text(SPEC.format(lattice='size = [4]\nboundary = "open"\nbonds.first = [{ offset = [1] }]', shell="")))
    for name in ("a.vtu", "a.vtr"):
        with pytest.raises(UsageError, match="no positions"):
            smidgen.snapshot(bare, tmp_path / name)
    assert bare.positions is None and not list(tmp_path.iterdir())


def test_discretisedfield_opens_meshes(tmp_path, results):
    df = pytest.importorskip("discretisedfield")
    for key, cell in (("boxes", [0.5, 1, 2]), ("flat", [0.5, 0.5, 0.5])):
        for ending in (".vtk", ".ovf"):
            field = df.Field.from_file(str(smidgen.snapshot(results[key], tmp_path / f"a{ending}")))
            np.testing.assert_allclose(field.mesh.cell, cell)
            np.testing.assert_array_equal(field.array.transpose(2, 1, 0, 3).reshape(-1, 3), results[key].final)


def test_vtk_reads_points_bonds_and_meshes(tmp_path, results):
    vtk, numbers = pytest.importorskip("vtk"), pytest.importorskip("vtk.util.numpy_support").vtk_to_numpy
    for key, ending, reader in (("honeycomb", ".vtu", "vtkXMLUnstructuredGridReader"), ("flat", ".vtr", "vtkXMLRectilinearGridReader"), ("boxes", ".vti", "vtkXMLImageDataReader")):
        one = getattr(vtk, reader)()
        one.SetFileName(str(smidgen.snapshot(results[key], tmp_path / f"a{ending}")))
        one.Update()
        data = one.GetOutput().GetPointData() if ending == ".vtu" else one.GetOutput().GetCellData()
        np.testing.assert_array_equal(numbers(data.GetArray("w")), results[key].final)
