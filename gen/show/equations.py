"""The equations of a spec in LaTeX: H by its effects, and what moves sites beside it."""
from __future__ import annotations

import math

from ..language.expr import Elem, Expr, Idx, Num, Op, Par, Spin, Time, Weight
from ..language.spec import Each, Graph, Lattice, Pairs, Sites, Spec

GREEK = frozenset("alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi chi psi omega "
                  "Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega".split())
SUM, PRODUCT, POWER, ATOM = range(4)        # how tightly a text binds
NAMED = frozenset("exp log sin cos tan sinh cosh tanh min max".split())
ARCS = {"asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan"}
COMPARED = {"<": "<", "<=": r"\le", ">": ">", ">=": r"\ge", "==": "=", "!=": r"\ne"}
JOINED = {"and": r"\text{ and }", "or": r"\text{ or }"}


def equations(spec: Spec) -> list[str]:
    """Lines of LaTeX: the equations of motion, one line for each energy of H, one for each other effect."""
    energies = {e.name for e in spec.energies}
    others = [rf"\text{{{plain(e.name)}: }} {text(Op('=', (Par(key), value)))}" for e in spec.effects if e.name not in energies for key, value in e.formulas.items()]
    if not energies:
        return others
    terms = [rf"\underbrace{{{summed(e)}}}_{{\text{{{plain(e.name)}}}}}" for e in spec.energies]
    motions = r", \quad ".join(motion(spec, f) for f in spec.families)
    return [rf"{motions}, \qquad H = {terms[0]}", *(f"+ {term}" for term in terms[1:]), *others]


def motion(spec: Spec, f) -> str:
    """The equation of the sites of a family; dots where effects that are no energies add to it."""
    w, sign, more = f"{symbol(f.name)}_i", "-" * (spec.orientation < 0), r" + \dots" * (f.name in (*spec.pushed, *spec.damped))
    kappa = r"\frac{1}{\kappa_i} " if f.kappa != Num(1) else ""
    normal = rf"\nabla C({w})" if f.kind == "nambu" else w
    return rf"\dot {w} = {sign}{kappa}{normal} \times \frac{{\partial H}}{{\partial {w}}}{more}"


def summed(term) -> str:
    """The sum over the index family of a term."""
    (sign, value), over = unsigned(term.value), below(term.over)
    return f"{sign}{over} {text(value, PRODUCT if over or sign else SUM)}".replace("  ", " ").strip()


def unsigned(e: Expr) -> tuple[str, Expr]:
    """("-" or "", what is left) where a sign stands before a product or quotient, or before its first factor."""
    if isinstance(e, Op) and e.op == "neg":
        sign, rest = unsigned(e.args[0])
        return "" if sign else "-", rest
    if isinstance(e, Op) and e.op in "*/":
        sign, first = unsigned(e.args[0])
        return sign, Op(e.op, (first, *e.args[1:]))
    return "", e


def below(over) -> str:
    """The sign of summation with its indices."""
    if isinstance(over, Sites):
        return rf"\sum_{{{over.index}}}"
    if isinstance(over, Pairs):
        return rf"\sum_{{{over.first} < {over.second}}}"
    if isinstance(over, Each):
        return rf"\sum_{{{', '.join(over.indices)}}}"
    if isinstance(over, (Lattice, Graph)):
        return rf"\sum_{{\langle {', '.join(over.bound)} \rangle}}"
    return ""


def text(e: Expr, least: int = SUM) -> str:
    """`e`, in parentheses where it binds less than `least`."""
    said, binds = written(e)
    return said if binds >= least else rf"\left({said}\right)"


def written(e: Expr) -> tuple[str, int]:
    """(LaTeX, how tightly it binds) of one node."""
    if isinstance(e, Op):
        sign, rest = unsigned(e)
        return (f"-{text(rest, PRODUCT)}", SUM) if sign else operation(rest)
    if isinstance(e, Num):
        said = number(e.value)
        return said, SUM if e.value < 0 else PRODUCT if "cdot" in said else ATOM
    if isinstance(e, Elem):
        return f"{symbol(e.name)}_{{{text(e.index)}}}", ATOM
    if isinstance(e, Spin):
        return f"{symbol(e.family)}_{{{e.slot}}}", ATOM
    return {Time: "t"}.get(type(e)) or symbol(e.name) if isinstance(e, (Par, Idx, Weight, Time)) else rf"\text{{{plain(str(e))}}}", ATOM


def number(value) -> str:
    """pi by its name, a power of ten in place of an exponent."""
    if value == math.pi:
        return r"\pi"
    digits, _, exponent = repr(value).partition("e")
    return rf"{digits} \cdot 10^{{{int(exponent)}}}" if exponent else digits


def symbol(name: str) -> str:
    """One letter as it is, a Greek one by its command, words upright; what follows an underscore or closing digits is below."""
    stem, _, index = name.partition("_")
    if not index and stem.rstrip("0123456789") != stem and stem.rstrip("0123456789"):
        stem, index = stem.rstrip("0123456789"), stem[len(stem.rstrip("0123456789")):]
    said = rf"\{stem}" if stem in GREEK else stem if len(stem) == 1 else rf"\mathrm{{{stem}}}"
    return said + (rf"_{{\mathrm{{{plain(index)}}}}}" if index else "")


def plain(words: str) -> str:
    """Words inside \\text: the signs of TeX taken literally."""
    return "".join({"\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}"}.get(c, "\\" + c if c in "#$%&_{}" else c) for c in words)


def operation(e: Op) -> tuple[str, int]:
    op, a = e.op, e.args
    if op in "+-=" and len(a) == 2:
        return f"{text(a[0])} {op} {text(a[1], PRODUCT if op == '-' else SUM)}", SUM
    if op == "*":
        return rf"{text(a[0], PRODUCT)}{dotted(a[1])}{text(a[1], PRODUCT)}", PRODUCT
    if op == "/":
        return rf"\frac{{{text(a[0])}}}{{{text(a[1])}}}", ATOM
    if op == "^":
        return f"{text(a[0], ATOM)}^{{{text(a[1])}}}", POWER
    return call(op, a)


def dotted(factor: Expr) -> str:
    """Between two factors: a point before a number."""
    return r" \cdot " if isinstance(factor, Num) else r" \, "


def call(op: str, a) -> tuple[str, int]:
    """Functions and what is written in a way of its own."""
    if op in "xyz":
        said = text(a[0], ATOM)
        return (f"{said[:-1]}, {op}}}" if isinstance(a[0], Spin) else f"{said}_{{{op}}}"), ATOM
    if op == "dot":
        return rf"{text(a[0], PRODUCT)} \cdot {text(a[1], PRODUCT)}", PRODUCT
    if op == "cross":
        return rf"{text(a[0], POWER)} \times {text(a[1], POWER)}", PRODUCT
    if op == "triple":
        return rf"{text(a[0], POWER)} \cdot \left({text(a[1], POWER)} \times {text(a[2], POWER)}\right)", PRODUCT
    if op in ("norm", "abs", "floor", "sqrt"):
        return {"norm": r"\left\lVert {} \right\rVert", "abs": r"\left| {} \right|", "floor": r"\left\lfloor {} \right\rfloor", "sqrt": r"\sqrt{{{}}}"}[op].format(text(a[0])), ATOM
    if op in COMPARED:
        return f"{text(a[0])} {COMPARED[op]} {text(a[1])}", SUM
    if op in JOINED:
        return JOINED[op].join(text(one) for one in a), SUM
    if op == "if":
        return rf"\begin{{cases}} {text(a[1])} & {text(a[0])} \\ {text(a[2])} & \text{{else}} \end{{cases}}", ATOM
    name = ARCS.get(op) or (rf"\{op}" if op in NAMED else rf"\operatorname{{{plain(op)}}}")
    return rf"{name}\left({', '.join(text(one) for one in a)}\right)", ATOM
