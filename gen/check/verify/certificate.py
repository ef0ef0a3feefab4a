"""The certificate: all rows of one run, as a table, as JSON, and its verdict."""
from __future__ import annotations

import dataclasses
import json

from ...version import __version__
from ...build.binary import compiler_version, find_compiler, generator_digest
from ...compile.features import chosen_features
from ...compile.select import select
from ...public import html_of
from ...errors import RunError, UsageError, ValidationError
from ...language.spec import Spec
from ...run.settings import settle
from .along import along
from .branch import branch
from .case import SEED, Case
from .casimirs import casimirs
from .contraction import contraction
from .effort import effort
from .equivariant import equivariant
from .integrals import integrals, known_integrals
from .members import members
from .noise import noise
from .order import order
from .outputs import outputs
from .refusals import refusals
from .restore import restore
from .reversible import reversible
from .round_off import round_off
from .row import CLAIMS, NO, UNITS, Row, refused
from .shared import shared
from .subject import emitted, fingerprint
from .sums import sums
from .symplectic import symplectic
from .tangent import tangent
from .whole_space import whole_space
from .witness_check import witness_check

FORMAT, VERSION = "smidgen certificate", 2
STATES = {"quick": 2, "normal": 4}


@dataclasses.dataclass(frozen=True)
class Certificate:
    """What was examined, how, and the rows. `facts` holds names, digests, compiler, choices."""
    rows: tuple[Row, ...]
    facts: dict

    def __repr__(self) -> str:
        f, failed = self.facts, [row.name for row in self.rows if row.verdict == NO]
        return f"<Certificate {f['spec']} {f['run']}: {f['method']}: {'no to ' + ', '.join(failed) if failed else 'yes'}>"

    @property
    def passed(self) -> bool:
        """No row says no."""
        return all(row.verdict != NO for row in self.rows)

    def row(self, name: str) -> Row:
        """The row of that name. Raises KeyError."""
        return {row.name: row for row in self.rows}[name]

    def check(self) -> "Certificate":
        """Itself, or ValidationError that lists the rows that say no."""
        failed = [f"{r.name}: {shown(r.measured)}, {r.criterion or 'no result'} {r.note}".rstrip()
                  for r in self.rows if r.verdict == NO]
        if failed:
            raise ValidationError(f"{self.facts['spec']} {self.facts['run']}: not certified\n" + "\n".join(failed))
        return self

    def as_dict(self) -> dict:
        """As the JSON has it; docs/verify.md is its schema."""
        rows = [{"name": r.name, "claim": r.claim, "measured": r.measured, "relation": r.relation,
                 "bound": r.bound, "unit": UNITS.get(r.name, ""), "verdict": r.verdict, "note": r.note}
                for r in self.rows]
        return {"format": FORMAT, "version": VERSION, "passed": self.passed, **self.facts, "rows": finite(rows)}

    def to_json(self) -> str:
        """The JSON text; numbers with all their digits, what is not finite as null."""
        return json.dumps(finite(self.as_dict()), indent=2, ensure_ascii=False, allow_nan=False) + "\n"

    def table(self):
        """A rich Table."""
        from rich.table import Table
        f = self.facts
        table = Table(title=f"{f['spec']} {f['run']}: {f['method']}, h = {f['h']:g}, {f['sites']} "
                            f"site{'s' * (f['sites'] != 1)}: {'yes' if self.passed else 'NO'}")
        table.caption = f"Not measured: {'; '.join(f['not_looked_at'])}." if f["not_looked_at"] else None
        for column in ("property", "measured", "criterion", "", "note"):
            table.add_column(column, overflow="fold")
        styles = {"yes": "green", "no": "bold red", "does not apply": "dim"}
        for r in self.rows:
            table.add_row(r.name, shown(r.measured), r.criterion, f"[{styles[r.verdict]}]{r.verdict}[/]", r.note)
        return table

    def _repr_html_(self) -> str:
        return html_of(self.text())

    def text(self) -> str:
        """The table as plain text."""
        from rich.console import Console
        console = Console(width=140, no_color=True, highlight=False)
        with console.capture() as capture:
            console.print(self.table())
        return capture.get()


def shown(x) -> str:
    """Three digits after the leading one: an order of 1.999 is not 2."""
    return "" if x is None else f"{x:.4g}"


def finite(data):
    """`data` with NaN and infinities replaced by None."""
    if isinstance(data, dict):
        return {k: finite(v) for k, v in data.items()}
    if isinstance(data, (list, tuple)):
        return [finite(v) for v in data]
    if isinstance(data, float):
        return data if abs(data) < float("inf") else None
    return data


def certify(spec: Spec, run=None, *, tier="normal", features=(), layouts=False, subject=None,
            seed_of_checks=SEED, **given) -> Certificate:
    """All checks of one run; `subject` in place of the generated code. Arguments as `verify`."""
    if not (tier in STATES or isinstance(tier, int) and not isinstance(tier, bool) and tier >= 1000):
        raise UsageError("tier must be \"quick\", \"normal\" or a number of steps of at least 1000")
    settings = settle(spec, run, **lengthened(spec, run, given))
    noisy, spec = spec, spec.calm
    case = Case(spec, settings, STATES.get(tier, STATES["normal"]), seed_of_checks, tier, features, layouts)
    subject = emitted(spec, settings, chosen_features(features)) if subject is None else subject
    rows = (*rows_of(case, subject), *noise(noisy, case))
    return Certificate(rows, {**facts_of(case, tier, features, noisy), **compiled_with(subject), "not_looked_at": case.unseen})


def lengthened(spec, run, given) -> dict:
    """A run that does not say how long it is has a thousand steps here."""
    from ...run.step.prepared import find_run
    base = find_run(spec, run)
    return {"steps": 1000, **given} if base.time is None and base.steps is None else given


def rows_of(case: Case, subject):
    """Every row, in the order of CLAIMS; a check that a failing step ends says no."""
    try:
        case.find_states(subject)
        subject.step(case.w, 0.0, case.h)
    except RunError as error:
        return [refused("steps", str(error))]
    known = known_integrals(case)
    checks = {"run": lambda: along(case, subject), "whole space": lambda: whole_space(case, subject),
              "branch": lambda: branch(case, subject), "refusals": lambda: refusals(case, subject), "casimirs": lambda: casimirs(case, subject), "order": lambda: order(case, subject),
              "symplectic": lambda: symplectic(case, subject), "tangent map": lambda: tangent(case, subject),
              "reversible": lambda: reversible(case, subject),
              "equivariant": lambda: equivariant(case, subject, known.actions),
              "momentum": lambda: integrals(case, subject, known),
              "sums": lambda: sums(case, subject), "outputs": lambda: outputs(case, subject),
              "round-off": lambda: round_off(case, subject, known),
              "residual": lambda: witness_check(case, subject), "iterations": lambda: effort(case, subject),
              "restore": lambda: restore(case, subject), "ensemble": lambda: members(case, subject),
              "by rows": lambda: contraction(case, subject), "threads": lambda: shared(case, subject)}
    rows = [row for name, check in checks.items() for row in guarded(name, check)]
    return sorted(rows, key=lambda row: list(CLAIMS).index(row.name))


def guarded(name, check):
    """The rows of a check, or one that says no with what the step said."""
    try:
        return check()
    except RunError as error:
        return [refused(name, str(error))]


def facts_of(case: Case, tier, features=(), noisy=None) -> dict:
    """What was examined and with what. noisy: the spec with its noise, where it has any."""
    s = case.settings
    scene = select(noisy, s.effects, s.parameters) if noisy is not None and noisy.heated else case.scene
    return {"spec": case.spec.name, "spec_digest": case.spec.digest, "run": s.run, "method": s.method,
            "solver": s.solver, "features": sorted(features), "fingerprint": fingerprint(scene, s.method, s.solver, features),
            "effects": list(case.scene.effect_names), "set": plain(s.parameters), "h": s.h,
            "probe": case.probe, "steps": s.steps, "start": s.start if isinstance(s.start, str) else None,
            "sites": case.sites, "tier": tier, "generator": __version__, "generator_digest": generator_digest()}


def compiled_with(subject) -> dict:
    """Compiler and flags of the code that was measured, where it is the generated one."""
    double = getattr(subject, "double", None)
    return {"compiler": compiler_version(find_compiler()), "flags": list(double.built.flags) if double else []}


def plain(values: dict) -> dict:
    """Parameter values as JSON has them."""
    return {k: list(map(float, v)) if hasattr(v, "__len__") else v for k, v in values.items()}
