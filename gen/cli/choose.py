"""`smidgen choose`: a method and a step for an accuracy."""
from __future__ import annotations

from pathlib import Path

from ..errors import UsageError
from .options import json_option, number, spec_argument, study_choices, study_options
from .say import printed, say

EXAMPLES = """  smidgen choose free_rigid_body --error 1e-8 --time 100
  smidgen choose heisenberg_chain --error 1e-6 --symplectic
  smidgen choose point_vortices --energy 1e-10
  smidgen choose film_pulse --error 0.3 --mean energy --time 10 --seconds 20   at a temperature
  smidgen choose top.toml --error 1e-9 --out chosen.toml   the spec with a run `chosen`"""


def add(commands):
    """The sub-command."""
    parser = commands.add("choose", command, "find the method and step that reach an accuracy in the least time", EXAMPLES)
    spec_argument(parser)
    study_options(parser)
    for word, said in (("--error", "largest error of the final state, relative to the largest |w|"),
                       ("--energy", "largest error of the energy during the run, in the unit of the energy")):
        parser.add_argument(word, type=lambda text, word=word: number(text, word), metavar="E", help=said)
    parser.add_argument("--mean", metavar="NUMBER", help="at a temperature: the quantity, energy or an observable, to whose mean --error refers (default: the energy)")
    parser.add_argument("--seconds", type=lambda text: number(text, "--seconds"), default=60.0, metavar="T", help="at a temperature: the most seconds to spend on the measurement (default: 60)")
    parser.add_argument("--symplectic", action="store_true", help="consider symplectic methods only")
    parser.add_argument("--out", metavar="FILE.toml", help="write a copy of the spec with an additional run `chosen`")
    json_option(parser)


def command(args):
    """The choice in words; with --out also as a run."""
    from ..cost import choose
    from ..progress import progress
    from ..read.shipped import load_spec
    spec = load_spec(args.spec, args.library)
    with progress(1000, "choose") as tick:
        choice = choose(spec, args.run, error=args.error, energy=args.energy, symplectic=args.symplectic, seconds=args.seconds, mean=args.mean, **study_choices(args),
                        progress=lambda what, done: tick(int(1000 * done)))
    if args.out:
        say(f"wrote {written(spec, args, choice)}")
    if args.json:
        return printed(choice.as_dict())
    print(choice)


def written(spec, args, choice) -> Path:
    """The text of the spec with a run `chosen` at its end."""
    path = Path(args.out)
    if len(spec.sources) != 1:
        raise UsageError("--out needs a spec that is a single file, but this one includes others")
    if any(run.name == "chosen" for run in spec.runs):
        raise UsageError("the spec already has a run 'chosen'")
    if args.parameters or args.effects or args.seed is not None or args.start is not None:
        raise UsageError("--out adds a run to the spec and cannot be combined with --set, --effects, --seed or --start")
    base = next((run for run in spec.runs if run.name == args.run), spec.runs[0] if spec.runs else None)
    start = f'start = "{base.start}"\n' if base is not None and base.start else ""
    row = choice.row
    tolerance = f"tolerance = {choice.settings['tolerance']!r}\n" if "tolerance" in choice.settings else ""
    try:
        path.write_text(f"{spec.sources[0][1].rstrip()}\n\n[runs.chosen]\n{start}method = \"{row.method}\"\nh = {row.h!r}\nsteps = {row.steps}\n{tolerance}", encoding="utf-8")
    except OSError as problem:
        raise UsageError(f"cannot write {path}: {problem.strerror}") from None
    return path
