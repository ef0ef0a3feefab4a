"""`smidgen run`: a run of a spec, its errors, its file."""
from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from .. import ranks
from ..errors import Exit, RunError, UsageError
from ..run.files.options import OPTIONS, SHORT
from .options import chosen, json_option, model_options, processor_options, run_option, spec_argument, start_of
from .say import notes_line, printed, say

EXAMPLES = """  smidgen run heisenberg_chain
  smidgen run heisenberg_chain demo --set n=1000 --h 0.05 --time 100 --out chain.h5
  smidgen run top.toml --effects kinetic --steps 1e6 --every 1000 --out top.csv
  smidgen run top.toml --steps 100 --out -       a table on stdout
  smidgen run --repeat chain.h5 --out again.h5   the same run again
  smidgen run top.toml --steps 1e9 --every 1e5 --checkpoint 1e6 --out top.h5
  smidgen run --resume top.h5                    go on where that one was stopped"""


def add(commands):
    """The sub-command."""
    parser = commands.add("run", command, "run a spec and write the result", EXAMPLES)
    spec_argument(parser, nargs="?")
    model_options(parser)
    run_option(parser, "h")
    for pair in (("steps", "time"), ("every", "period")):
        one = parser.add_mutually_exclusive_group()
        for name in pair:
            run_option(one, name)
    for name in ("what", "start", "seed"):
        run_option(parser, name)
    processor_options(parser)
    for name in ("fast", "threads", "real"):
        run_option(parser, name)
    parser.add_argument("--out", metavar="FILE", help="the result file: .csv, .npz or .h5, or - for a table on stdout")
    parser.add_argument("--repeat", metavar="FILE", help="repeat the run that wrote FILE")
    run_option(parser, "checkpoint")
    parser.add_argument("--distributed", action="store_true", help="with mpirun: each rank stores and writes only its own part of the lattice (--out result.h5)")
    parser.add_argument("--grid", metavar="AxBxC", help="with mpirun: cut a lattice into blocks, so many along each direction, such as 1x2x2, or auto")
    parser.add_argument("--resume", metavar="FILE", help="continue the interrupted run that wrote checkpoints for FILE")
    run_option(parser, "tolerance")
    one = parser.add_mutually_exclusive_group()
    one.add_argument("--estimate", action="store_const", const=True, help="repeat the run with larger and smaller steps to estimate its error, "
                     f"which takes 2 to 2.5 times as many steps (default: only if the run took less than {SHORT:g} s)")
    one.add_argument("--no-estimate", action="store_const", const=False, dest="estimate", help="do not estimate the error of the run")
    run_option(parser, "substeps")
    json_option(parser)


def command(args):
    """Run, then print the summary; what was computed before a failure is kept."""
    from ..run.run import Interrupted
    ranks.join()
    ranks.arrange(args.grid)
    with output_file(args) as out:
        try:
            result, code = go(args, out), Exit.OK
        except Interrupted as stop:
            result, code = stop.result, Exit.INTERRUPTED
        except RunError as error:
            if not hasattr(error, "result"):
                raise
            say(f"smidgen: {error}")
            result, code = error.result, error.exit_code
        report(args, result, int(code))
    ranks.finished()
    return code


WHOLE_STATE = ("# final:", "# meta:")       # lines of a table that tell the last state and all choices: of any length, for --repeat


class output_file:
    """The file that a run writes: --out, or for `-` one that goes to stdout at the end."""

    def __init__(self, args):
        self.piped, self.path = args.out == "-", args.out

    def __enter__(self):
        if self.piped:
            self.folder = tempfile.TemporaryDirectory(prefix="smidgen-")
            self.path = str(Path(self.folder.name, "table.csv"))
        return self.path

    def __exit__(self, *_):
        if not self.piped:
            return
        with self.folder:
            if Path(self.path).exists():
                with open(self.path, encoding="utf-8") as table:
                    sys.stdout.writelines(line for line in table if not line.startswith(WHOLE_STATE))


def go(args, out):
    """The run that the arguments ask for."""
    from ..run.files.output import known_format
    from ..progress import progress
    from ..run.run import run
    from ..run.settings import settle
    if args.resume is not None:
        return go_on(args)
    if args.checkpoint and args.out in (None, "-"):
        raise UsageError("checkpoints need a result file: add --out result.h5")
    if out is not None:
        known_format(out)
    spec, name, given = asked(args)
    settings = settle(spec, name, **given)
    warn_of_jumps(spec, settings)
    with progress(settings.steps, spec.name) as tick:
        if args.distributed:
            from ..run.distributed.run import run_distributed
            return run_distributed(spec, name, out, tick, **given)
        return run(spec, name, out=out, keep=False, progress=tick, **given)


def warn_of_jumps(spec, settings):
    """Before the first step: what an energy that jumps does to every method."""
    from ..analyse.symmetry.jumps import jumps
    from ..compile.select import select
    for name, size in jumps(select(spec, settings.effects, settings.parameters)).items():
        say(f"warning: the energy of '{name}' is discontinuous: one term jumps by {size:.2g}. "
            "A step across a jump does not conserve the energy, and the method loses its order there; see `smidgen explain`")


def go_on(args):
    """The rest of a run that was stopped."""
    from ..progress import progress
    from ..run.resume import resume, saved_run
    if args.spec is not None or args.repeat is not None or args.out is not None:
        raise UsageError("--resume takes all settings from the file: omit SPEC, --out and --repeat")
    refuse_choices(args, "--resume continues a run unchanged and can be combined with --json only")
    from ..run.distributed.store import Store
    if ranks.on_first(Store(args.resume).unfinished):
        from ..run.distributed.run import resume_distributed
        args.out = args.resume
        return resume_distributed(args.resume)
    meta = ranks.on_first(lambda: saved_run(args.resume))
    args.out, args.complete = args.resume, meta.get("status") == "complete"
    with progress(meta["steps"], meta["spec"]) as tick:
        return resume(args.resume, progress=tick, tell=lambda text: say(f"note: {text}"))


def asked(args):
    """(spec, run, choices) from SPEC and its options, or from a file to repeat."""
    if args.repeat is None:
        if args.spec is None:
            raise UsageError("no spec was given; `smidgen list` shows the specs that come with smidgen")
        from ..read.shipped import load_spec
        return load_spec(args.spec, args.library), args.run, choices(args)
    if args.spec is not None:
        raise UsageError("--repeat takes the spec from the file: omit SPEC")
    from ..build.binary import generator_name
    from ..run.files.output import load_result
    from ..run.files.recorded import recorded
    refuse_choices(args)
    meta = load_result(args.repeat).meta
    if meta.get("generator") != generator_name():
        say(f"note: {args.repeat} was written by {meta.get('generator')}, this is "
            f"{generator_name()}: the last digits may differ")
    return recorded(meta)


# what the command line may leave to the run; start, fast, real: `choices`
CHOICES = tuple(option.name for option in OPTIONS if option.reads and option.name not in ("start", "fast", "real"))


def choices(args) -> dict:
    """What the command line chooses, by the names that `run` has for it."""
    given = chosen(args, CHOICES)
    given.update(parameters=dict(args.parameters), native=args.native, fast=bool(args.fast), real=args.real, estimate=args.estimate)
    if args.start is not None:
        given["start"] = start_of(args.start)
    return given


def refuse_choices(args, said="--repeat repeats a run unchanged and can be combined with --out and --json only"):
    """A repeated run is the run as it was, and so is one that goes on."""
    if args.parameters or args.start or args.estimate is not None or args.native is not None or args.fast or args.real != "double" or chosen(args, CHOICES):
        raise UsageError(said)


def report(args, result, code: int):
    """The summary: on stdout, unless the table goes there."""
    if ranks.count() > 1 and not result.meta["chosen"].get("ranks"):
        say(f"note: each of the {ranks.count()} ranks took all steps, because only lattices processed by rows with a midpoint method can be shared")
    tell = say if args.out == "-" else print
    if args.json:
        return printed(facts(args, result, code))
    for line in lines(args, result):
        tell(line)


def facts(args, result, code) -> dict:
    """The summary for programs."""
    meta = {k: v for k, v in result.meta.items() if k not in ("sources", "start")}
    return {**meta, **result.summary, "out": args.out, "exit_code": code}


def lines(args, result):
    """The summary for people."""
    from ..run.step.library import binds
    meta = result.meta
    name = f"{meta['spec']} {meta['run']}" if meta["spec"] != meta["run"] else f"model {meta['spec']}, run {meta['run']}"
    yield (f"{name}: {meta['method']}, h = {meta['h']:.10g}{unit(meta, 't')}, {meta['done']} of "
           f"{meta['steps']} steps to t = {result.summary['t']:.10g}{unit(meta, 't')} in {result.summary['seconds']:.2f} s")
    if meta["chosen"]:
        yield f"chosen: {notes_line(meta['chosen'])}"
    if result.summary.get("by_rows") is not None:
        yield f"this run was solved {'by rows' if result.summary['by_rows'] else 'site by site, because h is too large for rows'}"
    if binds(meta.get("threads")):
        yield "threads were bound to processors (OMP_PROC_BIND=false leaves them free)"
    yield from deviation_lines(result.summary, meta)
    yield from estimate_lines(result)
    yield from split_lines(result)
    yield from halved_lines(result)
    yield from near_lines(result)
    yield from mean_lines(meta)
    if meta["status"] != "complete":
        yield f"status: {meta['status'] if meta['status'] == 'interrupted' else 'failed'}"
    if args.out not in (None, "-"):
        from ..run.files.checkpoint import folder_of
        yield f"{args.out} is complete: nothing was done" if getattr(args, "complete", False) else f"wrote {args.out}"
        if meta["status"] == "interrupted" and folder_of(args.out).is_dir():
            yield f"continue with: smidgen run --resume {args.out}"


def unit(meta, column: str) -> str:
    """` meV`, behind a number of that column; nothing where none is known."""
    units = meta.get("units") or {"columns": {}}
    found = units["columns"].get(column) or units.get("means", {}).get(column) or units.get({"t": "time"}.get(column, column), "1")
    return "" if found == "1" else f" ({found})" if found[0].isdigit() else f" {found}"


def mean_lines(meta):
    """The averages of a run that takes some; that there are none, where it ended before the first sample."""
    if meta["means"] == {}:
        yield f"no averages: there is no output from t = {meta['averages']['after']:g}{unit(meta, 't')} on"
    for name, one in (meta["means"] or {}).items():
        error = "" if one["error"] is None else f" ± {one['error']:.2g}"
        variance = "" if one["variance"] is None else f", variance {one['variance']:.4g}"
        correlation = "" if one["correlation"] is None else f", correlation time {one['correlation']:.3g}{unit(meta, 't')}"
        yield f"mean of {name} from t = {meta['averages']['after']:g}{unit(meta, 't')} on: {one['mean']:.8g}{error}{unit(meta, name)}{variance}{correlation}"


def directions(axes) -> dict:
    """kind -> along which axes the momentum is conserved (errors) and along which it is not (changes); "" where it is along all or none."""
    if len(axes) != 1:
        return {"errors": "", "changes": ""}
    names = [x for x, a in zip("xyz", axes[0]) if abs(a) > 1 - 1e-9]
    if not names:
        along = f"({', '.join(f'{a:.3g}' for a in axes[0])})"
        return {"errors": f" along {along}", "changes": f" across {along}"}
    return {"errors": f" along {names[0]}", "changes": f" along {', '.join(x for x in 'xyz' if x not in names)}"}


def deviation_lines(summary, meta):
    """Errors of what is conserved, changes of what is not."""
    along = directions(summary.get("axes", ()))
    for kind, said, change in (("errors", "", "error"), ("changes", "not conserved, ", "change")):
        names = {"momentum": f"momentum{along[kind]}", **({"energy": "energy without tracers"} if summary.get("without") else {})}
        for where, end in ((f"largest {change} over the outputs", False), (f"{change} of the last state", True)):
            found = [f"{names.get(name, name)} {value:.3g}{unit(meta, name)}" for name, value in summary[kind].items() if (name in summary.get("at_end", ())) == end]
            if found:
                yield f"{said}{where} (absolute): {', '.join(found)}"


VAGUE = 0.1     # an estimate beyond this tells that the end is not known


def estimate_lines(result):
    """How far the end is from the exact solution."""
    error, withheld = result.meta.get("end_error"), result.meta.get("end_error_withheld")
    if result.summary.get("estimate_left_out"):
        yield "error of the final state: not estimated, because this takes about 2.5 times as long as the run; use --estimate to estimate it"
    if withheld:
        yield f"error of the final state: no estimate: {withheld}"
    if error is None:
        return
    if error < VAGUE:
        yield f"estimated error of the final state: {error:.2g} of |w| (from two more runs with different steps; --no-estimate skips them)"
    else:
        yield "the final state is not resolved: it changes with h (h is too large, or the motion is chaotic)"


def halved_lines(result):
    """Steps of a thermal run that had no midpoint."""
    if result.summary.get("halved"):
        yield (f"{result.summary['halved']} of {result.meta['done']} steps had no solution after the first half of the noise: each was taken as two steps of h/2, with the same noise")


def split_lines(result):
    """What sub-stepping did."""
    if not result.summary["in_parts"]:
        return
    step, t, k = result.substeps[0]
    yield (f"warning: {result.summary['in_parts']} steps failed and were replaced by smaller ones, the first being step {step:.0f} "
           f"(t = {t:.10g}) in {2 ** int(k)} parts: with a varying step the method is not a single symplectic map, and its long-time behaviour is unknown")


def near_lines(result):
    """A midpoint that came near the centre of its sphere."""
    near = result.summary.get("nearest")
    if near:
        yield (f"warning: in step {near['step']} (t = {near['t']:.10g}) the midpoint of site {near['site']} came within "
               f"{near['rho']:.2g} radii of the centre, where steps cease to exist; use a smaller h (see `smidgen advise`)")
