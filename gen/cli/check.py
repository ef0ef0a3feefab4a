"""`smidgen check`: read specs and say what is in them, or what is wrong."""
from __future__ import annotations

from ..errors import Exit, SmidgenError
from .options import json_option, spec_argument
from .say import describe, printed, say

EXAMPLES = """  smidgen check top.toml
  smidgen check specs/*.toml --json"""


def add(commands):
    """The sub-command."""
    parser = commands.add("check", command, "read specs and report all errors", EXAMPLES)
    spec_argument(parser, nargs="+")
    json_option(parser)


def command(args):
    """All specs are read; the exit code is the first error's."""
    reports = [examine(word, args.library) for word in args.spec]
    if args.json:
        printed([{k: v for k, v in r.items() if k != "text"} for r in reports])
    for report in reports:
        if "error" in report:
            say(report["text"])
        elif not args.json:
            print(report["text"])
    return next((r["error"]["exit_code"] for r in reports if "error" in r), Exit.OK)


def examine(word: str, library) -> dict:
    """Facts of one spec, or its error."""
    try:
        return facts(word, library)
    except SmidgenError as error:
        return {"spec": word, "ok": False, "error": describe(error), "text": str(error)}


def facts(word: str, library) -> dict:
    """Load, settle every run, and count."""
    from ..language.names_used import unused
    from ..run.settings import settle
    from ..read.names import plural
    from ..read.shipped import load_spec
    from ..run.step.evaluated import sizes
    from ..analyse.symmetry.jumps import jumps
    spec = load_spec(word, library)
    families = {name: count for name, (_, count) in sizes(spec).items()}
    steps = {run.name: settle(spec, run.name).steps for run in spec.runs}
    idle, sudden = unused(spec), jumps(spec)
    text = f"{word}: good. {spec.title or spec.name}: " + ", ".join(
        [f"{plural(count, 'site')} {name}" for name, count in families.items()]
        + [f"effects {', '.join(spec.effect_names)}",
           f"runs {', '.join(steps) or 'none'}"]
        + ([f"in {', '.join(scale.text for scale in spec.units.scales)}"] if spec.units else []))
    text += "".join(f"\n  warning: the parameter '{name}' is not used" for name in idle)
    text += "".join(f"\n  warning: the energy of '{name}' is discontinuous: one term jumps by {size:.2g}; see `smidgen explain`"
                    for name, size in sudden.items())
    return {"spec": word, "ok": True, "name": spec.name, "families": families,
            "effects": list(spec.effect_names), "runs": steps, "unused": idle, "jumps": sudden, "text": text}
