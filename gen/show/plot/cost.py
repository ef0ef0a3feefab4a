"""The figure of a cost table, four panels: errors against the time they take, and the energy along long runs.

Drawn are the methods of the frontier: those that are the fastest of their kind for some error, and the spherical
midpoint, with which they are compared. The others are named below. The same file gives the same picture.
"""
from __future__ import annotations

from pathlib import Path

from ...cost.frontier import by_method, seconds_for, symplectic
from ...cost.peers import PEERS
from ...cost.report import Cost, cost_is_chaotic, label
from ...methods import METHODS, MIDPOINTS
from .colours import SOFT
from .style import footnote, method_marker, method_style, new_figure, save, styled

PANELS = (("end_error", "error of the final state, relative to |w|"), ("energy", "largest error of the energy"),
          ("casimir", "largest relative error of a Casimir"))
LEAST = 1e-17       # below it a point stands on the lower edge
LEVELS = [10.0 ** -k for k in range(2, 15, 2)]      # errors at which the fastest of each kind is looked for
KINDS = (symplectic, lambda name: name in METHODS and not symplectic(name), lambda name: name in PEERS)


def leading(rows, what: str) -> list[str]:
    """The methods that are the fastest of their kind for some error `what`, in the order of the rows; first the spherical midpoint."""
    own = by_method(rows)
    times = {name: [seconds_for(group, what, level) for level in LEVELS] for name, group in own.items()}
    found = {MIDPOINTS[0]} & set(own)
    for kind in KINDS:
        for k in range(len(LEVELS)):
            there = {name: t[k] for name, t in times.items() if kind(name) and t[k] == t[k]}
            found |= {min(there, key=there.get)} if there else set()
    return sorted(found, key=lambda name: (name != MIDPOINTS[0], list(own).index(name)))


def draw_cost(cost: Cost, path) -> Path:
    """Draw the table into a .png, .svg or .pdf; returns its path. Raises UsageError for another format."""
    return save(cost_figure(cost), path)


@styled
def cost_figure(cost: Cost):
    """Error against time, by energy, phase and end; below, the energy error along long runs."""
    figure = new_figure(11, 8)
    axes = figure.subplots(2, 2).ravel()
    names = leading(cost.rows, "energy" if cost_is_chaotic(cost) else "end_error")
    for ax, (what, words) in zip(axes, PANELS):
        panel(ax, cost, names, what, words)
    along(axes[3], cost, names)
    if cost_is_chaotic(cost):
        axes[0].text(0.5, 0.5, "no errors of the final state:\nit is not resolved", ha="center", transform=axes[0].transAxes)
    handles, labels = axes[1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper")
    f = cost.facts
    figure.suptitle(f"{f['spec']} {f['run']}: what accuracy costs (time {f['time']}, {f['sites']} sites)", x=0.01, ha="left")
    footnote(figure, f["machine"], f"reference: {f['reference']}", failures(cost), behind(cost.rows, names))
    return figure


def behind(rows, names) -> str:
    """The methods that are not drawn."""
    rest = [label(name) for name in by_method(rows) if name not in names]
    return f"measured, but not the fastest of their kind for any error: {', '.join(rest)}" if rest else ""


@styled
def accuracy_cost(table: Cost):
    """End error against time of short runs, and the energy error along long ones."""
    figure = new_figure(11, 4.6)
    left, right = figure.subplots(1, 2)
    names = leading(table.rows, "end_error")
    panel(left, table, names, *PANELS[0])
    along(right, table, names)
    left.set_title(f"Short runs: error at t = {table.facts['time']}")
    right.set_title("Long runs: with steps for the same error at the end of the short run")
    left.legend(loc="upper right")
    footnote(figure, table.facts["machine"], behind(table.rows, names))
    return figure


def panel(ax, cost: Cost, names, what: str, label: str) -> None:
    """An error against the time of a run, a line a method; of general integrators a dotted one."""
    for name in names:
        own = name in PEERS or name in METHODS and METHODS[name].controlled
        rows = [r for r in cost.rows if r.method == name and not r.status and getattr(r, what) == getattr(r, what) and (own or r.tolerance != r.tolerance)]
        if rows:
            ax.plot([r.seconds for r in rows], [max(getattr(r, what), LEAST) for r in rows], markersize=3.5, **look(name))
    ax.set(xscale="log", yscale="log", xlabel="time of the run [s]", ylabel=label)


def look(name: str) -> dict:
    """Of a line: that of the method everywhere, grey dots and a marker for a general integrator."""
    if name in PEERS:
        return {"label": PEERS[name].label, "color": SOFT, "linestyle": ":", "marker": "osD^v<>PX"[list(PEERS).index(name)], "markerfacecolor": "none"}
    return {**method_style(name), "marker": method_marker(name)}


def along(ax, cost: Cost, names) -> None:
    """The energy along long runs: each method with the step that came next to the same end error."""
    for name in [name for name in dict.fromkeys(m for m, *_ in cost.long) if name in names]:
        points = [(t, max(e, LEAST)) for m, _, t, e in cost.long if m == name]
        ax.plot(*zip(*points), **method_style(name))
    ax.set(xscale="log", yscale="log", xlabel="time along the run", ylabel="error of the energy")


def failures(cost: Cost) -> str:
    """How many runs did not get to the end."""
    failed = [row for row in cost.rows if row.status]
    names = ", ".join(dict.fromkeys(METHODS[r.method].label if r.method in METHODS else r.method for r in failed))
    return f"{len(failed)} runs with too large steps were not completed ({names})" if failed else ""
