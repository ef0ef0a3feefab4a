r"""Faults of the kinds that integrators suffer from, as patterns: they follow the code when it moves.

Each rule is (kind, files, pattern, new text): wherever the pattern matches in a line of code of such
a file, the new text (which may use groups, \1) is one mutant. A pattern that matches nowhere any
more is reported by `run.py --list` and by tests/mutants/test_mutants.py.
"""

STEP = "*.[jh]*"      # the headers of runtime/ and the templates
C = STEP
MIDPOINT, SPHERE = "runtime/newton/smg_midpoint.h", "runtime/method/midpoint/smg_sphere_template.h"
NEWTON, ALONE = "runtime/newton/smg_newton.h", "runtime/newton/smg_alone.h"
BAND, NOISE = "runtime/newton/smg_band.h", "runtime/newton/smg_noise.h"

# The field belongs to t0 + (count + 1/2) h; what depends on time is computed anew every step.
TIME = (
    (STEP, r"time_at\((&s->c, )?s, \(smg_real\)0\.5\)", r"time_at(\1s, 0)"),
    (STEP, r"time_at\((&s->c, )?s, \(smg_real\)0\.5\)", r"time_at(\1s, 1)"),
    (STEP, r"\(\(smg_real\)s->count \+ part\)", r"part"),
    (STEP, r"return \(smg_real\)s->t0 \+ ", r"return "),
    (STEP, r"return \(smg_real\)s->t0 \+ .*;", r"return (smg_real)s->t0;"),
    (STEP, r"smg_set_time\(c, t\)", r"smg_set_time(c, 0)"),
    (STEP, r"smg_begin\(&(k|c), model, t\)", r"smg_begin(&\1, model, 0)"),
    (STEP, r"return s->t0 \+ \(double\)s->count \* s->h", r"return s->t0"),
    (STEP, r"return s->t0 \+ \(double\)s->count", r"return s->t0 + (double)(s->count - 1)"),
    (STEP, r"\+\+s->count;", r";"),
    ("gen/compile/lower/lowering.py", r"return CLOCK", r"return PREPARE"),
    ("gen/compile/lower/lowering.py", r"max\(self\.when\(a\) for a in early\)", r"min(self.when(a) for a in early)"),
    ("gen/compile/assemble/parameters.py", r"Assign\(Member\(\"c\", name\), Name\(name\)\)", r'Assign(Member("c", name), ZERO)'),
    ("gen/compile/assemble/parameters.py", r"\*stored\(model, level\)", r"*stored(model, level)[:-1]"),
)

# J_ij = delta_ij + G_i (d2H/dw_i dw_j) S_j^T, its own part from the curvature of C, and what corrects with it.
JACOBIAN = (
    (MIDPOINT, r"smg_dot\(F \+ 3 \* r, turned\)", r"(0 * smg_dot(F + 3 * r, turned))"),
    (MIDPOINT, r" \+ rate \* smg_dot\(n, turned\)", r" + 0 * smg_dot(n, turned)"),
    (MIDPOINT, r"\(smg_dot\(n, res\) \+ ", r"(0 * smg_dot(n, res) + "),
    (MIDPOINT, r"l, rate, row, 3\)", r"l, 0, row, 3)"),
    (MIDPOINT, r"rate \* s \* smg_dot", r"rate * smg_dot"),
    (MIDPOINT, r"l, s, E \+ 3 \* l, 3\)", r"l, 1, E + 3 * l, 3)"),
    (MIDPOINT, r" \+ gamma \* along\[b\]", r""),
    (MIDPOINT, r"S\[b\] \* a\[0\] \+ ", r""),
    ("runtime/core/smg_site.h", r"-\(smg_dot\(E \+ 3 \* r, m\) / smg_dot\(n, m\)\)", r"0"),
    (NEWTON, r"smg_add_block\(s, smg_row\(&s->c, i\), smg_row\(&s->c, j\), block\)", r"smg_add_block(s, smg_row(&s->c, i), smg_row(&s->c, i), block)"),
    (NEWTON, r"( +)(smg_add_block\(s, smg_row)", r"\1if (i != j) \2"),
    (NEWTON, r"( +)(smg_add_block\(s, smg_row)", r"\1if (i <= j) \2"),
    ("runtime/newton/smg_matrix_*.h", r"smg_block_add\((.*), block\)", r"smg_block_copy(\1, block)"),
    (NEWTON, r"smg_hessian_blocks\(s\);", r""),
    (ALONE, r"e->J\[SMG_BS \* n \+ l\] \+= smg_dot\(G \+ 3 \* n, y\)", r"(void)n"),
    (ALONE, r"e->J\[SMG_BS \* n \+ l\] -= 0\.5 \* u\[n\] \* slope", r"(void)slope"),
    (SPHERE, r"eps \+ q \* mu", r"eps"),
    (SPHERE, r"smg_vec_add\(g0, smg_vec_scale\(eps, e\)\)", r"g0"),
    (SPHERE, r" - \(q \* q\) \* smg_vec_dot\(g0, e\)", r""),
    (SPHERE, r"smg_vec_add\(d, smg_vec_scale\(l, e\)\)", r"d"),
    (SPHERE, r"\(kept \* ga \+ gb\)", r"(kept * ga)"),
    (SPHERE, r"smg_slope_minors\(D\)", r"0 * smg_slope_minors(D)"),
    (SPHERE, r" - \(0\.5 \* q \* q \* q\) \* aa", r" - 0 * aa"),
    ("gen/compile/derive/derivatives.py", r"if any\(entry != 0 for entry in block\):", r"if k == l and any(entry != 0 for entry in block):"),
    ("gen/compile/derive/derivatives.py", r"if any\(entry != 0 for entry in block\):", r"if k <= l and any(entry != 0 for entry in block):"),
    ("gen/compile/derive/derivatives.py", r"parts\.slope\(row\[a\], column\[b\]\)", r"parts.slope(row[a], column[b]) if a == b else sp.S.Zero"),
    ("gen/compile/lower/kernels.py", r"hessian\[pair\]\[a, b\] \* DIRECTION\[b\] for b in range\(3\)",
     r"hessian[pair][a, b] * DIRECTION[b] for b in range(2)"),
    ("gen/compile/assemble/sums.py", r"for k, l in t\.derived\.hessian", r"for k, l in list(t.derived.hessian)[1:]"),
    ("gen/compile/assemble/sums.py", r"if \(k, k\) in t\.derived\.hessian else", r"if k > 0 and (k, k) in t.derived.hessian else"),
    ("gen/compile/assemble/solo.py", r"\(\(0, 1\), \(0, 2\), \(1, 2\)\)", r"((0, 1), (0, 2))"),
    ("gen/compile/assemble/solo.py", r"if a == row\]", r"if a == row == b]"),
    ("gen/compile/assemble/solo.py", r"X\.jacobian\(m\)", r"X.jacobian(m).multiply_elementwise(sp.eye(3))"),
)

# The solution must be the one connected to W = w at h = 0.
BRANCH = (
    (STEP, r"(?<!\w)certified \? SMG_OK : ", r"1 ? SMG_OK : "),
    (STEP, r"(\*sure = )smg_contracts\(.*\);", r"\1 1;"),
    (STEP, r"status == SMG_OK && sure\)", r"status == SMG_OK)"),
    (STEP, r"if \(residual_grew \|\| !\(bound <= SMG_CLEAR\)\) return 0;", r""),
    (STEP, r"if \(smg_contracts\(bound\)\) return 1;", r"if (smg_contracts(bound / 100)) return 1;"),
    (STEP, r"return smg_(dense|band|sparse)_coercive\(.*\);", r"return 1;"),
    (STEP, r"\*sure = smg_contracts\(most\)", r"*sure = most <= 4"),
    (STEP, r"if \(!smg_clear_of_branches\(n\.det\)( \|\| .*)?\) return SMG_WRONG_BRANCH;", r""),
    (STEP, r" SMG_AND smg_clear_of_branches\(n\.det\)", r""),
    (STEP, r"return smg_less\(smg_of\(\(smg_real\)0\.4375\), det\) .*;", r"return smg_less(smg_of(0), det);"),
    (STEP, r"solved && row < 1", r"solved"),
    (STEP, r"solved && ", r""),
    (STEP, r"smg_contracts\(mean\) \|\| \(SMG_PRODUCTS_LEFT\(s\) > 0 && smg_krylov_coercive\(&a, mean\)\)", r"1"),
    (STEP, r"if \(status == SMG_WRONG_BRANCH\) break;", r"if (status == SMG_WRONG_BRANCH) return SMG_OK;"),
    (STEP, r"status == SMG_WRONG_BRANCH \? followed : status;", r"status == SMG_WRONG_BRANCH ? SMG_OK : status;"),
    ("runtime/core/smg_block.h", r"&& \*pivots == 1\) \*pivots = 2;", r"&& *pivots == 1) *pivots = 1;"),
    ("runtime/core/smg_block.h", r"\) \*pivots = -\*pivots;", r") *pivots = *pivots;"),
    ("runtime/core/smg_small.h", r" & !negative_pair", r""),
    ("runtime/core/smg_small.h", r"\(smg_det2\(D\) > 0\) & ", r""),
    ("runtime/core/smg_small.h", r"if \(!\(c > 0\)\) return 0;", r""),
    ("runtime/core/smg_small.h", r"return s <= 0 \|\| .*;", r"return 1;"),
    ("runtime/newton/smg_dense.h", r"if \(i == j && !\(sum > 0\)\) return 0;", r"if (i == j && !(sum > 0)) return 1;"),
    ("runtime/newton/smg_*.h", r"return (smg_\w+_solve\(.*\)) == 0 && positive == 1;", r"return \1 == 0;"),
    ("runtime/newton/smg_follow.h", r"return SMG_(NO_SOLUTION|WRONG_BRANCH);", r"return SMG_OK;"),
    ("runtime/newton/smg_follow.h", r"return central \|\| far > .* \? SMG_NO_CONVERGENCE : SMG_OK;", r"return SMG_OK;"),
    ("runtime/newton/smg_follow.h", r" \|\| \(f->sign != 0 && \(f->sign < 0\) != \(f->q < 0\)\)", r""),
    ("runtime/core/smg_spin.h", r"if \(k >= 1 && d >= 0 && d <= 0\) return 0;", r""),
)

TOLERANCE = (
    (C, r"(?<!\(sqrt\)\()(?<!NEGLIGIBLE \()(?<!EPS \* )\bSMG_EPS\b", r"(1000000 * SMG_EPS)"),
    (C, r"smg_swept_to_round_off\(end\.residual", r"1 || smg_swept_to_round_off(end.residual"),
    (C, r"(?<=define SMG_NEGLIGIBLE ).*", r"1e-3"),
    (C, r"\bSMG_ROUNDOFF\b(?= \*)", r"(100000000 * SMG_ROUNDOFF)"),
    (C, r"\b1e-(12|9|5)\b(?! *\*/)", r"1e-3"),
    (C, r"(?<=SMG_SECOND \(smg_real\))0\.01\b", r"1e9"),
    (STEP, r"(?<=define SMG_CONTRACTS )\(smg_real\)0\.75", r"(smg_real)50"),
    (C, r"\bit > 6\b", r"it > 0"),
    (NOISE, r"even <= 0\.5 \* odd \? odd / SMG_PROBE : 0", r"odd > 0 ? (smg_real)1e-9 : 0"),
    (NOISE, r"even <= 0\.5 \* odd \? odd / SMG_PROBE : 0", r"even < 0 ? odd : 0"),
    (ALONE, r"> SMG_NEARLY \* s->scale\) return SMG_NO_CONVERGENCE", r"> SMG_MAX) return SMG_NO_CONVERGENCE"),
)

# A lattice, a ring or a remainder that closes at the wrong place.
WRAP = (
    ("runtime/core/smg_site.h", r"x < 0 \? x \+ n :", r"x < 0 ? 0 :"),
    ("runtime/core/smg_site.h", r"x < 0 \? x \+ n :", r"x < 0 ? x + n - 1 :"),
    ("runtime/core/smg_site.h", r": x >= n \? x - n :", r": x >= n ? n - 1 :"),
    ("runtime/core/smg_site.h", r": x >= n \? x - n :", r": x > n ? x - n :"),
    ("runtime/core/smg_site.h", r"\? r \+ b : r;", r"? r + b - 1 : r;"),
    ("runtime/core/smg_site.h", r"\(r < 0\) != \(b < 0\) \? r \+ b : r", r"(r < 0) != (b < 0) ? r : r"),
    ("runtime/core/smg_site.h", r"\(a - smg_mod\(a, b\)\) / b", r"a / b"),
    ("runtime/newton/smg_matrix_band.h", r"d -= smg_coupled\(&s->c\);", r"d -= smg_coupled(&s->c) - 1;"),
    ("runtime/newton/smg_matrix_band.h", r"d \+= smg_coupled\(&s->c\);", r"d += smg_coupled(&s->c) - 1;"),
    ("gen/compile/lower/loops.py", r"cell \+ shift\b(?! )", r"cell"),
    ("gen/compile/lower/loops.py", r'"<", size\) if shift > 0', r'"<", size) if shift < 0'),
    ("gen/compile/lower/loops.py", r"-shift, tests", r"shift, tests"),
    ("gen/compile/lower/loops.py", r"self\.low\.size\(over\.size\[d\]\), cell", r"self.low.size(over.size[0]), cell"),
    ("gen/compile/lower/loops.py", r"self\.low\.size\(over\.size\[d\]\) \*", r"self.low.size(over.size[-1]) *"),
    ("gen/compile/lower/loops.py", r"size = self\.low\.size\(over\.size\[d\]\)$", r"size = self.low.size(over.size[0])"),
    ("gen/compile/lower/loops.py", r"wrapped\(place, size\)", r"wrapped(place, size - 1)"),
    ("gen/compile/lower/loops.py", r'remainder\(Index\(f"r\{d\}"\), size\)', r'remainder(Index(f"r{d}"), size - 1)'),
    ("gen/compile/lower/loops.py", r"remainder\(SITE, over\.sites\)", r"remainder(SITE + 1, over.sites)"),
    ("gen/compile/lower/loops.py", r'Index\("colour"\) - others', r'Index("colour") + others'),
    ("gen/compile/lower/loops.py", r"Index\(i\) \+ 1", r"Index(i)"),
    ("gen/compile/lower/loops.py", r"SITE \+ 1, n", r"SITE, n"),
    ("gen/compile/lower/integers.py", r'Computed\("smg_mod"', r'Divided("%", whole(a), whole(n)) or Computed("smg_mod"'),
    ("gen/compile/lower/integers.py", r"found\.get\(term, 0\) \+ factor", r"factor"),
    ("gen/compile/lower/integers.py", r"times\(-1, other\)", r"other"),
    (BAND, r"if \(d < -k\) d \+= n;", r""),
    (BAND, r"c < 0 \? c \+ k : c - m", r"c < 0 ? c + k : 0"),
    (BAND, r"t - s \+ k\) \* SMG_BB", r"s - t + k) * SMG_BB"),
    (BAND, r"next = i \+ 1 \+ k", r"next = i + k"),
    (BAND, r"next >= n - 2 \* k && next < n - k", r"next >= n - k && next < n - k"),
)

# Lattices by rows in lanes: which sites stand beside a row, where its ends are, what of it is kept, and when steps may go so.
ROWS, ROW_STATE, ROW_SLOTS, ROW_PIECE, ROW_TEAM, ROW_SWEEP, ROW_STEP, ROW_END, ROW_WAVE, ROW_BLOCKS = (
    f"runtime/lattice/smg_{name}.h" for name in ("rows", "row_state", "row_slots", "row_piece", "row_team", "row_sweep", "row_step", "row_end", "row_wave", "row_blocks"))
BY_ROWS = "gen/compile/assemble/rows.py"
IN_ROWS = (
    (ROWS, r"s < n - reach \? reach :", r"s < n ? reach :"),
    (ROWS, r"if \(before > 0\) b\.from = .*;", r""),
    (ROWS, r"if \(inside < at->sites\) b\.to = .*;", r""),
    (ROWS, r"o->cell\[0\] < 0 \? x \+ n : x - n", r"o->cell[0] < 0 ? x + n : x"),
    (ROWS, r"if \(ring\) \*s = smg_wrap\(\*s, n\);", r""),
    (ROWS, r"at->first - SMG_TURN_0 \* SMG_WEIGHT_1", r"at->first"),
    (ROWS, r"smg_rank\(sub\) \* smg_cells\(c, 3\)", r"0 * smg_cells(c, 3)"),
    (ROWS, r"smg_lane_choose\(v, within, v, far, 3\);", r";"),
    (ROWS, r"\(at < \(smg_real\)b->to\)", r"(at <= (smg_real)b->to)"),
    (ROWS, r"end = smg_cells\(c, 1\) - SMG_REACH_1", r"end = smg_cells(c, 1)"),
    (ROWS, r"SMG_REACH_1 \+ s1 % SMG_ROW_STEP", "SMG_REACH_1"),
    (ROWS, r"run->sites == run->length", r"1"),
    (ROW_STATE, r"s->rows = s->row_bound <= SMG_ROW_BOUND", r"s->rows = 1"),
    (ROW_SLOTS, r"smg_numbered_site\(c, cell, at\.sub\)", r"smg_numbered_site(c, cell, 0)"),
    (ROWS, r"sub / SMG_HOME_PLACES \* \(smg_sites\(c\) / SMG_PLACES\) \+ cell", r"cell"),
    ("runtime/lattice/smg_row_field.h", r"k \+= SMG_SITE_VALUES \? 1 : smg_sites\(c\) / SMG_FAMILIES", r"k += smg_sites(c)"),
    (ROW_STATE, r"past \+ j \* n3", r"past"),
    (ROW_STATE, r"if \(s->history > SMG_ROW_HISTORY\) s->history = SMG_ROW_HISTORY;", r""),
    (ROW_PIECE, r"piece->at\.start \+ piece->from", r"piece->at.start"),
    (ROW_PIECE, r"piece->from = part\.from - first - row \* length", r"piece->from = 0"),
    (ROW_TEAM, r"smg_meet_at_seam\(c\) \? 1 : ", r""),
    (ROW_SWEEP, r"smg_lane_choose\(v, smg_lane_below\(in\), v, m, 3\);", r";"),
    (ROW_SWEEP, r"sweep->ended = pass\.last \? pass\.colour : -1", r"sweep->ended = pass.colour"),
    (ROW_SWEEP, r"s->row_weak \? SMG_COLOURS : 1", r"1"),
    (ROW_SWEEP, r" && smg_rest_settled\(&sweep->part, SMG_EPS\)", r""),
    ("runtime/lattice/smg_row_arrays.h", r"1 / \(smg_radius\(c, 0\) \* smg_radius\(c, 0\)\)", r"1 / smg_radius(c, 0)"),
    (ROW_END, r"smg_lane_of\(2 \* turn\.half\)", r"smg_lane_of(turn.half)"),
    (ROW_STEP, r"sweep->passes < SMG_ROW_PASSES \? SMG_OK : SMG_NO_CONVERGENCE", r"SMG_OK"),
    (ROW_STEP, r"near < last \? near : last", r"last"),
    (ROW_WAVE, r"s->row_reach \+ block - 1", r"s->row_reach - 1"),
    (ROW_WAVE, r"smg_predict_rows\(s\);", r""),
    (ROW_WAVE, r"at % wave->blocks", r"(at < wave->blocks ? at : wave->blocks - 1)"),
    (ROW_BLOCKS, r"x -= part \* b->shear\[d\]", r"x -= 0"),
    (ROW_BLOCKS, r"along\[lane\] \+= part \* b->shear\[d\]", r"along[lane] += 0"),
    (ROW_BLOCKS, r"\(l / unit \+ t / unit\)", r"(l / unit)"),
    (ROW_BLOCKS, r"smg_rank\(sub\)", r"0"),
    (ROW_BLOCKS, r"v\.cell\[d\] \+ beside\[k\]\.cell\[d\]", r"v.cell[d] - beside[k].cell[d]"),
    (ROW_BLOCKS, r"smg_slots\(c\) == smg_sites\(c\) && ", r""),
    (ROW_PIECE, r"smg_place\(piece->at\.colour, .*\);", r"smg_place(piece->at.colour, 0);"),
    (BY_ROWS, r"return closed and ", r"return "),
    (BY_ROWS, r"\(b - a for a, b in zip", r"(a - b for a, b in zip"),
    (BY_ROWS, r"any\(o and not one\.ring >> d & 1", r"any(o and one.ring >> d & 1"),
    (BY_ROWS, r"differs\(t\) or two_ended\(t\)", r"True"),
)

# Few sites and ensembles in lanes: what belongs to which lane, which terms a site feels, and what is left to Newton or to the state alone.
FEW, FEW_STEP, LANE_SPHERE = "runtime/lattice/smg_few.h", "runtime/lattice/smg_few_step.h", "runtime/members/smg_lane_sphere.h"
LANE_STEPS, CONTROL = "runtime/members/smg_lane_dop853.h", "runtime/method/explicit/smg_dop853_template.h"
LANE_ROWS, LANE_BATCH = "runtime/members/smg_lane_extrapolation.h", "runtime/members/smg_lane_batch.h"
IN_LANES = (
    (FEW, r"smg_lane_select\(own, smg_lane_of\(0\), more\[k\]\)", r"more[k]"),
    (FEW, r"i \+ l < sites \? i \+ l : sites - 1", r"0"),
    (FEW_STEP, r"\(smg_real\)0\.5 \* smg_h_over_kappa", r"smg_h_over_kappa"),
    (FEW_STEP, r"rate = 2 \* smg_lane_take", r"rate = smg_lane_take"),
    (FEW_STEP, r"smg_lane_take\(a \+ SMG_FEW_RADIUS \* pitch \+ i\) / square \* smg_lane_sqrt", r"1 / square * smg_lane_sqrt"),
    (FEW_STEP, r"smg_lane_cross\(u, m, smg_lane_respond\(told, m, g, room\)\)", r"smg_lane_cross(u, smg_lane_respond(told, m, g, room), m)"),
    (FEW_STEP, r"s->few\[\(SMG_FEW_U \+ q\) \* pitch \+ k\]", r"s->few[SMG_FEW_U * pitch + k]"),
    ("gen/compile/assemble/few.py", r'For\("j", i \+ Index\("SMG_LANES"\), n', r'For("j", i, n'),
    (LANE_BATCH, r"smg_lane_insert\(g->compensation, l, s->compensation, 3\);", r""),
    (LANE_SPHERE, r"s->rows \+ 4 \* s->row, newest", r"s->rows, newest"),
    (LANE_BATCH, r"s->count = g->began\[l\] \+ g->taken", r"s->count = g->taken"),
    (CONTROL, r"= smg_select\(good, pace->end, pace->done\)", r"= pace->end"),
    (CONTROL, r"smg_add_where\(good, y", r"smg_add_where(smg_all(1), y"),
    (LANE_STEPS, r"f->natural_before = smg_lane_select\(finished, pace->natural, f->natural_before\);", r""),
    (LANE_STEPS, r"smg_lane_set\(&f->natural_before, l, \*smg_natural\(s\)\);", r"smg_lane_set(&f->natural_before, l, 0);"),
    (LANE_ROWS, r"\(j - 1\) \* \(j - 1\) \+ m : 0", r"(j - 1) * (j - 1) + 1 : 0"),
    (LANE_BATCH, r"g->live\[l\] = 0;", r""),
    (LANE_BATCH, r"k < \(alike \? 1 : b\.groups\)", r"k < 1"),
    (CONTROL, r"smg_select\(pace->refused, smg_of\(1\), smg_of\(SMG_GROWTH\)\)", r"smg_of(SMG_GROWTH)"),
)

# Comparators, splittings and compositions: the order of their parts, the part of h that each has, the length that they keep; and the outputs.
AXES, CF4, ANGLES, HEUN, TURNED = (f"runtime/method/explicit/{name}.h" for name in ("smg_axis_splitting", "smg_cf4", "smg_angles", "smg_heun", "smg_depondt_mertens"))
IN_METHODS = (
    (AXES, r"smg_turn_h\(n, 3, h\)", r"0.5 * h"),
    (AXES, r"smg_turn_h\(n, 3, half\)", r"0.5 * half"),
    (AXES, r"tau \* v\[d\] - square", r"tau * v[d] + square"),
    ("runtime/method/tables/smg_tableau.h", r"return \(smg_real\)m / \(smg_real\)\(2 \* j\)", r"return (smg_real)(m - 1) / (smg_real)(2 * j)"),
    ("runtime/method/tables/smg_tableau.h", r"-66, 84480", r"66, 84480"),
    (CF4, r"third\[4\] = \{-0\.5, 0, 1, 0\}", r"third[4] = {0, 0, 1, 0}"),
    (CF4, r"\{first\[3\], first\[1\], first\[2\], first\[0\]\}", r"{first[0], first[1], first[2], first[3]}"),
    (CF4, r"smg_take_turns\(s, 4, h, 1\)", r"smg_take_turns(s, 4, h, (smg_real)0.5)"),
    (ANGLES, r"sqrt\)\(2 \* smg_diffusion", r"sqrt)(smg_diffusion"), (HEUN, r"\(x\[b\] \+ y\[b\]\)", r"(2 * x[b])"), (TURNED, r"mean\[2\] = \{0\.5, 0\.5\}", r"mean[2] = {1, 0}"),
    ("runtime/method/explicit/smg_pair_rotations.h", r"smg_each_pair_back\(", r"smg_each_pair("),
    ("runtime/core/smg_turn_template.h", r"one \* v\[b\] \+ other \* w\[b\]", r"v[b] + w[b]"),
    ("runtime/method/explicit/smg_pair_rotations.h", r"smg_turn_h\(k, n, h\)", r"0.5 * h"),
    ("runtime/method/explicit/smg_pair_rows.h", r"if \(around\) smg_put_some_spins\(.*\);", r";"),
    ("runtime/method/explicit/smg_pair_rows.h", r"behind \+ \(away > 0 \? away : 0\)", r"behind"),
    ("runtime/method/explicit/smg_pair_state.h", r"!smg_meet_at_seam\(&s->c\) && ", r""),
    ("runtime/method/explicit/smg_sublattice_rotations.h", r"smg_turn_h\(k, n, h\)", r"0.5 * h"),
    ("runtime/core/smg_triple_template.h", r"\*compensation = y - \(sum - \*w\)", r"*compensation = 0 * y"),
    ("runtime/method/explicit/smg_sublattice_rows.h", r"smg_real\)0\.5 \* smg_h_over_kappa\(&s->c, 0, h\)", r"smg_real)0.5 * h"),
    ("runtime/method/explicit/smg_sublattice_state.h", r"!smg_meet_at_seam\(&s->c\) && ", r""),
    ("runtime/method/midpoint/smg_geodesic_midpoint.h", r"smg_sinc\(smg_norm\(a\) / r\)", r"smg_sinc(smg_norm(a))"),
    ("runtime/core/smg_fixed_point.h", r"smg_begin_stages\(s, with, 0\);", r";"),
    ("runtime/method/midpoint/smg_rattle.h", r"- s / 2 \* q\[1 \+ b\]", r"+ s / 2 * q[1 + b]"),
    ("runtime/method/midpoint/smg_rattle.h", r"smg_dot\(g, g\) - smg_dot\(f, f\)", r"0 * (smg_dot(g, g) - smg_dot(f, f))"),
    ("runtime/method/midpoint/smg_rattle.h", r" / \(r > 0 \? r : 1\)", r""),
    ("runtime/method/midpoint/smg_exponential_midpoint.h", r" \+ 4 \* c \* xx\[b\]", r""),
    ("runtime/method/midpoint/smg_exponential_midpoint.h", r"< SMG_HALF_TURN", r"< SMG_MAX"),
    ("runtime/core/smg_turn_template.h", r"\(1 - inverse \* smg_dot\(w, w\)\)", r"(inverse * smg_dot(w, w) - 1)"),
    ("runtime/method/explicit/smg_explicit_step.h", r"done \+ \(smg_real\)0\.5 \* smg_gamma\[i\]", r"done"),
    ("runtime/method/explicit/smg_turn_steps.h", r"done \+ \(smg_real\)0\.5 \* smg_gamma\[i\]", r"done"),
    ("runtime/method/midpoint/smg_composition.h", r"s->prepared\[1\] == \(smg_real\)s->h", r"1"),
    ("runtime/method/midpoint/smg_composition.h", r"smg_copy\(s->compensation, s->before \+ n3, n3\);", r";"),
    ("runtime/method/midpoint/smg_composition.h", r"\*s = \*b;", r";"),
    ("runtime/method/midpoint/smg_composed_tangent.h", r"smg_copy\(s->w, end, n3\);", r";"),
    ("runtime/core/smg_outputs.h", r"\*done > 0 \? every : first", r"every"),
    ("runtime/core/smg_outputs.h", r"count - 1, &done", r"count, &done"),
    ("runtime/core/smg_outputs.h", r"rho < \*o->nearest", r"rho > *o->nearest"),
    ("runtime/core/smg_fixed_point.h", r"if \(!smg_sweeps_contract\(&watch\)\) break;", r""),
    ("runtime/method/gauss/smg_gauss_stages.h", r"smg_kind\(&s->c, k\) == SMG_SPHERE \? smg_radius\(&s->c, k\) : smg_norm", r"smg_norm"),
    ("runtime/method/gauss/smg_gauss_slots.h", r"\(r \+ smg_lane_abs", r"(0 * r + smg_lane_sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) + smg_lane_abs"),
)

KINDS = {"time": TIME, "jacobian": JACOBIAN, "branch": BRANCH, "tolerance": TOLERANCE, "wrap": WRAP, "rows": IN_ROWS, "method": (*IN_METHODS, *IN_LANES)}
RULES = tuple((kind, *rule) for kind, rules in KINDS.items() for rule in rules)
