"""Averages over time and over members, which differ by their noise: what an experiment at a temperature measures.

    found = smidgen.average(spec, what=["mz"], after=50, members=1000, out="mz.json")
    found["mz"].mean, found["mz"].error

Members go one after the other, and of each the samples are those of a run with the same seed: at every `every`-th step, later than `after`.
Memory does not grow with members or steps. While it runs, what is known lies in OUT.part, from which a run that was killed goes on.
"""
from __future__ import annotations

import base64
import hashlib
import json
import math
import os
import time as clock
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import ColumnError, OutputError, UsageError
from ...language.spec import Spec
from ...public import few, guess, public
from ...read.given import time as time_of
from ...read.shipped import SpecLike, spec_or_name
from ...version import __version__
from ..files.durable import check_place, write_new
from ..files.plain import plain
from ..record.means import BINS, Average, averages, numbers_of
from ..record.statistics import Statistics
from ..settings import Settings, model_of, number, settle, whole
from ..step.block import Block
from ..step.pace import Pace
from ..step.start import find_start, state_at

FORMAT = "smidgen averages 1"
PART, BETWEEN = ".part", 30.0       # the ending of a file that is not complete; seconds between two that are written


@dataclass(frozen=True)
class Averages(Mapping):
    """The result of `smidgen.average`: a mapping from the names of quantities to their Average.

    :ivar meta: everything that was chosen, and `samples`, the number of samples.
    """
    meta: dict
    of: dict

    def __getitem__(self, name: str) -> Average:
        """Raises ColumnError, a KeyError."""
        if name not in self.of:
            raise ColumnError(f"there is no average of '{name}'{guess(str(name), list(self.of), {})}")
        return self.of[name]

    def __iter__(self):
        return iter(self.of)

    def __len__(self) -> int:
        return len(self.of)

    def __repr__(self) -> str:
        return f"<Averages {self.meta['spec']}: {few(self.of)}; {self.meta['samples']} samples of {self.meta['members']} member{'s' * (self.meta['members'] != 1)}>"

    def text(self) -> str:
        """The contents of the .json file."""
        return json.dumps({"format": FORMAT, **self.meta, "averages": {name: vars(one) for name, one in self.of.items()}}, ensure_ascii=False, indent=1) + "\n"


@public
@spec_or_name
def average(spec: SpecLike, run: str | None = None, *, start: str | np.ndarray | None = None, method: str | None = None, solver: str | None = None,
            h: float | str | None = None, steps: int | None = None, time: float | str | None = None, every: int | None = None,
            period: float | str | None = None, what: Iterable[str] | None = None, effects: Iterable[str] | None = None, parameters: Mapping[str, object] | None = None,
            seed: int | None = None, native: bool | None = None, tolerance: float | None = None, after: float | str | None = None, members: int = 1, bins: int | None = None,
            out: str | os.PathLike | None = None, progress: Callable[[int], object] | None = None) -> Averages:
    """Compute averages over time, and over members that differ in their thermal noise.

    Arguments not listed here are as for `run`.

    :param what: names of observables, "energy", "energy.EFFECT", "momentum.FAMILY.x"; by default those of the run's `averages`, otherwise
        the energy and all observables.
    :param after: the time from which samples are taken; by default that of the run's `averages`, otherwise 0.
    :param members: the number of trajectories.
    :param bins: the largest number of bins of a histogram.
    :param out: a .json file. If an interrupted computation left FILE.part in the same folder, it is continued.
    :param progress: a function that is called with the number of members done.
    :raises UsageError: for an argument that does not fit.
    :raises RunError: if a step fails.
    """
    settings = settle(spec, run, start=start, method=method, solver=solver, h=h, steps=steps, time=time, every=every, period=period, effects=effects,
                      parameters=parameters, seed=seed, native=native, tolerance=tolerance)
    said = settings.averages or {}
    after = said.get("after", 0.0) if after is None else number(time_of(after, "after", spec) if isinstance(after, str) else after, settings.numbers.values, "after")
    job = Job(spec, settings, what or said.get("what"), after, members, said.get("bins", BINS) if bins is None else bins, None if out is None else Path(out))
    job.go_on()
    while job.done < job.members:
        job.member()
        if progress:
            progress(job.done)
    return job.finish()


class Job:
    """done: how many members are complete; begun: whether the next one is."""

    def __init__(self, spec: Spec, settings: Settings, what, after, members, bins, out: Path | None):
        self.settings, self.out, self.done, self.begun, self.saved = settings, out, 0, False, clock.monotonic()
        if out is not None:
            check_place(out)
        self.model = model_of(spec, settings)
        self.members, self.bins = whole(members, "members"), whole(bins, "bins")
        self.names = numbers_of(self.model, what)
        self.first = first_sample(after, settings)
        if self.members > 1 and not self.model.scene.heated:
            raise UsageError("members differ only in their noise, but no effect of the scene has kT; use members=1")
        if min(self.members, self.bins - 1) < 1:
            raise UsageError("an average needs at least one member and two bins")
        self.w = np.array(self.start(spec))
        self.block, self.pace = Block(self.model, False, self.names, casimirs=False), Pace()
        self.at = [self.model.columns.index(name) for name in self.names]
        self.statistics = Statistics(len(self.names), self.bins)
        self.meta = self.facts(spec, after)

    def start(self, spec):
        s = self.settings
        if isinstance(s.start, np.ndarray):
            return s.start
        find_start(spec, s.start)
        return state_at(self.model.prepared.numbers, s.start, s.seed)

    def facts(self, spec, after) -> dict:
        """All that decides the averages."""
        s = self.settings
        start = plain(s.start) if isinstance(s.start, np.ndarray) else find_start(spec, s.start).name
        return {"program": "smidgen", "version": __version__, "generator": self.model.built.generator, "spec": spec.name, "title": spec.title,
                "digest": spec.digest, "run": s.run, "effects": list(self.model.scene.effect_names), "start": start, "method": s.method, "solver": s.solver,
                "h": s.h, "steps": s.steps, "every": s.every, "after": float(after), "seed": s.seed, "tolerance": s.tolerance, "members": self.members,
                "bins": self.bins, "parameters": {name: plain(value) for name, value in self.model.parameters.items()},
                "what": list(self.names)}

    # A member

    def member(self) -> None:
        """From where the present one is, to its end."""
        s = self.settings
        if not self.begun:
            self.begin()
        while self.model.count < s.steps:
            self.some_steps()
            if clock.monotonic() - self.saved > BETWEEN:
                self.save()
        self.statistics.end()
        self.done, self.begun = self.done + 1, False

    def begin(self) -> None:
        s, self.begun = self.settings, True
        self.model.start(self.w.copy(), h=s.h, seed=s.seed, tolerance=s.tolerance, **({"member": self.done} if self.done else {}))

    def some_steps(self) -> None:
        """As many as fit in a moment, with the samples on the way."""
        s, model = self.settings, self.model
        left, size = s.steps - model.count, self.pace.size
        ahead = max(self.first, (model.count // s.every + 1) * s.every) - model.count
        if ahead > min(left, size):
            asked = min(left, size)
            done = self.pace.timed(model.advance, asked)
        else:
            rows = min(self.block.capacity, 1 + (min(left, size) - ahead) // s.every)
            asked, before = ahead + (rows - 1) * s.every, model.count
            got = self.pace.timed(lambda _: model.outputs(ahead, s.every, self.block, 0, rows), asked)
            self.statistics.add(self.block.values[:got, self.at])
            done = model.count - before
        if done < asked:
            raise model.failure()

    # The file

    def part(self) -> Path:
        return self.out.with_name(self.out.name + PART)

    def save(self) -> None:
        """What a killed run goes on from."""
        self.saved = clock.monotonic()
        if self.out is not None:
            state = base64.b64encode(self.model.save().tobytes()).decode()
            facts = {"meta": self.meta, "done": self.done, "state": state, "statistics": self.statistics.facts()}
            write(self.part(), json.dumps({**facts, "digest": digest(facts)}))

    def go_on(self) -> None:
        """Be where the file of a stopped run is, if there is one. Raises UsageError for one that is damaged, and for that of other choices."""
        if self.out is None or not self.part().is_file():
            return
        found = self.stopped()
        if other := [key for key, value in self.meta.items() if json.loads(json.dumps(value)) != found["meta"].get(key)]:
            raise UsageError(f"{self.part()} belongs to a run with different settings ({', '.join(other)}): remove it, or choose another file")
        self.done = found["done"]
        self.begin()
        self.model.restore(np.frombuffer(base64.b64decode(found["state"]), self.model.real))
        self.statistics.go_on(found["statistics"])

    def stopped(self) -> dict:
        """What the file of a stopped run holds: as it was written, to the byte."""
        try:
            found = json.loads(self.part().read_text(encoding="utf-8"))
            if found.pop("digest") != digest(found):
                raise ValueError
            return found
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
            raise UsageError(f"{self.part()} does not come from an interrupted run, or it is damaged: remove it, or choose another file") from None

    def finish(self) -> Averages:
        found = Averages({**self.meta, "samples": self.statistics.samples}, dict(zip(self.names, averages(self.statistics, self.settings.every * abs(self.settings.h)))))
        if self.out is not None:
            write(self.out, found.text())
            self.part().unlink(missing_ok=True)
        return found


def first_sample(after, settings) -> int:
    """Steps until the first sample, not the start itself. Raises UsageError where none is left."""
    after = number(after, {}, "after")
    first = max(1, math.ceil(after / abs(settings.h) / settings.every * (1 - 1e-15))) * settings.every
    if after < 0 or first > settings.steps:
        raise UsageError(f"no sample after t = {after:g}: the run ends at {settings.steps * abs(settings.h):g}, and samples are {settings.every} steps apart")
    return first


def digest(facts: dict) -> str:
    """sha256 of them, as JSON has them."""
    return hashlib.sha256(json.dumps(facts).encode()).hexdigest()


def write(path: Path, text: str) -> None:
    try:
        write_new(path, text.encode())
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from None


@public
def load_averages(path: str | os.PathLike) -> Averages:
    """Read a file that `average` wrote.

    :raises UsageError: if it is not such a file.
    """
    try:
        meta = json.loads(Path(path).read_text(encoding="utf-8"))
        if meta.pop("format") != FORMAT:
            raise ValueError
        return Averages(meta, {name: Average(**one) for name, one in meta.pop("averages").items()})
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise UsageError(f"{path} contains no averages") from None
