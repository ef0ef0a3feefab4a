"""All definitions of a model, in an order in which each follows what it mentions."""
from __future__ import annotations

from .families import number_functions, site_functions
from .parameters import parameter_functions
from .sums import site_sums, sum_functions
from .sweeps import visits
from .tables import tables
from .value_sums import value_sums
from ..lower.code import mentions, needed
from ..lower.trim import trim


def definitions(model) -> tuple[list, list]:
    """(tables, types and functions; `value_sums`): what nothing mentions is left out, arguments that nothing reads too."""
    kernels = [f for t in (*model.fields, *model.values, *model.observables) for f in t.functions]
    first = [f for part in model.parts for f in part.first(model)]
    functions = [*first, *parameter_functions(model), *kernels, *number_functions(model), *site_functions(model), *sum_functions(model), *site_sums(model),
                 *visits(model), *(f for part in model.parts for f in part.functions(model))]
    values = value_sums(model)
    kept, bodies = trim(needed([*tables(model), *functions], called(values)), [body for _, _, body in values])
    values = [(kind, name, body) for (kind, name, _), body in zip(values, bodies)]
    return needed(kept, called(values)), values


def called(values) -> set:
    """The names that the sums mention."""
    return mentions(*(statement for _, _, body in values for statement in body))
