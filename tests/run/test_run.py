"""Runs and their files, on a model written by hand: w' = w x (0, 0, J), stepped exactly."""
import contextlib
import json
import os
import resource
import signal
import subprocess
import sys
import threading
import time
from fractions import Fraction
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest
import smidgen
from smidgen.run.step.integrator import Integrator
from smidgen.run.files.output import OutputError
from smidgen.run.settings import multiple, settle

pytestmark = pytest.mark.quick
FORMATS = [".csv", ".npz", ".h5"]


def turned(w, angle):
    """w turned by -angle about z: the flow of w' = w x (0, 0, 1)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * w[..., 0] + s * w[..., 1], c * w[..., 1] - s * w[..., 0], w[..., 2]], -1)


# The Integrator

def test_steps_are_in_place(toy):
    w = np.array([[0.6, 0.0, 0.8]] * 3)
    first = w.copy()
    top = smidgen.build(toy, effects=["field"], parameters={"J": 2.0}).start(w, t0=1.0, h=0.1)
    assert top.step() is top and top.w is w
    np.testing.assert_allclose(w, turned(first, 0.2), atol=1e-15)
    top.steps(9)
    assert top.t == 1.0 + 10 * 0.1 and top.count == 10
    np.testing.assert_allclose(w, turned(first, 2.0), atol=1e-14)
    np.testing.assert_allclose(top.field(), [[0, 0, 2.0]] * 3)
    assert top.energy() == pytest.approx(2.0 * 2.4)
    np.testing.assert_allclose(top.casimirs(), 1.0)


def test_a_named_start_and_a_new_start(toy):
    top = smidgen.build(toy, effects=["field"])
    a = top.start("any", h=0.1).w.copy()
    b = top.start("any", h=0.1, seed=8).w.copy()
    assert not np.allclose(a, b) and top.count == 0


def test_a_list_or_another_type_is_copied(toy):
    given = np.array([[0.6, 0.0, 0.8]] * 3, dtype=np.float32)
    top = smidgen.build(toy, effects=["field"])
    top.start(given, h=0.1).step()
    assert given[0, 0] == np.float32(0.6) and top.w.dtype == np.float64
    top.start([[1, 0, 0], [0, 1, 0], [0, 0, 1]], h=0.1).step()


@pytest.mark.parametrize("w, said", [
    (np.zeros((2, 3)), r"shape \(3, 3\)"), ([["a"] * 3] * 3, "array of numbers"),
    (np.array([[1, 0, 0]] * 3, complex), "array of real numbers"), ("nowhere", "ring")])
def test_wrong_starts(toy, w, said):
    with pytest.raises(smidgen.UsageError, match=said):
        smidgen.build(toy, effects=["field"]).start(w, h=0.1)


def test_complex_numbers_are_refused_and_arrays_of_one_number_are_numbers(toy):
    for value in (np.complex128(2), np.complex64(2), np.array(2j)):
        with pytest.raises(smidgen.UsageError, match="J. must be one number"):
            smidgen.run(toy, "demo", parameters={"J": value})
    with pytest.raises(smidgen.UsageError, match="start"):
        smidgen.ensemble(toy, start=np.array([[[1, 0, 0]] * 3] * 2, complex), h=0.1, steps=2)
    one, other = (smidgen.run(toy, "demo", parameters={"J": value}) for value in (2.0, np.array(2.0)))
    assert np.array_equal(one.final, other.final) and other.meta["parameters"]["J"] == 2.0


@pytest.mark.parametrize("given", [
    {"parameters": {"J": Fraction(3, 2)}}, {"parameters": {"J": np.longdouble(1.5)}}, {"parameters": {"J": np.array(2), "n": np.int64(4)}}, {"parameters": {"shift": [np.int64(1), Fraction(1, 2)]}},
    {"parameters": {"shift": range(2)}}, {"parameters": {"shift": np.array([1, 2], np.longdouble)}}, {"native": np.bool_(False)},
    {"start": np.array([[0.5, 0, np.sqrt(0.75)]] * 3, np.longdouble)}, {"start": [[np.float32(0.5), Fraction(0), np.sqrt(0.75)]] * 3}])
def test_numbers_of_any_kind_stand_in_a_file_that_repeats_the_run(toy, tmp_path, given):
    result = smidgen.run(toy, "demo", out=tmp_path / "a.csv", keep=True, **given)
    smidgen.repeat(tmp_path / "a.csv", out=tmp_path / "b.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    assert json.loads(json.dumps(result.meta)) == smidgen.load_result(tmp_path / "a.csv").meta


@pytest.mark.skipif(np.finfo(np.longdouble).eps == np.finfo(float).eps, reason="long double is double here")
def test_a_start_with_more_digits_than_a_file_has_is_refused_before_the_run(toy, tmp_path):
    start = np.array([[np.longdouble("0.6"), 0, np.longdouble("0.8")]] * 3)
    with pytest.raises(smidgen.UsageError, match="more digits than a double.*astype"):
        smidgen.run(toy, "demo", start=start, out=tmp_path / "a.csv")
    assert not (tmp_path / "a.csv").exists() and len(smidgen.run(toy, "demo", start=start).t) == 5
    assert smidgen.run(toy, "demo", start=start.astype(float), out=tmp_path / "a.csv").meta["status"] == "complete"


@pytest.mark.parametrize("given", [{"averages": []}, {"averages": "mz"}, {"parameters": [("J", 1.0)]}])
def test_what_must_be_a_dictionary(toy, given):
    with pytest.raises(smidgen.UsageError, match="must be a dictionary"):
        smidgen.run(toy, "demo", **given)


@pytest.mark.parametrize("h", [None, 0.0, float("nan"), float("inf")])
def test_wrong_steps(toy, h):
    with pytest.raises(smidgen.UsageError, match="h must be"):
        smidgen.build(toy, effects=["field"]).start("ring", h=h)


def test_stepping_before_a_start(toy):
    top = smidgen.build(toy, effects=["field"])
    w = np.eye(3)
    for use in (top.step, top.state, top.values, lambda: top.t, top.energy, top.field, lambda: top.energy(w, 0.0), lambda: top.field(w, 0.0)):
        with pytest.raises(smidgen.UsageError, match="start"):
            use()


def test_a_failed_step_says_where(toy):
    top = smidgen.build(toy, effects=["field"], parameters={"fail": 3, "status": 3})
    top.start("ring", h=0.1)
    with pytest.raises(smidgen.RunError, match="wrong branch.*site 1") as caught:
        top.steps(10)
    error = caught.value
    assert (error.status, error.step, error.iterations, error.site) == (3, 3, 4, 1)
    assert error.residual == 0.25 and error.exit_code == 4
    assert top.count == 3 and top.t == 3 * 0.1
    np.testing.assert_allclose(top.w, top.state())      # three steps were done and are there


def test_what_the_model_refuses(toy):
    with pytest.raises(smidgen.RunError, match="bad parameter"):
        smidgen.build(toy, parameters={"J": 0.0}).start("ring", h=0.1)


def test_long_double(toy):
    top = smidgen.build(toy, effects=["field"], real="long double").start("ring", h=0.1)
    top.steps(1000)
    assert top.w.dtype == np.longdouble
    exact = turned(top.start("ring", h=0.1).w.copy(), np.longdouble(1000) * np.longdouble(0.1))
    assert abs(top.steps(1000).w - exact).max() < 1e-16


@pytest.mark.parametrize("wrong, said", [
    ({"method": "leapfrog"}, "spherical-midpoint"), ({"solver": "magic"}, "newton"),
    ({"real": "half"}, "long double"), ({"effects": ["nothing"]}, "nothing"),
    ({"parameters": {"Q": 1.0}}, "Q"), ({"parameters": {"n": 2.5}}, "integer")])
def test_wrong_names(toy, wrong, said):
    with pytest.raises(smidgen.UsageError, match=said):
        smidgen.build(toy, **wrong)


def test_the_status_texts_are_those_of_the_runtime(root):
    from smidgen.run.step.status import STATUS
    header = (root / "runtime" / "core" / "smidgen.h").read_text()
    for number, (name, _) in STATUS.items():
        assert f"SMG_{name.upper().replace(' ', '_')} = {number}," in header.replace(
            "SMG_SINGULAR = 7", "SMG_SINGULAR = 7,")


# Runs

def test_a_run_of_the_spec(toy):
    result = smidgen.run(toy, "demo")
    assert result.step.tolist() == [0, 5, 10, 15, 20]
    np.testing.assert_array_equal(result.t, result.step * 0.125)
    assert result.w["w"].shape == (5, 3, 3)
    for t, w in zip(result.t, result.w["w"]):
        np.testing.assert_allclose(w, turned(result.w["w"][0], t), atol=1e-14)
    np.testing.assert_allclose(result.values["energy"], 2.4)
    np.testing.assert_allclose(result.values["energy.field"], 2.4)
    np.testing.assert_allclose(result.values["momentum.w"], result.w["w"].sum(axis=1), atol=1e-15)
    np.testing.assert_allclose(result.values["casimirs"], 1.0)
    np.testing.assert_allclose(result.values["mz"], 0.8)
    np.testing.assert_array_equal(result.final, result.w["w"][-1])
    assert result.meta["status"] == "complete" and result.meta["done"] == 20


def test_only_what_is_asked(toy):
    result = smidgen.run(toy, "demo", what=["mz"], every=1)
    assert set(result.values) == {"mz"} and result.w is None and len(result.t) == 21


def test_backward(toy):
    there = smidgen.run(toy, "demo")
    back = smidgen.run(toy, "demo", h=-0.125, start=there.final)
    assert back.t[-1] == -20 * 0.125
    np.testing.assert_allclose(back.final, there.w["w"][0], atol=1e-14)


def test_sections(toy):
    result = smidgen.run(toy, "turns")
    assert result.step.tolist() == [0, 20, 40, 60]
    np.testing.assert_allclose(result.w["w"], np.broadcast_to(result.w["w"][0], (4, 3, 3)),
                               atol=1e-14)
    assert result.meta["period"] == pytest.approx(2 * np.pi)


def test_a_period_must_be_a_multiple_of_h(toy):
    with pytest.raises(smidgen.UsageError, match=r"period 1 is not a multiple of h = 0.375.*0.75.*1.125"):
        smidgen.run(toy, "demo", h=0.375, period=1.0)


def test_a_duration_must_be_a_multiple_of_h(toy):
    with pytest.raises(smidgen.UsageError, match=r"0.875 \(7 steps\) and 1 \(8 steps\)"):
        smidgen.run(toy, "demo", time=0.9)


@pytest.mark.parametrize("time_, h, steps", [(1000, 0.1, 10000), (0.3, 0.1, 3), (0.3, -0.1, 3),
                                             (6 * np.pi, 2 * np.pi / 20, 60), (0, 0.1, 0)])
def test_multiples_bear_rounding(time_, h, steps):
    assert multiple(float(time_), h, "time") == steps


@pytest.mark.parametrize("relative, good", [(0.9e-12, True), (1.1e-12, False)])
def test_the_edge_of_a_multiple(relative, good):
    if good:
        assert multiple(1000.0 * (1 + relative), 0.1, "time") == 10000
    else:
        with pytest.raises(smidgen.UsageError):
            multiple(1000.0 * (1 + relative), 0.1, "time")


@pytest.mark.parametrize("given, said", [
    ({"steps": 3, "time": 1.0}, "either steps or time"), ({"steps": -1}, "non-negative"),
    ({"steps": 10 ** 15 + 1}, "10"), ({"h": 0}, "must not be 0"), ({"h": float("nan")}, "finite"),
    ({"time": -1.0}, "negative h"), ({"every": 0}, "every"), ({"every": 10 ** 12 + 1}, "every"),
    ({"what": ["spin"]}, "momentum"), ({"start": "nowhere"}, "ring"), ({"name": "x"}, "demo"),
    ({"steps": 2.5}, "integer"), ({"seed": -1}, "seed"), ({"every": "2"}, "every"),
    ({"start": [[1, 0], [0]]}, "a state must be an array of numbers"), ({"start": [["a"] * 3] * 3}, "a state must be an array of numbers"),
    ({"h": "q"}, "h:1:1"), ({"h": "w"}, "h:1:1"), ({"h": "1/0"}, "finite|zero"), ({"h": [1]}, "number"),
    ({"time": 1e300}, "more than"), ({"time": 1e300, "h": 1e-300}, "more than"), ({"period": 0.0}, "the period must be a multiple of h .* and not 0"), ({"period": "0*pi"}, "the period must be")])
def test_wrong_settings(toy, given, said):
    with pytest.raises(smidgen.UsageError, match=said):
        smidgen.run(toy, given.pop("name", "demo"), **given)


def test_settings_take_formulas_and_numpy_numbers(toy):
    given = settle(toy, h="2*pi/(n + 1)", steps=np.int64(7), every=np.int32(2), seed=np.int64(3))
    assert (given.h, given.steps, given.every, given.seed) == (2 * np.pi / 4, 7, 2, 3)
    assert json.dumps([given.h, given.steps, given.seed])
    assert settle(toy, parameters={"n": 7}, h="1/n", time="2").steps == 14


def test_the_first_run_is_the_default(toy):
    assert settle(toy).run == "demo"


def test_too_much_for_memory(toy):
    with pytest.raises(smidgen.UsageError, match="GiB.*h5"):
        smidgen.run(toy, "demo", steps=10 ** 8, every=1)


def test_a_failure_keeps_what_was_computed(toy, tmp_path):
    out = tmp_path / "part.h5"
    with pytest.raises(smidgen.RunError) as caught:
        smidgen.run(toy, "demo", parameters={"fail": 12}, out=out, keep=True)
    whole = smidgen.run(toy, "demo")
    for result in (caught.value.result, smidgen.load_result(out)):
        assert result.step.tolist() == [0, 5, 10] and result.meta["done"] == 12
        np.testing.assert_array_equal(result.w["w"], whole.w["w"][:3])
        assert result.meta["status"].startswith("failed: step 13")


def test_progress_is_told(toy):
    seen = []
    smidgen.run(toy, "demo", progress=seen.append)
    assert seen[-1] == 20 and seen == sorted(seen)


def test_results_do_not_depend_on_the_outputs(toy):
    fine = smidgen.run(toy, "demo", steps=1000, every=1)
    coarse = smidgen.run(toy, "demo", steps=1000, every=250)
    np.testing.assert_array_equal(fine.w["w"][::250], coarse.w["w"])


def test_more_rows_than_a_buffer(toy, tmp_path):
    result = smidgen.run(toy, "demo", steps=10000, every=1, out=tmp_path / "a.h5", keep=True)
    from_file = smidgen.load_result(tmp_path / "a.h5")
    assert len(result.t) == 10001
    np.testing.assert_array_equal(result.w["w"], from_file.w["w"])


# Files

@pytest.mark.parametrize("suffix", FORMATS)
def test_files_hold_what_arrays_hold(toy, tmp_path, suffix):
    out = tmp_path / f"a{suffix}"
    kept = smidgen.run(toy, "demo", out=out, keep=True, steps=37, every=2)
    read = smidgen.load_result(out)
    assert set(read.values) == set(kept.values) and set(read.w) == {"w"}
    for name in kept.values:
        np.testing.assert_array_equal(read.values[name], kept.values[name])
    np.testing.assert_array_equal(read.w["w"], kept.w["w"])
    np.testing.assert_array_equal(read.t, kept.t)
    np.testing.assert_array_equal(read.final, kept.final)
    assert read.step.dtype == np.int64 and read.meta == json.loads(json.dumps(kept.meta))


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_same_run_gives_the_same_file(toy, tmp_path, suffix):
    for name in "ab":
        smidgen.run(toy, "demo", out=tmp_path / f"{name}{suffix}")
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("given", [
    {"h": 0.1, "steps": 33, "every": 4, "parameters": {"J": 1.7, "n": 5, "shift": [0.1, 0.2]}},
    {"start": "any", "seed": 99, "effects": ["field", "extra"], "what": ["energy"]},
    {"start": [[0.6, 0.0, 0.8]] * 3}, {"real": "long double"}])
def test_a_file_repeats_its_run(toy, tmp_path, suffix, given):
    first, again = tmp_path / f"a{suffix}", tmp_path / f"b{suffix}"
    smidgen.run(toy, "demo", out=first, **given)
    smidgen.repeat(first, out=again)
    assert first.read_bytes() == again.read_bytes()


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("checkpoint", [None, 5])
def test_a_file_that_cannot_be_is_told_before_the_first_step(toy, tmp_path, suffix, checkpoint):
    out, seen = tmp_path / f"a{suffix}", []
    out.mkdir()
    for place, said in ((out, "Is a directory"), (tmp_path / "nowhere" / out.name, "No such file")):
        with pytest.raises(OutputError, match=f"cannot write {place}: {said}"):
            smidgen.run(toy, "demo", out=place, checkpoint=checkpoint, progress=seen.append)
    assert not seen and sorted(p.name for p in tmp_path.iterdir()) == [out.name, "toy.toml"]


def test_a_section_repeats(toy, tmp_path):
    smidgen.run(toy, "turns", out=tmp_path / "a.npz")
    smidgen.repeat(tmp_path / "a.npz", out=tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_the_metadata_tells_the_run(toy, tmp_path):
    meta = smidgen.run(toy, "demo", start="any", parameters={"J": 2.5}, seed=4).meta
    assert meta["orientation"] == 1 and meta["h"] == 0.125 and meta["digest"] == toy.digest
    assert meta["parameters"]["J"] == 2.5 and meta["parameters"]["n"] == 3 and meta["set"] == {"J": 2.5}
    assert meta["effects"] == ["field"] and meta["chosen"] == {"solver": "exact"}
    assert meta["seed"] == 4 and "-ffp-contract=off" in meta["flags"] and meta["compiler"]
    assert "[space]" in meta["sources"][0][1]


def test_csv_is_plain(toy, tmp_path):
    smidgen.run(toy, "demo", out=tmp_path / "a.csv")
    lines = (tmp_path / "a.csv").read_text().splitlines()
    header = next(line for line in lines if not line.startswith("#")).split(",")
    assert header[:5] == ["step", "t", "w[0].x", "w[0].y", "w[0].z"]
    assert header[-4:] == ["casimirs[0]", "casimirs[1]", "casimirs[2]", "mz"]
    assert "# orientation: 1" in lines and "# h: 0.125" in lines
    table = np.genfromtxt(tmp_path / "a.csv", delimiter=",", skip_header=len(lines) - 5)
    assert table.shape == (5, len(header))


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_extended_precision_keeps_its_digits(toy, tmp_path, suffix):
    given = dict(real="long double", substeps=True)
    found, path = smidgen.run(toy, "demo", **given), tmp_path / f"a{suffix}"
    smidgen.run(toy, "demo", **given, out=path)
    again = smidgen.load_result(path)
    for name in found.keys():
        assert np.array_equal(found[name], again[name]) and found[name].dtype == again[name].dtype
    assert np.array_equal(found.final, again.final) and again.final.dtype == np.longdouble and again.substeps.shape == (0, 3)
    assert np.finfo(np.longdouble).nmant == 52 or not np.array_equal(found.final, found.final.astype(float))


@pytest.mark.skipif(np.dtype(np.longdouble).itemsize != 16 or np.finfo(np.longdouble).nmant != 63, reason="no long double of 80 bits")
def test_files_hold_no_bytes_of_memory_beside_the_numbers(toy, tmp_path, monkeypatch):
    state = Integrator.state

    def spoilt(self, out=None):
        found = state(self, out)
        found.view(np.uint8).reshape(-1, 16)[:, 10:] = 0xFF
        return found
    monkeypatch.setattr(Integrator, "state", spoilt)
    smidgen.run(toy, "demo", real="long double", out=tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as file:
        assert not any(file[name].view(np.uint8).reshape(-1, 16)[:, 10:].any() for name in file if file[name].dtype == np.longdouble)


@pytest.mark.parametrize("sites, good", [(29_998, True), (29_999, False)])
def test_the_widest_table(toy, tmp_path, sites, good):
    """step, t and one column a site: 30000 columns are text, one more is refused."""
    given = dict(start="any", parameters={"n": sites}, what=["casimirs"], steps=1, out=tmp_path / "a.csv")
    if good:
        assert smidgen.run(toy, "demo", **given).meta["status"] == "complete"
        assert smidgen.load_result(tmp_path / "a.csv").values["casimirs"].shape == (1, sites)
    else:
        with pytest.raises(OutputError, match="30001 columns.*h5"):
            smidgen.run(toy, "demo", **given)


@pytest.mark.parametrize("steps, good", [(2 ** 28 - 1, True), (2 ** 28, False)])
def test_the_most_memory(steps, good):
    """2 GiB of outputs are kept, an entry more is refused."""
    layout, settings = {"energy": ((), np.dtype(float))}, SimpleNamespace(steps=steps, every=1, what=["energy"])
    check = import_module("smidgen.run.run")._affordable
    check(layout, settings, keep=False)
    if good:
        check(layout, settings, keep=True)
    else:
        with pytest.raises(smidgen.UsageError, match="2.0 GiB"):
            check(layout, settings, keep=True)


@pytest.mark.parametrize("name", ["a.txt", "a", "a.csv.gz"])
def test_unknown_formats(toy, tmp_path, name):
    with pytest.raises(smidgen.UsageError, match=r"\.csv, \.npz, \.h5"):
        smidgen.run(toy, "demo", out=tmp_path / name)


@pytest.mark.parametrize("suffix", FORMATS)
def test_no_such_folder(toy, tmp_path, suffix):
    with pytest.raises(OutputError, match="No such file") as caught:
        smidgen.run(toy, "demo", out=tmp_path / "none" / f"a{suffix}")
    assert caught.value.exit_code == 8


@pytest.mark.parametrize("suffix", FORMATS)
def test_files_that_are_none(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    for content in (None, b"", b"# meta: {}\nstep,t\n", b"PK\x03\x04", b"\x89HDF\r\n\x1a\n"):
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(smidgen.UsageError, match="not a file of a smidgen run|No such file"):
            smidgen.load_result(path)


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("room", [0, 100, 5000, 100_000, pytest.param(1_000_000, marks=pytest.mark.long)])
def test_a_full_disk_leaves_the_earlier_file(toy, tmp_path, suffix, room):
    """The size limit of a process stands for the disk: writing fails in the middle."""
    out = tmp_path / f"a{suffix}"
    smidgen.run(toy, "demo", out=out)
    before = out.read_bytes()
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))
        try:
            smidgen.run(toy, "demo", out=out, steps=50_000, every=1)
        except OutputError:
            os._exit(8)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 8
    assert out.read_bytes() == before
    assert [p for p in tmp_path.iterdir() if p.name.startswith(".")] == []


def test_clashing_names_are_refused(tmp_path):
    from support import toy as model
    path = tmp_path / "clash.toml"
    path.write_text(model.SPEC.replace("[observables.mz]", "[observables.final]").replace('"mz"', '"final"'))
    with pytest.raises(smidgen.SmidgenError, match="final"):
        smidgen.run(smidgen.load(str(path)), "demo")


# Ctrl-C

@contextlib.contextmanager
def interrupted_after(seconds):
    """Ctrl-C comes while the body runs."""
    timer = threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def test_an_interrupt_finishes_the_step_and_keeps_the_rest(toy, tmp_path):
    out = tmp_path / "a.h5"
    smidgen.build(toy, effects=["field"])
    before = signal.getsignal(signal.SIGINT)
    with interrupted_after(0.5), pytest.raises(smidgen.Interrupted) as caught:
        smidgen.run(toy, "demo", steps=10 ** 12, every=1000, out=out, what=["energy"])
    read = smidgen.load_result(out)
    assert read.meta["status"] == "interrupted" and 0 < read.meta["done"] < 10 ** 12
    assert len(read.t) == read.meta["done"] // 1000 + 1
    assert caught.value.result.meta == read.meta
    assert signal.getsignal(signal.SIGINT) is before


def test_an_interrupt_is_prompt(toy):
    """However long the way to the next output is."""
    smidgen.build(toy, effects=["field"])
    begin = time.perf_counter()
    with interrupted_after(0.5), pytest.raises(smidgen.Interrupted):
        smidgen.run(toy, "demo", steps=10 ** 12, every=10 ** 12)
    assert time.perf_counter() - begin < 3


def test_runs_outside_the_main_thread(toy):
    found = []
    worker = threading.Thread(target=lambda: found.append(smidgen.run(toy, "demo").step[-1]))
    worker.start()
    worker.join()
    assert found == [20]


def test_importing_is_light():
    """Reading a spec or a result must not wait for sympy, matplotlib or h5py."""
    code = "import smidgen, sys; print([m for m in ('sympy','matplotlib','h5py','rich','plotly') if m in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"


@pytest.mark.quick
@pytest.mark.parametrize("count", [-1, 2 ** 63, 2 ** 64 + 3])
def test_a_number_of_steps_that_c_does_not_take(count):
    """Beyond 64 bits it would be another number."""
    one = smidgen.build("free_rigid_body").start("paper", h=0.1)
    for steps in (one.steps, one.advance, lambda n: one.push_forward(np.zeros((1, 3)), n)):
        with pytest.raises(smidgen.UsageError, match="the number of steps must"):
            steps(count)
    assert one.count == 0
