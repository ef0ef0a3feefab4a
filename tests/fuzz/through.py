"""All that one spec must go through: read, generate, a strict compiler, sanitizers, restore, members, the witness.

The compilers are drawn with the spec (`fuzz.drawn`): one of C or C++ with its level for the program, one of C with its own for the library. The
same C has the same bits in both, whatever they are, but where a formula calls functions of the mathematical library, which compilers may evaluate.

    found = through(text)           # what was done, in words; Fault where something is wrong

A step or a start that is refused with a status is no fault; `found["verdict"]` is "refused" then.
"""
from __future__ import annotations

import contextlib
import dataclasses
import os
import re
import resource
import subprocess
import tempfile
import time
from importlib import import_module
from pathlib import Path

import numpy as np
from support.strict import CALLS, COMPILERS, WARNINGS, compile_all

import smidgen
from smidgen.build.binary import build_library, write_files
from smidgen.compile.emit.emit import generate
from smidgen.compile.features import EVERYWHERE
from smidgen.errors import RunError, UsageError
from smidgen.methods import METHODS
from smidgen.run.step.integrator import Integrator
from smidgen.run.step.prepared import prepare, scene_of
from smidgen.resources import include_flags
from smidgen.compile.select import select
from smidgen.run.settings import settle
from smidgen.run.step.evaluated import parameter_values
from smidgen.run.step.start import initial_state
from smidgen.run.step.status import Status
from smidgen.check.witness import Witness, thermal

from .differential import ALLOWED, EPSILON, UNIT, Pair, compare, random_state
from .drawn import builds_of, features_of, said
from .invent import WHOLE, files_of, put_files
from .program import COUNT, numbers_of, program

SECONDS = 20        # of processor time, for each stage and each program that it starts
JUDGED = 8          # of them for the witness's steps
SANITIZE = (CALLS, "-ffp-contract=off", "-fsanitize=address,undefined", "-fsanitize=float-cast-overflow",
            "-fno-sanitize-recover=all")
STRICT = ("-ffp-contract=off", "-Wno-psabi", *WARNINGS)
STANDARD = ("-std=c11", "-fno-math-errno")
LAYOUTS = ("sites", "single sphere", "few in lanes", "rows", "blocks", "wavefronts")      # in the order of fuzz.program
SMALLER = 3         # times that h becomes an eighth of itself until a lattice goes by rows
TOO_MANY = "numbers differ from site to site (at most"        # which the drawing of a spec counts for itself, but not those of merged effects
DENSE = 60          # sites: beyond, a midpoint's steps are judged by their residuals, for the witness's matrix is dense
DIGEST = re.compile(r"from spec \w+")     # of a text, in the first comment
EDGES = re.compile(r"\b(if|mod|floor|abs|min|max)\(")
TOLERANCE, COARSE = 1e-11, 1e-6     # ten times what step control aims at; across an edge its estimates are none
STAGES = {"extrapolation-12": 16}   # the sum of the weights of its rows, in absolute value, is 14.9
CALLED = re.compile(r"\b(sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|exp|log)\(|\^(-?\d*\.\d|a\b|sin)|\b2\^")


SAME = {"restored": "a restored state goes on with other bits", "stays": "a step that failed has changed the state",
        "together": "steps in one call have other bits than one by one", "members": "a member of an ensemble has other bits than alone"}


class Fault(Exception):
    """Something that must not be: its text begins with what, then says where."""


def nothing(name):
    """Called with the name of each stage as it begins."""


def through(text: str, stage=nothing, change=lambda files: files, found=None) -> dict:
    """What was done with the spec: method, solver, features, sites, verdict ("fine" or "refused"), note.

    stage: is told the name of each stage as it begins; change: what a test does to the generated files; found: a dict
    to fill, for those who want what is known of a spec with a fault.
    """
    with tempfile.TemporaryDirectory() as where:
        one = Passage(text, Path(where), stage, change, {} if found is None else found)
        one.read()
        one.generate()
        one.scene_of_files()
        one.compilers()
        one.sanitizers()
        one.shared_library()
        one.witness()
        return one.found


class Passage:
    """One spec on its way."""

    def __init__(self, text, where, stage, change, found):
        self.text, self.where, self.stage, self.change = text, where, stage, change
        self.dice, self.features = np.random.default_rng(len(text)), features_of(text)
        self.program_by, self.shared_by = builds_of(text)
        self.meant = said(text, "goes") == "by rows"
        self.found = found
        found.update(verdict="fine", note="", program=" ".join(self.program_by), library=" ".join(self.shared_by))

    def refused(self, why, status=0):
        """A step that is refused is no fault, unless a value is not finite: formulas and starts are drawn so that all are."""
        if Status.NOT_FINITE in (status, getattr(why, "status", 0)):
            raise Fault(f"not finite: {why}")
        self.found.update(verdict="refused", note=f"{self.found['note']} {str(why)[:160]}".strip())

    def read(self):
        """Read the spec and its run; the state, time and step to begin with, of a fifth of the inverse rate."""
        self.stage("read")
        put_files(self.where, files_of(self.text) | {"model.toml": self.text})
        self.spec = self.loaded("model.toml")
        s = self.settings = settle(self.spec, self.spec.runs[0].name)
        self.features = tuple(f for f in self.features if f in (*METHODS[s.method].features, *EVERYWHERE))
        self.values = parameter_values(self.spec, s.parameters)
        self.w = initial_state(self.spec, s.start, s.parameters)
        self.found.update(method=s.method, features=" ".join(self.features), sites=len(self.w))

    def loaded(self, name):
        library = self.where / "library"
        return smidgen.load(self.where / name, library=[library] if library.exists() else [])

    def scene_of_files(self):
        """A scene is what its files say together: the same spec written as one has the same C, start and run."""
        if not (self.where / WHOLE).exists():
            return
        self.stage("scene")
        whole = self.loaded(WHOLE)
        s = settle(whole, whole.runs[0].name)
        for what, mine, other in (("step", self.settings.h, s.h), ("method", self.settings.method, s.method), ("steps", self.settings.steps, s.steps),
                                  ("start", self.w.tolist(), initial_state(whole, s.start, s.parameters).tolist())):
            if mine != other:
                raise Fault(f"the {what} of the scene is another one than that of the spec written as one: {mine}, {other}")
        other = self.generated(scene_of(whole, s.effects, s.parameters))
        for name in self.files:
            text, by_one = DIGEST.sub("", self.files[name]), DIGEST.sub("", other[name])
            if text != by_one:
                gap = next(((a, b) for a, b in zip(text.splitlines(), by_one.splitlines()) if a != b), ("more or less lines", ""))
                raise Fault(f"the C of the scene is another one than that of the spec written as one\n{name}: {gap[0]}\nby one: {gap[1]}")

    def generate(self):
        """C for the values of the run, as Python and the command build it; and C for the defaults, where it differs."""
        s = self.settings
        self.stage("generate")
        self.scene = scene_of(self.spec, s.effects, s.parameters)
        self.files = self.generated(self.scene)
        first = self.at_defaults()
        self.same = [p.default for p in first.parameters] == [p.default for p in self.scene.parameters]
        self.defaults = self.files if self.same else self.generated(first)
        self.found["solver"] = self.files.notes["solver"]
        self.meant = self.meant and TOO_MANY not in self.files.notes["reason"]
        if self.meant and "site by site" in self.files.notes["reason"]:
            raise Fault(f"it goes {self.files.notes['reason'].rpartition('; ')[2]}")

    def at_defaults(self):
        """The scene of the spec's own numbers, but for what is compiled in; the run's where such a list has another size."""
        s = self.settings
        fixed = {p.name: s.parameters[p.name] for p in self.spec.parameters if p.fixed and p.name in s.parameters}
        try:
            return select(self.spec, s.effects, fixed)
        except UsageError:
            return self.scene

    def generated(self, scene):
        """The files; what does not exist together is refused in words, and done without."""
        try:
            made = generate(scene, self.settings.method, self.settings.solver, features=self.features)
        except UsageError as refusal:
            self.found["note"] += f"{str(refusal)[:80]} "
            self.features = tuple(f for f in self.features if not str(refusal).startswith(f"feature {f}"))
            self.found["features"] = " ".join(self.features)
            made = generate(scene, self.settings.method, features=self.features)
        notes, made = made.notes, type(made)(self.change(dict(made)))
        made.notes = notes
        return made

    def compilers(self):
        """The program's compiler, every warning an error, in double and in extended precision."""
        self.stage("compilers")
        for name, files in [("run", self.files), *[("defaults", self.defaults)] * (not self.same)]:
            here = self.where / name
            here.mkdir()
            write_files(files, here)
            sources = sorted(f for f in files if f.endswith(".c"))
            for real in ("double", "long double"):
                told = compile_all(here, sources, self.program_by[0], "-Wno-psabi", real=real)
                if told:
                    raise Fault(f"{told}\n{self.program_by[0]}, {real}")

    def sanitizers(self):
        """Ten steps, and a restored state that goes on with the same bits, under ASan and UBSan."""
        self.stage("sanitizers")
        self.witness_of = Witness(self.spec, self.values, self.settings.effects)
        self.t = float(self.dice.uniform(0, 3))
        pair = Compared(self)
        factor = 6.0 if len(self.text) % 7 == 0 and METHODS[self.settings.method].midpoint and self.settings.method != "moser-veselov" else 1.0
        self.h = float(np.copysign(factor * pair.step_size(self.w, self.t), self.settings.h))
        self.small = factor == 1
        here, name = self.where / ("run" if self.same else "defaults"), self.scene.name
        (here / "main.c").write_text(program(self.scene, self.values, self.w, self.t, self.h, self.features))
        self.exact = self.same and (not CALLED.search(self.text) or self.program_by == self.shared_by)
        compiler, level = self.program_by
        ran(here, compiler, *COMPILERS[compiler], level, *SANITIZE, *said(self.text, "define").split(), "-I.", *include_flags(), "main.c", "-o", "program", "-lm")
        told = self.in_lanes(here, numbers_of(ran(here, "./program")))
        if told["check"][0] or told["init"][0]:
            return self.refused(f"check {told['check'][0]:g}, init {told.get('init', [0])[0]:g}")
        for name, fault in SAME.items():
            if name in told and not told[name][0]:
                raise Fault(fault)
        self.said = told
        self.found["layout"] = LAYOUTS[int(told["layout"][0])] + ("" if "lanes" not in told else ", ensemble" + " in lanes" * int(told["lanes"][0] > 1))

    def in_lanes(self, here, told) -> dict:
        """What the program says, of a lattice that is meant to go by rows at an h that is small enough for it. Splittings go so where the colours fit a ring."""
        if not self.meant or METHODS[self.settings.method].splitting:
            return told
        for _ in range(SMALLER):
            if told.get("layout", [1])[0]:
                break
            self.h, self.small = self.h / 8, True
            told = numbers_of(ran(here, "./program", self.h.hex()))
        if not told.get("layout", [1])[0]:
            raise Fault("it goes site by site, however small h is")
        return told

    def shared_library(self):
        """The library that Python calls, compiled with every warning an error, but for functions and tables of the other unit: the numbers of the program."""
        self.stage("library")
        compiler, level = self.shared_by
        with builds((*STANDARD, level, *STRICT, "-Wno-unused-function", "-Wno-unused-const-variable"), self.where / "cache", compiler):
            built = build_library(self.scene, self.settings.method, self.settings.solver, "double", False, self.features,
                                  generate=lambda *_: self.files)
        prepared = prepare(self.spec, self.settings.method, self.settings.effects, self.settings.parameters, self.settings.solver)
        self.model = Integrator(dataclasses.replace(prepared, scene=self.scene, numbers=prepared.numbers.of(self.scene)), built)

    def witness(self):
        """Energy, effects, field, observables, momentum, Casimirs and ten steps, of the library and of the program."""
        self.stage("witness")
        pair = Compared(self)
        try:
            pair.numbers(self.w, self.t)
            pair.numbers(random_state(self.scene, pair.values, self.dice), float(self.dice.uniform(0, 3)))
        except RunError as refusal:
            return self.refused(refusal)
        try:
            if self.small and (len(self.w) <= DENSE or not METHODS[self.settings.method].of_midpoints):
                self.found["judged"] = self.judged(pair)
                if self.found["judged"]:
                    pair.steps(self.w, self.t, self.h, self.found["judged"])
            else:
                pair.residuals(self.w, self.t, self.h)
        except RunError as refusal:
            self.refused(refusal)
        if hasattr(self, "said"):
            self.program_and_library(pair)

    def judged(self, pair) -> int:
        """How many steps the witness takes: those that the program took, as far as JUDGED seconds go, but one of those at least."""
        taken = len(self.said.get("w", ()))
        if taken < 2:
            return taken
        began = time.process_time()
        with contextlib.suppress(RunError):
            pair.witness.steps(self.w, self.t, self.h, 1, self.settings.method)
        self.stage("witness")       # its time begins again: one such step may take most of it
        return max(1, min(taken, int(JUDGED / (time.process_time() - began))))

    def program_and_library(self, pair):
        """The same C gives the same bits; C for other sizes, or of another compiler, the same up to round-off."""
        self.model.start(self.w.copy(), t0=self.t, h=self.h)
        mine, done = self.said.get("w", np.empty((0, 0))), 0
        allowed = 0 if self.exact else pair.allowed(self.w, self.t, self.h, COUNT)
        for row in mine if self.small else mine[:1]:
            done += 1
            try:
                gap = np.abs(self.model.step().w.ravel() - row).max()
            except RunError as refusal:
                if self.exact:
                    raise Fault(f"the program takes step {done}, the library does not: {refusal}") from None
                return self.refused(refusal)
            if not gap <= allowed:
                raise Fault(f"the program's state after {done} steps is {gap:.3g} from the library's, {allowed:.3g} is allowed")
        if self.said["status"][0]:
            self.refused(f"status {self.said['status'][0]:g} after {len(mine)} steps", self.said["status"][0])


class Compared(Pair):
    """The comparison of fuzz.differential for what is built already."""

    def __init__(self, one: Passage):
        self.spec, self.dice, self.witness = one.scene, one.dice, one.witness_of
        self.values = {p.name: one.values[p.name] for p in one.scene.parameters}
        self.model = getattr(one, "model", None)

    def allowed(self, w, t, h, count):
        """As for a midpoint, for each stage of a composition; of step control its tolerance, as far as H is smooth."""
        method = METHODS[self.model.method]
        given = (TOLERANCE if smooth(self.spec) else COARSE) * count * (1 + np.abs(w).max()) if method.controlled else 0
        return super().allowed(w, t, h, count) * STAGES.get(method.name, method.stages) + given

    def residuals(self, w, t, h):
        """Steps too large to compare states: each one solves the witness's equation."""
        self.model.start(w.copy(), t0=t, h=h)
        for k in range(COUNT):
            before, now, halved = self.model.state(), t + k*h, self.model.halved
            after = self.model.step().state()
            if self.model.halved > halved:
                continue
            before, after, turns = self.cooled(before, after, h, k)
            compare(f"residual of step {k + 1} of {h!r}", self.witness.residual(before, after, now, h, self.model.method), 0,
                    (1 + turns) * self.round_off(before, after, now, h))

    def cooled(self, before, after, h, step):
        """The two ends of the step without noise, between its two halves, and how many turns these are."""
        if self.witness.diffusion is None:
            return before, after, 0
        first, second = (thermal.turns(self.witness.diffusion, h, self.witness.seed, step, half) for half in (0, 1))
        for theta in first:
            before = thermal.turned(before, theta)
        for theta in reversed(second):
            after = thermal.turned(after, -theta)
        return before, after, len(first) + len(second)

    def round_off(self, before, after, t, h):
        """The residual that units in the last place of both states and of the time make, the largest of some tries: the projection onto
        a leaf near its cone, for one, magnifies them."""
        def moved(w):
            return w * (1 + UNIT * self.dice.uniform(-1, 1, np.shape(w)))
        tries = [self.witness.residual(moved(before), moved(after), moved(t), h, self.model.method) for _ in range(12)]
        return ALLOWED * EPSILON / UNIT * max(tries)


def smooth(spec) -> bool:
    """No formula of it has an edge."""
    return not EDGES.search(" ".join(text for _, text in spec.sources))


@contextlib.contextmanager
def builds(words, cache, compiler):
    """Libraries by this compiler with these options, in a cache of their own."""
    module, before = import_module("smidgen.build.binary"), {name: os.environ.get(name) for name in ("SMIDGEN_CACHE", "CC")}
    flags, module.FLAGS = module.FLAGS, words
    os.environ.update(SMIDGEN_CACHE=str(cache), CC=compiler)
    try:
        yield
    finally:
        module.FLAGS = flags
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


def ran(where, *words) -> str:
    """What a program printed; Fault with what it said when it does not end well."""
    def limited():
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
    done = subprocess.run(words, cwd=where, capture_output=True, text=True, errors="replace", preexec_fn=limited,
                          env={**os.environ, "ASAN_OPTIONS": "detect_leaks=0", "UBSAN_OPTIONS": "print_stacktrace=1"})
    if done.returncode:
        hang = "hangs: " if done.returncode in (-24, -9) else ""
        raise Fault(f"{hang}{(done.stderr + done.stdout)[:6000]}\n{words[0]}: exit status {done.returncode}")
    return done.stdout
