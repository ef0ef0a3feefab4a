"""The scalar printer: the intermediate form as C over smg_real (double, long double or quadruple precision). Other targets
say what they print otherwise, in a class over this one.
"""
from __future__ import annotations

from itertools import chain, groupby

from sympy.logic.boolalg import Boolean

from ..lower.code import Either, For, Let, Return, Variable, Zeros, mentions
from ..lower.integers import Int, Product, Whole, times
from ...language.c_names import in_c
from .formulas import ATOM, PRODUCT, SUM, TEST, Formulas, number

STRENGTH = {"+": SUM, "-": SUM, "*": PRODUCT, "/": PRODUCT, "%": PRODUCT, "==": TEST}
LINE = 110      # columns of a statement that stands beside its head, before it is indented; a function, which is not, may have 120
LINKAGE = {"usual": "static inline", "always": "SMG_INLINE", "never": "static", "lanes": "SMG_LANE_KERNEL"}


def indent(lines, by: int = 1) -> list:
    return ["  " * by + line for line in lines]


def block(head: str, lines) -> list:
    return [f"{head} {{" if head else "{", *indent(lines), "}"]


class Scalar:
    """`show_<node>` gives (text, strength) of a value, `do_<node>` the lines of a statement, `define_<node>` a definition;
    `leaf` what a symbol of a formula stands for; `formulas` and `real`: the arithmetic, and its type; `zeros`: the type of vectors that begin as 0; `linkage` of functions."""
    formulas, real, linkage, zeros = Formulas, "smg_real", LINKAGE, "smg_real"
    model = "c->model"      # where parameters and what they decide are found

    def __call__(self, node) -> str:
        return self.show(node)[0]

    def show(self, node) -> tuple[str, int]:
        return getattr(self, "show_" + type(node).__name__.lower(), self.leaf)(node)

    def inside(self, node, strength: int) -> str:
        text, own = self.show(node)
        return text if own >= strength else f"({text})"

    def args(self, nodes) -> str:
        return ", ".join(map(self, nodes))

    # -- integers -----------------------------------------------------------------------------
    def show_whole(self, n):
        return str(n.value), ATOM if n.value >= 0 else SUM

    def show_index(self, n):
        return n.name, ATOM

    def show_field(self, n):
        return f"{n.of}.{n.name}", ATOM

    def show_pointed(self, n):
        return f"{n.of}->{n.name}", ATOM

    def show_size(self, n):
        return f"{self.model}->{n.name}", ATOM

    def show_given(self, n):
        return f"{self.model}->p.{in_c(n.name)}", ATOM

    def show_cell(self, n):
        return n.table + "".join(f"[{self(place)}]" for place in n.places), ATOM

    def show_sum(self, n):
        text = self(n.terms[0])
        for term in n.terms[1:]:
            text += f" - {self.inside(times(-1, term), PRODUCT)}" if is_negative(term) else f" + {self.inside(term, PRODUCT)}"
        return text, SUM

    def show_product(self, n):
        first, *others = n.factors
        if first == Whole(-1):
            return "-" + self.inside(times(*others), PRODUCT), SUM
        shown = self(first) if isinstance(first, Whole) else self.inside(first, ATOM)
        return "*".join([shown, *(self.inside(f, ATOM) for f in others)]), SUM if is_negative(n) else PRODUCT

    def show_divided(self, n):
        return f"{self.inside(n.above, PRODUCT)} {n.op} {self.inside(n.below, ATOM)}", PRODUCT

    def show_computed(self, n):
        return f"{n.function}({self.args(n.args)})", ATOM

    # -- real numbers -------------------------------------------------------------------------
    def show_real(self, r):
        shown = self.formulas(lambda name: self.leaf(r.leaves[name]))
        return (shown.test(r.expr), ATOM) if isinstance(r.expr, Boolean) else shown.show(r.expr)

    def leaf(self, node) -> tuple[str, int]:
        """What a symbol stands for, as a real number."""
        if isinstance(node, Int):
            return f"(smg_real){Scalar.inside(self, node, ATOM)}", ATOM
        return getattr(self, "leaf_" + type(node).__name__.lower())(node)

    def leaf_component(self, n):
        return f"{n.vector}[{n.axis}]", ATOM

    def leaf_element(self, n):
        return f"{n.array}[{n.place}]", ATOM

    def leaf_local(self, n):
        return n.name, ATOM

    def leaf_held(self, n):
        return f"{self.model if n.of_model else n.holder}->{n.name}", ATOM

    def leaf_parameter(self, n):
        return f"{self.model}->p.{in_c(n.name)}" + (f"[{self(n.place)}]" if n.place is not None else ""), ATOM

    def leaf_constant(self, n):
        return number(n.value), ATOM if n.value >= 0 else SUM

    def leaf_entry(self, n):
        return f"{n.table}[{self(n.place)}]", ATOM

    def leaf_drawn(self, n):
        where = "site" if len(n.of) == 2 else "bond"
        return f"smg_{n.kind}_number(smg_words_of_{where}({self.args(n.of)}, SMG_USE_{n.kind.upper()}))", ATOM

    def leaf_ofsite(self, n):
        return f"{n.function}(c, {self(n.place)})", ATOM

    # -- other values -------------------------------------------------------------------------
    def show_name(self, n):
        return n.text, ATOM

    def show_member(self, n):
        return f"{n.of}->{n.name}", ATOM

    def show_at(self, n):
        array = self(n.array)
        return (array, ATOM) if n.offset == Whole(0) else (f"{array} + {self(n.offset)}", SUM)

    def show_unary(self, n):
        return n.op + self.inside(n.of, ATOM), ATOM

    def show_ordered(self, n):
        own = STRENGTH[n.op]
        blank = " " if own < PRODUCT or n.op == "/" else ""
        return f"{self.inside(n.left, own)}{blank}{n.op}{blank}{self.inside(n.right, own + 1)}", own

    def show_number(self, n):
        return number(n.value) if n.value != int(n.value) else str(int(n.value)), ATOM

    def show_call(self, n):
        return f"{n.function}({self.args(n.args)})", ATOM

    def show_braces(self, n):
        return f"{{{self.args(n.args)}}}", ATOM

    def show_assign(self, s):
        return f"{self(s.target)} {s.op} {self(s.value)}", TEST

    # -- tests --------------------------------------------------------------------------------
    def show_compare(self, t):
        return f"{self(t.left)} {t.op} {self(t.right)}", TEST

    def show_either(self, t):
        return " || ".join(self.inside(test, TEST) for test in t.tests), TEST

    def show_not(self, t):
        return f"!{self.inside(t.test, ATOM)}", ATOM

    # -- statements ---------------------------------------------------------------------------
    def lines(self, statements) -> list:
        """Declarations of one kind that follow each other share lines."""
        found: list = []
        for kind, some in groupby(statements, self.shared):
            found += [line for s in some for line in self.do(s)] if kind is None else together(kind, map(self.declarator, some))
        return found

    def shared(self, s) -> str | None:
        """The kind of an integer, and of arrays that have no values or zeros; None of another statement."""
        if isinstance(s, Zeros):
            return self.zeros
        plain = isinstance(s, Let) and s.kind == "const int64_t" or isinstance(s, Variable) and s.start is None and s.kind == self.zeros
        return s.kind if plain else None

    def declarator(self, s) -> str:
        return self.of_zeros(s) if isinstance(s, Zeros) else f"{s.name} = {self(s.value)}" if isinstance(s, Let) else s.name

    def of_zeros(self, s) -> str:
        return f"{s.name}[{s.size}] = {{{', '.join('0' * s.size)}}}"

    def do(self, s) -> list:
        return getattr(self, "do_" + type(s).__name__.lower())(s)

    def do_let(self, s):
        return [f"{declared(s.kind, s.name)} = {self(s.value)};"]

    def do_value(self, s):
        kind = "int" if isinstance(s.value.expr, Boolean) and not s.value.expr.is_Symbol else self.real
        return [f"const {kind} {s.name} = {self(s.value)};"]

    def do_variable(self, s):
        return [declared(s.kind, s.name) + (f" = {self(s.start)}" if s.start is not None else "") + ";"]

    def do_assign(self, s):
        return [f"{self(s)};"]

    def do_add(self, s):
        e = s.value.expr
        if (e.is_Mul or e.is_Number) and e.could_extract_minus_sign():
            return [f"{self(s.target)} -= {self(type(s.value)(-e, s.value.leaves))};"]
        return [f"{self(s.target)} += {self(s.value)};"]

    def do_return(self, s):
        return ["return;" if s.value is None else f"return {self(s.value)};"]

    def do_call(self, s):
        return [f"{self(s)};"]

    def do_for(self, s):
        if s.step == -1:
            return block(f"for (int64_t {s.index} = {self(s.end)}; {s.index}-- > {self(s.start)};)", self.lines(s.body))
        step = f"++{s.index}" if s.step == 1 else f"{s.index} += {s.step if isinstance(s.step, int) else self(s.step)}"
        lines = self.short(f"for (int64_t {s.index} = {self(s.start)}; {s.index} < {self(s.end)}; {step})", s.body)
        return ["SMG_UNROLL_SITES", *lines] if s.few else lines

    def short(self, head: str, body) -> list:
        """A single statement that is no block stands beside its head where there is room."""
        lines = self.lines(body)
        one = f"{head} {lines[0]}" if len(body) == len(lines) == 1 else ""
        if one and isinstance(body[0], For):
            return [head, *indent(lines)]
        return [one] if one and len(one) <= LINE else block(head, lines)

    def do_if(self, s):
        head = f"if ({' && '.join(self.one_of(s.tests, test) for test in s.tests)})"
        if len(s.body) == 1 and isinstance(s.body[0], Return):
            return [f"{head} {self.do(s.body[0])[0]}"]
        return block(head, self.lines(s.body))

    def one_of(self, tests, test) -> str:
        """A test beside others, all of which must hold: `a && (b || c)`."""
        return f"({self(test)})" if isinstance(test, Either) and len(tests) > 1 else self(test)

    def do_scope(self, s):
        return block("", self.lines(s.body))

    # -- definitions --------------------------------------------------------------------------
    def define(self, d) -> str:
        return "\n".join(getattr(self, "define_" + type(d).__name__.lower())(d))

    def define_function(self, f):
        """An argument that the body does not mention is said to be unused."""
        known = self.known(f)
        unused = ", ".join(f"(void){a.name}" for a in f.arguments if a.name not in known)
        arguments = ", ".join(f"{a.kind} (*{a.name})({a.signature})" if a.signature else declared(a.kind, a.name) for a in f.arguments)
        head, lines = f"{self.linkage[f.inlined]} {declared(f.kind, f.name)}({arguments})", [f"{unused};"] * bool(unused) + self.lines(f.body)
        one = f"{head} {{ {lines[0]} }}" if len(f.body) == len(lines) == 1 and isinstance(f.body[0], Return) else ""
        return [one] if one and len(one) <= LINE + 10 else block(head, lines)

    def known(self, f) -> set:
        """Names of arguments that the body mentions."""
        return mentions(*f.body)

    def define_struct(self, d):
        return [f"typedef struct {d.name} {{", f"  {self.real} {', '.join(d.members)};", f"}} {d.name};"]

    def define_table(self, d):
        """Numbers as number() prints them, by one format for all rows."""
        one = "%r" if d.kind == "double" else "%d"
        row = "{" + ", ".join([one] * d.columns) + "}" if d.columns else one
        values = chain.from_iterable(d.values) if d.columns else d.values
        printed = ", ".join([row] * len(d.values)) % tuple(map(float, values) if d.kind == "double" else values)
        return [f"static const {d.kind} {d.name}[]{f'[{d.columns}]' if d.columns else ''} = {{{printed}}};"]


class OfModel(Scalar):
    """What prepares a model, which has no coefficients yet."""
    model = "model"

    def known(self, f):
        return {self.model if name == "c" else name for name in super().known(f)}


def together(kind: str, declarators) -> list:
    """Declarations, as many in a line as there is room for."""
    rows: list = [[]]
    for one in declarators:
        if rows[-1] and len(kind) + sum(len(x) + 2 for x in (*rows[-1], one)) > LINE:
            rows.append([])
        rows[-1].append(one)
    return [f"{kind} {', '.join(row)};" for row in rows]


def declared(kind: str, name: str) -> str:
    return f"{kind}{name}" if kind.endswith("*") else f"{kind} {name}"


def is_negative(n) -> bool:
    first = n.factors[0] if isinstance(n, Product) else n
    return isinstance(first, Whole) and first.value < 0
