"""The choices of a run: keywords of `smidgen.run`, keys of the metadata, options of the command, each in one line."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .kinds import VALUE, count, either, finite_or_not, flag, listed, none, number, seed, table, text

ALWAYS = object()       # every file has it
SHORT = 2.0             # seconds that a run may take for its error to be estimated unasked


@dataclass(frozen=True)
class Option:
    """name: the keyword; kind: what the metadata must hold of it, None where they do not tell it; older: what it was in files of
    versions that did not have it; help, reads, metavar: of the command, `--name`, where reads says what its text is
    (`READS` of gen/cli/options.py), "" where the command has it in another way; as_key: its key in the metadata, if not its name."""
    name: str
    kind: Callable | None
    older: object = ALWAYS
    reads: str = ""
    help: str = ""
    metavar: str | None = None
    as_key: str = ""

    @property
    def key(self) -> str:
        return self.as_key or self.name


OPTIONS = (
    Option("start", either(text, listed(listed(finite_or_not))), reads="start", help="a start of the spec, or a file: .csv or .npy with rows x,y,z, .ovf or .vtk"),
    Option("method", text, reads="method", help="the method, one of `smidgen list --methods` (default: that of the run)", metavar="NAME"),
    Option("solver", text, reads="solver", help="solver of the step equation"),
    Option("h", number, reads="formula", help="the step, a number or a formula such as 2*pi/n; a negative step runs backward (write --h=-0.1)"),
    Option("steps", count, reads="whole", help="number of steps to take"),
    Option("time", None, reads="formula", help="duration of the run, a multiple of h"),        # told as `steps`
    Option("every", count, reads="whole", help="write an output every K steps", metavar="K"),
    Option("period", either(none, number), reads="formula", help="write an output at multiples of the time PERIOD, a multiple of h", metavar="PERIOD"),
    Option("what", listed(text), reads="names", metavar="A,B",
           help="quantities to output: states, energy, momentum, casimirs, magnetisation, charge, or names of observables"),
    Option("effects", listed(text), reads="names", help="use these effects only", metavar="A,B"),
    Option("parameters", table(VALUE), as_key="set"),
    Option("seed", either(none, seed), reads="whole", help="seed of a random start and of thermal noise"),
    Option("real", text, reads="real"),
    Option("native", either(none, flag)),
    Option("substeps", flag, False, "flag", "replace a step that fails by up to 1024 smaller ones, and report it"),
    Option("checkpoint", None, reads="whole", metavar="N", help="write a checkpoint every N steps, from which an interrupted run can be continued"),
    Option("estimate", either(none, flag), False),
    Option("tolerance", either(none, number), None, "number", metavar="E", help="largest error allowed in a step, relative to the largest component of w (default: round-off)"),
    Option("fast", flag, False, "flag", "like --native, but with fused multiply-add: trades bit-reproducibility for speed"),
    Option("threads", either(none, count), None, "whole", "number of threads that share a step; only for lattices processed by rows, and without effect on the bits", "N"),
    Option("averages", either(none, table(either(number, listed(text)))), None),
)
