"""`smidgen choose`: a method and a step for an accuracy."""
from __future__ import annotations

import json
import tomllib
from pathlib import Path

from ..errors import UsageError
from .options import check_places, json_option, number, spec_argument, study_choices, study_options
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
    if args.out:
        check_places(args.out)
        check_addable(spec, args)
    with progress(1000, "choose") as tick:
        choice = choose(spec, args.run, error=args.error, energy=args.energy, symplectic=args.symplectic, seconds=args.seconds, mean=args.mean, **study_choices(args),
                        progress=lambda what, done: tick(int(1000 * done)))
    if args.out:
        say(f"wrote {written(spec, args, choice)}")
    if args.json:
        return printed(choice.as_dict())
    print(choice)


def check_addable(spec, args) -> None:
    """Raises UsageError where the run cannot be written as one of the spec."""
    if len(spec.sources) != 1:
        raise UsageError("--out needs a spec that is a single file, but this one includes others")
    if any(run.name == "chosen" for run in spec.runs):
        raise UsageError("the spec already has a run 'chosen'")
    if args.parameters or args.effects or args.seed is not None or args.start is not None:
        raise UsageError("--out adds a run to the spec and cannot be combined with --set, --effects, --seed or --start")


def written(spec, args, choice) -> Path:
    """The text of the spec with a run `chosen` at its end."""
    from ..run.files.durable import write_new
    path = Path(args.out)
    base = next((run for run in spec.runs if run.name == args.run), spec.runs[0] if spec.runs else None)
    try:
        write_new(path, f"{spec.sources[0][1].rstrip()}\n\n[runs.chosen]\n{run_text(spec, base, choice)}".encode())
    except OSError as problem:
        raise UsageError(f"cannot write {path}: {problem.strerror}") from None
    return path


def run_text(spec, base, choice) -> str:
    """The keys of the run: what was chosen, for the start, the effects and the values of the run that was measured."""
    from ..language.units import TIME
    row, unit = choice.row, f" {spec.units.spelt(TIME)}" if spec.units else ""
    keys = {"start": base and base.start, "effects": base and base.effects, "method": row.method, "h": f"{row.h!r}{unit}" if unit else row.h, "steps": row.steps,
            "tolerance": choice.settings.get("tolerance")}
    lines = [f"{key} = {json.dumps(value)}\n" for key, value in keys.items() if value]
    values = set_in(tomllib.loads(spec.sources[0][1])["runs"], base.name) if base else {}
    return "".join(lines) + (f"set = {{ {', '.join(f'{name} = {json.dumps(value)}' for name, value in values.items())} }}\n" if values else "")


def set_in(runs: dict, name: str) -> dict:
    """The values that a run sets, as they are written; those of a run that it is like come first."""
    run = runs[name]
    return {**(set_in(runs, run["like"]) if "like" in run else {}), **run.get("set", {})}
