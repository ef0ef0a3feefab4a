"""Bounds of what a site of a lattice feels, at all times and of all states: of the field of no spins, and of the norms of the Hessian's blocks in its row.

A term that is quadratic in the spins has the same Hessian at all states. That of another one is bounded where no spin is longer than its radius r, by the ends of each entry
(`extent.py`): along the ray from 0 to a state the gradient g changes by no more than that, so that |g| <= |g(0)| + B r as for quadratic terms.
"""
from __future__ import annotations

import sympy as sp

from ..derive.derivatives import is_real, scalar
from ..derive.parts import is_large
from .extent import MOST, OneTime, expanded, largest, largest_ever, varies
from .norms import isotropic, spectral_bound


MOST_MONOMIALS = 200    # of an entry of the Hessian


class Spins:
    """The vectors of a term where none is longer than the radius of its family; ends: the least and the largest value of each component, and of a symbol for each of their products."""

    def __init__(self, low, t, radii):
        vectors, r = t.derived.vectors, [length(low, radii[family]) for family, _ in t.slots]
        pairs = {sp.Dummy(real=True): (n, m) for n in range(len(vectors)) for m in range(n, len(vectors))}
        self.vectors, self.components = vectors, {x for v in vectors for x in v}
        self.products = {p: (vectors[n], vectors[m]) for p, (n, m) in pairs.items()}
        self.ends = {**{x: (-r[n], r[n]) for n, v in enumerate(vectors) for x in v}, **{p: (-r[n] * r[m], r[n] * r[m]) for p, (n, m) in pairs.items()}}

    def named(self, e):
        """With their symbols for products of vectors that stand there as such, expanded."""
        return expanded(e.subs({self.written_out(p): p for p in self.products}))

    def in_lengths(self, e):
        """A polynomial with |v|^2 - v.x^2 - v.y^2 in place of v.z^2."""
        e = expanded(e)
        for p, (v, w) in self.products.items():
            e = replaced(e, p, v, w) if v == w else e
        return e

    def parted(self, block):
        """(what products of vectors add to the whole diagonal, in their symbols; the block without it)."""
        scale, e = sp.S.Zero, block[0, 0]
        for p, (v, w) in self.products.items():
            e = min(e, replaced(e, p, v, w), key=terms)
        for x in sp.Add.make_args(e):
            rest = min(((block - y * sp.eye(3)).applyfunc(expanded) for y in (x, self.written_out(x))), key=all_terms)
            if not x.free_symbols & self.components and all_terms(rest) < all_terms(block):
                scale, block = scale + x, rest
        return scale, block

    def written_out(self, e):
        return expanded(e.xreplace({p: sum(map(sp.Mul, v, w)) for p, (v, w) in self.products.items()}))

    def of_components(self, e) -> bool:
        """Is it a polynomial of components?"""
        return e.is_polynomial(*self.components) and not is_large(e, *MOST)


def length(low, radius):
    value, leaves = scalar(radius)
    low.leaves.update(leaves)
    return low.number_values(value)


def terms(e) -> int:
    return len(sp.Add.make_args(e)) if e != 0 else 0


def all_terms(block) -> int:
    return sum(map(terms, block))


def replaced(e, product, v, w):
    """e with that symbol in place of v.z w.z, and the rest of the product taken off it."""
    return expanded(e.subs(v[2] * w[2], product - v[0] * w[0] - v[1] * w[1]))


def bounds_of_terms(low, terms, radii, stepped: bool) -> tuple:
    """({(prefix, slot): bounds}, whether some hold at the time of one step alone); radii: of each family; stepped: may they?"""
    bounds = {(t.prefix, k): bounds_of_term(low, t, k, radii) for t in terms for k in range(len(t.slots))}
    timely = {(t.prefix, k): bounds_of_term(OneTime(low), t, k, radii) for t in terms for k in range(len(t.slots)) if stepped and None in bounds[t.prefix, k]}
    return {**bounds, **timely}, bool(timely)


def bounds_of_term(low, t, k: int, radii) -> tuple:
    """(of the field of no spins, of the Hessian) in the row of slot k; None where there is none."""
    return rest_norm(low, t, k), hessian_norm(low, t, k, Spins(low, t, radii))


def bends(t) -> bool:
    """Is the Hessian not the same at all states?"""
    components = {x for vector in t.derived.vectors for x in vector}
    return any(components & block.free_symbols for block in t.derived.hessian.values())


def rest_norm(low, t, k):
    origin = {v: 0 for vector in t.derived.vectors for v in vector}
    values = [low.number_values(sp.sympify(x).subs(origin)) for x in t.derived.gradient[k]]
    return largest_ever(low, sp.sqrt(sum(x ** 2 for x in values))) if all(map(is_real, values)) else None


def hessian_norm(low, t, k, spins: Spins):
    norms = block_norms(low, t, k, spins).values()
    return None if None in norms else sum(norms, sp.S.Zero)


def block_norms(low, t, k, spins: Spins) -> dict:
    """{slot: that of the block beside it, in the row of slot k}. Where time or spins enter, entry by entry."""
    blocks = {q: block.applyfunc(low.number_values) for (a, q), block in t.derived.hessian.items() if a == k}
    return {q: of_all_states(low, b, spins) if b.free_symbols & spins.components else largest_norm(low, b, t.derived.joined) if any(varies(low, x) for x in b) else spectral_bound(b, t.derived.joined)
            for q, b in blocks.items()}


def largest_norm(low, block, joined):
    """As `spectral_bound`: of the symmetric part, and of the antisymmetric one."""
    even, odd = (block + block.T) / 2, (block - block.T) / 2
    scale, even = isotropic(even) if joined else (None, even)
    alike = even == even[0, 0] * sp.eye(3)
    entries = [*([[scale]] if joined else []), [even[0, 0]] if alike else list(even), [odd[0, 1], odd[0, 2], odd[1, 2]]]
    sizes = [[largest_ever(low, sp.Abs(x)) for x in part] for part in entries]
    return None if any(None in part for part in sizes) else sum(sp.sqrt(sum(x ** 2 for x in part)) for part in sizes)


def of_all_states(low, block, spins: Spins):
    """Of a multiple of I that products of vectors give, as in dot(v, w)^2, and of what is left."""
    if not all(map(spins.of_components, block)):
        return largest_sums(low, block, spins)
    exact = {x: sp.Rational(repr(float(x))) for x in block.atoms(sp.Float)}      # so that terms cancel out
    scale, rest = spins.parted(block.xreplace(exact).applyfunc(spins.named))
    norms = largest_ever(low, sp.Abs(scale), spins.ends), frobenius(low, rest, spins) or largest_sums(low, rest, spins)
    return None if None in norms else rounded(sum(norms))


def rounded(e):
    """With real numbers in place of fractions; exponents are halves."""
    return e.xreplace({x: sp.Float(x) for x in e.atoms(sp.Rational) if x.q > 2})


def frobenius(low, block, spins: Spins):
    """Where lengths alone enter it."""
    square = spins.in_lengths(sum(x ** 2 for x in block))
    return None if square.free_symbols & spins.components else largest_ever(low, sp.sqrt(square), spins.ends)


def largest_sums(low, block, spins: Spins):
    """The root of the largest sum of a row times that of a column."""
    sizes = [largest_of_monomials(low, x, spins) or largest_ever(low, sp.Abs(x), spins.ends) for x in block]
    if None in sizes:
        return None
    rows, columns = [sum(sizes[3 * a:3 * a + 3]) for a in range(3)], [sum(sizes[a::3]) for a in range(3)]
    most, across = (largest(*([x for x in part if x != 0] or [sp.S.Zero])) for part in (rows, columns))
    return most if rows == columns else sp.sqrt(most * across)


# Polynomials

def largest_of_monomials(low, e, spins: Spins):
    """Of a polynomial of components, whose coefficients may turn with the time: the sum of |coefficient| times the largest value of its monomial; None of another formula, or of a long one.

    Of cosines and sines it is a sum of waves, each with an amplitude of its own: cos(a)^4 - 6 cos(a)^2 sin(a)^2 + sin(a)^4 = cos(4 a) is no larger than 1.
    """
    e, turning = in_waves(low, e)
    variables = {*spins.ends, *turning}
    found = {}
    for term in sp.Add.make_args(e):
        factor, monomial = term.as_independent(*variables, as_Add=False)
        found[monomial] = found.get(monomial, 0) + factor
    whole = all(x in variables and n.is_Integer and (n > 0 or x in turning) for m in found for x, n in m.as_powers_dict().items() if x != 1)
    fixed = whole and not any(varies(low, factor) for factor in found.values())
    return sum((modulus(factor) * largest_value(m, spins, turning) for m, factor in found.items()), sp.S.Zero) if fixed and len(found) <= MOST_MONOMIALS else None


def in_waves(low, e) -> tuple:
    """(e, expanded, with (u + 1/u)/2 and (u - 1/u)/2i in place of the cosine and the sine of an angle that the time enters, the symbols u)."""
    angles = {x.args[0]: sp.Dummy("u") for x in e.atoms(sp.cos, sp.sin) if varies(low, x)}
    waves = {f: (u + sign / u) / (2 if sign > 0 else 2 * sp.I) for angle, u in angles.items() for f, sign in ((sp.cos(angle), 1), (sp.sin(angle), -1))}
    return expanded(e.xreplace(waves)), set(angles.values())


def modulus(factor):
    """That of a complex number whose parts are formulas."""
    imaginary = factor.coeff(sp.I)
    real = expanded(factor - sp.I * imaginary)
    return sp.Abs(real) if imaginary == 0 else sp.Abs(imaginary) if real == 0 else sp.sqrt(real ** 2 + imaginary ** 2)


def largest_value(monomial, spins: Spins, turning):
    """Of |x^a y^b z^c| where (x, y, z) is no longer than r: r^n sqrt(a^a b^b c^c/n^n), n = a + b + c."""
    powers = {x: int(n) for x, n in monomial.as_powers_dict().items() if x not in (1, *turning)}
    value = sp.prod(spins.ends[x][1] ** n for x, n in powers.items())
    for vector in dict.fromkeys(map(tuple, spins.vectors)):
        n = [powers.get(x, 0) for x in vector]
        value *= sp.sqrt(sp.Rational(sp.prod(k ** k for k in n), sum(n) ** sum(n)))
    return value
