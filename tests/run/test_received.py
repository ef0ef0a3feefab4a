"""Results and checkpoints from elsewhere: an error of its own for whatever is wrong, never a traceback, a
wait, or memory that the file does not pay for."""
import io
import json
import os
import shutil
import tracemalloc
import zipfile

import h5py
import numpy as np
import pytest
import smidgen
from hypothesis import given, settings as hypothesis_settings, strategies as st
from smidgen import cli
from smidgen.language import limits
from smidgen.run.files import received
from smidgen.run.files.checkpoint import Folder, digest_of, folder_of, packed
from smidgen.run.files.recorded import recorded
from smidgen.run.settings import settle
from smidgen.read.shipped import load_spec
from support.runs import chain_run, patient_disk       # noqa: F401

FORMATS = [".csv", ".npz", ".h5"]
TERABYTES = (10 ** 12, 3)


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """suffix -> the bytes of a result."""
    folder, found = tmp_path_factory.mktemp("good"), {}
    for suffix in FORMATS:
        smidgen.run(load_spec("two_bodies"), out=folder / f"a{suffix}", steps=4, every=2, substeps=True)
        found[suffix] = (folder / f"a{suffix}").read_bytes()
    return found


def meta_of(data: bytes) -> dict:
    """The metadata of a .csv, as it stands there."""
    line = next(x for x in data.decode().splitlines() if x.startswith("# meta: "))
    return json.loads(line.removeprefix("# meta: "))


def with_meta(suffix: str, data: bytes, meta: str) -> bytes:
    """The same result with other text for metadata."""
    if suffix == ".csv":
        lines = [f"# meta: {meta}" if x.startswith("# meta: ") else x for x in data.decode().split("\n")]
        return "\n".join(lines).encode("utf-8", "surrogatepass")
    image = io.BytesIO(data)
    if suffix == ".npz":
        arrays = dict(np.load(image))
        return saved(**{**arrays, "meta": np.array(meta)})
    with h5py.File(image, "a") as h5:
        del h5["meta"]
        data = meta.encode("utf-8", "surrogatepass") or b" "
        h5.create_dataset("meta", data=data, dtype=h5py.string_dtype("utf-8", len(data)))
    return image.getvalue()


def saved(**arrays) -> bytes:
    image = io.BytesIO()
    np.savez(image, **arrays)
    return image.getvalue()


def judged(path):
    """A Result or a UsageError whose words can be printed; with at most some times the memory of the file."""
    tracemalloc.start()
    try:
        return smidgen.load_result(path)
    except smidgen.UsageError as error:
        assert "\n" not in str(error)
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 2e7 + 50 * path.stat().st_size


def refused(path, said):
    """The command ends with 2 and one line."""
    with pytest.raises(smidgen.UsageError, match=said):
        smidgen.load_result(path)
    assert cli.main(["run", "--repeat", str(path)]) == cli.main(["plot", str(path)]) == 2


def test_the_metadata_is_all_known(good):
    """A key that `describe` adds is named here, with what it must be."""
    assert set(meta_of(good[".csv"])) == set(received.META)


@pytest.mark.parametrize("name", ["nambu_a34"])
def test_what_is_written_can_be_read(tmp_path, name):
    spec = load_spec(name)
    values = {p.name: p.default for p in spec.parameters}
    result = smidgen.run(spec, steps=1, every=1, parameters=values, out=tmp_path / "a.h5", keep=True)
    start = result.final
    again = smidgen.run(spec, steps=1, every=1, start=start, seed=None, out=tmp_path / "b.csv", keep=True)
    for path, meta in (("a.h5", result.meta), ("b.csv", again.meta)):
        assert smidgen.load_result(tmp_path / path).meta == json.loads(json.dumps(meta))


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_file_that_is_not_there(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    refused(path, f"cannot read {path}: No such file or directory$")
    path.mkdir()
    refused(path, "it is not a regular file|Is a directory")
    path.rmdir()
    os.mkfifo(path)
    refused(path, "not a regular file")         # and is not waited for
    path.unlink()
    path.symlink_to("/dev/zero")
    refused(path, "not a regular file")
    path.unlink()
    path.write_bytes(b"no such thing")
    refused(path, "is not a file of a smidgen run")


# Bytes

@pytest.mark.parametrize("suffix", FORMATS)
def test_any_damage(tmp_path, good, suffix):
    path, data = tmp_path / f"a{suffix}", good[suffix]
    place = st.one_of(st.integers(0, len(data) - 1), st.integers(0, min(4000, len(data) - 1)))
    piece = st.one_of(st.binary(min_size=1, max_size=9), st.sampled_from([b"\xff" * 8, bytes(8), b"\x7f" * 4, b"9" * 20]))

    @hypothesis_settings(max_examples=60, deadline=None)
    @given(st.lists(st.tuples(place, piece), min_size=1, max_size=8), st.one_of(st.none(), place))
    def damage(pieces, end):
        spoilt = bytearray(data)
        for at, new in pieces:
            spoilt[at:at + len(new)] = new
        path.write_bytes(spoilt[:end])
        judged(path)
    damage()


@pytest.mark.parametrize("suffix", FORMATS)
def test_any_bytes(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    for head in (b"", b"# meta: {}\n", b"PK\x03\x04", b"\x89HDF\r\n\x1a\n", b"\x93NUMPY\x01\x00"):
        for tail in (b"", b"\x00" * 3000, b"\xff" * 3000, os.urandom(3000), b"a,b\n1,2\n"):
            path.write_bytes(head + tail)
            refused(path, "is not a file of a smidgen run")


# Metadata

json_values = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=5),
              st.sampled_from([10 ** 400, -1, 2 ** 53 + 1, 1e308, "../x", "a" * 300, "\ud800", "x\0", "spec.toml/x", "."])),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=3), inner, max_size=3)), max_leaves=6)


def test_any_metadata(tmp_path, good):
    """Down to the choices of the run: one or two keys hold something else, at any depth."""
    path, meta = tmp_path / "a.csv", meta_of(good[".csv"])

    @hypothesis_settings(max_examples=150, deadline=None)
    @given(st.dictionaries(st.sampled_from(sorted(meta)), json_values, min_size=1, max_size=2), st.booleans())
    def spoil(other, inside):
        changed = {**meta, **other}
        if inside:
            for key in other:
                changed[key] = [other[key]] if isinstance(meta[key], list) else \
                    {k: other[key] for k in meta[key]} if isinstance(meta[key], dict) else other[key]
        path.write_bytes(with_meta(".csv", good[".csv"], json.dumps(changed)))
        found = judged(path)
        if found is None:
            return
        try:
            spec, run, choices = recorded(found.meta)
            settle(spec, run, **{k: v for k, v in choices.items() if k != "start"})
        except smidgen.SmidgenError:
            pass
    spoil()


@pytest.mark.parametrize("key", sorted(received.META))
@pytest.mark.parametrize("wrong", [{"a": {}}, [[[]]], 10 ** 400, float("inf"), -7, 0.5, [None]])
def test_metadata_of_the_wrong_shape(tmp_path, good, key, wrong):
    meta = meta_of(good[".csv"])
    if received.META[key](wrong):
        pytest.skip("that is a value of it")
    for changed in ({**meta, key: wrong}, {k: v for k, v in meta.items() if k != key or k in received.ADDED}):
        path = tmp_path / "a.csv"
        path.write_bytes(with_meta(".csv", good[".csv"], json.dumps(changed)))
        if key in changed or key not in received.ADDED:
            with pytest.raises(smidgen.UsageError, match=f"{key}|not JSON") if changed != meta else pytest.raises(AssertionError):
                assert smidgen.load_result(path) is None


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("text", ["[" * 100_000, '{"a":' * 100_000, "[]", "{}", "1", "null", '"x"', "", "{", "\ud800", "9" * 5000])
def test_text_that_is_no_metadata(tmp_path, good, suffix, text):
    if suffix == ".npz" and text == "\ud800":
        text = "\udfff"
    path = tmp_path / f"a{suffix}"
    path.write_bytes(with_meta(suffix, good[suffix], text))
    refused(path, "is not a file of a smidgen run")


@pytest.mark.parametrize("sources", [[], [["spec.toml", ""]], [["a", "b"], ["../../evil", "x"]], [["a", "b"], ["a" * 5000, "x"]],
                                     [["a", "b"], ["x\0", "y"]], [["a", "b"], ["spec.toml/x", "y"]], [["a", "\ud800"]], [["a", "b"], [".", "y"]],
                                     [["a", "b"], ["/etc/evil", "y"]]])
def test_sources_that_are_none(tmp_path, good, sources):
    path = tmp_path / "a.csv"
    path.write_bytes(with_meta(".csv", good[".csv"], json.dumps({**meta_of(good[".csv"]), "sources": sources})))
    for words in (["run", "--repeat"], ["plot", "--out", str(tmp_path / "a.png"), "--kind", "energy"]):
        assert cli.main([*words, str(path)]) in (2, 3) or (sources == [] and words[0] == "plot")


# Arrays

def npy(shape, data=b"", kind="<f8", order=False) -> bytes:
    image = io.BytesIO()
    np.lib.format.write_array_header_2_0(image, {"descr": kind, "fortran_order": order, "shape": shape})
    return image.getvalue() + data


def zipped(members: dict, how=zipfile.ZIP_STORED) -> bytes:
    image = io.BytesIO()
    with zipfile.ZipFile(image, "w", how) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return image.getvalue()


def members(data: bytes) -> dict:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {n: archive.read(n) for n in archive.namelist()}


@pytest.mark.parametrize("array", [
    npy(TERABYTES), npy((2 ** 40,) * 8), npy((-1,)), npy((3, 3), bytes(72), order=True), npy((5,), bytes(40), "|O"), npy((5,), bytes(10), "<U1"),
    npy((), bytes(8)), npy((3,), bytes(23)), npy((3,), bytes(25)), npy((3,), bytes(48), "<c16"), b"", b"\x93NUMPY\x03\x00", b"\x93NUMPY\x02\x00\xff\xff\xff\xff",
    b"\x93NUMPY\x01\x00\x76\x00" + b"(" * 117 + b"\n"])
def test_arrays_of_an_npz_that_are_none(tmp_path, good, array):
    path = tmp_path / "a.npz"
    path.write_bytes(zipped({**members(good[".npz"]), "energy.npy": array}))
    judged(path)
    refused(path, "not a file of a smidgen run")


def test_a_zip_bomb(tmp_path, good):
    path, inside = tmp_path / "a.npz", members(good[".npz"])
    path.write_bytes(zipped({**inside, "bomb.npy": npy((3, 10 ** 6), bytes(24 * 10 ** 6))}, zipfile.ZIP_DEFLATED))
    assert judged(path) is None
    refused(path, "compressed")
    path.write_bytes(zipped(inside, zipfile.ZIP_LZMA))
    refused(path, "compressed")
    data = bytearray(zipped(inside))                 # a central directory that says terabytes
    at = data.rindex(b"PK\x01\x02")
    data[at + 20:at + 28] = b"\xfe\xff\xff\xff" * 2
    path.write_bytes(data)
    judged(path)
    refused(path, "header implies")


def test_members_that_lie_on_each_other(tmp_path, good):
    """A thousand entries of the directory, the same bytes behind them: more than the file has."""
    data = zipped({**members(good[".npz"]), "x.npy": npy((2, 1000), bytes(16000))})
    end = data.rindex(b"PK\x05\x06")
    at = data.rindex(b"PK\x01\x02", 0, end)
    entry, tail = data[at:end], bytearray(data[end:])
    count = 1 + int.from_bytes(tail[8:10], "little") + 99
    tail[8:10] = tail[10:12] = count.to_bytes(2, "little")
    start = int.from_bytes(tail[16:20], "little")
    tail[12:16] = (end + 100 * len(entry) - start).to_bytes(4, "little")
    path = tmp_path / "a.npz"
    path.write_bytes(data[:end] + 100 * entry + tail)
    judged(path)
    refused(path, "header implies")


def planted(h5, folder, how):
    """Something in an HDF5 file that is no data set of its own."""
    (folder / "secret").write_bytes(bytes(24))
    if how == "shape":
        h5.create_dataset("energy", TERABYTES, "f8", chunks=(1024, 3))
    elif how == "flat":
        h5.create_dataset("energy", TERABYTES, "f8")
    elif how == "filter":
        h5.create_dataset("energy", data=np.zeros(3), compression="gzip")
    elif how == "external":
        h5.create_dataset("energy", (3,), "f8", external=[(str(folder / "secret"), 0, 24)])
    elif how == "link":
        h5["energy"] = h5py.ExternalLink(str(folder / "other.h5"), "t")
    elif how == "soft":
        h5["energy"] = h5py.SoftLink("/t")
    elif how == "virtual":
        layout = h5py.VirtualLayout((3,), "f8")
        layout[:] = h5py.VirtualSource(str(folder / "other.h5"), "t", (3,))
        h5.create_virtual_dataset("energy", layout)
    elif how == "group":
        h5.create_group("energy")
    elif how == "text":
        h5.create_dataset("energy", data=["a", "b", "c"], dtype=h5py.string_dtype())
    elif how == "empty":
        h5["energy"] = h5py.Empty("f8")
    elif how == "record":
        h5.create_dataset("energy", data=np.zeros(3, [("a", "f8")]))
    elif how == "complex":
        h5.create_dataset("energy", data=np.zeros(3, complex))
    elif how == "chunk":
        h5.create_dataset("energy", (3,), "f8", chunks=(2 ** 27,), maxshape=(None,))
    elif how == "heap":
        meta = h5["meta"][()]
        del h5["meta"]
        h5.create_dataset("meta", data=meta, dtype=h5py.string_dtype())
    elif how == "many":
        h5["large"] = np.zeros((3, 10 ** 5))
        h5["again"] = h5["large"]


@pytest.mark.parametrize("how", ["shape", "flat", "filter", "external", "link", "soft", "virtual", "group", "text", "empty", "record", "complex",
                                 "chunk", "many", "heap"])
def test_sets_of_an_h5_that_are_none(tmp_path, good, how):
    (tmp_path / "other.h5").write_bytes(good[".h5"])
    path = tmp_path / "a.h5"
    path.write_bytes(good[".h5"])
    with h5py.File(path, "a") as h5:
        if "energy" in h5:
            del h5["energy"]
        planted(h5, tmp_path, how)
    judged(path)
    refused(path, "not a file of a smidgen run")


@pytest.mark.parametrize("name, shape", [("t", (2,)), ("t", (3, 1)), ("step", (4,)), ("w", (3, 2, 2)), ("w", (3, 1, 3)), ("w", (3, 6)), ("final", (1, 3)),
                                         ("final", (6,)), ("substeps", (3,)), ("substeps", (1, 2)), ("energy", (2,)), ("energy", (3, 1, 1)), ("energy", ())])
def test_columns_that_do_not_fit(tmp_path, good, name, shape):
    path, arrays = tmp_path / "a.npz", dict(np.load(io.BytesIO(good[".npz"])))
    first = next(iter(json.loads(str(arrays["meta"]))["families"]))
    path.write_bytes(saved(**{**arrays, first if name == "w" else name: np.zeros(shape)}))
    refused(path, "differs from that of the others|missing")
    path.write_bytes(saved(**{k: v for k, v in arrays.items() if k != "t"}))
    refused(path, "are missing")


# The limits

@pytest.mark.parametrize("suffix", FORMATS)
def test_the_limit_of_the_metadata(tmp_path, good, suffix, monkeypatch):
    path, text = tmp_path / f"a{suffix}", json.dumps(meta_of(good[".csv"]))
    path.write_bytes(with_meta(suffix, good[suffix], text))
    monkeypatch.setattr(limits, "META", len(text))
    smidgen.load_result(path)
    monkeypatch.setattr(limits, "META", len(text) - 1)
    refused(path, "at most")


def test_the_limit_of_columns(tmp_path, good, monkeypatch):
    path = tmp_path / "a.csv"
    path.write_bytes(good[".csv"])
    width = good[".csv"].decode().splitlines()[-1].count(",") + 1
    monkeypatch.setattr(limits, "CSV_COLUMNS", width)
    smidgen.load_result(path)
    monkeypatch.setattr(limits, "CSV_COLUMNS", width - 1)
    refused(path, "columns")


# Checkpoints

@pytest.fixture
def stopped(tmp_path, patient_disk):
    """A run of which something is saved."""
    out = tmp_path / "a.h5"

    def interrupt(done):
        if done > 60:
            raise RuntimeError
    with pytest.raises(RuntimeError):
        chain_run(out, progress=interrupt)
    return out


def replaced(out, kind, change):
    """The last part of a kind with other content, under the name that this content has."""
    part = Folder(out).parts(kind)[-1]
    facts, arrays = part.read()
    data = change(facts, arrays)
    data = packed(*data) if isinstance(data, tuple) else data
    part.path.unlink()
    part.path.with_name(f"{kind}-{part.number:018d}-{digest_of(data)}.h5").write_bytes(data)


HOSTILE = [("run", lambda f, a, w=w: ({**f, "meta": w}, a)) for w in (None, [], {}, "x", {"generator": 1})] + \
          [("run", lambda f, a, k=k: ({**f, "meta": {**f["meta"], k: {"a": [[]]}}}, a)) for k in received.META] + \
          [("run", lambda f, a: ({}, {})), ("run", lambda f, a: ({**f, "format": []}, a))] + \
          [("state", lambda f, a, k=k, w=w: ({**f, k: w}, a)) for k in ("count", "rows", "seconds", "largest", "substeps")
           for w in (None, "x", [1], -1, 10 ** 400, {"a": []})] + \
          [("state", lambda f, a: (f, {})), ("state", lambda f, a: (f, {"state": np.zeros((2, 2))})),
           ("state", lambda f, a: (f, {"state": a["state"][:-1]})), ("state", lambda f, a: (f, {"state": a["state"] * np.nan})),
           ("state", lambda f, a: (f, {"state": np.array([1 + 1j])})),
           ("rows", lambda f, a: (f, {})), ("rows", lambda f, a: (f, {**a, "t": np.array(1.0)})), ("rows", lambda f, a: (f, {"t": a["t"]})),
           ("rows", lambda f, a: (f, {**a, "w": a["w"][:, :-1]})), ("rows", lambda f, a: (f, {**a, "energy": a["energy"].astype(int)})),
           *[(kind, lambda f, a: b"\x89HDF\r\n\x1a\n" + bytes(100)) for kind in ("run", "rows", "state")],
           ("run", lambda f, a: ([[]], a))]


@pytest.mark.filterwarnings("ignore:.*going back")
def test_hostile_parts(stopped, tmp_path):
    """With the right digest in the name: one who plants a part knows how to take it."""
    kept = tmp_path / "kept"
    shutil.copytree(folder_of(stopped), kept)
    for kind, change in HOSTILE:
        shutil.rmtree(folder_of(stopped), ignore_errors=True)
        shutil.copytree(kept, folder_of(stopped))
        replaced(stopped, kind, change)
        try:
            smidgen.resume(stopped)
        except (smidgen.CheckpointError, smidgen.RunError, smidgen.UsageError):
            continue
        stopped.unlink()                             # the state before served
        assert kind != "run"


@pytest.mark.parametrize("name", ["run-\u00b2-x.h5", "run-1-x.h5", "rows-" + "9" * 100 + "-x.h5", "other-000000000000000001-x.h5", "state-x-y.h5"])
def test_names_that_no_part_has(stopped, name):
    """They are not read, and a resume clears them away."""
    (folder_of(stopped) / name).write_bytes(b"")
    assert smidgen.resume(stopped).meta["status"] == "complete"


def test_planted_links_and_pipes(stopped, tmp_path):
    victim = tmp_path / "victim"
    victim.write_text("dear")
    folder = folder_of(stopped)
    (folder / "lock").unlink()
    (folder / "lock").symlink_to(victim)
    with pytest.raises(smidgen.CheckpointError, match="cannot use"):
        smidgen.resume(stopped)
    (folder / "lock").unlink()
    part = Folder(stopped).parts("run")[0].path
    part.unlink()
    os.mkfifo(part)
    with pytest.raises(smidgen.CheckpointError, match="not a regular file"):
        smidgen.resume(stopped)
    assert victim.read_text() == "dear"


def test_a_file_is_not_written_through_a_link(tmp_path):
    from smidgen.run.files.durable import FRESH, write_new
    victim = tmp_path / "victim"
    victim.write_text("dear")
    (tmp_path / f"a{FRESH}").symlink_to(victim)
    with pytest.raises(OSError):
        write_new(tmp_path / "a", b"new")
    assert victim.read_text() == "dear" and not (tmp_path / "a").exists()


# Starts

@pytest.mark.parametrize("name", ["w.csv", "w.npy"])
def test_starts_that_are_no_files(tmp_path, name):
    path = tmp_path / name
    for make in (lambda: os.mkfifo(path), lambda: path.symlink_to("/dev/zero"), path.mkdir, lambda: path.write_bytes(npy(TERABYTES)),
                 lambda: path.write_bytes(b"\x93NUMPY\x01\x00\x76\x00" + b"(" * 117 + b"\n"), lambda: None):
        make()
        assert cli.main(["run", "free_rigid_body", "--start", str(path)]) == 2
        if path.is_dir():
            path.rmdir()
        elif os.path.lexists(path):
            path.unlink()
