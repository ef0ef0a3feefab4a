"""`smidgen gen` and `smidgen build`: the C of a spec, and libraries of it."""
from __future__ import annotations

from .options import feature_option, json_option, model_options, spec_argument
from .say import notes_line, printed, say

GEN = """  smidgen gen heisenberg_chain --out chain
  smidgen gen top.toml --amalgamate --out .      two files, all that a program needs
  smidgen gen top.toml --effects kinetic --set I=1,2,4 --method classical-midpoint"""
BUILD = """  smidgen build top.toml                    compile into the cache, print the library
  smidgen build top.toml --out /usr/local   lib/libtop.a, include/top.h, lib/pkgconfig/top.pc"""


def add(commands):
    """Both sub-commands."""
    parser = commands.add("gen", gen, "write the C code of a spec", GEN)
    spec_argument(parser)
    model_options(parser)
    feature_option(parser)
    parser.add_argument("--out", default=".", metavar="DIR", help="folder to write to (default: the current one)")
    parser.add_argument("--amalgamate", action="store_true",
                        help="include the runtime in the generated files: one .h and one .c, nothing else")
    parser.add_argument("--certificate", metavar="FILE", help="a certificate written by `smidgen verify --json`, to be quoted in the header")
    json_option(parser)
    parser = commands.add("build", build, "compile a spec", BUILD)
    spec_argument(parser)
    model_options(parser)
    feature_option(parser)
    parser.add_argument("--out", metavar="DIR", help="install a static library, its headers "
                        "and a pkg-config file below DIR")
    parser.add_argument("--native", action="store_true",
                        help="compile for this processor only (-march=native)")
    parser.add_argument("--real", choices=("double", "long double"), default="double")
    json_option(parser)


def scene_of(args):
    """(selected spec, method, solver) that the arguments ask for."""
    from ..compile.select import select
    from ..read.shipped import load_spec
    from ..run.step.evaluated import parameter_values
    from ..run.step.prepared import asked
    spec = load_spec(args.spec, args.library)
    run = asked(spec, args.run, args.method, args.solver, args.effects, dict(args.parameters))
    parameter_values(spec, dict(run.parameters))
    return select(spec, run.effects, dict(run.parameters)), run.method, run.solver


def gen(args):
    """Write the files; their paths are the data."""
    from ..build.export import export_sources
    from ..check.verify.embed import with_certificate
    scene, method, solver = scene_of(args)

    def certified(files):
        return files if args.certificate is None else with_certificate(files, scene, method, solver, args.features, args.certificate)

    files, notes, most = export_sources(scene, args.out, method, solver, args.amalgamate, args.features, certified)
    report(args, scene, method, notes, files, most)


def build(args):
    """Compile into the cache or below --out; the paths are the data."""
    from ..build.binary import build_library
    from ..build.export import export_library
    scene, method, solver = scene_of(args)
    if args.out:
        files, notes = export_library(scene, args.out, method, solver, args.features)
    else:
        built = build_library(scene, method, solver, args.real, args.native or False, args.features)
        files, notes = [built.binary], built.notes
    report(args, scene, method, notes, files)


MOST = {"gradients": "evaluations of dH/dw of a site", "hessians": "evaluations of d2H/dw2 of a site", "iterations": "iterations", "stack": "bytes of stack"}
SIZES = {"model": "sizeof(model)", "state": "sizeof(state)", "memory": "memsize(&model)"}


def report(args, scene, method, notes, files, most=None):
    """What was chosen, what a step takes at most, and which files there are now."""
    if args.json:
        return printed({"model": scene.name, "method": method, "chosen": notes, **({"most": most} if most else {}), "files": [str(f) for f in files]})
    say(f"{scene.name}: {method}" + (f"; {notes_line(notes)}" if notes else ""))
    for line in effort_lines(most) if most else ():
        say(line)
    for file in files:
        print(file)


def effort_lines(most: dict):
    """What a step takes at most, and the bytes of a model, a state and its arrays: a short table."""
    yield "a step takes at most"
    for key, meaning in MOST.items():
        yield f"  {most[key]:>13,}  {meaning}"
    yield "sizes in bytes (smg_real = double)"
    for key, meaning in SIZES.items():
        yield f"  {'?' if most[key] is None else format(most[key], ','):>13}  {meaning}" + " depends on the sizes" * (most[key] is None)
