"""Results as other tools have them: columns by name, xarray, pandas, netCDF, and HDF5 files that netCDF's readers open."""
import numpy as np
import pytest
import smidgen
from smidgen.errors import ColumnError, MissingTool
from smidgen import packages
from smidgen.run.files.labels import apart, coordinates

CLASH = """
[model]
name = "clash"
[space]
site = { sphere = 2 }
[effects.e]
over = "site(i) of site"
energy = "site[i].z^2"
[observables.component]
value = "0*t"
over = "site(i) of site"
[starts.s.site]
vectors = [[1, 0, 0], [0.6, 0, 0.8]]
[runs.demo]
start = "s"
h = 0.1
steps = 4
output = { what = ["states", "energy", "component"] }
"""


@pytest.fixture(scope="module")
def one():
    """A model with two families, momenta and energies, run for a few outputs."""
    return smidgen.run("vortex_tracers", steps=6, every=2)


def test_columns_by_name(one):
    assert one["t"] is one.t and one["step"] is one.step and one["w"] is one.w["w"] and one["energy"] is one.values["energy"]
    assert list(one) == one.keys() == ["step", "t", "w", "p", *one.values]
    assert dict(one).keys() == set(one.keys())


def test_a_column_that_is_not_there(one):
    with pytest.raises(KeyError) as said:
        one["enrgy"]
    assert isinstance(said.value, ColumnError) and str(said.value) == "a result of vortex_tracers has no column 'enrgy'; did you mean 'energy'?"


def test_a_column_is_named_by_a_text(one):
    for wrong in (0, ["t"], None):
        with pytest.raises(ColumnError, match="there are: step, t"):
            one[wrong]


def test_a_dataset_holds_all_columns_over_named_axes(one):
    data = one.to_xarray()
    assert data["w"].dims == ("t", "site_w", "component") and data["p"].dims == ("t", "site_p", "component")
    assert data["momentum.w"].dims == ("t", "component") and data["final"].dims == ("site", "component")
    assert data["w"].sel(component="z").isel(t=-1).values.tolist() == one.w["w"][-1, :, 2].tolist()
    assert np.array_equal(data["energy"], one["energy"]) and np.array_equal(data["t"], one.t) and np.array_equal(data["step"], one.step)
    assert {*data.data_vars} == {*one.keys(), "final"} - {"t", "step"}
    assert data.attrs["spec"] == "vortex_tracers" and data.attrs["h"] == 0.1 and data.attrs["method"] == "spherical-midpoint"


def test_netcdf_by_xarray(one, tmp_path):
    xarray = pytest.importorskip("xarray")
    one.to_xarray().to_netcdf(tmp_path / "one.nc")
    with xarray.open_dataset(tmp_path / "one.nc") as back:
        assert back.equals(one.to_xarray()) and back.attrs["title"] == "Passive tracers among point vortices"


def test_a_dataframe_has_the_columns_of_a_csv(one, tmp_path):
    frame = one.to_dataframe()
    one = smidgen.run("vortex_tracers", steps=6, every=2, out=tmp_path / "one.csv", keep=True)
    header = next(line for line in (tmp_path / "one.csv").read_text().splitlines() if not line.startswith("#")).split(",")
    assert sorted([frame.index.name, *frame.columns]) == sorted(header)
    assert np.array_equal(frame["w[2].y"], one.w["w"][:, 2, 1]) and np.array_equal(frame["energy"], one["energy"])
    assert np.array_equal(frame.index, one.t) and frame["step"].tolist() == [0, 2, 4, 6]


def test_a_result_whose_outputs_are_in_its_file_alone_is_an_empty_table(tmp_path):
    found = smidgen.run("vortex_tracers", steps=2, out=tmp_path / "a.npz")
    frame = found.to_dataframe()
    assert len(frame) == 0 and frame.index.name == "t" and found.to_xarray().sizes["t"] == 0


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_netcdf_readers_open_an_h5(one, tmp_path, engine):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip({"netcdf4": "netCDF4"}.get(engine, engine))
    smidgen.run("vortex_tracers", steps=6, every=2, out=tmp_path / "one.h5")
    with xarray.open_dataset(tmp_path / "one.h5", engine=engine) as data:
        assert {name: data[name].dims for name in ("w", "p", "energy", "momentum.p", "final", "step")} == {
            "w": ("t", "site_w", "component"), "p": ("t", "site_p", "component"), "energy": ("t",), "momentum.p": ("t", "component"),
            "final": ("site", "component"), "step": ("t",)}
        assert data["component"].values.tolist() == [b"x", b"y", b"z"] and data["site_p"].values.tolist() == [*range(20)]
        assert np.array_equal(data["p"], one["p"])


def test_names_of_a_model_that_axes_have_too(tmp_path):
    """A family `site` and an observable `component`: they are columns, the axes have underscores, and the file is read as any other."""
    xarray = pytest.importorskip("xarray")
    result = smidgen.run(smidgen.load_text(CLASH), out=tmp_path / "clash.h5", keep=True)
    with xarray.open_dataset(tmp_path / "clash.h5", engine="h5netcdf") as data:
        assert data["site"].dims == ("t", "site_", "component_") and data["component"].dims == ("t",)
    assert result.to_xarray()["site"].dims == ("t", "site_", "component_")
    again = smidgen.load_result(tmp_path / "clash.h5")
    assert {*again} == {*result} and np.array_equal(again["component"], result["component"]) and np.array_equal(again["site"], result["site"])


@pytest.mark.parametrize("more", [{"substeps": True}, {"what": []}, {"what": ["magnetisation", "casimirs"]}, {"real": "long double"}])
def test_every_axis_of_every_file_has_a_scale(tmp_path, more):
    """Without one, netCDF's readers refuse a file or invent names."""
    import h5py
    smidgen.run("heisenberg_chain", steps=3, every=1, parameters={"n": 4}, out=tmp_path / "a.h5", **more)
    with h5py.File(tmp_path / "a.h5") as h5:
        bare = [name for name, data in h5.items() if not data.is_scale and any(len(axis) != 1 for axis in data.dims)]
    assert bare == []
    assert {*smidgen.load_result(tmp_path / "a.h5")} >= {"t", "step"}


def test_every_axis_has_a_name_of_its_own():
    assert apart(["site", "site_w", "site_w_"], {"site_w"}) == {"site": "site", "site_w": "site_w_", "site_w_": "site_w__"}
    assert {name: len(values) for name, values in coordinates({"w": 2, "p": 3}).items()} == {"site": 5, "site_w": 2, "site_p": 3, "component": 3}


def test_a_package_that_is_not_there(one, monkeypatch):
    def none(name):
        raise ImportError(name)
    monkeypatch.setattr(packages.importlib, "import_module", none)
    for call, package in ((one.to_xarray, "xarray"), (one.to_dataframe, "pandas")):
        with pytest.raises(MissingTool, match=rf"needs the package `{package}`: pip install 'smidgen\[data\]'"):
            call()


def test_a_spec_by_name_or_path(tmp_path):
    path = tmp_path / "clash.toml"
    path.write_text(CLASH)
    assert np.array_equal(smidgen.run(path).final, smidgen.run(smidgen.load(path)).final)
    assert smidgen.run(spec=str(path), h=0.05).meta["h"] == 0.05
    with pytest.raises(smidgen.UsageError, match="'free_rigid_bodi' is neither a file nor a shipped spec; did you mean 'free_rigid_body'"):
        smidgen.verify("free_rigid_bodi")
    with pytest.raises(smidgen.UsageError, match="expected a spec as returned by smidgen.load, not a int"):
        smidgen.run(3)
