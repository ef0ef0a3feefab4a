"""C to shared library, cached by content.

The key of a build is a digest of all that its bytes depend on: the selected spec without
texts and run-time values (`program_of`), the plan of its step, the generator's own sources
with templates and runtime, compiler, flags. So a build serves all sizes that lead to one
plan. A model with vectors of lanes is compiled for this processor: it has the same bits with
vectors of every width. Two builds of the same thing at once are safe, and so is the library that is found: `cache.py`.
"""
from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from ..methods import DEFAULT
from ..version import __version__
from ..compile.features import chosen_features
from ..compile.plan.plan import Plan, choose
from ..compile.program import program_of
from ..errors import BuildError, MissingTool, UsageError
from ..language.spec import Spec
from ..resources import HERE, folder, include_flags
from .cache import cache_folder, entry
from .mpi import mpi_compiler

FLAGS = ("-std=c11", "-O3", "-ffp-contract=off", "-fno-math-errno")    # the same bits on every machine; roots in lanes, since they set no errno
SECOND = ("-O2", "-fno-tree-vectorize")    # of lattices by rows: Newton and energies, which few steps need, take half of the time of -O3; loops that are not unrolled would be fused, too
SHARED = ("-fPIC", "-shared")
NATIVE = ("-march=native",)
THREADS = ("-fopenmp",)
UNFUSED = ("-fno-tree-slp-vectorize",)       # gcc 12: its vectoriser of straight-line code fuses products and sums whatever -ffp-contract says
FAST = (*NATIVE, "-ffp-contract=fast")      # the last word on contraction counts
REALS = {"double": (), "long double": ("-DSMG_LONG_DOUBLE",)}
LIBRARY = "model.so"
GENERATOR = ("methods.py", "version.py", "language", "effects", "read", "compile")     # what decides the generated text, beside templates and runtime


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


def build_library(spec: Spec, method: str = DEFAULT, solver: str = "auto",
                  real: str = "double", native: bool | None = None, features=(), generate=None, fast: bool = False,
                  threads: bool = False, ranks: bool = False, grid: tuple = (), defines: tuple = (),
                  plan: Plan | None = None) -> Built:
    """Generate and compile a selected spec, or find it in the cache.

    real: "double" or "long double"; native: -march=native or not; None: for models with vectors of lanes; fast: products and sums
    in one operation too, which the digits of extended precision do not survive; features: names of `features.FEATURES`; threads:
    with OpenMP; ranks: with MPI, and grid: flags for the grid of ranks, which no result tells: they decide no bit; generate: in place of the
    generator, and defines: flags beside the others, which must tell its text from that of others; plan: of this spec, method and solver, where it is known. Raises UsageError for a name that is none and for threads where steps have none, MissingTool without a C compiler,
    without OpenMP or mpicc, and BuildError when it refuses.
    """
    features, compiler = chosen_features(features), find_compiler()
    if fast and "extended" in features:
        raise UsageError("extended precision cannot be combined with a fast build")
    flags = (*FLAGS, *SHARED, *REALS[real], *(FAST if fast else NATIVE if native else ()), *(threads_of(compiler) if threads else ()), *defines)
    wide = native is None and not fast
    caller = (*mpi_compiler(compiler), *grid) if ranks else compiler
    linked = (caller, ran([*caller, "-show"]).stdout) if ranks else ()
    program, plan = program_of(spec), choose(spec, method, solver) if plan is None else plan
    key = digest(identity(program), plan, solver, features, generator_digest(),
                 compiler_version(compiler), flags, UNFUSED, SECOND, wide, processor(), *linked)
    text = (lambda: _generate(program, plan, features)) if generate is None else lambda: generate(spec, method, solver, features)
    place = entry(f"{spec.name}-{key[:32]}",
                  lambda work: _build_into(work, text, caller, flags, wide, not ranks))
    facts = json.loads((place / "built.json").read_text())
    if threads and not facts["notes"].get("threads"):
        raise UsageError(f"steps of {spec.name} by {method} use one thread: only lattices processed by rows can use several")
    return Built(spec.name, place / LIBRARY, place, real, compiler_version(compiler),
                 tuple(facts["flags"]), facts["notes"], generator_name())


def find_compiler() -> tuple[str, ...]:
    """The C compiler: $CC (with its options), else the first of cc, gcc, clang. Raises MissingTool."""
    try:
        wanted = shlex.split(os.environ.get("CC", ""))
    except ValueError as problem:
        raise MissingTool(f"the environment variable CC does not hold a command: {problem} in {os.environ['CC']!r}") from None
    for words in ([wanted] if wanted else [["cc"], ["gcc"], ["clang"]]):
        path = shutil.which(words[0])
        if path:
            return _of_c((path, *words[1:]))
    raise MissingTool(f"no C compiler: {wanted[0]!r} was not found" if wanted else
                      "no C compiler (cc, gcc or clang) was found: install one, on Debian with apt-get install gcc libc6-dev")


@functools.lru_cache(maxsize=None)
def _of_c(compiler: tuple[str, ...]) -> tuple[str, ...]:
    """`compiler`, if it takes a file .c for C: in C++ the functions have other names."""
    with tempfile.TemporaryDirectory(prefix="smidgen-") as folder_:
        Path(folder_, "language.c").write_text("#ifdef __cplusplus\nno C\n#endif\n")
        if "no C" in ran([*compiler, "-E", "language.c"], folder_).stdout.splitlines():
            raise MissingTool(f"{shlex.join(compiler)} compiles C++, not C: set CC to a C compiler, such as gcc or clang")
    return compiler


def ran(command, cwd=None, hint: str = "") -> subprocess.CompletedProcess:
    """The finished process with what it said. Raises MissingTool for a program that cannot be started."""
    try:
        return subprocess.run(command, cwd=cwd, capture_output=True, text=True, errors="replace")
    except OSError as problem:
        raise MissingTool(f"cannot run {command[0]}: {problem.strerror}{hint}") from None


@functools.lru_cache(maxsize=None)
def compiler_version(compiler: tuple[str, ...]) -> str:
    """The first line of `cc --version`, after the options given in $CC."""
    said = ran([*compiler, "--version"])
    return " ".join([said.stdout.partition("\n")[0] or compiler[0], *compiler[1:]])


@functools.lru_cache(maxsize=None)
def takes(compiler: tuple[str, ...], flags: tuple[str, ...]) -> bool:
    """Does the compiler know these flags?"""
    with tempfile.TemporaryDirectory(prefix="smidgen-") as folder_:
        Path(folder_, "empty.c").write_text("#ifdef _OPENMP\n#include <omp.h>\n#endif\ntypedef int nothing;\n")
        return ran([*compiler, *flags, *SHARED, "empty.c", "-o", "empty.so"], folder_).returncode == 0


@functools.lru_cache(maxsize=None)
def macros_of(compiler: tuple[str, ...], flags: tuple[str, ...]) -> str:
    """The macros that the compiler defines with these flags; "" where it does not know them."""
    return ran([*compiler, *flags, "-dM", "-E", "-x", "c", os.devnull]).stdout


def native_of(compiler: tuple[str, ...]) -> tuple[str, ...]:
    """-march=native, where the compiler knows it."""
    return NATIVE if macros_of(compiler, NATIVE) else ()


@functools.lru_cache(maxsize=None)
def lanes_of(compiler: tuple[str, ...], flags: tuple[str, ...]) -> int:
    """Numbers of double precision in a register for which models with lanes are compiled by these flags, as smg_lanes.h has it."""
    with tempfile.TemporaryDirectory(prefix="smidgen-") as folder_:
        Path(folder_, "lanes.c").write_text('#define SMG_HAS_LANES 1\n#include "smg_lanes.h"\n')
        said = ran([*compiler, *flags, *include_flags(), "-dM", "-E", "lanes.c"], folder_).stdout
    return next((int(line.split()[2]) for line in said.splitlines() if line.startswith("#define SMG_NATIVE_LANES ")), 1)


@functools.lru_cache(maxsize=None)
def unfused(compiler: tuple[str, ...], flags: tuple[str, ...]) -> tuple[str, ...]:
    """What keeps gcc from fusing products and sums, where the processor that these flags name can, and they do not ask for it."""
    if FAST[-1] in flags:
        return ()
    macros = macros_of(compiler, flags)
    return UNFUSED if "__FP_FAST_FMA " in macros and "__GNUC__" in macros and "__clang__" not in macros else ()


def threads_of(compiler: tuple[str, ...]) -> tuple[str, ...]:
    """The flags for OpenMP. Raises MissingTool."""
    if not takes(compiler, THREADS):
        raise MissingTool(f"{shlex.join(compiler)} does not support OpenMP, which threads require; on Debian, use gcc, or clang with libomp-dev")
    return THREADS


@functools.lru_cache(maxsize=None)
def processor() -> str:
    """This kind of processor by what it can do: a cache may be shared by machines of several kinds."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    kinds = [line for line in lines if line.lower().startswith(("model name", "flags", "features"))]
    return digest(platform.machine(), platform.processor(), sorted(set(kinds)))


@functools.lru_cache(maxsize=None)
def generator_digest() -> str:
    """Digest of what decides the generated text: the compiler's own modules and templates."""
    roots = [*(HERE / stage for stage in GENERATOR), folder("templates"), folder("runtime")]
    files = sorted(p for root in roots for p in (root, *root.rglob("*")) if p.is_file() and "__pycache__" not in p.parts)
    return digest(*((p.name, p.read_bytes()) for p in files))


def generator_name() -> str:
    """Version and content of the generator, as results record it."""
    return f"smidgen {__version__} {generator_digest()[:16]}"


def digest(*parts) -> str:
    """sha256 of the repr of `parts`."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def identity(spec: Spec) -> str:
    """All of a spec; its repr is a short line."""
    return repr([(f.name, getattr(spec, f.name)) for f in dataclasses.fields(spec)])


def _generate(program, plan, features):
    from ..compile.emit.emit import emitted
    return emitted(program, plan, features)


def _build_into(work, text, compiler, flags, wide, apart=True):
    files, notes = split_notes(text())
    if wide and notes.get("lanes"):
        flags = (*flags, *native_of(compiler))
    flags = (*flags, *unfused(compiler, flags))
    write_files(files, work)
    compile_shared(work, sorted(f for f in files if f.endswith(".c")), compiler, flags, notes.get("units", 1) if apart else 1, SECOND if notes.get("rows") else ())
    (work / "built.json").write_text(json.dumps({"notes": notes, "flags": flags}))


def split_notes(made) -> tuple[dict, dict]:
    """(files, notes) of what `generate` returned: a pair, or a mapping with `.notes`."""
    if isinstance(made, tuple):
        return made
    return made, getattr(made, "notes", {})


def write_files(files: dict, where: Path) -> None:
    """Write generated files; a name is one plain word, never a path."""
    for name, text in files.items():
        if Path(name).name != name:
            raise BuildError(f"{name!r} is not a file name")
        (where / name).write_text(text, encoding="utf-8")


def compile_shared(work: Path, sources, compiler, flags, units: int = 1, second=()) -> None:
    """model.so from `sources` in `work`, whose parts are compiled side by side: two of the model where it has two `units` (smg_defaults.h), the other one with the flags `second` after the others. BuildError names the log that is kept."""
    parts = [(source, f"{source}_{unit}.o", (f"-DSMG_UNIT={unit}", *(second if unit > 1 else ())) if units > 1 else ()) for source in sources for unit in (range(1, 2 if source.endswith("_abi.c") else 1 + units))]
    with ThreadPoolExecutor(len(parts)) as pool:
        objects = [word for word in (*compiler, *flags) if word != "-shared"]       # of which clang warns where nothing is linked
        list(pool.map(lambda part: _compile([*objects, *part[2], "-I", ".", *include_flags(), "-c", part[0], "-o", part[1]], work, part[1]), parts))
    _compile([*compiler, *flags, *(made for _, made, _ in parts), "-o", LIBRARY, "-lm"], work, LIBRARY)
    for _, made, _ in parts:
        (work / made).unlink()


def _compile(command, work: Path, made: str) -> None:
    """Raises BuildError where `command` does not make that file."""
    said = ran(command, work)
    if said.returncode or not (work / made).is_file():
        text = shlex.join(command) + "\n" + said.stderr
        log = _keep_log(text)
        first = next((line for line in said.stderr.splitlines() if "error" in line), "")
        raise BuildError(f"the C compiler failed: {first or said.stderr.strip()[:200] or 'it did not write a library'}\n"
                         f"its output is in {log}", log=text)


def _keep_log(text: str) -> Path:
    handle, name = tempfile.mkstemp(prefix="failed-", suffix=".log", dir=cache_folder())
    with os.fdopen(handle, "w") as out:
        out.write(text)
    return Path(name)
