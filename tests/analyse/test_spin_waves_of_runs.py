"""Lines of linear spin waves beside runs: the derivative of the compiled motion, the maxima of S(q, omega), neutrons, files, the command."""
import json

import numpy as np
import pytest
import smidgen
from support.lattices import random_spins
from support.magnets import AXIS, DMI, FIELD, NEEL, RATE, TURNS, magnet, shaken


# The motion itself

@pytest.mark.parametrize("more, held", [("", 0), ('[effects.edge]\nover = "site(i) of w"\npinned = "i == 0"\n', 1)], ids=["free", "pinned"])
def test_frequencies_are_those_of_the_derivative_of_the_compiled_motion(more, held):
    """A disordered chain with open ends, for which there is no formula: eigenvalues of the derivative of w x b, by differences of the compiled field."""
    text = magnet("chain", n=7).sources[0][1].replace("chain(n, periodic)", "chain(n, open)").replace("-J*dot(w[i], w[j])", "-J*(1 + 0.3*normal(2, i, j))*dot(w[i], w[j]) - 0.3*w[i].x*w[j].z")
    spec = smidgen.load_text(text.replace("[starts.order]", FIELD + AXIS + more + "[starts.order]"))
    found = smidgen.spin_waves(spec, relax=True, start=shaken(1.5 * random_spins(7), 0.01), q=[[0.0]])
    assert found.meta["cell"] == [7] and found.meta["torque"] < 1e-9
    model = smidgen.build(spec).start(found.w, h=0.1)

    def rate(w):
        return (np.cross(w, model.field(w)) * (np.arange(7) >= held)[:, None]).ravel()
    moves = 1e-5 * np.eye(21).reshape(21, 7, 3)
    slope = np.stack([(rate(found.w + d) - rate(found.w - d)) / 2e-5 for d in moves], axis=1)
    values = np.linalg.eigvals(slope).imag
    assert found.omega.shape == (1, 7 - held)
    np.testing.assert_allclose(found.omega[0], np.sort(values)[-(7 - held):], atol=1e-6)


# Runs

def peaks(found):
    up = found.omega >= 0
    return found.omega[up][found.mean[:, up].argmax(axis=1)]


@pytest.mark.parametrize("spec, path", [
    (magnet("honeycomb", 2, 6), "Gamma K M Gamma"), (magnet("square", n=12, theta=NEEL, J=-0.8), "0,0 1/2,0 1/2,1/2 0,0"),
    (magnet("triangular", n=12, theta="pi/2", phi=TURNS, J=-0.8), "Gamma K M Gamma")], ids=["ferromagnet", "neel", "120 degrees"])
def test_maxima_of_runs_lie_on_the_lines(spec, path):
    """Within one frequency: the strongest of each q on a line; and on each line that stands apart from the others a maximum."""
    w = smidgen.spin_waves(spec, q=path).w
    found = smidgen.spectrum(spec, q=path, start=shaken(w), window="hann", theory=True)
    lines = [omega[seen] for omega, seen in zip(found.theory.omega[::8], found.theory.seen[::8])]
    moving = [k for k, line in enumerate(lines) if line.max() > 4 * found.resolution]
    assert len(moving) > 4
    off = [np.abs(lines[k] - peaks(found)[k]).min() for k in moving]
    assert max(off) < found.resolution
    tested = 0
    for k in moving:
        apart = np.unique(np.round(lines[k], 6))
        for line in apart:
            if line > 4 * found.resolution and sum(np.abs(apart - line) < 5 * found.resolution) == 1:
                near = np.abs(found.omega - line) < 1.01 * found.resolution
                row, inner = found.mean[k], np.flatnonzero(near)
                assert any(row[m] > row[m - 1] and row[m] > row[m + 1] for m in inner), (found.q[k], line)
                tested += 1
    assert tested > 5


def test_what_neutrons_see():
    """S = sum S_aa for q along z across a ferromagnet of z: of a chain along x the component x falls away."""
    spec = magnet("chain", n=8)
    found = smidgen.spectrum(spec, q="0 1/2", start=shaken(np.tile([0, 0, 1.5], (8, 1))), neutron=True, parts=2)
    np.testing.assert_allclose(found.neutron[1:], found.s[1:, :, 1:].sum(axis=2), rtol=1e-9, atol=1e-15)
    assert np.all(found.neutron > -1e-12)
    plain = smidgen.load_text(magnet("chain", n=8).sources[0][1].replace("bond(i, j) of chain(n, periodic)", "bond(i, j) of ring.a") + '[lattices.ring]\nsize = ["n"]\n'
                              'boundary = "periodic"\nbonds.a = [{ from = 0, to = 0, offset = [1] }]\n')
    with pytest.raises(smidgen.UsageError, match="direction of q in space"):
        smidgen.spectrum(plain, neutron=True)
    assert smidgen.spin_waves(plain).omega.max() == pytest.approx(4 * RATE)


def test_waves_to_the_left_and_to_the_right():
    """omega(q) and omega(-q) differ; S has each at the q that it has, with the bracket reversed too."""
    spec = magnet("chain", n=16, more=DMI.replace("tan(2*pi/8)", "0.3") + FIELD.replace("0.2", "2"), orientation=-1)
    found = smidgen.spectrum(spec, q=[[3 / 16], [-3 / 16]], start=shaken(np.tile([0, 0, 1.5], (16, 1))), theory="order", window="hann")
    assert peaks(found) == pytest.approx(found.theory.omega[:, 0], abs=found.resolution)
    assert abs(np.diff(found.theory.omega[:, 0])[0]) > 5 * found.resolution


# Files, the command

def test_lines_that_are_given():
    """A pulse moves the spins; the lines are those without it."""
    pulse = '[effects.pulse]\nover = "site(i) of w"\nenergy = "-0.05*exp(-(t - 3)^2)*w[i].x*if(i == 0, 1, 0)"\n'
    spec = magnet("chain", n=8, more=pulse + FIELD)
    lines = smidgen.spin_waves(spec, effects=["exchange", "field"], q="0 1/2", between=2)
    found = smidgen.spectrum(spec, q="0 1/2", theory=lines, window="hann")
    assert found.theory is lines and peaks(found)[2:] == pytest.approx(lines.omega[4::2, 0], abs=found.resolution)
    with pytest.raises(smidgen.UsageError, match="other wave vectors"):
        smidgen.spectrum(spec, q="0 1/4", theory=lines)
    with pytest.raises(smidgen.UsageError, match=r"`pulse` depends on time.*theory=spin_waves\(effects="):
        smidgen.spectrum(spec, q="0 1/2", theory=True)


def test_files_keep_the_lines(tmp_path):
    from smidgen.show.plot.spectrum import draw_spectrum
    found = smidgen.spectrum(magnet("chain", n=8), q="0 1/2", time=20, theory=True, neutron=True)
    again = smidgen.load_spectrum(found.save(tmp_path / "a.npz"))
    assert again.theory.meta == found.theory.meta and again.save(tmp_path / "b.npz").read_bytes() == (tmp_path / "a.npz").read_bytes()
    for name in ("q", "omega", "weights", "growth", "w"):
        np.testing.assert_array_equal(getattr(again.theory, name), getattr(found.theory, name))
    np.testing.assert_array_equal(again.neutron, found.neutron)
    assert draw_spectrum(again, tmp_path / "a.png").stat().st_size > 1000
    assert smidgen.load_spectrum(found.save(tmp_path / "a.csv")).theory is None
    data = dict(np.load(tmp_path / "a.npz"))
    for broken in ({"theory_q": data["theory_q"][1:]}, {"theory_w": data["theory_w"][:, :2]}, {"theory_meta": np.array("{}")}, {"neutron": data["neutron"][1:]}):
        np.savez(tmp_path / "c.npz", **{**data, **broken})
        with pytest.raises(smidgen.UsageError, match="is not a file of a smidgen run"):
            smidgen.load_spectrum(tmp_path / "c.npz")


def test_the_command(command, tmp_path):
    (tmp_path / "m.toml").write_text(magnet("chain", n=8).sources[0][1])
    said = command("spectrum", "m.toml", "--q", "0 1/2", "--time", "20", "--neutron", "--out", "a.npz", "--plot", "a.png", "--theory")
    assert said.returncode == 0 and "linear spin waves: magnetic cell 1; |n x g| is 0 of the field" in said.stdout, said.stdout + said.stderr
    assert said.stdout.splitlines()[6].split()[-1] == "2.4"
    facts = json.loads(command("spectrum", "m.toml", "--q", "1/2", "--time", "20", "--theory=order", "--json").stdout)
    assert facts["theory"]["lines"] == [[pytest.approx(2.4)]] and facts["theory"]["stable"] is True
    short = command("spectrum", "m.toml", "--q", "1/2", "--time", "20", "--theory=order", "--out", "a.csv")
    assert short.returncode == 0 and "use an .npz for the lines" in short.stderr
    refused = command("spectrum", "m.toml", "--theory=other", "--time", "20")
    assert refused.returncode == 2 and "no start 'other'" in refused.stderr
