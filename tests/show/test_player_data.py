"""What a player's page carries: directions, modules, colours, numbers of sites."""
import base64
import json
import shutil
import subprocess
import zlib

import numpy as np
import pytest
from support.pictures import FILM_BONDS, data_of, film, pairs_of  # noqa: F401

from smidgen.show.plot import bundle, coding, colours, draw, extras, player

NODE = shutil.which("node")
with_node = pytest.mark.skipif(NODE is None, reason="node is not installed")


def directions(*shape, seed=3):
    w = np.random.default_rng(seed).standard_normal((*shape, 3))
    return w / np.linalg.norm(w, axis=-1, keepdims=True)


def inflated(entry, kind):
    return np.frombuffer(zlib.decompress(base64.b64decode(entry["deflated"])), kind)


@with_node
def test_directions_come_back_as_they_were(tmp_path):
    """Also along the axes and on the folds; by the module that the page has."""
    w = np.concatenate([directions(4, 500), np.broadcast_to([[0, 0, 1], [0, 0, -1], [1, 0, 0], [0, -1, 0]], (4, 4, 3))], axis=1)
    planes = inflated(coding.vectors(w, 1e-4, False, True)["changes"], "u1")
    (tmp_path / "planes").write_bytes(planes.tobytes())
    (tmp_path / "read.mjs").write_text(f"""
import fs from "node:fs";
import {{ summed, unfolded }} from "{bundle.FOLDER.as_uri()}/load.mjs";
const q = summed(new Uint8Array(fs.readFileSync("{tmp_path}/planes")), 2 * {w.shape[1]}, 2047), v = [0, 0, 0], out = [];
for (let i = 0; i < q.length; i += 2) {{ unfolded(q[i], q[i + 1], v); out.push(...v); }}
console.log(JSON.stringify(out));""")
    said = subprocess.run([NODE, str(tmp_path / "read.mjs")], capture_output=True, text=True, check=True).stdout
    back = np.fromstring(said.strip().strip("[]"), sep=",").reshape(w.shape)
    assert np.degrees(np.arccos(np.clip(np.sum(back * w, axis=-1), -1, 1))).max() < 0.12


@with_node
def test_isolines_of_a_slope_are_straight(tmp_path):
    """w_z = (x + 0.3)/5 on a grid: lines along y where it is a multiple of a fifth, each through all five rows of triangles."""
    x, y = np.meshgrid(np.arange(-4, 5), np.arange(6))
    where = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    height = (where[:, 0] + 0.3) / 5
    w = np.rint(32000 * np.stack([np.sqrt(1 - height ** 2), 0 * height, height], axis=1)).astype(int)
    (tmp_path / "read.mjs").write_text(f"""
import {{ it }} from "{bundle.FOLDER.as_uri()}/state.mjs";
import {{ isolines }} from "{bundle.FOLDER.as_uri()}/isolines.mjs";
Object.assign(it, {{ frames: 1, now: 0, data: {{ quantum: 1 / 32000, reach: 1, ball: true }} }});
const f = {{ name: "w", count: {len(where)}, places: {where.ravel().tolist()}, w: {w.ravel().tolist()}, triangles: {extras.triangles(where.astype(float)).ravel().tolist()} }};
console.log(JSON.stringify([...isolines(f, {{ kind: 3 }})]));""")
    said = subprocess.run([NODE, str(tmp_path / "read.mjs")], capture_output=True, text=True, check=True).stdout
    ends = np.array(json.loads(said)).reshape(-1, 2, 3)
    assert np.allclose(ends[:, 0, 0], ends[:, 1, 0], atol=1e-2) and np.allclose(ends[:, 0, 0] + 0.3, np.rint(ends[:, 0, 0] + 0.3), atol=1e-2)
    for level in range(-3, 4):
        along = ends[np.abs(ends[:, 0, 0] + 0.3 - level) < 0.1]
        assert np.abs(along[:, 0, 1] - along[:, 1, 1]).sum() == pytest.approx(5, abs=0.02)


def test_a_hundred_thousand_sites_fit_into_forty_megabytes():
    """Random at every output, the worst case: a tenth of it here."""
    w = directions(100, 10_000)
    text = coding.vectors(w, 1e-4, False, True)
    assert 10 * (len(text["changes"]["deflated"]) + len(text["lengths"]["deflated"])) < 38.5e6
    assert len(player.frames_of(range(1000), {"w": np.broadcast_to(w[:, :1], (100, 100_000, 3))}, True)) == 100


def test_modules_are_joined_in_their_order():
    """None twice, none before what it imports, and nothing left of the words of modules."""
    text = bundle.script()
    names = [line.split()[1] for line in text.splitlines() if line.startswith("const $")]
    assert len(names) == len(set(names)) == len(list(bundle.FOLDER.glob("*.mjs"))) and names[-1] == "$main"
    assert not any(line.startswith(("import ", "export ")) for line in text.splitlines())
    for name in names:
        assert all(names.index(f"${other}") < names.index(name) for _, other in bundle.IMPORT.findall(bundle.asset(f"{name[1:]}.mjs")))


# sRGB seen without one kind of cone: Machado, Oliveira, Fernandes, IEEE Transactions on Visualization and Computer Graphics 15 (2009) 1291, severity 1
BLIND = {"none": np.eye(3),
         "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
         "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
         "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]}


def lab(linear):
    xyz = linear @ np.linalg.inv(colours._RGB).T / colours._WHITE
    f = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz * 841 / 108 + 4 / 29)
    return np.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], axis=-1)


@pytest.mark.parametrize("kind", BLIND)
def test_azimuths_are_told_apart_with_every_kind_of_colour_vision(kind):
    """Sixty degrees apart in the plane, by 7 at least, where 2.3 is just seen (CIE 1976)."""
    phi = np.radians(np.arange(0, 360, 10))
    rgb = colours.of_directions(np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=-1))
    seen = lab(np.clip(np.where(rgb > 0.04045, ((rgb + 0.055) / 1.055) ** 2.4, rgb / 12.92) @ np.transpose(BLIND[kind]), 0, 1))
    apart = np.abs((np.arange(36)[:, None] - np.arange(36) + 18) % 36 - 18) >= 6
    assert np.linalg.norm(seen[:, None] - seen, axis=-1)[apart].min() > 7


def test_lightness_is_height():
    height = np.linspace(-1, 1, 9)
    rgb = colours.of_directions(np.stack([0 * height, 0 * height, height], axis=-1))
    assert np.all(np.diff(rgb.sum(axis=-1)) > 0) and rgb[0].max() < 0.3 and rgb[-1].min() > 0.85


def test_a_film_has_places_bonds_and_its_energy_site_by_site(film):
    """A site has half of the energy of each of its bonds, and its own in the field."""
    data = data_of(draw.page(film))
    family = data["families"][0]
    places = inflated(family["places"], "<f4").reshape(-1, 3)
    assert np.array_equal(places[:, :2], [[i % 6, i // 6] for i in range(30)]) and family["cell"] == {"size": [6, 5], "sites": 1}
    assert pairs_of(inflated(family["links"], "<i4").reshape(-1, 2)) == FILM_BONDS
    assert len(inflated(family["triangles"], "<i4")) == 3 * 2 * 5 * 4
    w = film.w["w"][0]
    half = np.zeros(30)
    for i, j in FILM_BONDS:
        half[[i, j]] -= w[i] @ w[j] / 2
    maps = {m["name"]: m for m in data["maps"]}
    for name, wanted in [("energy.exchange", half), ("energy.field", -w[:, 2]), ("energy", half - w[:, 2])]:
        m = maps[name]
        values = m["low"] + (m["high"] - m["low"]) * inflated(m["values"], "u1").reshape(-1, 30)[0] / 255
        assert np.abs(values - wanted).max() < (m["high"] - m["low"]) / 500, name
