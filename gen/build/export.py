"""What another program links: sources with the headers they need, or a library.

    export_sources   <model>.h, <model>.c, runtime headers; or the two amalgamated files
    export_library   include/, lib/lib<model>.a, lib/pkgconfig/<model>.pc
"""
from __future__ import annotations

import tempfile
from pathlib import Path

from ..version import __version__
from ..compile.emit.includes import included, macros_of
from ..errors import BuildError, OutputError, UsageError
from ..language.spec import Spec
from ..resources import runtime_header
from .binary import FLAGS, find_compiler, ran, split_notes, unfused, write_files

# lib<model>.a would be found in the place of these: of C, its compilers and their run times.
LIBRARIES = frozenset("c m dl rt pthread util mvec crypt resolv gcc gcc_s atomic gomp omp quadmath mpi".split())


def export_sources(spec: Spec, where, method: str, solver: str, amalgamate: bool = False, features=(), finish=lambda files: files):
    """Write the C of a selected spec to the folder `where`; returns (files, notes, what a step takes at most).

    finish: what is done to the files (name -> text) before they are written.
    """
    from ..compile.emit.emit import generate
    made = generate(spec, method=method, solver=solver, amalgamate=amalgamate, features=features)
    files, notes = split_notes(made)
    linked = {name: text for name, text in files.items() if not name.endswith("_abi.c")}
    if not amalgamate:
        linked.update(runtime_headers(linked))
    linked = finish(linked)
    _write(linked, Path(where))
    return [Path(where) / name for name in linked], notes, made.most


def runtime_headers(files: dict) -> dict:
    """The headers of the runtime that `files` include, directly or not."""
    found, waiting = {}, list(files.values())
    macros = {name: value for text in files.values() for name, value in macros_of(text).items()}
    while waiting:
        for name in included(waiting.pop(), macros):
            path = runtime_header(name)
            if name not in files and name not in found and path is not None:
                found[name] = path.read_text(encoding="utf-8")
                waiting.append(found[name])
    return found


def export_library(spec: Spec, where, method: str, solver: str, features=()):
    """Build lib<model>.a with headers and a .pc file below `where`; returns (files, notes). Raises UsageError for the name of a system library."""
    where, name = Path(where), spec.name
    if name.lower() in LIBRARIES:
        raise UsageError(f"a library of the model `{name}` would be called lib{name}.a and would hide the system library of that name: rename the model")
    include, lib = where / "include", where / "lib"
    with tempfile.TemporaryDirectory(prefix="smidgen-") as work:
        files, notes, _ = export_sources(spec, work, method, solver, features=features)
        headers = {f.name: f.read_text() for f in files if f.suffix == ".h"}
        _write(headers, include)
        _write({f"{name}.pc": pkgconfig(spec)}, lib / "pkgconfig")
        _archive(Path(work), name, lib / f"lib{name}.a")
    return [*(include / h for h in headers), lib / f"lib{name}.a",
            lib / "pkgconfig" / f"{name}.pc"], notes


def pkgconfig(spec: Spec) -> str:
    """The .pc file: relative to itself, so that the folder may be moved."""
    title = " ".join(spec.title.split()) or spec.name
    return (f"prefix=${{pcfiledir}}/../..\n\nName: {spec.name}\nDescription: {title}\n"
            f"Version: {__version__}\nCflags: -I${{prefix}}/include\n"
            f"Libs: -L${{prefix}}/lib -l{spec.name} -lm\n")


def _archive(work: Path, name: str, target: Path):
    _tool([*find_compiler(), *FLAGS, *unfused(find_compiler(), FLAGS), "-fPIC", "-I", ".", "-c", f"{name}.c", "-o", f"{name}.o"], work)
    target.unlink(missing_ok=True)
    _tool(["ar", "rcsD", str(target.resolve()), f"{name}.o"], work)


def _tool(command, work):
    said = ran(command, work, " (Debian: install binutils)")
    if said.returncode:
        raise BuildError(f"{command[0]} failed: {said.stderr.strip()[:400]}", log=said.stderr)


def _write(files, where):
    try:
        where.mkdir(parents=True, exist_ok=True)
        write_files(files, where)
    except OSError as problem:
        raise OutputError(f"cannot write to {where}: {problem.strerror}") from None
