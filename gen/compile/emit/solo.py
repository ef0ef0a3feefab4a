"""One unit sphere alone: kernels by value for the fastest step."""
from __future__ import annotations

import sympy as sp

from ..derive.derivatives import scalar
from ..derive.parts import expanded, functions_apart, is_short
from ..lower.kernels import function
from ..lower.lowering import SITE
from .statics import Static


class SoloParts:
    """Kernels of a single sphere; part of `Emitter`."""

    def is_solo(self) -> bool:
        """One unit sphere whose field depends on itself: the fastest step."""
        f = self.families[0]
        return (self.method.of_midpoints and self.method.onto_leaf and len(self.families) == 1 and f.count == "1"
                and f.unit and not self.closed_form(f)
                and not any(t.derived.parts for t in self.effects)
                and all(self.low.level(s.name) < SITE for t in self.effects for b in t.derived.hessian.values()
                        for s in b.free_symbols if s.name[0] != "v")
                and any(x != 0 for x in self.solo_field()[3]))

    def solo_field(self) -> tuple:
        """(m, h b(m), h X(m), its derivative): a vector m of symbols, and sympy matrices."""
        m = sp.Matrix(sp.symbols("v0x v0y v0z", real=True))
        kappa, leaves = scalar(self.spec.families[0].kappa)
        self.low.leaves.update(leaves)
        b = sp.Matrix([sum(t.derived.gradient[0][a] for t in self.effects if t.slots) for a in range(3)])
        b = (b * self.low.step_size() / kappa).applyfunc(self.low.number_values).applyfunc(lambda e: shorter(e, m))
        X = m.cross(b).applyfunc(lambda e: shorter(e, m))
        return m, b, X, X.jacobian(m).applyfunc(lambda e: shorter(e, m))

    def solo_kernels(self):
        """h X(m), its derivative times q in a struct of its non-zero entries, and e = h DX(m) m."""
        m, b, X, D = self.solo_field()
        entries = [(a, b) for a in range(3) for b in range(3) if D[a, b] != 0]
        functions = {"smg_motion": self.solo_motion(X, b, m), "smg_radial": self.solo_radial(X, D, m), "smg_slope": self.solo_matrix(entries),
                     "smg_derivative": self.solo_derivative(D, entries), "smg_slope_times": self.solo_apply(entries),
                     "smg_slope_minors": self.solo_minors(entries)}
        return [Static(name, text, True) for name, text in functions.items()]

    def solo_function(self, kind: str, name: str, arguments, body) -> str:
        declared = ["const smg_coefficients *c", *arguments]
        return function(f"{kind} {name}", declared, [by_value(line) for line in body],
                        ["c", *(x.split()[1] for x in arguments)])

    def solo_vector(self, name: str, arguments, expressions) -> str:
        kernel = self.low.kernel(expressions, {})
        return self.solo_function("smg_vec", name, arguments,
                                  [*kernel.lines, f"return smg_vec_of({', '.join(kernel.results)});"])

    def solo_motion(self, X, b, m) -> str:
        """h X(m). As m x b it stays tangent whatever the coefficients are rounded to; three single
        products, a free body's, need less work and what rounding leaves, d mx my mz, averages out."""
        if all(is_short(x) and len(sp.Add.make_args(expanded(x))) == 1 for x in X):
            return self.solo_vector("smg_motion", ["smg_vec m"], list(X))
        kernel = self.low.kernel(list(b), {})
        return self.solo_function("smg_vec", "smg_motion", ["smg_vec m"],
                                  [*kernel.lines, f"return smg_vec_cross(m, smg_vec_of({', '.join(kernel.results)}));"])

    def solo_radial(self, X, D, m) -> str:
        """e = DX m; for a field homogeneous of degree p this is p X."""
        e = D * m
        for degree in range(1, 9):
            if all(expanded(e[a] - degree * X[a]) == 0 for a in range(3)):
                return self.solo_function("smg_vec", "smg_radial", ["smg_vec m", "smg_vec g"],
                                          [f"return smg_vec_scale({degree}, g);"])
        return self.solo_vector("smg_radial", ["smg_vec m", "smg_vec g"], [shorter(x, m) for x in e])

    def solo_matrix(self, entries) -> str:
        members = ", ".join(f"e{a}{b}" for a, b in entries) or "none"
        return f"typedef struct smg_slope {{\n  smg_real {members};\n}} smg_slope;"

    def solo_derivative(self, D, entries) -> str:
        q = sp.Symbol("q", real=True)
        kernel = self.low.kernel([q * D[a, b] for a, b in entries], {})
        body = [*kernel.lines, f"smg_slope D;"]
        body += [f"D.e{a}{b} = {result};" for (a, b), result in zip(entries, kernel.results)]
        return self.solo_function("smg_slope", "smg_derivative", ["smg_vec m", "smg_real q"],
                                  [*body, "return D;"])

    def solo_apply(self, entries) -> str:
        rows = [" + ".join(f"D.e{a}{b}*v.{'xyz'[b]}" for a, b in entries if a == row) or "0" for row in range(3)]
        return function("smg_vec smg_slope_times", ["smg_slope D", "smg_vec v"],
                        [f"return smg_vec_of({', '.join(rows)});"], ["D", "v"])

    def solo_minors(self, entries) -> str:
        """e2(D): the sum of the principal 2x2 minors."""
        terms = []
        for a, b in ((0, 1), (0, 2), (1, 2)):
            if (a, a) in entries and (b, b) in entries:
                terms.append(f"+ D.e{a}{a}*D.e{b}{b}")
            if (a, b) in entries and (b, a) in entries:
                terms.append(f"- D.e{a}{b}*D.e{b}{a}")
        text = " ".join(terms).removeprefix("+ ") or "0"
        return function("smg_real smg_slope_minors", ["smg_slope D"], [f"return {text};"], ["D"])


def shorter(e, m):
    """A polynomial in m with its coefficients collected, where that takes fewer operations."""
    if not is_short(e):
        return e
    whole, back = functions_apart(e)        # Poly would multiply out what stands in them
    if any(f.free_symbols & set(m) for f in back.values()):
        return e
    return collected(whole, m).xreplace(back)


def collected(e, m):
    """The same without functions."""
    long = expanded(e)
    if not long.is_polynomial(*m) or len(sp.Add.make_args(long)) > 40:
        return e
    terms = sp.Poly(long, *m).terms()
    monomials = [sp.prod(x ** k for x, k in zip(m, powers)) for powers, _ in terms]
    bare = sum(sp.Symbol(f"known{k}") * monomial for k, monomial in enumerate(monomials))
    if sp.count_ops(bare) < work(e, m):
        return sum(c * monomial for (_, c), monomial in zip(terms, monomials))
    return e


def work(e, m) -> int:
    """Operations that remain when all that is free of m is known."""
    rest = e.replace(lambda x: isinstance(x, sp.Expr) and not x.is_Atom and not (x.free_symbols & set(m)), lambda x: sp.Dummy())
    return int(sp.count_ops(rest))


def by_value(line: str) -> str:
    """The array v0 of a kernel as the vector m by value."""
    for axis in range(3):
        line = line.replace(f"v0[{axis}]", f"m.{'xyz'[axis]}")
    return line
