"""S(q, omega): magnons where the theory has them, sums that it stands for, wave vectors by name, files, the command."""
import json

import numpy as np
import pytest
import smidgen
from smidgen.analyse.spectrum import Spectrum
from smidgen.analyse.waves import Components, every_wave, waves
from smidgen.cli.spectrum import lines, peaks, peaks_away, reached
from smidgen.run.fields.grid import Grid
from support.lattices import HONEY, random_spins

pytestmark = pytest.mark.quick
MAGNET = """[model]
name = "magnet"
orientation = {orientation}
[space]
w = {{ sphere = "{count}", kappa = 2, radius = 1.5 }}
[parameters]
n = 16
J = 0.8
[effects.exchange]
over = "bond(i, j) of {lattice}"
energy = "-J*dot(w[i], w[j])"
[runs.demo]
start = "up"
h = 0.05
time = 60
output = {{ every = 8, what = ["states"] }}
[starts.up]
theta = 0.1
phi = "1.3*i^2"
"""
RATE = 2 * 0.8 * 1.5 / 2        # 2 J S with the bracket's scale, S = r/kappa


def chain(orientation=1):
    return smidgen.load_text(MAGNET.format(orientation=orientation, count="n", lattice="chain(n, periodic)"))


def square():
    return smidgen.load_text(MAGNET.format(orientation=1, count="n*n", lattice="square(n, n, periodic)"))


def nearly_up(count, size=0.01, seed=5):
    """Vectors of length 1.5 near the z axis: waves of every q at once, small enough not to meet."""
    w = np.array([0, 0, 1.0]) + size * np.random.default_rng(seed).standard_normal((count, 3)) * [1, 1, 0]
    return 1.5 * w / np.linalg.norm(w, axis=1)[:, None]


@pytest.fixture(scope="module")
def random_run():
    """Spins anyhow: (spectrum with two parts, states (outputs, 16, 3), dt)."""
    start = 1.5 * random_spins(16)
    found = smidgen.spectrum(chain(), q="all", parts=2, autocorrelation=True, start=start)
    return found, smidgen.run(chain(), start=start).w["w"], 0.4


# Physics

@pytest.mark.parametrize("window", ["none", "hann"])
@pytest.mark.parametrize("spec, path, energy", [
    (chain(), "0 1/2", lambda q: 1 - np.cos(2 * np.pi * q[:, 0])),
    (square(), "0,0 1/2,0 1/2,1/2 0,0", lambda q: 2 - np.cos(2 * np.pi * q).sum(axis=1)),
], ids=["chain", "square"])
def test_magnons_of_a_ferromagnet_are_where_the_theory_has_them(spec, path, energy, window):
    """omega(q) = 2 J S sum_d (1 - cos q_d), for instance C. Kittel, Introduction to Solid State Physics, chapter 12; within a frequency bin."""
    found = smidgen.spectrum(spec, q=path, window=window, start=nearly_up(16 if "n*n" not in spec.sources[0][1] else 256))
    across, up = found.s[..., :2].sum(axis=-1), found.omega >= 0
    peak = found.omega[up][across[:, up].argmax(axis=1)]
    width = found.omega[1] - found.omega[0]
    assert width == pytest.approx(2 * np.pi / 60) and RATE * energy(found.q).max() > 20 * width
    assert np.abs(peak - RATE * energy(found.q)).max() < width
    at_peak = np.abs(np.abs(found.omega) - peak[:, None]) < 2.5 * width
    assert np.all((across * at_peak).sum(axis=1) > 0.8 * across.sum(axis=1))


@pytest.mark.parametrize("orientation", [1, -1])
def test_a_wave_has_the_sign_of_the_way_it_goes(orientation):
    """w' = w x dH/dw turns the spiral (cos kc, sin kc) so that its phase is kc + Omega t: it goes towards -c."""
    k = 2 * np.pi * np.arange(16) / 16
    w = np.stack([0.02 * np.cos(k), 0.02 * np.sin(k), np.ones(16)], axis=1)
    found = smidgen.spectrum(chain(orientation), q=[[1 / 16], [-1 / 16]], start=1.5 * w / np.linalg.norm(w, axis=1)[:, None], window="hann", time=240)
    strongest = found.omega[found.s[..., :2].sum(axis=-1).argmax(axis=1)]
    speed = RATE * (1 - np.cos(2 * np.pi / 16))
    assert np.abs(strongest - speed * orientation * np.array([-1, 1])).max() < 2 * np.pi / 240


# Sums

def test_components_are_the_sums_that_they_stand_for():
    for grid, basis in [(Grid((5,), (True,)), None), (Grid((4, 3), (True, False)), None), (Grid((3, 4, 2), (True,) * 3), None),
                        (Grid((4, 3), (True, True), 2), None), (Grid((4, 3), (True, True), 2), [[0, 0], [1 / 3, 1 / 3]])]:
        w, m = random_spins(grid.count), np.concatenate([every_wave(grid), every_wave(grid)[::-1] + 7])
        turns = grid.positions(basis) @ (m / grid.size).T
        direct = np.exp(-2j * np.pi * turns).T @ w / np.sqrt(grid.count)
        np.testing.assert_allclose(Components(grid, m, basis).of(w), direct, atol=1e-13)


def test_the_spectrum_is_the_sum_that_it_stands_for(random_run):
    found, states, dt = random_run
    assert found.s.shape == (16, 75, 3) and found.omega.shape == (75,)
    q = found.q[:, 0]
    waves_ = np.einsum("qj,tja->tqa", np.exp(-2j * np.pi * np.outer(q, np.arange(16))) / 4, states)
    turn = np.exp(1j * np.outer(found.omega, dt * np.arange(75)))
    direct = [np.abs(np.einsum("wt,tqa->qwa", turn, waves_[k:k + 75])) ** 2 / 75 ** 2 for k in (0, 75)]
    np.testing.assert_allclose(found.s, np.mean(direct, axis=0), atol=1e-11)
    late = [np.einsum("tqa,tqa->qa", waves_[k:k + 70].conj(), waves_[k + 5:k + 75]) / 70 for k in (0, 75)]
    np.testing.assert_allclose(found.autocorrelation[:, 5], np.mean(late, axis=0), atol=1e-11)
    assert found.tau[5] == pytest.approx(5 * dt)


def test_parseval(random_run):
    found = random_run[0]
    np.testing.assert_allclose(found.s.sum(axis=1), found.equal_time, rtol=1e-12)
    np.testing.assert_allclose(found.autocorrelation[:, 0], found.equal_time, rtol=1e-12)
    assert found.equal_time.sum() == pytest.approx(16 * 1.5 ** 2, rel=1e-12)      # sum over q of |S_q|^2 is sum over sites of |w|^2
    windowed = smidgen.spectrum(chain(), q="0 1/2", window="hann", start=nearly_up(16, 0.3))
    assert np.all(windowed.s.sum(axis=1) > 0) and windowed.s[0, :, 2].sum() == pytest.approx(windowed.equal_time[0, 2], rel=1e-3)


def test_a_run_backward_tells_the_same_waves(tmp_path):
    one, other = (smidgen.spectrum(chain(), q="1/16", start=nearly_up(16), h=h) for h in (0.05, -0.05))
    assert np.all(np.diff(other.omega) > 0)
    assert abs(one.omega[one.mean[0].argmax()]) == pytest.approx(abs(other.omega[other.mean[0].argmax()]))
    for name in ("a.csv", "a.npz"):     # outputs are at t = 0, dt, .. with dt < 0
        tau = smidgen.load_spectrum(other.save(tmp_path / name)).tau
        assert np.array_equal(tau, other.tau) and tau[1] == pytest.approx(-one.tau[1])


def test_cells_of_two_sites():
    spec = smidgen.load_text(HONEY)
    found = smidgen.spectrum(spec, q="all", start=random_spins(30))
    assert found.q.shape == (15, 2) and found.equal_time.sum() == pytest.approx(15, rel=0.5)


# Wave vectors

def test_wave_vectors_by_name():
    ring, plane = Grid((6,), (True,)), Grid((4, 6), (True, True))
    assert every_wave(ring)[:, 0].tolist() == [-2, -1, 0, 1, 2, 3] and len(every_wave(plane)) == 24
    assert waves(ring, "0 1/2").tolist() == [[0], [1], [2], [3]]
    assert waves(plane, "0,0 1/2,1/2 0,1/2").tolist() == [[0, 0], [2, 3], [1, 3], [0, 3]]
    assert waves(plane, "0,0 1/2,0 1/2,0").tolist() == [[0, 0], [1, 0], [2, 0]]
    assert waves(plane, [0.25, 1.5]).tolist() == [[1, 9]]


@pytest.mark.parametrize("q, said", [
    ("0 1/4", "q = 0.25 is not a wave vector of 6 cells; the nearest are 1/6 and 2/6"), ("0,0 1/2,0", "must consist of 1 finite numbers"), ("", "points of 1 numbers"),
    ("0 a", "has no point .a."), ("0 1,2", "points of 1"), ([np.nan], "finite"), ([1e300], "finite"), ("al", "has no point .al."), ([[[0]]], "1 finite"), ([["x"]], "rows of numbers"),
    ("0 1/0", ".")])
def test_what_is_no_wave_vector(q, said):
    with pytest.raises(smidgen.UsageError, match=said):
        waves(Grid((6,), (True,)), q)


def test_what_makes_no_spectrum():
    spec = chain()
    for given, said in [({"steps": 8}, "1 parts of at least two"), ({"parts": 0}, "into 0 parts"), ({"parts": 40, "time": 20}, "into 40 parts"), ({"window": "han"}, "no window 'han'"),
                        ({"every": 1, "time": 0.05 * 10 ** 8}, "GiB of memory"), ({"basis": [[0], [1]]}, "a basis must have 1 rows")]:
        with pytest.raises(smidgen.UsageError, match=said):
            smidgen.spectrum(spec, **given)
    with pytest.raises(smidgen.UsageError, match="no lattice joins"):
        smidgen.spectrum(smidgen.load("point_vortices"))
    with pytest.raises(smidgen.errors.RunError, match="step"):
        smidgen.spectrum(spec, h=50.0, steps=100, every=1, start=1.5 * random_spins(16))


# Files, pictures, the command

def test_files_and_pictures(random_run, tmp_path):
    from smidgen.show.plot.spectrum import draw_spectrum
    found = random_run[0]
    data = np.load(found.save(tmp_path / "a.npz"))
    assert all(np.array_equal(data[name], getattr(found, name)) for name in ("q", "omega", "s", "equal_time", "tau", "autocorrelation"))
    assert json.loads(str(data["meta"]))["parts"] == 2
    assert (tmp_path / "a.npz").read_bytes() == found.save(tmp_path / "b.npz").read_bytes()
    rows = np.loadtxt(found.save(tmp_path / "a.csv"), delimiter=",", skiprows=2)
    assert rows.shape == (16 * 75, 5) and np.array_equal(rows[:, 2:].reshape(16, 75, 3), found.s)
    for ending in ("npz", "csv"):
        again, more = smidgen.load_spectrum(tmp_path / f"a.{ending}"), ("equal_time", "autocorrelation")
        assert again.meta == found.meta and all(np.array_equal(getattr(again, name), getattr(found, name)) for name in ("q", "omega", "s", "tau"))
        assert all(np.array_equal(getattr(again, name), getattr(found, name)) if ending == "npz" else getattr(again, name) is None for name in more)
        assert again.save(tmp_path / f"again.{ending}").read_bytes() == (tmp_path / f"a.{ending}").read_bytes()
    for ending in ("png", "svg", "pdf"):
        assert draw_spectrum(found, tmp_path / f"a.{ending}").stat().st_size > 1000
    with pytest.raises(smidgen.UsageError, match="must end in .npz or .csv"):
        found.save(tmp_path / "a.txt")
    with pytest.raises(smidgen.OutputError, match="cannot write"):
        found.save(tmp_path / "none" / "a.npz")
    with pytest.raises(smidgen.UsageError, match="needs a path"):
        draw_spectrum(smidgen.spectrum(square(), q="all", time=10), tmp_path / "b.png")
    with pytest.raises(smidgen.ReadOnlyError, match="another spectrum"):
        found.omega = None
    assert "16 waves, 75 frequencies" in repr(found)


def test_files_that_are_no_spectrum(random_run, tmp_path):
    found = random_run[0]
    text = found.save(tmp_path / "a.csv").read_text()
    head, lines = text.splitlines()[0], text.splitlines()[1:]
    wrong = {"cut.csv": "\n".join([head, *lines[:-1]]), "turned.csv": "\n".join([head, lines[0], *lines[:0:-1]]).replace("# meta", "# else"),
             "mixed.csv": "\n".join([head, lines[0], lines[2], lines[1], *lines[3:-1], lines[1]]), "other.csv": text.replace("zz", "xy"),
             "asked.csv": text.replace('"window"', '"wind"'), "a.csv.npz": text}
    for name, content in wrong.items():
        (tmp_path / name).write_text(content)
        with pytest.raises(smidgen.UsageError, match="is not a file of a smidgen run"):
            smidgen.load_spectrum(tmp_path / name)
    data = dict(np.load(found.save(tmp_path / "a.npz")))
    for broken in ({"s": data["s"][1:]}, {"omega": data["omega"][:, None]}, {"q": data["q"].astype(int)}, {"tau": data["tau"][1:]}):
        np.savez(tmp_path / "b.npz", **{**data, **broken})
        with pytest.raises(smidgen.UsageError, match="is not a file of a smidgen run"):
            smidgen.load_spectrum(tmp_path / "b.npz")
    for name, said in (("a.txt", "must end in .npz or .csv"), ("none.csv", "cannot read")):
        with pytest.raises(smidgen.UsageError, match=said):
            smidgen.load_spectrum(tmp_path / name)


def test_what_stands_still_hides_no_wave():
    """The frequency away from 0; below it all weight, so that a larger --every would do; with units frequencies have theirs."""
    omega, s = np.arange(-100, 100) * 0.5, np.zeros((2, 200, 3))
    s[:, 100], s[0, 106], s[1, 108] = 1000, 1, 2            # omega = 0, 3 and 4
    meta = {"spec": "a", "run": "b", "family": "w", "every": 2, "window": "none", "units": {"time": "ps"}, "zone": {}}
    found = Spectrum(meta, np.array([[0.0], [0.5]]), omega, s, s.sum(axis=1), np.arange(200.0))
    assert peaks(found) == [0, 0] and peaks_away(found) == [3, 4] and reached(found) == 4
    told = list(lines(found))
    assert told[0].endswith("up to 49.5 rad/ps") and "below 4 rad/ps: --every 12" in told[1] and [row.split()[2] for row in told[3:]] == ["3", "4"]


def test_the_command(command, tmp_path):
    (tmp_path / "m.toml").write_text(MAGNET.format(orientation=1, count="n", lattice="chain(n, periodic)"))
    said = command("spectrum", "m.toml", "--q", "0 1/2", "--window", "hann", "--out", "a.npz", "--plot", "a.png")
    assert said.returncode == 0 and "9 waves of w, 150 frequencies" in said.stdout and (tmp_path / "a.png").exists(), said.stderr
    assert "more wave" not in said.stdout and len(said.stdout.splitlines()) == 11
    many = command("spectrum", "m.toml", "--set", "n=24", "--time", "4").stdout.splitlines()
    assert len(many) == 23 and many[-1].startswith(".. and 4 more waves; use --out FILE")
    facts = json.loads(command("spectrum", "m.toml", "--q", "1/4", "--json").stdout)
    assert facts["q"] == [[0.25]] and len(facts["peak"]) == 1
    table = command("spectrum", "m.toml", "--q", "1/4", "--time", "4", "--out", "-").stdout.splitlines()
    assert table[1] == "q0,omega,xx,yy,zz" and len(table) == 12
    assert command("spectrum", "m.toml", "--q", "1/5").returncode == 2
    assert command("spectrum", "m.toml", "--out", "a.txt").returncode == 2
