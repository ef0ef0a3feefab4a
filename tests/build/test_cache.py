"""The cache is ours alone, follows no link, and nothing in it is loaded that is not as it was made."""
import os

import pytest
import smidgen
from smidgen.build import cache
from smidgen.build.cache import SEAL, cache_folder, entry, lock

pytestmark = pytest.mark.quick


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """A cache that does not exist yet."""
    monkeypatch.setenv("SMIDGEN_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def made(content=b"library"):
    """An entry, and how often it was made."""
    calls = []

    def make(work):
        calls.append(work)
        (work / "a.so").write_bytes(content)
        (work / "built.json").write_text("{}")
    return entry("a-1", make), len(calls)


def test_an_entry_is_made_once():
    one, first = made()
    assert (one / "a.so").read_bytes() == b"library" and (first, made()[1]) == (1, 0)


@pytest.mark.filterwarnings("ignore:.*damaged")
@pytest.mark.parametrize("name", ["a.so", "built.json", SEAL])
def test_every_bit_is_watched(name):
    path = made()[0] / name
    good = path.read_bytes()
    for at in range(0, 8 * len(good), 3):
        data = bytearray(good)
        data[at // 8] ^= 1 << at % 8
        path.write_bytes(data)
        assert made()[1] == 1 and path.read_bytes() == good


def cut(path):
    path.write_bytes(path.read_bytes()[:-1])


def linked(path):
    path.rename(path.with_name("elsewhere"))
    path.symlink_to("elsewhere")


@pytest.mark.parametrize("damage", [
    lambda e: cut(e / "a.so"), lambda e: (e / "a.so").unlink(), lambda e: (e / SEAL).unlink(), lambda e: cut(e / SEAL),
    lambda e: (e / "more.so").write_bytes(b""), lambda e: e.chmod(0o777), lambda e: e.chmod(0o720), linked,
    lambda e: os.chown(e, 12345, -1) if os.getuid() == 0 else e.chmod(0o702)])
def test_what_is_not_as_it_was_made_is_made_again(damage):
    damage(made()[0])
    with pytest.warns(UserWarning, match="damaged or writable by other users"):
        found, count = made()
    assert count == 1 and (found / "a.so").read_bytes() == b"library" and made()[1] == 0


def test_what_changes_behind_a_link_is_seen(tmp_path):
    """The seal of a link to the same bytes is right, but its target may change while the link stays."""
    path = made()[0] / "a.so"
    path.rename(tmp_path / "elsewhere")
    path.symlink_to(tmp_path / "elsewhere")
    with pytest.warns(UserWarning, match="damaged"):
        assert made()[1] == 1
    assert not path.is_symlink() and made()[1] == 0


def test_a_digest_is_taken_once_and_again_after_a_change(monkeypatch):
    """In one process, of an entry whose files are so old that a change would have another time."""
    place, asked, digest = made()[0], [], cache.digest_of
    monkeypatch.setattr(cache, "digest_of", lambda place: asked.append(place) or digest(place))
    assert [made()[1] for _ in range(2)] == [0, 0] and len(asked) == 2
    monkeypatch.setattr(cache, "TICK", 0)
    assert [made()[1] for _ in range(3)] == [0, 0, 0] and len(asked) == 3
    flip(place / "a.so")
    with pytest.warns(UserWarning, match="damaged"):
        assert made()[1] == 1


def flip(path):
    """A bit in the middle; a new file, for the old one may be loaded."""
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.unlink()
    path.write_bytes(data)


def test_a_damaged_library_never_runs(toy):
    binary = smidgen.build(toy).built.binary
    good = binary.read_bytes()
    flip(binary)
    with pytest.warns(UserWarning, match="rebuilt"):
        again = smidgen.build(toy).built.binary
    assert again.read_bytes() == good


def test_the_witness_is_watched_too(monkeypatch):
    from smidgen.check.witness import native
    monkeypatch.setattr(native, "_compile", lambda command, work: (work / native.NAME).write_bytes(bytes(100)))
    library = native._built()
    good = library.read_bytes()
    flip(library)
    with pytest.warns(UserWarning, match="rebuilt"):
        assert native._built().read_bytes() == good


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o702, 0o1777, 0o720])
def test_a_cache_that_others_may_write_is_refused(place, mode):
    place.mkdir()
    place.chmod(mode)
    with pytest.raises(smidgen.BuildError, match=f"can be written by others .mode {mode:o}.*delete it.*SMIDGEN_CACHE"):
        made()
    assert list(place.iterdir()) == []


@pytest.mark.parametrize("mode", [0o700, 0o755, 0o500 | 0o200])
def test_a_cache_that_others_may_only_read_serves(place, mode):
    place.mkdir()
    place.chmod(mode)
    assert made()[1] == 1


@pytest.mark.skipif(os.getuid() != 0, reason="only root gives folders away")
@pytest.mark.parametrize("through_a_link", [False, True])
def test_a_cache_of_someone_else_is_refused(place, through_a_link):
    there = place.with_name("there") if through_a_link else place
    there.mkdir()
    if through_a_link:
        place.symlink_to(there)
    os.chown(place, 12345, -1, follow_symlinks=False)
    with pytest.raises(smidgen.BuildError, match="belongs to user 12345"):
        made()


def test_a_private_folder_in_one_like_tmp_serves(place, monkeypatch):
    """As $SMIDGEN_CACHE=/tmp/mine: what is new is made private, whatever the umask."""
    place.mkdir()
    place.chmod(0o1777)
    monkeypatch.setenv("SMIDGEN_CACHE", str(place / "mine"))
    before = os.umask(0)
    try:
        assert made()[1] == 1
    finally:
        os.umask(before)
    assert cache_folder().stat().st_mode & 0o777 == 0o700


def test_the_lock_follows_no_link_and_empties_nothing(place, tmp_path):
    victim = tmp_path / "victim"
    victim.write_text("dear")
    cache_folder()
    (place / "a-1.lock").symlink_to(victim)
    with pytest.raises(smidgen.BuildError, match="a-1.lock"):
        made()
    assert victim.read_text() == "dear"
    (place / "a-1.lock").unlink()
    (place / "a-1.lock").write_text("dear")
    made()
    assert (place / "a-1.lock").read_text() == "dear"


def test_a_planted_link_makes_no_file(place, tmp_path):
    cache_folder()
    (place / "a-1.lock").symlink_to(tmp_path / "new")
    with pytest.raises(OSError), lock(place / "a-1"):
        pass
    assert not (tmp_path / "new").exists()
