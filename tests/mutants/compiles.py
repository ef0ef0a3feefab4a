"""A program: generate and compile many models with the tree it lies in, and print a digest of each.

    python compiles.py few|all text|syntax|objects [NAME ..]

Exit status 1: something is not generated or not compiled; stderr says what. The digests, a JSON
object by name, are of the C without comments (text; syntax: looked at by the compiler too) or of
the object code (objects). For the objects, and where `headers` is among the names, the test programs
of the runtime are compiled, too.
"""
import hashlib
import itertools
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from support import texts
from support.features import ANYWHERE, DIVIDED
from support.filters import HERE, WARNINGS

import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.errors import UsageError
from smidgen.compile.features import FEATURES
from smidgen.methods import METHODS, MIDPOINTS, SOLVERS
from smidgen.run.step.prepared import scene_of
from smidgen.resources import folder, include_flags

SPHERICAL, CLASSICAL, VESELOV = MIDPOINTS
COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
FEW = (("free_rigid_body", SPHERICAL, "auto"), ("free_rigid_body", VESELOV, "auto"),
       ("forced_rigid_body", SPHERICAL, "auto"), ("forced_rigid_body", CLASSICAL, "auto"),
       ("heisenberg_chain", SPHERICAL, "auto"), ("heisenberg_chain", CLASSICAL, "auto"),
       ("j1j2_chain", SPHERICAL, "newton"), ("point_vortices", SPHERICAL, "auto"), ("product", CLASSICAL, "auto"),
       ("product", SPHERICAL, "rotation"), ("vortex_tracers", SPHERICAL, "auto"),
       ("cubic_lattice", SPHERICAL, "auto"), ("honeycomb", SPHERICAL, "auto"), ("mixed", SPHERICAL, "auto"),
       ("open", SPHERICAL, "plain"), ("glass", SPHERICAL, "newton"), ("corners", SPHERICAL, "auto"))
TEXTS = {"field": texts.FIELD, "mixed": texts.MIXED, "glass": texts.GLASS, "pulse": texts.PULSE,
         "open": texts.OPEN_CHAIN, "corners": texts.CORNERS}
OTHERS = tuple((name, method, "auto") for method in METHODS if method not in MIDPOINTS
               for name in ("free_rigid_body", "heisenberg_chain", "point_vortices"))
OF_MODELS = ("composed", "late_messages", "most", "omp_in_sight")     # test programs that need a model, which `wanted` has, MPI, or threads
MORE = {"gauss": ("-DSMG_STAGES=3", "-DFIELD=0")}
FILTERS = [(name, bs) for name in sorted(p.stem for p in (HERE / "runtime").glob("*.c")) if name not in OF_MODELS for bs in (2, 3)]


def spec_of(name: str, place: Path):
    """A shipped spec, one of tests/user, or one of tests/support/texts.py."""
    if name in TEXTS:
        return texts.read(TEXTS[name], place)
    shipped = folder("specs") / f"{name}.toml"
    return smidgen.load(shipped if shipped.exists() else HERE / "user" / f"{name.removeprefix('user/')}.toml")


def wanted(which: str):
    """(spec, method, solver, features): a few that use every template, or all there are."""
    if which == "few":
        yield from ((*one, ()) for one in FEW)
        yield from (("heisenberg_chain", SPHERICAL, "auto", features) for features in (ANYWHERE, DIVIDED))
        yield from ((*one, ()) for one in OTHERS if not METHODS[one[1]].variant)
        return
    names = [*(p.stem for p in sorted(folder("specs").glob("*.toml"))), *TEXTS,
             *(f"user/{p.stem}" for p in sorted((HERE / "user").glob("*.toml")))]
    for name, (method, solver) in itertools.product(names, [(SPHERICAL, s) for s in SOLVERS] + [
            (CLASSICAL, "auto"), (VESELOV, "auto")]):
        yield name, method, solver, ()
    for name, feature in itertools.product(names, FEATURES):
        yield name, SPHERICAL, "auto", (feature,)
    yield from ((*one, ()) for one in OTHERS if one[0] == OTHERS[0][0])      # variants too: of one model


def compiled(words, where: Path, source: str, objects: bool) -> bytes:
    """Object code of one file, or nothing when only its syntax is looked at."""
    how = ["-O2", "-c", "-o", "one.o"] if objects else ["-fsyntax-only"]
    subprocess.run(["gcc", "-std=c11", "-ffp-contract=off", *words, *how, source], cwd=where, check=True,
                   capture_output=True, text=True)
    return (where / "one.o").read_bytes() if objects else b""


def model_digest(which, place: Path, how: str):
    """Of one model; None where the generator refuses the combination."""
    name, method, solver, features = which
    try:
        files = generate(scene_of(spec_of(name, place)), method, solver, features=features)
    except UsageError:
        return None
    parts = [COMMENT.sub("", text).encode() for text in files.values()] if how != "objects" else []
    for file, text in files.items():
        (place / file).write_text(text)
    for file in sorted(f for f in files if f.endswith(".c") and how != "text"):
        parts.append(compiled(["-I.", *include_flags()], place, file, how == "objects"))
    return digest(parts)


def filter_digest(name: str, bs: int, place: Path, how: str) -> str:
    """Of one test program, compiled with all the warnings that its test asks for."""
    words = [*WARNINGS, f"-DSMG_BS={bs}", *MORE.get(name, ()), *include_flags(), f"-I{HERE / 'runtime'}"]
    (place / f"{name}.c").write_text((HERE / "runtime" / f"{name}.c").read_text())
    return digest([compiled(words, place, f"{name}.c", how == "objects")])


def digest(parts) -> str:
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def digests(which: str, how: str, names) -> dict:
    """{name: digest} of the models, or of those named, and of the test programs of the runtime."""
    found = {}
    with tempfile.TemporaryDirectory() as place:
        for one in wanted(which):
            name = "/".join([*one[:3], *one[3]])
            made = model_digest(one, Path(place), how) if not names or name in names else None
            if made is not None:
                found[name] = made
        for name, bs in FILTERS if "headers" in names or how == "objects" and not names else ():
            found[f"{name}{bs}"] = filter_digest(name, bs, Path(place), how)
    return found


if __name__ == "__main__":
    try:
        print(json.dumps(digests(sys.argv[1], sys.argv[2], sys.argv[3:])))
    except subprocess.CalledProcessError as problem:
        sys.exit(problem.stderr)
