"""Sums as C loops (stage `lower`): each term once, and for one site exactly the terms it stands in."""
import subprocess
from collections import Counter

import numpy as np
import pytest
from smidgen.compile.assemble.tables import graph_tables
from smidgen.compile.emit.targets import PRINTERS, printed
from smidgen.compile.lower.code import Call, Name, Unary
from smidgen.compile.lower.integers import Index
from smidgen.compile.lower.loops import Loops, graph_name
from smidgen.compile.lower.lowering import Lowering
from smidgen.compile.plan.colouring import colouring
from smidgen.language.instances import instances_of
from smidgen.language.spec import Graph, Lattice
from smidgen.read import load_text
from smidgen.resources import include_flags

pytestmark = pytest.mark.quick

SPEC = """
[model]
name = "m"
[space]
w = {{ sphere = "{sites}" }}
{more}
[parameters]
n = {{ default = 5 }}
[effects.e]
over = "{over}"
energy = "{energy}"
"""
FAMILIES = {
    "sites": ("n", "site(i) of w", "w[i].x^2", ""),
    "pairs": ("n", "pair(i, j) of w", "dot(w[i], w[j])", ""),
    "each": ("n", "each(i of w, j of v)", "dot(w[i], v[j])", "v = { sphere = 3 }"),
    "ring": ("n", "bond(i, j) of chain(n, periodic)", "dot(w[i], w[j])", ""),
    "open chain": ("n", "bond(i, j) of chain(n, open)", "dot(w[i], w[j])", ""),
    "square": ("n*n", "bond(i, j) of square(n, n, periodic)", "dot(w[i], w[j])", ""),
    "cubic": ("n*n*n", "bond(i, j) of cubic(n, n, n, open)", "dot(w[i], w[j])", ""),
}
PROGRAM = """
#include <stdio.h>
#include "smg_site.h"
typedef struct {{ int64_t n; }} params;
typedef struct {{ params p; int64_t n0, n1, n2, n3; }} model;
typedef struct {{ const model *model; }} coefficients;
{tables}
int main(void) {{
  model k;
  const coefficients own = {{&k}}, *c = &own;
  k.p.n = 5;
{sizes}
{scatter}
  puts("gather");
  for (int64_t site = 0; site < {sites}; ++site) {{
{gather}
  }}
  return 0;
}}
"""


def spec_of(name, ends=None):
    sites, over, energy, more = FAMILIES[name]
    over = over.replace("periodic", ends) if ends else over
    return load_text(SPEC.format(sites=sites, over=over, energy=energy, more=more))


def say(form, indices):
    return Call("printf", (Name(form), *(Unary("(int)", Index(i)) for i in indices)))


def visited(tmp_path, name):
    """(terms of the sum, (site, term) of the sums of each site) as the C loops visit them, and the term."""
    spec = spec_of(name)
    low, term = Lowering(spec), spec.effects[0]
    counts = {f.name: low.size(f.count) for f in spec.families}
    loops, show = Loops(low, counts.get), PRINTERS["scalar"]
    tables = graph_tables(graph_name(term.over), term.over) if isinstance(term.over, Graph) else []
    line = say('"' + " ".join(["%d"] * len(term.over.bound)) + '\\n"', term.over.bound)
    own = [slot for slot in (("w", i) for i in term.over.bound) if not (name == "each" and slot[1] == "j")]
    gather = [g for slot in own for g in loops.gather(term.over, slot, (say('"%d: "', ["site"]), line))]
    text = PROGRAM.format(tables="\n".join(map(printed, tables)), sizes="\n".join(f"  k.{member} = {show(n)};" for n, member in low.sizes.items()),
                          scatter="\n".join(show.lines(loops.scatter(term.over, (line,)))), sites=show(counts["w"]), gather="\n".join(show.lines(gather)))
    (tmp_path / "main.c").write_text(text)
    subprocess.run(["gcc", "-std=c11", *include_flags(), "main.c", "-lm", "-o", "main"], cwd=tmp_path, check=True)
    said = subprocess.run(["./main"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    whole, _, by_site = said.partition("gather\n")
    return whole.splitlines(), by_site.splitlines(), spec


@pytest.mark.parametrize("name", FAMILIES)
def test_loops_visit_each_term_once(name, tmp_path):
    """The same terms as the interpreter's numpy arrays have, and each site meets those in which it stands."""
    whole, by_site, spec = visited(tmp_path, name)
    over = spec.effects[0].over
    sites = {"n": 5, "n*n": 25, "n*n*n": 125}[FAMILIES[name][0]]
    index, _ = instances_of(over, {"n": 5}, {"w": (0, sites), "v": (sites, 3)})
    terms = list(zip(*(np.asarray(index[i]) for i in over.bound)))
    expected = [" ".join(map(str, map(int, t))) for t in terms]
    assert Counter(whole) == Counter(expected) and len(whole) == len(set(whole)) > 1
    mine = 1 if name == "each" else len(over.bound)
    assert Counter(by_site) == Counter(f"{t[k]}: {text}" for t, text in zip(terms, expected) for k in range(mine))


@pytest.mark.parametrize("name", ["ring", "square", "cubic"])
def test_sites_of_one_colour_do_not_meet(name):
    """Of the cells of a large lattice, by their own numbers."""
    term = spec_of(name, "open").effects[0].over
    assert isinstance(term, Lattice)
    found = colouring([term])
    for bond in term.bonds:
        (_, a), (_, b) = bond
        ca, cb = (sum(w * x for w, x in zip(found.weights, place)) % found.colours for place in (a, b))
        assert ca != cb
