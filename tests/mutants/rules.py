r"""Faults of the kinds that integrators suffer from, as patterns: they follow the code when it moves.

Each rule is (kind, files, pattern, new text): wherever the pattern matches in a line of code of such
a file, the new text (which may use groups, \1) is one mutant. A pattern that matches nowhere any
more is reported by `run.py --list` and by tests/test_mutants.py.
"""

STEP = "templates/*.j2"
C = "[tr][eu]*/*.[jh]*"         # templates/*.j2 and runtime/*.h
BAND = "runtime/smg_band.h"

# The field belongs to t0 + (count + 1/2) h; what depends on time is computed anew every step.
TIME = (
    (STEP, r"\(\(smg_real\)s->count \+ \(smg_real\)0\.5\)", r"(smg_real)s->count"),
    (STEP, r"\(\(smg_real\)s->count \+ \(smg_real\)0\.5\)", r"((smg_real)s->count + (smg_real)1)"),
    (STEP, r"\(\(smg_real\)s->count \+ \(smg_real\)0\.5\)", r"(smg_real)0.5"),
    (STEP, r"(_clock\(&s->c, )\(smg_real\)s->t0 \+ ", r"\1"),
    (STEP, r"(_clock\(&s->c, \(smg_real\)s->t0) \+ .*(\);)", r"\1\2"),
    (STEP, r"_clock\(c, t\)", r"_clock(c, 0)"),
    (STEP, r"_begin\(&k, p, t\)", r"_begin(&k, p, 0)"),
    (STEP, r"return s->t0 \+ \(double\)s->count \* s->h", r"return s->t0"),
    (STEP, r"return s->t0 \+ \(double\)s->count", r"return s->t0 + (double)(s->count - 1)"),
    (STEP, r"\+\+s->count;", r";"),
    ("gen/compile/lower/lowering.py", r"return CLOCK", r"return PREPARE"),
    ("gen/compile/lower/lowering.py", r"max\(self\.when\(a\) for a in early\)", r"min(self.when(a) for a in early)"),
    ("gen/compile/emit/interface.py", r'"k->t = t;"', r'"k->t = 0;"'),
    ("gen/compile/emit/interface.py", r"level == CLOCK\]", r"level == CLOCK][:-1]"),
)

# J_ij = delta_ij + G_i (d2H/dw_i dw_j) S_j^T, its own part from the curvature of C, and what corrects with it.
JACOBIAN = (
    ("templates/family.c.j2", r"smg_dot\(F \+ 3 \* r, turn\)", r"(0 * smg_dot(F + 3 * r, turn))"),
    ("templates/family.c.j2", r" \+ k \* smg_dot\(n, turn\)", r" + 0 * smg_dot(n, turn)"),
    ("templates/family.c.j2", r"\(smg_dot\(n, res\) \+ ", r"(0 * smg_dot(n, res) + "),
    ("templates/family.c.j2", r"G\[3 \* l \+ a\] = k \* row\[a\]", r"G[3 * l + a] = 0 * row[a]"),
    ("templates/family.c.j2", r'\{\{ "s \* " if BS == 2 \}\}', r""),
    ("templates/family.c.j2", r" \+ gamma \* m\[b\]", r""),
    ("templates/family.c.j2", r"S\[b\] \* a\[0\] \+ ", r""),
    ("runtime/smg_site.h", r" - a \* n\[q\]", r""),
    ("templates/newton.c.j2", r"_block_add\(s, row, column, block\)", r"_block_add(s, row, row, block)"),
    ("templates/newton.c.j2", r"( +)(\{\{ M \}\}_block_add\(s, row, column, block\);)", r"\1if ((row) != (column)) \2"),
    ("templates/newton.c.j2", r"( +)(\{\{ M \}\}_block_add\(s, row, column, block\);)", r"\1if ((row) <= (column)) \2"),
    ("templates/newton.c.j2", r"at\[k\] \+= block", r"at[k] = block"),
    ("templates/newton.c.j2", r"^\{\{ blocks \}\}", r""),
    ("templates/local.c.j2", r"J\[SMG_BS \* n \+ l\] \+= smg_dot\(G \+ 3 \* n, y\)", r"(void)n"),
    ("templates/local.c.j2", r"J\[SMG_BS \* n \+ l\] -= 0\.5 \* u\[n\] \* bend", r"(void)bend"),
    ("templates/solo.c.j2", r"eps \+ q \* mu", r"eps"),
    ("templates/solo.c.j2", r"smg_vec_add\(g0, smg_vec_scale\(eps, e\)\)", r"g0"),
    ("templates/solo.c.j2", r" - \(q \* q\) \* smg_vec_dot\(g0, e\)", r""),
    ("templates/solo.c.j2", r"smg_vec_add\(d, smg_vec_scale\(l, e\)\)", r"d"),
    ("templates/solo.c.j2", r"\(ga \+ gb\)", r"ga"),
    ("templates/solo.c.j2", r"\{\{ M \}\}_solo_minors\(D\)", r"0 * {{ M }}_solo_minors(D)"),
    ("templates/solo.c.j2", r" - \(0\.5 \* q \* q \* q\) \* aa", r" - 0 * aa"),
    ("gen/compile/derive/derivatives.py", r"if any\(entry != 0 for entry in block\):", r"if k == l and any(entry != 0 for entry in block):"),
    ("gen/compile/derive/derivatives.py", r"if any\(entry != 0 for entry in block\):", r"if k <= l and any(entry != 0 for entry in block):"),
    ("gen/compile/derive/derivatives.py", r"parts\.slope\(row\[a\], column\[b\]\)", r"parts.slope(row[a], column[b]) if a == b else sp.S.Zero"),
    ("gen/compile/lower/kernels.py", r"hessian\[pair\]\[a, b\] \* DIRECTION\[b\] for b in range\(3\)",
     r"hessian[pair][a, b] * DIRECTION[b] for b in range(2)"),
    ("gen/compile/emit/sums.py", r"for k, l in t\.derived\.hessian", r"for k, l in list(t.derived.hessian)[1:]"),
    ("gen/compile/emit/sums.py", r"if \(k, k\) in t\.derived\.hessian:", r"if k > 0 and (k, k) in t.derived.hessian:"),
    ("gen/compile/emit/solo.py", r"\(\(0, 1\), \(0, 2\), \(1, 2\)\)", r"((0, 1), (0, 2))"),
    ("gen/compile/emit/solo.py", r"if a == row\)", r"if a == row == b)"),
    ("gen/compile/emit/solo.py", r"X\.jacobian\(m\)", r"X.jacobian(m).multiply_elementwise(sp.eye(3))"),
)

# The solution must be the one connected to W = w at h = 0.
BRANCH = (
    (STEP, r"(?<!\w)sure \? SMG_OK : ", r"1 ? SMG_OK : "),
    (STEP, r"(\*sure = )\w+ <= .*;", r"\1 1;"),
    (STEP, r"status == SMG_OK && sure\)", r"status == SMG_OK)"),
    (STEP, r"if \(wild \|\| !\(bound <= SMG_CLEAR\)\) return 0;", r""),
    (STEP, r"if \(bound <= SMG_CONTRACTS\) return 1;", r"if (bound <= 100 * SMG_CONTRACTS) return 1;"),
    (STEP, r"return smg_(dense|band|sparse)_coercive\(.*\);", r"return 1;"),
    (STEP, r"\*sure = most <= SMG_CONTRACTS", r"*sure = most <= 4"),
    (STEP, r"if \(!\{\{ M \}\}_solo_sure\(det\)( \|\| .*)?\) return SMG_WRONG_BRANCH;", r""),
    (STEP, r"\{\{ M \}\}_solo_sure\(det\) && ", r""),
    (STEP, r"return smg_abs\(det - .*;", r"return det > 0;"),
    (STEP, r"solved && row < 1", r"solved"),
    (STEP, r"solved && ", r""),
    (STEP, r"mean <= SMG_CONTRACTS \|\| smg_krylov_coercive\(&a, mean\)", r"1"),
    (STEP, r"if \(status == SMG_WRONG_BRANCH\) break;", r"if (status == SMG_WRONG_BRANCH) return SMG_OK;"),
    (STEP, r"status = followed;", r"status = SMG_OK;"),
    ("runtime/smg_block.h", r"&& \*pivots == 1\) \*pivots = 2;", r"&& *pivots == 1) *pivots = 1;"),
    ("runtime/smg_block.h", r"\) \*pivots = -\*pivots;", r") *pivots = *pivots;"),
    ("runtime/smg_small.h", r" & !negative_pair", r""),
    ("runtime/smg_small.h", r"\(smg_det2\(D\) > 0\) & ", r""),
    ("runtime/smg_small.h", r"if \(!\(c > 0\)\) return 0;", r""),
    ("runtime/smg_small.h", r"return s <= 0 \|\| .*;", r"return 1;"),
    ("runtime/smg_dense.h", r"if \(i == j && !\(sum > 0\)\) return 0;", r"if (i == j && !(sum > 0)) return 1;"),
    ("runtime/smg_*.h", r"return (smg_\w+_solve\(.*\)) == 0 && positive == 1;", r"return \1 == 0;"),
    ("runtime/smg_follow.h", r"return SMG_(NO_SOLUTION|WRONG_BRANCH);", r"return SMG_OK;"),
    ("runtime/smg_follow.h", r"return central \|\| far > .* \? SMG_NO_CONVERGENCE : SMG_OK;", r"return SMG_OK;"),
    ("runtime/smg_follow.h", r" \|\| \(f->sign != 0 && \(f->sign < 0\) != \(f->q < 0\)\)", r""),
    ("runtime/smg_spin.h", r"if \(k >= 1 && d >= 0 && d <= 0\) return 0;", r""),
)

TOLERANCE = (
    (C, r"(?<!\(sqrt\)\()(?<!NEGLIGIBLE \()(?<!EPS \* )\bSMG_EPS\b", r"(1000000 * SMG_EPS)"),
    (C, r"found\.residual <= SMG_SETTLED", r"1 || found.residual <= SMG_SETTLED"),
    (C, r"(?<=define SMG_NEGLIGIBLE ).*", r"1e-3"),
    (C, r"\bSMG_ROUNDOFF\b(?= \*)", r"(100000000 * SMG_ROUNDOFF)"),
    (C, r"\b1e-(12|9|5)\b(?! *\*/)", r"1e-3"),
    (C, r"(?<=size < )0\.01\b", r"1e9"),
    (STEP, r"(?<=define SMG_CONTRACTS )\(smg_real\)0\.75", r"(smg_real)50"),
    (C, r"\bit > 6\b", r"it > 0"),
)

# A lattice, a ring or a remainder that closes at the wrong place.
WRAP = (
    ("runtime/smg_site.h", r"x < 0 \? x \+ n :", r"x < 0 ? 0 :"),
    ("runtime/smg_site.h", r"x < 0 \? x \+ n :", r"x < 0 ? x + n - 1 :"),
    ("runtime/smg_site.h", r": x >= n \? x - n :", r": x >= n ? n - 1 :"),
    ("runtime/smg_site.h", r": x >= n \? x - n :", r": x > n ? x - n :"),
    ("runtime/smg_site.h", r"\? r \+ b : r;", r"? r + b - 1 : r;"),
    ("runtime/smg_site.h", r"\(r < 0\) != \(b < 0\) \? r \+ b : r", r"(r < 0) != (b < 0) ? r : r"),
    ("runtime/smg_site.h", r"\(a - smg_mod\(a, b\)\) / b", r"a / b"),
    ("templates/newton.c.j2", r"d -= \{\{ order \}\};", r"d -= {{ order }} - 1;"),
    ("templates/newton.c.j2", r"d \+= \{\{ order \}\};", r"d += {{ order }} - 1;"),
    ("gen/compile/lower/loops.py", r"'\+' if shift > 0 else '-'", r"'-' if shift > 0 else '+'"),
    ("gen/compile/lower/loops.py", r"'-' if shift > 0 else '\+'", r"'+' if shift > 0 else '-'"),
    ("gen/compile/lower/loops.py", r"size = self\.low\.size\(over\.size\[d\]\)", r"size = self.low.size(over.size[0])"),
    ("gen/compile/lower/loops.py", r"\{self\.low\.size\(over\.size\[d\]\)\}\*", r"{self.low.size(over.size[-1])}*"),
    ("gen/compile/lower/loops.py", r"abs\(shift\)", r"1"),
    ("gen/compile/lower/loops.py", r"smg_wrap\(\{moved\}, \{size\}\)", r"smg_wrap({moved}, {size} - 1)"),
    ("gen/compile/lower/loops.py", r"r\{d\} % \{size\}", r"r{d} % ({size} - 1)"),
    ("gen/compile/lower/loops.py", r"site % \{over\.sites\}", r"(site + 1) % {over.sites}"),
    ("gen/compile/lower/loops.py", r"\}\*\(colour - \(", r"}*(colour + ("),
    ("gen/compile/lower/loops.py", r'start=f"\{i\} \+ 1"', r'start=f"{i}"'),
    ("gen/compile/lower/loops.py", r'start="site \+ 1"', r'start="site"'),
    ("gen/compile/lower/lowering.py", r"smg_mod\(\{args\[0\]\}, \{args\[1\]\}\)", r"({args[0]} % {args[1]})"),
    (BAND, r"q->E\[e \* \(SMG_BS \+ 1\)\] = -1", r"q->E[e * (SMG_BS + 1)] = 1"),
    (BAND, r"border \+ 2 \* SMG_BB", r"border"),
    (BAND, r"smg_block_add\(q->E, q->U\);", r""),
    (BAND, r"smg_block_add\(q->F, border\);", r"(void)border;"),
    (BAND, r"if \(d > k\) d -= n;", r""),
    (BAND, r"if \(d < -k\) d \+= n;", r""),
    (BAND, r"c < 0 \? c \+ n - m : c - m", r"c < 0 ? c + k : c - m"),
    (BAND, r"c < 0 \? c \+ n - m : c - m", r"c < 0 ? c + n - m : 0"),
    (BAND, r"t - s \+ k\) \* SMG_BB", r"s - t + k) * SMG_BB"),
    (BAND, r"next = i \+ 1 \+ k", r"next = i + k"),
    (BAND, r"next >= n - 2 \* k && next < n - k", r"next >= n - k && next < n - k"),
)

KINDS = {"time": TIME, "jacobian": JACOBIAN, "branch": BRANCH, "tolerance": TOLERANCE, "wrap": WRAP}
RULES = tuple((kind, *rule) for kind, rules in KINDS.items() for rule in rules)
