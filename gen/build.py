"""C to shared library, cached by content.

The key of a build is a digest of all that its bytes depend on: the selected spec without
texts and run-time values (`program_of`), the plan of its step, the generator's own sources
with templates and runtime, compiler, flags. So a build serves all sizes that lead to one
plan. Two builds of the same thing at once are safe: a lock a key, a temporary folder, one rename.
"""
from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import functools
import hashlib
import json
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path

from . import __version__
from .errors import BuildError, MissingTool
from .features import chosen_features
from .plan import choose
from .program import program_of
from .resources import HERE, folder
from .spec import Spec

FLAGS = ("-std=c11", "-O3", "-ffp-contract=off")    # the same bits on every machine
SHARED = ("-fPIC", "-shared")
REALS = {"double": (), "long double": ("-DSMG_LONG_DOUBLE",)}
KEPT = 300      # builds that the cache keeps; the ones unused longest go first
DOWNSTREAM = {"cli", "plot", "witness", "integrator.py", "run.py", "settings.py",
              "given.py", "record.py", "recorded.py", "output.py", "progress.py", "validate.py", "verify", "demo",
              "checkpoint.py", "durable.py", "resume.py", "safe.py", "saved.py", "substeps.py",
              "lyapunov.py", "symmetry", "advice", "__pycache__"}     # no part of the generator


@dataclasses.dataclass(frozen=True)
class Built:
    """A compiled model. `notes` is what `generate` said it chose, by name."""
    name: str
    binary: Path
    folder: Path
    real: str
    compiler: str
    flags: tuple[str, ...]
    notes: dict
    generator: str


def build_library(spec: Spec, method: str = "spherical-midpoint", solver: str = "auto",
                  real: str = "double", native: bool = False, features=(), generate=None) -> Built:
    """Generate and compile a selected spec, or find it in the cache.

    real: "double" or "long double"; native: -march=native, whose bits differ between
    machines; features: names of `features.FEATURES`. Raises UsageError for a name that is none, MissingTool without a C compiler and BuildError when it refuses.
    """
    features, compiler = chosen_features(features), find_compiler()
    flags = (*FLAGS, *SHARED, *REALS[real], *(("-march=native",) if native else ()))
    key = digest(program_of(spec), choose(spec, method, solver), solver, features, generator_digest(),
                 compiler_version(compiler), flags, native and platform.processor())
    place = cache_folder() / f"{spec.name}-{key[:32]}"
    try:
        with _lock(place):
            if not (place / "built.json").exists():
                _build_into(place, generate or _generate, (spec, method, solver, features), compiler, flags)
            os.utime(place)
        facts = json.loads((place / "built.json").read_text())
    except OSError as problem:
        raise BuildError(f"cannot build in the cache {place.parent}: {problem.strerror}; "
                         "set SMIDGEN_CACHE to a folder that can be written") from None
    return Built(spec.name, place / "model.so", place, real, compiler_version(compiler),
                 flags, facts["notes"], generator_name())


def find_compiler() -> tuple[str, ...]:
    """The C compiler: $CC (with its options), else the first of cc, gcc, clang."""
    wanted = shlex.split(os.environ.get("CC", ""))
    for words in ([wanted] if wanted else [["cc"], ["gcc"], ["clang"]]):
        path = shutil.which(words[0])
        if path:
            return (path, *words[1:])
    raise MissingTool(f"no C compiler: {wanted[0]} is not there" if wanted else
                      "no C compiler (cc, gcc or clang): install one, on Debian with "
                      "apt-get install gcc libc6-dev")


@functools.lru_cache(maxsize=None)
def compiler_version(compiler: tuple[str, ...]) -> str:
    """The first line of `cc --version`, after the options given in $CC."""
    said = subprocess.run([*compiler, "--version"], capture_output=True, text=True)
    return " ".join([said.stdout.partition("\n")[0] or compiler[0], *compiler[1:]])


@functools.lru_cache(maxsize=None)
def generator_digest() -> str:
    """Digest of what decides the generated text: the compiler's own modules and templates."""
    files = sorted(p for root in (HERE, folder("templates"), folder("runtime"))
                   for p in root.rglob("*") if p.is_file()
                   and not DOWNSTREAM & set(p.relative_to(root).parts))
    return digest(*((p.name, p.read_bytes()) for p in files))


def generator_name() -> str:
    """Version and content of the generator, as results record it."""
    return f"smidgen {__version__} {generator_digest()[:16]}"


def digest(*parts) -> str:
    """sha256 of the repr of `parts`."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def cache_folder() -> Path:
    """$SMIDGEN_CACHE, else smidgen in $XDG_CACHE_HOME or ~/.cache; made when missing."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    place = Path(os.environ.get("SMIDGEN_CACHE") or Path(base) / "smidgen")
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise BuildError(f"cannot make the cache {place}: {problem.strerror}; "
                         "set SMIDGEN_CACHE to a folder that can be written") from None
    return place


def _generate(spec, method, solver, features):
    from .emit import generate_program
    return generate_program(spec, method, solver, features)


@contextlib.contextmanager
def _lock(place: Path):
    """One process at a time; the kernel frees the lock of one that dies."""
    with open(place.with_suffix(".lock"), "w") as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield


def _build_into(place, generate, wanted, compiler, flags):
    work = Path(tempfile.mkdtemp(prefix=".building-", dir=place.parent))
    try:
        made = generate(*wanted)
        files, notes = split_notes(made)
        write_files(files, work)
        compile_shared(work, sorted(f for f in files if f.endswith(".c")), compiler, flags)
        (work / "built.json").write_text(json.dumps({"notes": notes}))
        with contextlib.suppress(FileExistsError):      # another one has just made it
            os.rename(work, place)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    _prune(place.parent)


def split_notes(made) -> tuple[dict, dict]:
    """(files, notes) of what `generate` returned: a pair, or a mapping with `.notes`."""
    if isinstance(made, tuple):
        return made
    return made, getattr(made, "notes", {})


def write_files(files: dict, where: Path) -> None:
    """Write generated files; a name is one plain word, never a path."""
    for name, text in files.items():
        if Path(name).name != name:
            raise BuildError(f"{name!r} is no file name")
        (where / name).write_text(text, encoding="utf-8")


def compile_shared(work: Path, sources, compiler, flags) -> None:
    """model.so from `sources` in `work`. BuildError names the log that is kept."""
    command = [*compiler, *flags, "-I", ".", "-I", str(folder("runtime")),
               *sources, "-o", "model.so", "-lm"]
    said = subprocess.run(command, cwd=work, capture_output=True, text=True)
    if said.returncode:
        text = shlex.join(command) + "\n" + said.stderr
        log = _keep_log(text)
        first = next((line for line in said.stderr.splitlines() if "error" in line), "")
        raise BuildError(f"the C compiler failed: {first or said.stderr.strip()[:200]}\n"
                         f"all it said is in {log}", log=text)


def _keep_log(text: str) -> Path:
    handle, name = tempfile.mkstemp(prefix="failed-", suffix=".log", dir=cache_folder())
    with os.fdopen(handle, "w") as out:
        out.write(text)
    return Path(name)


def _prune(cache: Path) -> None:
    """Forget the builds unused longest. A loaded library survives its file on Linux."""
    builds = sorted((p for p in cache.iterdir() if (p / "built.json").exists()),
                    key=lambda p: p.stat().st_mtime, reverse=True)
    for old in builds[KEPT:]:
        shutil.rmtree(old, ignore_errors=True)
        old.with_suffix(".lock").unlink(missing_ok=True)
