"""The laws of pieces: each [test] is a small spec with the piece as its effect `it`, run, and compared with formulas.

    [test]
    arguments = { J = 0.8, bonds = "chain(2, open)" }
    law = ["w[0] == turned(w0[0], w0[0] + w0[1], 0.8*norm(w0[0] + w0[1])*t/1.7)"]

A side of a law is a formula of the state w, the start w0 and the time t, or the word `energy`; in `mean`, its left side is averaged over the run.
"""
from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np

from ..errors import SpecError, UsageError
from ..language.evaluate import evaluate
from ..methods import ACCURATE
from ..read import load_text
from ..read.catalogue import Piece
from ..run.run import run

SPACE = {"w": {"sphere": 2, "kappa": 1.7}}
OPTIONS = {"method": ACCURATE, "time": 1.5, "steps": 60, "within": 1e-10}     # of a test that does not say them
FORMULAS = {"artanh(x)": "log((1 + x)/(1 - x))/2",
            "turned(a, axis, angle)": "a*cos(angle) + cross(axis, a)*(sin(angle)/norm(axis)) + axis*(dot(axis, a)*(1 - cos(angle))/dot(axis, axis))"}
SIGMAS = 4          # standard errors within which a mean agrees
BLOCKS = 40         # of a run, whose means tell the standard error


@dataclass(frozen=True)
class Verdict:
    """Of one law: by how much its sides differ, at most, and what is allowed."""
    piece: str
    law: str
    deviation: float
    within: float

    @property
    def passed(self) -> bool:
        return self.deviation <= self.within


def verdicts(piece: Piece, library=()) -> list[Verdict]:
    """Those of all laws of a piece; none where it has no test. Raises UsageError for a test that cannot be run."""
    if not piece.test:
        return []
    says = checked({**OPTIONS, **piece.test}, piece)
    try:
        result = computed(piece, says, library)
        return [*(still(piece, says, law, result) for law in says.get("law", ())),
                *(mean(piece, says, law, result) for law in says.get("mean", ()))]
    except SpecError as error:
        first = error.diagnostics[0]
        raise UsageError(f"the test of {piece.name} is not a spec: {first.cause}: `{first.text.strip()}` ({first.hint})") from None


def checked(says: dict, piece) -> dict:
    """The test itself. Raises UsageError where a number or a list of laws is something else."""
    for key, kind, what in (("time", (int, float), "a number"), ("within", (int, float), "a number"), ("steps", int, "an integer"),
                            ("law", list, "a list of laws"), ("mean", list, "a list of laws")):
        if key in says and not isinstance(says[key], kind):
            raise UsageError(f"the test of {piece.name}: `{key}` is {what}")
    laws = [*says.get("law", ()), *says.get("mean", ())]
    if says["steps"] < 1 or not says["time"]:
        raise UsageError(f"the test of {piece.name}: `steps` must be at least 1, and `time` not 0")
    if not laws or not all(isinstance(law, str) for law in laws):
        raise UsageError(f"the test of {piece.name}: `law` or `mean` must list at least one law, as text")
    return says


def table(laws):
    """A rich Table."""
    from rich.markup import escape
    from rich.table import Table
    found = Table()
    for column in ("piece", "law", "deviation", "at most", ""):
        found.add_column(column, overflow="fold")
    for law in laws:
        found.add_row(law.piece, escape(law.law), f"{law.deviation:.3g}", f"{law.within:.3g}", "[green]yes[/]" if law.passed else "[bold red]no[/]")
    return found


def computed(piece, says, library):
    """The result of the run."""
    kept = [f"o{k}" for k in range(len(says.get("mean", ())))]
    return run(load_text(moving(piece, says), library=library), method=says["method"], h=says["time"] / says["steps"], steps=says["steps"],
               every=1 if kept else says["steps"], what=["states", "energy", *kept])


def moving(piece, says) -> str:
    """The spec that is run."""
    space = says.get("space", SPACE)
    random = {"random": 1} if len(space) == 1 else {name: {"random": 1} for name in space}
    return written({"model": {"name": "test", "orientation": says.get("orientation", 1)}, "space": space, "formulas": FORMULAS,
                    **{section: says[section] for section in ("parameters", "lattices") if section in says},
                    "effects": {"it": {"use": piece.name, **says.get("arguments", {})}, **says.get("effects", {})},
                    "starts": {"a": says.get("start", random)}, "observables": {f"o{k}": {"value": sides(law)[0]} for k, law in enumerate(says.get("mean", ()))}})


def reading(says, value: str) -> str:
    """A spec in which the value is a formula of each family and of its start; nothing moves."""
    space = says.get("space", SPACE)
    still = {f"e{k}": {"over": f"site(i) of {name}", "energy": f"{name}[i].z"} for k, name in enumerate(space)}
    return written({"model": {"name": "law"}, "space": {**space, **{f"{name}0": family for name, family in space.items()}},
                    "parameters": says.get("parameters", {}), "formulas": {**FORMULAS, **says.get("formulas", {})},
                    "effects": still, "observables": {"off": {"value": value}}})


def still(piece, says, law, result) -> Verdict:
    """A law at the end of the run."""
    left, right = sides(law)
    spins = {**{f: w[-1] for f, w in result.w.items()}, **{f"{f}0": w[0] for f, w in result.w.items()}}
    left = repr(float(result.values["energy"][-1])) if left == "energy" else left
    return Verdict(piece.name, law, difference(says, left, right, {"t": float(result.t[-1]), "spins": spins}), says["within"])


def mean(piece, says, law, result) -> Verdict:
    """A law of the mean over the run, after its first tenth."""
    values = np.asarray(result.values[f"o{says['mean'].index(law)}"], float)
    blocks = np.array([part.mean() for part in np.array_split(values[len(values) // 10:], BLOCKS)])
    off = difference(says, repr(float(blocks.mean())), sides(law)[1], {})
    return Verdict(piece.name, law, off, SIGMAS * float(blocks.std(ddof=1)) / BLOCKS ** 0.5)


def difference(says, left: str, right: str, env: dict) -> float:
    """The size of left - right, vectors or numbers; env: the time and the states."""
    try:
        spec = load_text(reading(says, f"norm(({left}) - ({right}))"))
    except SpecError:
        spec = load_text(reading(says, f"abs(({left}) - ({right}))"))
    return float(evaluate(spec.observables[0].value, {**{p.name: p.default for p in spec.parameters}, **env}))


def sides(law: str) -> tuple[str, str]:
    left, equal, right = law.partition("==")
    if not equal or not left.strip() or not right.strip():
        raise UsageError(f"`{law}` is not a law: a law has the form `left == right`")
    return left.strip(), right.strip()


# A spec of tables as text

def written(tables: dict) -> str:
    return "\n".join(f"[{name}]\n" + "".join(f"{json.dumps(key)} = {value(entry)}\n" for key, entry in table.items()) for name, table in tables.items())


def value(entry) -> str:
    if isinstance(entry, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {value(inner)}" for key, inner in entry.items()) + " }"
    if isinstance(entry, list):
        return "[" + ", ".join(map(value, entry)) + "]"
    return json.dumps(entry, ensure_ascii=False) if isinstance(entry, (str, bool)) else repr(entry)
