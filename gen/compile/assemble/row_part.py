"""What lattices by rows add to a model, and the arrays of their states."""
from __future__ import annotations

from dataclasses import replace

from ..lower.code import Call, If, Member, Name, Return
from ..lower.integers import Computed, Index, whole
from .beside_norms import beside_norms, norm_function
from .effort import beyond_rows, by_rows
from .part import MOST_LANES, Part, buffer, placed
from .row_changes import change_functions, changes_of
from .rows import Rows, besides, kinds_size, row_functions, row_settings, rows, site_values, slots_of


class ByRows(Part):
    """Lattices by rows, sites in lanes."""
    name, layout = "in_rows", "rows"

    def made(self, model, low):
        found = rows(model, low)
        model.why_by_site = found if isinstance(found, str) else ""
        if not isinstance(found, Rows):
            return None
        found = replace(found, changes=changes_of(model, low, found)) if "tangent" in model.features else found
        return replace(found, norms=beside_norms(model, low, found)) if proved_at_solutions(model) else found

    def functions(self, model):
        return [*row_functions(model), *change_functions(model), *norm_function(model.in_rows)]

    def headers(self, model):
        return ["smg_rows.h"]

    def settings(self, model):
        return row_settings(model)

    def members(self, model):
        values = [("smg_real *row_values", "values of sites by slots")] if site_values(model) else []
        values += [("void *row_kinds", "what stands beside rows of each kind")] * bool(kinds_size(model) and not model.method.takes_fields)
        values += [("void *row_known", "what stands beside rows, during a call")] * model.method.by_field
        values += [(f"smg_real *row_increments[{model.composed}]", "increments of all stages of the last step by slots, for the tangent map")] * bool(model.composed and model.in_rows.changes)
        return values + ([] if model.method.takes_fields else row_members(model.method.of_midpoints, model.composed, "tangent" in model.features))

    def buffers(self, model):
        """Where h is beyond the bound, midpoints are swept by slots too."""
        size = Computed("smg_beyond_size", (Index("c"),))
        return [buffer("row_beyond", size, "the same arrays by slots where the bound does not hold")] if proved_at_solutions(model) else []

    def instead(self, model):
        """Methods that take fields by rows keep all by slots."""
        if model.method.by_field:
            (name, numbers, more, meaning), = model.method.arrays
            sizes = (("u", 3, 0, "increment W - w of the current step, by slots"), (name, numbers, more, f"{meaning}, by slots"),
                     ("row_spins", 6 + site_values(model), 0, "w and its rounding errors by slots, during a call"))
            return [*(buffer(name, Computed("smg_slot_numbers", (Index("c"), whole(n))) + more, meaning) for name, n, more, meaning in sizes), *kinds_buffer(model)]
        size = Computed("smg_stages_size", (Index("c"),))
        return [buffer("stages", size, "components by slots: w, z, points, stages and slopes"), *kinds_buffer(model)] if model.method.stage_rows else []

    def laid_out(self, model):
        """Where steps go by rows, with no other arrays than those."""
        used = Call("smg_row_layout", (Name("s"), Name("mem")))
        for b in (b for part in model.parts for b in part.around(model)):
            used = placed(b, used)
        by_rows = If((Member("s", "rows"),), (Return(used),))
        return () if model.method.takes_fields else (by_rows,)

    def most(self, model, step):
        if not model.method.of_midpoints:
            return step
        return (step + beyond_rows() if proved_at_solutions(model) else step).either(by_rows())

    def sizes(self, model, value):
        if model.method.by_field:
            return {"smg_slot_numbers": lambda n: MOST_LANES + n * slots_of(model, value).pitch, "smg_kinds_size": lambda: kinds_size(model)}
        return {"smg_beyond_size": lambda: beyond(model, value), "smg_kinds_size": lambda: kinds_size(model),
                "smg_stages_size": lambda: MOST_LANES + (10 + 15 * dict(model.method.defines)["SMG_STAGES"] + site_values(model)) * slots_of(model, value).pitch}

    def numbers(self, model, value):
        """smg_row_layout, and of maps around the step."""
        if model.method.takes_fields:
            return 0
        around = sum(value(b.size) for part in model.parts for b in part.around(model))
        slots = slots_of(model, value)
        return around + slots.arrays(model.method.of_midpoints, model.composed, model.history, bool(model.in_rows.changes)) + slots.tables(site_values(model), besides(model), kinds_size(model))

    def lanes(self, model):
        return MOST_LANES


def proved_at_solutions(model) -> bool:
    """Are sweeps by rows beyond the bound shown to be right at their solution? Where midpoints stand on spheres."""
    return bool(model.plan.coupled) and model.method.onto_leaf


def kinds_buffer(model) -> list:
    """The table of what stands beside rows of many kinds, of methods that have no other arrays by rows."""
    return [buffer("row_kinds", Computed("smg_kinds_size", ()), "what stands beside rows of each kind")] * bool(kinds_size(model))


def beyond(model, value) -> int:
    """smg_beyond_size."""
    slots = slots_of(model, value)
    return slots.beyond() + slots.tables(site_values(model), besides(model), kinds_size(model))


def row_members(swept: bool, stages: int | None, tangent: bool) -> list:
    """swept: by sweeps, of midpoints; stages: of their composition; tangent: with the tangent map."""
    each = f"[{stages}]" if stages and swept else ""
    of_sweeps = [("int row_strong, row_flat, row_weak, row_stretched", "flags: |h b| may be large, may exceed 1.4, is small, may exceed 1/3"),
                 ("int row_alone", "flag: sites do not interact with sites of their own colour, nor with themselves"),
                 ("int row_due", "flag: the increments of the last step have not yet been added to row_w"),
                 (f"int64_t row_passes{each}, row_fewest{each}", f"passes over the colours in the last step{', of each stage' if each else ''}, and the smaller number of the last two steps"),
                 ("int64_t row_from", "the pass from which the changes of the midpoints are measured"),
                 (f"int64_t row_near{each}, row_reach", "the pass from which small components are checked, and the range of the interaction in slots"),
                 ("smg_real row_bound", "bound on the factor by which a sweep reduces errors, if below 1")]
    later = [("smg_real *row_u, *row_late", "increments of the current step, of the first colour and of the others")]
    later += [("smg_real *row_w_before, *row_compensation_before", "row_w and row_compensation before the step, for one that fails")] * bool(each)
    later += [("smg_real *row_u_before", "row_u before the step, for one that fails")] * tangent
    return [("int rows, row_team", "1 if steps are taken by rows of the lattice, in lanes, using the arrays row_*, and number of threads that share them (OpenMP)"),
            *(of_sweeps if swept else []), ("int row_kept", "flag: w is in row_w, as the last call has left it"),
            ("int32_t *row_beside", "if the lattice is stored in blocks: the slots of the neighbours of each vector, otherwise NULL"),
            ("smg_real *row_w, *row_compensation" + ", *row_m" * swept,
             "w, its rounding errors" + " and midpoints" * swept + " by rows" + " (between calls, w is stored in row_m)" * swept), *(later if swept else [])]
