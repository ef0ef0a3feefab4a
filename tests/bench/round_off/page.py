"""The page docs/round_off.md from its tables."""
from string import Template

from .growth import LONGER, LONGEST
from .programs import DEFAULT, LANES
from .rows import exponent, small

LAW = 0.6       # the largest exponent that passes for sqrt(N)
BASES = (DEFAULT, next(iter(LANES)))    # what costs are compared with
NOTHING = "(not measured yet)"


def page(growth, cost, prose: str) -> str:
    """The text of docs/round_off.md: the prose with its tables."""
    machines = sorted({r.machine for r in growth} | {r.machine for r in cost})
    return Template(prose).substitute(
        machines="; ".join(machines), free=growth_table(growth, "free", "H"), free_w=growth_table(growth, "free", "|w|"),
        lanes=growth_table(growth, "lanes", "H"), lanes_w=growth_table(growth, "lanes", "|w|"),
        irreversible=growth_table(growth, "irreversible", "|w|"), chain_8=growth_table(growth, "chain of 8", "|w|"),
        chain_100=growth_table(growth, "chain of 100", "|w|"), distance=growth_table(growth, "distance", "|dw|"),
        free_cost=cost_table(cost, "free"), irreversible_cost=cost_table(cost, "irreversible"),
        chain_cost=cost_table(cost, "chain of 100"), lanes_cost=cost_table(cost, "lanes"),
        irreversible_standing=standings(growth, "irreversible", "|w|"), chain_standing=standings(growth, "chain of 8", "|w|"),
        verdict=verdict(growth, cost, "free"), lanes_verdict=verdict(growth, cost, "lanes"))


def in_order(values):
    """The different ones among `values`, first come first."""
    return list(dict.fromkeys(values))


def table(head, body) -> str:
    """A table in Markdown."""
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, ["---"] * len(head), *body))


def chosen(rows, **asked):
    """The rows whose fields have these values."""
    return [r for r in rows if all(getattr(r, k) == v for k, v in asked.items())]


def power(n: int) -> str:
    return f"10{str(len(str(n)) - 1).translate(str.maketrans('0123456789', '⁰¹²³⁴⁵⁶⁷⁸⁹'))}"


def growth_table(rows, name, quantity) -> str:
    """rms after each number of steps, with the exponent; in brackets: over how many orbits, where fewer."""
    rows = chosen(rows, table=name, quantity=quantity)
    if not rows:
        return NOTHING
    steps = sorted({r.steps for r in rows})
    body = []
    for variant in in_order(r.variant for r in rows):
        mine = chosen(rows, variant=variant)
        cells = {r.steps: f"{r.rms:.2g}" + (f" ({r.orbits})" if r.orbits != mine[0].orbits else "") for r in mine}
        body.append([variant, str(mine[0].orbits), *(cells.get(n, "") for n in steps), f"{exponent(mine):.2f}"])
    return table(["variant", "orbits", *map(power, steps), "exponent"], body)


def cost_table(rows, name) -> str:
    """Nanoseconds, a line for each variant."""
    rows = chosen(rows, table=name)
    base = next((r.median for r in rows if r.variant in BASES), None)
    return NOTHING if base is None else table(["variant", "median ns", "least", "greatest", "relative time"],
                 [[r.variant, f"{r.median:.1f}", f"{r.least:.1f}", f"{r.greatest:.1f}", f"{r.median / base:.2f}"]
                  for r in sorted(rows, key=lambda r: r.median)])


def late(rows) -> list:
    """The rows at 1e7 and 1e8 steps."""
    return [r for r in rows if r.steps in (LONGER, LONGEST)]


def meets(rows) -> bool:
    """rms dH <= 1e-18 sqrt(N) at 1e7 and 1e8 steps, exponent at most LAW."""
    return len(late(rows)) == 2 and small(late(rows)) and exponent(rows) <= LAW


def verdict(growth, cost, name) -> str:
    """How each variant stands to the law of dH, and which of those that keep it costs least."""
    kept = {v for v, rows in by_variant(growth, name, "H").items() if meets(rows)}
    best = min((r for r in chosen(cost, table=name) if r.variant in kept), key=lambda r: r.median, default=None)
    said = f"**{best.variant}**, {best.median:.1f} ns" if best else "none"
    return f"{standings(growth, name, 'H')}\n\nThe cheapest variant that meets the requirement: {said}."


def by_variant(growth, name, quantity) -> dict:
    """The rows of each variant."""
    rows = chosen(growth, table=name, quantity=quantity)
    return {v: chosen(rows, variant=v) for v in in_order(r.variant for r in rows)}


def standings(growth, name, quantity) -> str:
    """A line for each variant that was followed to 1e7 steps."""
    return "\n".join(f"- {v}: {standing(r)}" for v, r in by_variant(growth, name, quantity).items() if late(r))


def standing(rows) -> str:
    """rms/sqrt(N) at 1e7 and 1e8 steps, the exponent, and whether each is within the law."""
    sizes = " and ".join(f"{r.rms / r.steps**0.5:.2e}" for r in late(rows))
    size = "at most 1e-18" if small(late(rows)) else "more than 1e-18"
    steep = "at most" if exponent(rows) <= LAW else "more than"
    return f"rms/√N = {sizes}, {size}; exponent {exponent(rows):.2f}, {steep} {LAW}."
