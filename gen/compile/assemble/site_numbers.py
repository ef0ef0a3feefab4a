"""Numbers that sites have by their number alone, whatever the state and the time, and that are work to find: random ones above all
(runtime/core/smg_random.h). A state keeps them in an array, found once; a call without a state finds them anew.
"""
from __future__ import annotations

from ..lower.code import Argument, At, Call, Function, If, Member, Name, Return, Unary
from ..lower.integers import Index, compare, total
from ..lower.kernels import COEFFICIENTS
from .part import Part, buffer

SITE = (COEFFICIENTS, Argument("int64_t", "i"))


class SiteNumbers(Part):
    """{function: kernel of what it gives of the i-th site of a family}. Asked last, when all other kernels are made."""
    name = "site_numbers"

    def made(self, model, low):
        return {name: low.unkept(e) for e, name in low.site_numbers.items()} if low.site_numbers or low.draws else None

    def first(self, model):
        """site_number_0, ..: out of the array, where there is one, which has room for the number of any site of any family."""
        def kept(n):
            place = n * model.total + Index("i")
            return If((Member("c", "of_sites"),), (Return(Unary("*", At(Member("c", "of_sites"), place))),))
        return [Function("smg_real", name, SITE, (kept(n), *kernel.values, Return(kernel.results[0])))
                for n, (name, kernel) in enumerate(model.site_numbers.items())]

    def functions(self, model):
        """smg_site_number(c, n, i): the n-th of them."""
        *some, last = [Call(name, (Name("c"), Index("i"))) for name in model.site_numbers] or [None]
        if last is None:
            return []
        tests = [If((compare(Index("n"), "==", total(n)),), (Return(call),)) for n, call in enumerate(some)]
        return [Function("smg_real", "smg_site_number", (COEFFICIENTS, Argument("int64_t", "n"), *SITE[1:]), (*tests, Return(last)), wanted=True)]

    def headers(self, model):
        return ["smg_random.h"] * model.low.draws

    def settings(self, model):
        return {"SMG_SITE_NUMBERS": len(model.site_numbers)}

    def held(self, model):
        return [("const smg_real *of_sites", "values of sites, or NULL: then they are computed when needed")] * bool(model.site_numbers)

    def around(self, model):
        numbers = len(model.site_numbers)
        return [buffer("site_numbers", numbers * model.total, "values of formulas at each site")] if numbers else []
