"""`smidgen spectrum`: S(q, omega) of the spins of a lattice."""
from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from ..public import few
from .options import check_places, chosen, json_option, model_options, processor_options, run_option, spec_argument, start_of, whole
from .say import printed, say

EXAMPLES = """  smidgen spectrum heisenberg_chain random --q "0 1/2" --time 200 --every 5 --plot chain.png
  smidgen spectrum film.toml --q "0,0 1/2,0 1/2,1/2 0,0" --window hann --out film.npz
  smidgen spectrum film.toml --q "0,0 1/2,0" --plot film.png --theory   with the lines of linear spin waves
  smidgen spectrum film.toml --parts 10 --out -          a table on stdout"""
TOLD = 20       # waves whose peaks are said
STATIC = 2.5    # frequencies next to 0 into which what does not move leaks
MOST = 0.999    # of the weight away from 0
ROOM = 4        # times as far as that weight: beyond it a larger --every would do


def add(commands):
    """The sub-command."""
    parser = commands.add("spectrum", command, "run a lattice and compute S(q, omega), the spectrum of its waves", EXAMPLES)
    spec_argument(parser)
    model_options(parser)
    parser.add_argument("--family", metavar="FAMILY", help="the family of vectors (default: the only one)")
    parser.add_argument("--q", metavar="PATH", default="all", help="wave vectors in units of the reciprocal lattice vectors: corners of a path, by numbers or by name (Gamma K M Gamma), "
                        "such as \"0,0 1/2,0 1/2,1/2\", or all (default)")
    parser.add_argument("--h", help="the step, a number or a formula")
    long = parser.add_mutually_exclusive_group()
    long.add_argument("--steps", type=whole, help="number of steps")
    long.add_argument("--time", help="duration of the run, a multiple of h; frequencies are 2 pi/time apart")
    parser.add_argument("--every", type=whole, metavar="K", help="steps between samples; the largest frequency is pi/(K h)")
    parser.add_argument("--window", choices=("none", "hann"), default="none", help="window in time (default: none)")
    parser.add_argument("--parts", type=whole, default=1, metavar="P", help="average over the spectra of P equal parts of the run")
    parser.add_argument("--autocorrelation", action="store_true", help="also compute autocorrelations in time (.npz only)")
    parser.add_argument("--neutron", action="store_true", help="also compute the quantity measured by neutron scattering, with the factor delta_ab - q_a q_b/|q|^2")
    parser.add_argument("--theory", metavar="START", nargs="?", const=True, default=False,
                        help="also compute the frequencies of linear spin waves about an equilibrium: "
                        "START must be one; without START, the start of the run is relaxed to one")
    for name in ("start", "seed"):
        run_option(parser, name)
    processor_options(parser)
    run_option(parser, "threads")
    parser.add_argument("--out", metavar="FILE", help="the file to write: .npz or .csv, or - for a table on stdout")
    parser.add_argument("--plot", metavar="FILE", help="draw a heat map along the path into this .png, .svg or .pdf file")
    json_option(parser)


CHOICES = ("family", "q", "window", "parts", "autocorrelation", "neutron", "method", "solver", "h", "steps", "time", "every", "effects", "seed",
           "native", "threads")


def command(args):
    """Run; then the file, the picture and where the waves are strongest."""
    from ..analyse.spectrum import saved_as
    if args.out not in (None, "-"):
        saved_as(args.out)
    check_places(args.out, args.plot)
    found = measured(args)
    if args.out == "-":
        return table(found)
    made = {}
    if args.out:
        made["out"] = str(found.save(args.out))
        if args.out.endswith(".csv") and (found.theory is not None or found.neutron is not None):
            say("a .csv can hold q, omega and S only; use an .npz for the lines of linear spin waves and the quantity measured by neutron scattering")
    if args.plot:
        from ..show.plot.spectrum import draw_spectrum
        made["plot"] = str(draw_spectrum(found, args.plot))
    if args.json:
        return printed({**facts(found), **made})
    for line in lines(found):
        print(line)
    for path in made.values():
        say(f"wrote {path}")


def measured(args):
    """The spectrum that the arguments ask for."""
    from ..analyse.spectrum import spectrum
    from ..progress import progress
    from ..read.shipped import load_spec
    from ..run.settings import settle
    given = chosen(args, CHOICES)
    given["parameters"] = dict(args.parameters)
    if args.start is not None:
        given["start"] = start_of(args.start)
    given["theory"] = start_of(args.theory) if isinstance(args.theory, str) else args.theory
    spec = load_spec(args.spec, args.library)
    total = settle(spec, args.run, **{k: given[k] for k in ("h", "steps", "time", "every", "parameters") if k in given}).steps
    with progress(total, spec.name) as tick:
        return spectrum(spec, args.run, progress=tick, **given)


def peaks(found) -> list:
    """For each wave the frequency, from 0 up, at which it is strongest."""
    up = found.omega >= 0
    return found.omega[up][found.mean[:, up].argmax(axis=1)].tolist()


def moving(found) -> tuple:
    """(frequencies away from 0, S there, its mean over the components): without what stands still, such as magnetic order."""
    away = found.omega > STATIC * found.resolution
    return found.omega[away], found.mean[:, away]


def peaks_away(found) -> list:
    """For each wave the frequency away from 0 at which it is strongest; None where there is none."""
    omega, s = moving(found)
    return omega[s.argmax(axis=1)].tolist() if len(omega) else [None] * len(found.q)


def reached(found):
    """The frequency below which MOST of the weight away from 0 lies; None without any."""
    import numpy as np
    omega, s = moving(found)
    total = np.cumsum(s.sum(axis=0))
    return float(omega[np.searchsorted(total, MOST * total[-1])]) if len(omega) and total[-1] > 0 else None


def facts(found) -> dict:
    """For programs."""
    meta = {k: v for k, v in found.meta.items() if k not in ("sources", "start")}
    theory = {} if found.theory is None else {"theory": {**found.theory.meta, "lines": [line.tolist() for line in lines_of(found)]}}
    return {**meta, "q": found.q.tolist(), "omega": [float(found.omega[0]), float(found.omega[-1]), len(found.omega)],
            "peak": peaks(found), "peak_away_from_0": peaks_away(found), "equal_time": found.equal_time.tolist(), **theory}


def lines_of(found) -> list:
    """Of linear spin waves, the frequencies that are seen at each wave vector."""
    theory = found.theory
    return [omega[seen] for omega, seen in zip(theory.omega[::theory.meta["between"]], theory.seen[::theory.meta["between"]])]


def lines(found):
    """For people."""
    unit = f" rad/{found.meta['units']['time']}" if found.meta.get("units") else ""
    yield (f"{found.meta['spec']} {found.meta['run']}: {len(found.q)} waves of {found.meta['family']}, {len(found.omega)} frequencies "
           f"{found.omega[1] - found.omega[0]:.6g} apart up to {found.omega[-1]:.6g}{unit}")
    yield from sampling(found, unit)
    lines = [[]] * len(found.q) if found.theory is None else lines_of(found)
    yield f"{'q':>20} {'strongest at':>14} {'away from 0':>14} {'mean |S_q|^2':>14}" + "  linear spin waves" * (found.theory is not None)
    for q, omega, away, power, line in list(zip(found.q, peaks(found), peaks_away(found), found.equal_time.sum(axis=1), lines))[:TOLD]:
        told = "  " * bool(len(line)) + few(f"{x:.6g}" for x in distinct(line))
        yield f"{', '.join(f'{x:.6g}' for x in q):>20} {omega:14.6g} {'' if away is None else f'{away:.6g}':>14} {power:14.6g}{told}"
    if found.theory is not None:
        yield from theory_lines(found)
    if len(found.q) > TOLD:
        left = len(found.q) - TOLD
        yield f".. and {left} more wave{'s' * (left > 1)}; use --out FILE, --out - or --json to see all"


def sampling(found, unit: str):
    """What --every should be where most of the frequencies have no weight."""
    most = reached(found)
    every = found.meta["every"] if most is None else int(found.meta["every"] * found.omega[-1] / (2 * most))
    if most is not None and ROOM * most < found.omega[-1]:
        yield f"99.9 % of the weight away from 0 lies below {most:.6g}{unit}: --every {every} would be enough"


def distinct(line) -> list:
    """Frequencies in rising order, each once."""
    return [x for k, x in enumerate(line) if k == 0 or x - line[k - 1] > 1e-6 * line[-1]]


def theory_lines(found):
    """What is known of the equilibrium, and what the lines do not tell."""
    import numpy as np
    meta = found.theory.meta
    repeats = (f"each cell is the previous one turned by {', '.join(f'{x:.6g}' for x in meta['turns'])} degrees" if meta["turns"] else
               f"magnetic cell {' x '.join(map(str, meta['cell']))}")
    moved = f", {meta['moved']:.3g} degrees from the start" * (meta["moved"] > 0)
    yield f"linear spin waves: {repeats}; |n x g| is {meta['torque']:.2g} of the field{moved}"
    aliased = np.nanmax(found.theory.omega) > found.omega[-1] + found.resolution / 2
    yield from meta["notes"] + [f"lines go up to {np.nanmax(found.theory.omega):.6g}, beyond pi/dt: take a smaller --every"] * bool(aliased)


def table(found) -> None:
    """The .csv on stdout."""
    with tempfile.TemporaryDirectory(prefix="smidgen-") as folder:
        sys.stdout.write(found.save(Path(folder, "table.csv")).read_text())
