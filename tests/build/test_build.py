"""The build cache: same content, same build; anything else, another; two at once are safe."""
import contextlib
import dataclasses
import json
import multiprocessing
import os
import stat
import threading
import time
from importlib import import_module

import pytest
import smidgen
from smidgen.build import cache
from support import toy as model
from smidgen.build.binary import build_library, cache_folder, find_compiler, generator_digest

pytestmark = pytest.mark.quick
BUILD = import_module("smidgen.build.binary")


@pytest.fixture(autouse=True)
def fresh(tmp_path, monkeypatch):
    """An empty cache and a count of generations."""
    monkeypatch.setenv("SMIDGEN_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def spec():
    return dataclasses.replace(smidgen.load_text(model.SPEC), path="")


class Counting:
    """A generator that counts its calls."""

    def __init__(self, source=model.SOURCE):
        self.calls, self.source = 0, source

    def __call__(self, spec, method, solver, features):
        self.calls += 1
        return {"toy.h": model.HEADER, "toy_abi.c": self.source}, {"solver": "exact"}


def test_a_second_build_is_found(spec):
    made = Counting()
    first, second = (build_library(spec, generate=made) for _ in range(2))
    assert made.calls == 1
    assert first == second and first.binary.exists() and first.notes == {"solver": "exact"}


@pytest.mark.parametrize("change", [
    {"method": "classical-midpoint"}, {"solver": "plain"}, {"real": "long double"},
    {"native": True}])
def test_a_choice_makes_another_build(spec, change):
    made = Counting()
    one = build_library(spec, generate=made)
    other = build_library(spec, generate=made, **change)
    assert made.calls == 2 and one.binary != other.binary


def test_another_spec_makes_another_build(spec):
    made = Counting()
    build_library(spec, generate=made)
    build_library(dataclasses.replace(spec, orientation=-1), generate=made)
    assert made.calls == 2


def test_the_place_of_a_spec_does_not_matter(spec):
    made = Counting()
    build_library(spec, generate=made)
    build_library(dataclasses.replace(spec, path="/elsewhere/toy.toml"), generate=made)
    assert made.calls == 1


def test_another_generator_makes_another_build(spec, monkeypatch):
    made = Counting()
    build_library(spec, generate=made)
    monkeypatch.setattr(BUILD, "generator_digest", lambda: "0" * 64)
    build_library(spec, generate=made)
    assert made.calls == 2


def test_the_generator_is_known_by_its_content(tmp_path, monkeypatch):
    for name in ("code/language", "code/read", "code/compile", "code/run", "templates", "runtime"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "a").write_text(name)
    monkeypatch.setattr(BUILD, "HERE", tmp_path / "code")
    monkeypatch.setattr(BUILD, "folder", lambda name: tmp_path / name)
    digests = []
    for change in ("runtime/a", "templates/a", "code/compile/a", "code/language/a", "code/read/a", "code/run/a"):
        generator_digest.cache_clear()
        digests.append(generator_digest())
        (tmp_path / change).write_text("changed")
    generator_digest.cache_clear()
    digests.append(generator_digest())
    generator_digest.cache_clear()
    assert len(set(digests[:6])) == 6 and digests[5] == digests[6]    # what comes after the compiler decides nothing


def test_compile_errors_name_a_log(spec):
    with pytest.raises(smidgen.BuildError) as caught:
        build_library(spec, generate=Counting("int f(void) { return nonsense; }\n"))
    log = str(caught.value).rsplit(" ", 1)[1]
    assert "nonsense" in str(caught.value) and "nonsense" in caught.value.log
    assert "nonsense" in open(log).read()
    assert caught.value.exit_code == 7


def test_a_failed_build_leaves_nothing_to_be_found(spec):
    with pytest.raises(smidgen.BuildError):
        build_library(spec, generate=Counting("#error no\n"))
    assert not [p for p in cache_folder().iterdir() if p.is_dir()]
    assert build_library(spec, generate=Counting()).binary.exists()


def test_no_compiler(spec, monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(smidgen.MissingTool, match="apt-get install gcc") as caught:
        build_library(spec, generate=Counting())
    assert caught.value.exit_code == 6


def test_cc_is_heeded(monkeypatch):
    monkeypatch.setenv("CC", "gcc -m64")
    assert find_compiler()[0].endswith("gcc") and find_compiler()[1:] == ("-m64",)
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(smidgen.MissingTool, match="no-such-compiler"):
        find_compiler()


@pytest.mark.parametrize("words, said", [
    ("gcc '", "No closing quotation"), ('"gcc', "No closing quotation"), ("gcc \\", "No escaped character"),
    ("g++", "compiles C\\+\\+, not C"), ("gcc -x c++", "compiles C\\+\\+"), ("''", "was not found"), ("/", "was not found"),
    ("/etc/passwd", "was not found"), ("{script}", "cannot run")])
def test_what_is_no_c_compiler(spec, tmp_path, monkeypatch, words, said):
    script = tmp_path / "cc"
    script.write_bytes(b"\x7fELF no program")
    script.chmod(0o755)
    monkeypatch.setenv("CC", words.format(script=script))
    with pytest.raises(smidgen.MissingTool, match=said):
        build_library(spec, generate=Counting())


@pytest.mark.parametrize("words, said", [("true", "did not write a library"), ("false", "did not write a library"), ("gcc --no-such", "no-such"),
                                         ("gcc -E", "linking not done"), ("gcc -fvisibility=hidden", "does not export the function")])
def test_compilers_that_make_no_library_of_use(toy, monkeypatch, words, said):
    monkeypatch.setenv("CC", words)
    with pytest.raises(smidgen.BuildError, match=said):
        smidgen.build(toy)


def test_what_a_compiler_says_need_not_be_text(spec, tmp_path, monkeypatch):
    script = tmp_path / "cc"
    script.write_text("#!/bin/sh\nprintf 'error: \\377\\376\\n' >&2; printf '\\377'; exit 1\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    with pytest.raises(smidgen.BuildError, match="error: "):
        build_library(spec, generate=Counting())


def test_generated_names_stay_in_their_folder(spec):
    with pytest.raises(smidgen.BuildError, match="not a file name"):
        build_library(spec, generate=lambda *_: ({"../evil.c": ""}, {}))


def test_a_cache_that_cannot_be_made(spec, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SMIDGEN_CACHE", str(tmp_path / "file" / "cache"))
    with pytest.raises(smidgen.BuildError, match="SMIDGEN_CACHE"):
        build_library(spec, generate=Counting())


def test_many_at_once_make_one(spec, tmp_path):
    context = multiprocessing.get_context("fork")
    with context.Pool(4) as pool:
        found = pool.map(_build_counted, [(spec, tmp_path)] * 8)
    assert len(set(found)) == 1
    assert len(list(tmp_path.glob("made-*"))) == 1
    assert not [p for p in cache_folder().iterdir() if p.name.startswith(".building")]


def _build_counted(given):
    spec, folder = given

    def generate(*args):
        handle = os.open(folder / f"made-{os.getpid()}-{os.times().elapsed}", os.O_CREAT)
        os.close(handle)
        return model.generate(*args)
    return str(build_library(spec, generate=generate).binary)


def test_the_cache_forgets_the_oldest(spec, monkeypatch):
    monkeypatch.setattr(cache, "KEPT", 2)
    monkeypatch.setattr(cache, "RECENT", 0)
    for solver in ("auto", "newton", "plain", "rotation"):
        last = build_library(spec, solver=solver, generate=Counting())
    kept = [p for p in cache_folder().iterdir() if (p / "built.json").exists()]
    assert len(kept) == 2 and last.folder in kept


def test_the_cache_forgets_old_logs_and_what_killed_processes_left(spec):
    build_library(spec, generate=Counting())
    left, fresh = [cache_folder() / name for name in ("failed-old.log", ".building-old")], cache_folder() / "failed-new.log"
    left[1].mkdir()
    for path in (left[0], fresh):
        path.touch()
    for path in left:
        os.utime(path, (1, 1))
    build_library(spec, solver="newton", generate=Counting())
    assert fresh.exists() and not any(map(os.path.exists, left))


def test_the_cache_keeps_what_may_just_be_loaded(spec, monkeypatch):
    """However many there are: the process that found an entry reads it after it has left the lock."""
    monkeypatch.setattr(cache, "KEPT", 1)
    built = [build_library(spec, solver=solver, generate=Counting()) for solver in ("auto", "newton", "plain")]
    assert all(one.binary.exists() for one in built)


def test_an_entry_found_by_another_process_stays(spec, monkeypatch):
    """It is used between the look at the times and the removal."""
    built = build_library(spec, generate=Counting())
    os.utime(built.folder, (1, 1))
    monkeypatch.setattr(cache, "KEPT", 0)
    whole = cache.lock

    @contextlib.contextmanager
    def used_meanwhile(place):
        os.utime(built.folder)
        with whole(place):
            yield
    monkeypatch.setattr(cache, "lock", used_meanwhile)
    cache._prune(cache_folder())
    assert built.binary.exists()
    os.utime(built.folder, (1, 1))
    monkeypatch.setattr(cache, "lock", whole)
    cache._prune(cache_folder())
    assert not built.binary.exists() and not built.folder.with_suffix(".lock").exists()


def test_a_lock_that_was_removed_is_taken_anew(tmp_path):
    """Two that hold different files of one name would both be at work."""
    place, taken = tmp_path / "entry", []
    first = cache.locked(place.with_suffix(".lock"), 0o600, wait=True)

    def wait():
        with cache.lock(place):
            taken.append(os.stat(place.with_suffix(".lock")).st_ino)
    other = threading.Thread(target=wait)
    other.start()
    time.sleep(0.2)
    place.with_suffix(".lock").unlink()
    fresh = os.open(place.with_suffix(".lock"), os.O_RDWR | os.O_CREAT, 0o600)
    os.close(first)
    other.join(10)
    assert taken == [os.fstat(fresh).st_ino]


def test_what_is_built_can_be_read(spec):
    built = build_library(spec, generate=Counting())
    assert json.loads((built.folder / "built.json").read_text())["notes"] == built.notes
    assert "-ffp-contract=off" in built.flags and "-march=native" not in built.flags
    assert built.binary.stat().st_mode & stat.S_IRUSR


class InLanes(Counting):
    """The same, with a note that the model has vectors of lanes."""

    def __call__(self, *wanted):
        files, notes = super().__call__(*wanted)
        return files, {**notes, "lanes": True}


def test_a_model_in_lanes_is_compiled_for_this_processor(spec):
    """By default, since its bits are the same; not where a library for every processor is asked for."""
    assert "-march=native" in build_library(spec, generate=InLanes()).flags
    assert "-march=native" not in build_library(spec, generate=InLanes(), native=False).flags
    assert "-march=native" in build_library(spec, generate=InLanes()).flags      # of the one that is found


def test_a_compiler_that_cannot_compile_for_this_processor_is_not_asked_to(spec, monkeypatch):
    monkeypatch.setattr(BUILD, "NATIVE", ("-march=nowhere",))
    assert "-march=nowhere" not in build_library(spec, generate=InLanes()).flags


def test_a_cache_shared_by_processors_keeps_their_builds_apart(spec, monkeypatch):
    one = build_library(spec, generate=InLanes())
    monkeypatch.setattr(BUILD, "processor", lambda: "another")
    assert build_library(spec, generate=InLanes()).binary != one.binary


def test_a_new_value_is_no_new_build(toy):
    one = smidgen.build(toy, parameters={"J": 2.0, "shift": [1.0, 2.0]})
    other = smidgen.build(toy, parameters={"J": 3.0})
    assert one.built.binary == other.built.binary == smidgen.build(toy, parameters={"n": 4}).built.binary


def test_a_cache_that_cannot_be_written(spec, tmp_path, monkeypatch):
    """A folder stands where the lock should be: as good as no permission, for root too."""
    place = cache_folder()
    monkeypatch.setattr(BUILD, "digest", lambda *parts: "0" * 64)
    (place / f"toy-{'0' * 32}.lock").mkdir()
    with pytest.raises(smidgen.BuildError, match="set SMIDGEN_CACHE"):
        build_library(spec, generate=Counting())


def test_a_library_that_cannot_be_loaded(toy):
    built = smidgen.build(toy).built
    copy = dataclasses.replace(built, binary=built.binary.with_name("copy.so"))
    copy.binary.write_bytes(b"no library")
    with pytest.raises(smidgen.BuildError, match="cannot load"):
        smidgen.Integrator(smidgen.build(toy).prepared, copy)
