"""Averages over time and members: the numbers of the samples, errors that count correlation, and the same bytes after a kill."""
import json
import math
import re
import signal

import numpy as np
import pytest

import smidgen
from smidgen.errors import UsageError
from smidgen.run.many import average as module
from smidgen.run.record.statistics import Histogram, Statistics

quick = pytest.mark.quick
SPIN = """[model]
name = "spin"
[space]
w = { sphere = 1 }
[parameters]
kT = 0.5
[effects.field]
energy = "-w.z"
[effects.bath]
over = "site(i) of w"
damping = 0.5
kT = "kT"
[observables.mz]
value = "w.z"
[observables.mx]
value = "w.x"
[starts.up]
theta = 1.0
phi = 0.0
[runs.demo]
start = "up"
h = 0.1
time = 300
"""


def correlated(n, rho, seed=1):
    """An AR(1) sequence of variance 1: the variance of its mean is (1 + rho)/(1 - rho)/n."""
    dice = np.random.default_rng(seed)
    x, noise = np.empty(n), dice.standard_normal(n) * math.sqrt(1 - rho * rho)
    x[0] = noise[0] / math.sqrt(1 - rho * rho)
    for k in range(1, n):
        x[k] = rho * x[k - 1] + noise[k]
    return x


@quick
def test_the_same_bits_however_samples_are_handed_over():
    x, dice = np.random.default_rng(3).standard_normal((10_000, 2)), np.random.default_rng(4)
    one, other = Statistics(2, 20), Statistics(2, 20)
    for k in range(0, 10_000, 5_000):
        one.add(x[k:k + 5_000])
        one.end()
        at = k
        while at < k + 5_000:
            step = min(int(dice.integers(1, 1500)), k + 5_000 - at)
            other.add(x[at:at + step])
            kept, at = json.loads(json.dumps(other.facts())), at + step
            other = Statistics(2, 20)
            other.go_on(kept)
        other.end()
    assert one.facts() == other.facts() and one.samples == 10_000 and one.members.n == 2
    np.testing.assert_allclose(one.levels[0].mean, x.mean(0), rtol=1e-13)
    np.testing.assert_allclose(one.levels[0].variance(), x.var(0, ddof=1), rtol=1e-13)


@quick
@pytest.mark.parametrize("first", [1, 2, 700])
def test_the_same_bits_however_samples_lie_in_memory(first):
    """A run hands over columns of a larger table, the first alone where it is slow; numpy adds columns and rows up in different orders."""
    x = np.random.default_rng(3).standard_normal((3000, 5))
    rows, columns, resumed = Statistics(2, 20), Statistics(2, 20), Statistics(2, 20)
    rows.add(np.ascontiguousarray(x[:, [3, 1]]))
    for part in (x[:first], x[first:1500], x[1500:]):
        columns.add(part[:, [3, 1]])
        resumed.add(part[:, [3, 1]])
        resumed.go_on(json.loads(json.dumps(resumed.facts())))
    assert rows.facts() == columns.facts() == resumed.facts()


@quick
@pytest.mark.parametrize("rho", [0.0, 0.9, 0.99])
def test_the_standard_error_counts_correlation(rho):
    """One trajectory by blocking, 64 of them by their means."""
    n, spread = 2 ** 16, math.sqrt((1 + rho) / (1 - rho) / 2 ** 16)
    one, many = Statistics(1, 8), Statistics(1, 8)
    one.add(correlated(n, rho)[:, None])
    for k in range(64):
        many.add(correlated(n // 64, rho, k)[:, None])
        many.end()
    assert one.errors()[0] == pytest.approx(spread, rel=0.3) and many.errors()[0] == pytest.approx(spread, rel=0.3)
    assert abs(one.levels[0].mean[0]) < 4 * spread and abs(many.levels[0].mean[0]) < 4 * spread


@quick
def test_too_few_samples_tell_no_error():
    one = Statistics(1, 8)
    one.add(np.arange(20.0)[:, None])
    one.end()
    assert math.isnan(one.errors()[0]) and one.levels[0].mean[0] == 9.5


@quick
def test_memory_does_not_grow_with_samples():
    sizes = []
    for n in (2 ** 14, 2 ** 18):
        one = Statistics(1, 64)
        one.add(np.random.default_rng(0).standard_normal((n, 1)))
        one.end()
        sizes.append(len(json.dumps(one.facts())))
    assert sizes[1] < sizes[0] + 1000


@quick
@pytest.mark.parametrize("scale", [1e-200, 1.0, 1e200])
def test_a_histogram_counts_every_sample_in_its_bin(scale):
    x = scale * np.concatenate([np.random.default_rng(0).standard_normal(1000), [0.0, 7.0, -3.0]])
    whole, parts = Histogram(32), Histogram(32)
    whole.add(x)
    for part in np.array_split(x, 17):
        parts.add(part)
    table = whole.table()
    assert table["counts"] == parts.table()["counts"] and table["width"] == parts.table()["width"]
    edges = table["low"] + table["width"] * np.arange(len(table["counts"]) + 1)
    assert np.histogram(x, edges)[0].tolist() == table["counts"] and 16 <= len(table["counts"]) <= 32


@quick
def test_samples_are_those_of_runs(tmp_path):
    """Of each member, at every third step from t = 5 on; the file is read again."""
    spec = smidgen.load_text(SPIN)
    found = smidgen.average(spec, what=["mz", "energy"], time=30, every=3, after=5, members=5, seed=9, out=tmp_path / "a.json")
    samples, one = [], smidgen.build(spec)
    for k in range(5):
        one.start("up", h=0.1, seed=9, member=k).steps(48)
        for _ in range(51, 301, 3):
            samples.append(one.steps(3).w[0, 2])
    assert found.meta["samples"] == len(samples) == 5 * 84
    assert found["mz"].mean == pytest.approx(np.mean(samples), rel=1e-13) and found["energy"].mean == pytest.approx(-np.mean(samples), rel=1e-13)
    assert found["mz"].variance == pytest.approx(np.var(samples, ddof=1), rel=1e-12) and sum(found["mz"].histogram["counts"]) == len(samples)
    again = smidgen.load_averages(tmp_path / "a.json")
    assert again == found and "5 members" in repr(found)


@quick
def test_a_scene_without_noise_is_averaged_over_time():
    """Free precession: mx = sin(1) cos(t) has the variance sin(1)^2/2."""
    found = smidgen.average(smidgen.load_text(SPIN), effects=["field"], time=2000, what=["mx"])
    assert abs(found["mx"].mean) < 1e-3 and found["mx"].variance == pytest.approx(math.sin(1) ** 2 / 2, rel=1e-2)


class Killed(Exception):
    pass


@quick
@pytest.mark.parametrize("members, after_saves", [(1, 3), (6, 1), (6, 9)])
def test_a_killed_run_goes_on_to_the_byte(tmp_path, monkeypatch, members, after_saves):
    spec, choices = smidgen.load_text(SPIN), dict(after=2, members=members, seed=4, time=600 / members)
    smidgen.average(spec, **choices, out=tmp_path / "whole.json")
    monkeypatch.setattr(module, "BETWEEN", 0.0)
    saves, save = [], module.Job.save

    def killing(self):
        save(self)
        saves.append(self.model.count)
        if len(saves) == after_saves:
            raise Killed
    monkeypatch.setattr(module.Job, "save", killing)
    with pytest.raises(Killed):
        smidgen.average(spec, **choices, out=tmp_path / "killed.json")
    assert (tmp_path / "killed.json.part").is_file() and not (tmp_path / "killed.json").exists()
    with pytest.raises(UsageError, match=r"different settings \(seed\)"):
        smidgen.average(spec, **{**choices, "seed": 5}, out=tmp_path / "killed.json")
    smidgen.average(spec, **choices, out=tmp_path / "killed.json")
    assert (tmp_path / "killed.json").read_bytes() == (tmp_path / "whole.json").read_bytes()
    assert not (tmp_path / "killed.json.part").exists()


DAMAGES = {     # name: what the file of a stopped run becomes
    "empty": lambda data: b"", "cut": lambda data: data[:len(data) // 2], "cut in its state": lambda data: data[:data.index(b'"state"') + 40],
    "without its last byte": lambda data: data[:-1], "garbage": lambda data: bytes(range(256)), "another object": lambda data: b"[1, 2]", "deep": lambda data: b"[" * 100_000,
    "a shorter state": lambda data: changed(data, lambda found: found.update(state=found["state"][:-8])),
    "no state": lambda data: changed(data, lambda found: found.pop("state")),
    "statistics of fewer numbers": lambda data: changed(data, lambda found: found["statistics"].update(rest=[[0.5]])),
    "statistics that are none": lambda data: changed(data, lambda found: found.update(statistics=[])),
    "a member that is not there": lambda data: changed(data, lambda found: found.update(done=7)),
    "a digit": lambda data: changed(data, lambda found: found["statistics"]["members"].__setitem__(0, 3))}


def changed(data, change) -> bytes:
    found = json.loads(data)
    change(found)
    return json.dumps(found).encode()


@quick
def test_a_damaged_file_of_a_stopped_run_is_refused_and_kept(tmp_path, monkeypatch):
    spec, choices, part = smidgen.load_text(SPIN), dict(after=2, members=2, seed=4, time=60, out=tmp_path / "a.json"), tmp_path / "a.json.part"
    monkeypatch.setattr(module, "BETWEEN", 0.0)
    with monkeypatch.context() as m:
        m.setattr(module.Job, "finish", lambda self: None)
        smidgen.average(spec, **choices)
    data = part.read_bytes()
    for name, damage in DAMAGES.items():
        part.write_bytes(damage(data))
        with pytest.raises(UsageError, match="a.json.part does not come from an interrupted run, or it is damaged"):
            smidgen.average(spec, **choices)
        assert part.read_bytes() == damage(data) and not (tmp_path / "a.json").exists(), name
    part.write_bytes(data)
    assert smidgen.average(spec, **choices) == smidgen.average(spec, **{**choices, "out": None})


@quick
@pytest.mark.parametrize("given, said", [
    (dict(what=["my"]), "no quantity 'my'.*mz"), (dict(after=400), "no sample after t = 400"), (dict(after=-1), "no sample"), (dict(members=0), "at least one member"),
    (dict(members=2, effects=["field"]), "no effect of the scene has kT"), (dict(bins=1), "two bins"), (dict(h=-0.1), "steps cannot be negative")])
def test_what_does_not_fit_is_refused(given, said):
    with pytest.raises(UsageError, match=said):
        smidgen.average(smidgen.load_text(SPIN), **given)


@quick
def test_files_that_are_none(tmp_path):
    (tmp_path / "a.json").write_text("{}")
    with pytest.raises(UsageError, match="contains no averages"):
        smidgen.load_averages(tmp_path / "a.json")
    (tmp_path / "b.json.part").write_text('{"meta": 3}')
    with pytest.raises(UsageError, match="does not come from an interrupted run"):
        smidgen.average(smidgen.load_text(SPIN), out=tmp_path / "b.json")


@quick
def test_averages_are_a_mapping_and_a_start_may_be_a_list():
    spec = smidgen.load_text(SPIN)
    found = smidgen.average(spec, time=1, start=[[0, 0, 1]])
    assert [*found] == ["energy", "mz", "mx"] and len(found) == 3 and "mz" in found and dict(found)["mz"] == found["mz"] == found.get("mz")
    assert found == smidgen.average(spec, time=1, start=np.array([[0.0, 0, 1]]))
    with pytest.raises(smidgen.errors.ColumnError, match="no average of 'mzz'; did you mean 'mz'"):
        found["mzz"]


@quick
def test_a_file_that_cannot_be_is_told_before_the_first_member(tmp_path):
    seen = []
    for place in (tmp_path, tmp_path / "nowhere" / "a.json"):
        with pytest.raises(smidgen.errors.OutputError, match="cannot write"):
            smidgen.average(smidgen.load_text(SPIN), time=1, out=place, progress=seen.append)
    assert not seen


@quick
def test_the_command(tmp_path, capsys):
    from smidgen.cli import main
    (tmp_path / "spin.toml").write_text(SPIN)
    words = ["average", str(tmp_path / "spin.toml"), "--what", "mz", "--time", "20", "--after", "10", "--members", "3", "--out", str(tmp_path / "m.json")]
    assert main(words) == 0
    out = capsys.readouterr().out
    assert "303 samples of 3 members" in out and "standard error" in out
    assert main([*words[:-2], "--period", "0.5", "--portable"]) == 0 and "63 samples of 3 members" in capsys.readouterr().out
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["averages"]["mz"]["mean"] == smidgen.load_averages(tmp_path / "m.json")["mz"].mean


@quick
@pytest.mark.parametrize("time, said", [("1", True), ("20", False)])
def test_a_run_that_ends_before_its_first_sample_says_so(tmp_path, capsys, time, said):
    from smidgen.cli import main
    (tmp_path / "spin.toml").write_text(SPIN + '[runs.late]\nstart = "up"\nh = 0.1\ntime = 20\naverages = { what = ["mz"], after = 10 }\n')
    assert main(["run", str(tmp_path / "spin.toml"), "late", "--time", time, "--no-estimate"]) == 0
    found = "".join(capsys.readouterr())
    assert ("no averages: there is no output from t = 10 on" in found) is said and ("mean of mz from t = 10" in found) is not said


@pytest.mark.long
@pytest.mark.parametrize("kT", [0.5, 0.2])
def test_a_hundred_thousand_members_have_langevins_mean(tmp_path, kT):
    """coth(1/kT) - kT; the bias of the step is below 1e-4 at h = 0.05."""
    found = smidgen.average(smidgen.load_text(SPIN), what=["mz"], h=0.05, time=16, after=16, members=100_000, parameters={"kT": kT}, out=tmp_path / "a.json")
    exact = 1 / math.tanh(1 / kT) - kT
    assert found.meta["samples"] == 100_000 and found["mz"].error < 2e-3
    assert abs(found["mz"].mean - exact) < 3 * found["mz"].error
    assert (tmp_path / "a.json").stat().st_size < 1e6


# --- averages of a run

AVERAGED = SPIN + 'output = { every = 2 }\naverages = { what = ["mz", "energy.field"], after = "100*kT - 40", bins = 16 }\n'


def test_a_run_gives_the_averages_that_its_spec_asks_for(tmp_path):
    """Those of `average`; rows are the first and the last alone, in memory and in files."""
    spec = smidgen.load_text(AVERAGED)
    found = smidgen.average(spec, seed=3)
    for out in (None, tmp_path / "a.h5", tmp_path / "a.csv", tmp_path / "a.npz"):
        result = smidgen.run(spec, seed=3, out=out)
        if out is not None:
            assert smidgen.load_result(out).step.tolist() == [0, 3000]
            assert smidgen.load_result(out).meta["means"] == result.meta["means"]
        assert {name: vars(one) for name, one in found.of.items()} == result.meta["means"]
    assert smidgen.run(spec, seed=3, steps=2999).step.tolist() == [0, 2998]
    assert list(found.of) == ["mz", "energy.field"] and found.meta["after"] == 10 and found.meta["bins"] == 16
    assert smidgen.repeat(tmp_path / "a.h5").meta["means"] == result.meta["means"]
    long = smidgen.run(spec, seed=3, steps=20_000, out=tmp_path / "long.h5")
    assert long.meta["done"] == 20_000 and (tmp_path / "long.h5").stat().st_size < 1.05 * (tmp_path / "a.h5").stat().st_size


@quick
@pytest.mark.quick
@pytest.mark.parametrize("averages, said", [
    ({"waht": ["mz"]}, "averages have no 'waht'; did you mean 'what'?"), ({"": False}, "averages have no ''"), ({"what": False}, "averages: `what` must be a list of names"),
    ({"what": [1]}, "averages: `what` must be a list of names"), ({"bins": 1}, "`bins` must be at least 2"), ({"after": -1}, "`after` must not be negative"), ({"bins": "many"}, "bins")])
def test_averages_that_cannot_be(averages, said):
    with pytest.raises(UsageError, match=re.escape(said)):
        smidgen.run(smidgen.load_text(SPIN), steps=2, averages=averages)


def test_rows_beside_averages_and_averages_from_python():
    spec = smidgen.load_text(SPIN)
    plain = smidgen.run(spec, seed=2, steps=200, what=["mz"])
    found = smidgen.run(spec, seed=2, steps=200, what=["mz"], averages={"what": ["mz"], "after": 5})
    assert plain.meta["means"] is None and np.array_equal(found.values["mz"], plain.values["mz"])
    assert found.meta["means"]["mz"]["mean"] == pytest.approx(plain.values["mz"][50:].mean(), rel=1e-14)
    assert len(smidgen.run(spec, steps=50, what=(), averages={}).t) == 2
    with pytest.raises(UsageError, match="spin has no quantity 'my' to average"):
        smidgen.run(spec, steps=5, averages={"what": ["my"]})
    with pytest.raises(smidgen.SpecError, match="there is no quantity `mw` to average"):
        smidgen.load_text(AVERAGED.replace('"mz"', '"mw"'))


def test_a_killed_run_goes_on_to_the_same_averages(tmp_path):
    spec, calls = smidgen.load_text(AVERAGED), []

    def stop(done):
        calls.append(done)
        if len(calls) == 3:
            raise RuntimeError

    whole = smidgen.run(spec, seed=5, out=tmp_path / "whole.h5", checkpoint=700)
    with pytest.raises(RuntimeError):
        smidgen.run(spec, seed=5, out=tmp_path / "a.h5", checkpoint=700, progress=stop)
    again = smidgen.resume(tmp_path / "a.h5")
    assert again.meta["means"] == whole.meta["means"] and np.array_equal(again.final, whole.final)
    assert smidgen.load_result(tmp_path / "a.h5").step.tolist() == [0, 3000]


def test_an_interrupted_run_goes_on_to_the_same_averages(tmp_path):
    """It has told its averages so far, which is no end of them."""
    spec = smidgen.load_text(AVERAGED)

    def stop(done):         # between two checkpoints
        if done > 150 and done % 700:
            signal.raise_signal(signal.SIGINT)

    smidgen.run(spec, seed=5, out=tmp_path / "whole.h5")
    with pytest.raises(smidgen.Interrupted) as caught:
        smidgen.run(spec, seed=5, out=tmp_path / "a.h5", checkpoint=700, progress=stop)
    assert caught.value.result.meta["means"]["mz"]["histogram"]["counts"]
    smidgen.resume(tmp_path / "a.h5")
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "whole.h5").read_bytes()
