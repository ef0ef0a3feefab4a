"""The order of visits of a large graph: neighbours soon after each other, whatever their numbers and the rows of the file."""
import re

import numpy as np
import pytest

import smidgen
from smidgen.compile.assemble import visiting
from smidgen.compile.emit.emit import generate
from smidgen.language.spec import Graph

SIDE = 72       # of a square of sites, more than visiting.LARGE in all
SPEC = """
[model]
name = "net"
[space]
w = {{ sphere = {sites} }}
[graphs.g]
file = "edges.csv"
[effects.exchange]
over = "edge(i, j, K) of g"
energy = "-K*dot(w[i], w[j])"
{more}
"""


def square(side: int):
    """The edges of nearest neighbours on a square with open ends."""
    n = np.arange(side * side).reshape(side, side)
    return np.concatenate([np.stack([n[:, :-1].ravel(), n[:, 1:].ravel()], axis=1), np.stack([n[:-1].ravel(), n[1:].ravel()], axis=1)])


def graph(edges) -> Graph:
    return Graph("i", "j", tuple(map(tuple, edges.tolist())))


def test_every_site_is_visited_once_breadth_first():
    """A site that is not a root comes after a neighbour, and the neighbours of an earlier site come before those of a later one."""
    edges = np.array([[0, 5], [5, 3], [3, 0], [1, 4], [6, 6]])
    order = visiting.cuthill_mckee(edges, 8).tolist()
    assert order == [2, 7, 1, 4, 0, 3, 5, 6]        # those without a neighbour, the pair, the triangle, the site that is its own neighbour


@pytest.mark.parametrize("seed", range(5))
def test_neighbours_of_a_shuffled_square_are_near(seed):
    """As near as rows of a square can be, where in the numbers of the sites they are thousands apart."""
    number = np.random.default_rng(seed).permutation(SIDE * SIDE)
    edges = number[square(SIDE)]
    order = visiting.visit_order((graph(edges),))
    assert sorted(order.tolist()) == list(range(SIDE * SIDE))
    assert visiting.distance(edges, np.argsort(order)) < SIDE < visiting.distance(edges, np.arange(SIDE * SIDE)) / 20


def test_good_numbers_and_few_sites_stay():
    assert visiting.visit_order((graph(square(SIDE)),)) is None
    few = np.random.default_rng(1).permutation(60 * 60)[square(60)]
    assert visiting.visit_order((graph(few),)) is None


def net(folder, edges, weights, more=""):
    """The spec of a graph."""
    folder.mkdir()
    np.savetxt(folder / "edges.csv", np.column_stack([edges, weights]), delimiter=",", fmt=["%d", "%d", "%.17g"])
    (folder / "net.toml").write_text(SPEC.format(sites=SIDE * SIDE + 3, more=more))     # three without an edge
    return smidgen.load(folder / "net.toml")


def three_nets(folder):
    """A square with its natural numbers, with others, and with these and the rows of the file in another order; the other numbers."""
    edges, rng = square(SIDE), np.random.default_rng(7)
    weights, number, rows = rng.normal(size=len(edges)), rng.permutation(SIDE * SIDE), rng.permutation(len(edges))
    return net(folder / "a", edges, weights), net(folder / "b", number[edges], weights), net(folder / "c", number[edges][rows], weights[rows]), number


def tables(spec) -> str:
    """The generated C without the name of the graph, which is a digest of the file, and that of the spec."""
    return re.sub(r"graph_\w{8}|spec \w+", "", generate(spec, solver="rotation")["net.c"])


def test_the_c_does_not_depend_on_the_order_of_the_rows(tmp_path):
    natural, shuffled, in_another_order, _ = three_nets(tmp_path)
    assert tables(shuffled) == tables(in_another_order)
    assert "smg_visits" in tables(shuffled) and "smg_visits" not in tables(natural)


def shuffled_net(folder, more=""):
    edges, rng = square(SIDE), np.random.default_rng(3)
    return net(folder, rng.permutation(SIDE * SIDE)[edges][rng.permutation(len(edges))], rng.normal(size=len(edges)), more)


def edges_in(c: str) -> list:
    return re.findall(r"\{(\d+), (\d+)\}", re.search(r"graph_\w+_edge\[\]\[2\] = (.*);", c)[1])


def test_pair_rotations_take_the_edges_in_the_order_of_the_file(tmp_path):
    """It decides their steps."""
    spec = shuffled_net(tmp_path / "a")
    in_the_file = [tuple(line.split(",")[:2]) for line in (tmp_path / "a/edges.csv").read_text().splitlines()]
    assert edges_in(generate(spec, method="pair-rotations")["net.c"]) == in_the_file
    by_visits = edges_in(generate(spec, solver="rotation")["net.c"])
    assert by_visits != in_the_file and sorted(by_visits) == sorted(in_the_file)


def test_rows_of_a_smaller_graph_are_not_fetched(tmp_path):
    """It has none for most sites."""
    more = """[graphs.few]
edges = [[0, 5], [7, 3]]
[effects.few]
over = "edge(i, j) of few"
energy = "w[i].x*w[j].y"
"""
    c = generate(shuffled_net(tmp_path / "a", more), solver="rotation")["net.c"]
    assert len(set(re.findall(r"(graph_\w+)_first_row\[\]", c))) == 2
    assert len(set(re.findall(r"SMG_FETCH\((graph_\w+)_first_row", c))) == 1


def test_an_observable_may_have_a_graph_with_more_sites(tmp_path):
    """The order of visits does not have them."""
    last = SIDE * SIDE + 2
    more = f"""[graphs.wide]
edges = [[0, {last}], [{last}, 7]]
[observables.wide]
over = "edge(i, j) of wide"
value = "dot(w[i], w[j])"
"""
    c = generate(shuffled_net(tmp_path / "a", more), solver="rotation")["net.c"]
    assert "smg_visits" in c and f"{{{{0, {last}}}, {{7, {last}}}}}" in c.replace(f"{{{last}, 7}}", f"{{7, {last}}}")


def test_terms_of_single_sites_on_a_lattice_keep_its_order(tmp_path):
    more = f"""[effects.field]
over = "bond(i, j) of chain({SIDE * SIDE + 3}, open)"
energy = "w[i].z"
"""
    assert "smg_visits" not in generate(shuffled_net(tmp_path / "a", more), solver="rotation")["net.c"]


def test_rows_that_two_effects_read_are_fetched_once(tmp_path):
    """Here the ends have other names in the second one."""
    more = """[effects.push]
over = "edge(a, b, K) of g"
torque = "cross(w[a], w[b])"
"""
    c = generate(shuffled_net(tmp_path / "a", more), solver="rotation")["net.c"]
    loop = c[c.index("smg_each_coloured("):]
    assert loop[:loop.index("visit(context, at)")].count("SMG_FETCH(") == 2


def test_states_do_not_depend_on_the_numbers_of_sites(tmp_path):
    """Up to rounding."""
    natural, shuffled, _, number = three_nets(tmp_path)
    w = np.random.default_rng(1).normal(size=(SIDE * SIDE + 3, 3))
    w /= np.linalg.norm(w, axis=1)[:, None]
    number = np.append(number, SIDE * SIDE + np.arange(3))
    a = smidgen.run(natural, start=w, h=0.05, steps=5, solver="rotation").final
    b = smidgen.run(shuffled, start=w[np.argsort(number)], h=0.05, steps=5, solver="rotation").final
    assert np.abs(b[number] - a).max() < 1e-14
