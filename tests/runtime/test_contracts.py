"""One name, one meaning: headers define the same name only where each is another way to do what one contract asks for."""
import re

import pytest
from support.headers import RUNTIME, counts, defined, headers, shared, statements

pytestmark = pytest.mark.quick
TABLES = "smg_kl17a smg_kl9a smg_ss11 smg_ss13 smg_ss21 smg_ss35 smg_suzuki5"
EXPLICIT = "smg_axis_splitting smg_cf4 smg_depondt_mertens smg_heun smg_pair_rotations smg_sublattice_rotations"
METHODS = f"smg_classical_midpoint smg_spherical_midpoint smg_geodesic_midpoint smg_isospectral_midpoint smg_exponential_midpoint smg_rattle smg_dop853 smg_dormand_prince smg_extrapolation smg_gauss_site {EXPLICIT}"
# (what is asked for, the headers that answer it, of which a program has one, or a default and one)
CONTRACTS = tuple((said, frozenset(headers.split())) for said, headers in (
    ("what a method says of itself", f"smg_block smg_state smg_history smg_sphere_history smg_no_history smg_one_stage smg_slopes smg_explicit smg_angles {METHODS}"),
    ("the step, and many of them", "smg_composition smg_explicit_step smg_field_steps smg_gauss smg_gauss_rows smg_slopes smg_single_sphere smg_step"),
    ("the history of a method", "smg_dop853 smg_explicit smg_no_history smg_gauss_site smg_gauss_step smg_history smg_slopes smg_sphere_history"),
    ("the midpoint of a method", "smg_classical_midpoint smg_spherical_midpoint"),
    ("the points and the motion of implicit stages", "smg_exponential_midpoint smg_geodesic_midpoint smg_isospectral_midpoint smg_rattle"),
    ("the stages to begin with, and a pass over them (smg_fixed_point.h)", "smg_gauss_stages smg_gauss_step smg_gauss_sweep smg_one_stage smg_rattle smg_slopes"),
    ("the stages of Gauss collocation, of sites or of slots (smg_gauss_step.h)", "smg_gauss_slots smg_gauss_stages smg_gauss_sweep smg_row_slots"),
    ("a stage of an explicit method (smg_explicit_step.h)", EXPLICIT),
    ("the increment of an explicit method (smg_increment_step.h)", "smg_dormand_prince smg_extrapolation"),
    ("what asks for the right-hand side alone (smg_right_side.h), of sites or of slots: its vectors, and the field", "smg_right_side smg_field_rows"),
    ("one step of such a method (smg_field_steps.h)", "smg_dop853 smg_increment_step"),
    ("what an internal step asks of single sites, or of slots", "smg_dop853 smg_dop853_slots"),
    ("a stage by rows (smg_turn_steps.h)", "smg_pair_rows smg_sublattice_rows"),
    ("the matrix of Newton's method", "smg_matrix_band smg_matrix_dense smg_matrix_free smg_matrix_sparse smg_newton"),
    ("a matrix that is kept for the steps after, or not", "smg_matrix_dense smg_matrix_sparse smg_matrix_unkept"),
    ("the predictor, of steps, of stages or none", "smg_predictor smg_stage_predictor smg_single_sphere smg_composition smg_saved"),
    ("a lattice by rows", "smg_row_state smg_turn_state smg_pair_state smg_sublattice_state"),
    ("steps by rows", "smg_row_step smg_turn_steps"),
    ("sweeps, from site to site or by rows", "smg_row_beyond smg_sweep"),
    ("the slots that a rank has, in layers or in a block, and what ranks tell each other", "smg_row_faces smg_row_grid smg_row_halo smg_row_ranks smg_row_team"),
    ("the sites that a rank has, and what ranks tell each other of them", "smg_own smg_row_grid smg_row_layers smg_row_parts smg_row_ranks smg_row_state smg_sum"),
    ("the tangent map, of a step or of a composition", "smg_tangent smg_composed_tangent"),
    ("the types of templates, of one number and of lanes", "smg_template smg_in_lanes smg_in_numbers"),
    ("states in lanes", "smg_lane_composition smg_lane_dop853 smg_lane_extrapolation smg_lane_sphere"),
    ("coefficients", f"smg_dop853_table smg_gauss_table smg_explicit_step {TABLES}")))
# Counted when it was last changed; `python tests/support/headers.py` counts.
MOST_STATEMENTS = 7886


def unexplained(names: dict) -> dict:
    return {name: headers for name, headers in names.items() if not any(headers <= several for _, several in CONTRACTS)}


def test_no_name_has_two_meanings():
    assert unexplained(shared()) == {}


def test_every_contract_is_asked_for():
    """And every header that it names answers with some name of it."""
    names = shared().values()
    for said, several in CONTRACTS:
        answers = [headers for headers in names if headers <= several]
        assert frozenset().union(*answers) == several, said


def test_no_header_defines_what_a_model_gives():
    """The functions in the comment of smg_model.h; those of plain unit spheres are in smg_plain.h."""
    asked = set(re.findall(r"\b(smg_\w+)\(", (RUNTIME / "core" / "smg_model.h").read_text().split("*/")[0]))
    found = {path.stem: both for path in headers() if (both := asked & defined(path.read_text()))}
    assert len(asked) > 40 and set(found) == {"smg_plain"}


def test_a_second_meaning_is_seen():
    """As smg_turning had: two types of two methods that no contract joins."""
    one = defined("typedef struct smg_turning {\n  int a; /* f() { */\n} smg_turning;\nstatic int smg_turn(int a) { return a; }\n")
    two = defined("#define SMG_SMALL 1\nenum smg_turning { A };\nSMG_INLINE void smg_turn(void) {\n  if (1) smg_f();\n}\n")
    assert defined("#define smg_turn smg_lane_turn\n") == set() and defined("#define smg_turn smg_lane_turning\n") == {"smg_turn"}
    assert one == {"smg_turning", "smg_turn"} and two == {"SMG_SMALL", "smg_turning", "smg_turn"}
    assert unexplained({"smg_turning": {"smg_pair_rotations", "smg_row_end"}}) and not unexplained({"smg_stage": {"smg_cf4", "smg_axis_splitting"}})


def test_statements_become_no_more():
    """A change that needs more raises the ceiling, and says what for."""
    assert sum(counts().values()) <= MOST_STATEMENTS


def test_statements_are_semicolons_outside_comments_and_strings():
    assert statements('int a; /* b; c; */ // d;\nfor (;;) f(";", \';\');\n') == 4
