"""Graphs from files: swept before Newton, with the same steps and the same folds; generated in time that grows with their edges."""
import time

import numpy as np
import pytest
import smidgen
from smidgen.compile.assemble.norms import shares
from smidgen.compile.emit.emit import generate
from smidgen.compile.lower.loops import graph_name
from smidgen.compile.plan.ordering import TooMuchFill, symbolic
from smidgen.errors import RunError
from smidgen.language.spec import Graph
from smidgen.read import files
from smidgen.read.files import plain_rows

TEXT = """
[model]
name = "web"
[space]
w = {{ sphere = {n}{more} }}
[parameters]
J = 0.7
[graphs.g]
file = "edges.csv"
[effects.bonds]
over = "edge(i, j, K) of g"
energy = "{energy}"
[starts.random]
random = 2
"""
EXCHANGE, LOG = "-J*K*dot(w[i], w[j])", "-J*K*log(2.5 - 2*dot(w[i], w[j]))"


def random_edges(n, m, seed=1):
    rng, edges = np.random.default_rng(seed), set()
    while len(edges) < m:
        i, j = map(int, rng.integers(n, size=2))
        if i != j:
            edges.add((min(i, j), max(i, j)))
    return np.array(sorted(edges))


def web(folder, n=60, m=150, energy=EXCHANGE, more=""):
    edges = random_edges(n, m)
    (folder / "edges.csv").write_text("i,j,K\n" + "".join(f"{i},{j},{1 + (i + j) % 3 / 4}\n" for i, j in edges))
    (folder / "web.toml").write_text(TEXT.format(n=n, energy=energy, more=more))
    return smidgen.load(folder / "web.toml")


@pytest.mark.quick
def test_sweeps_come_first(tmp_path):
    spec = web(tmp_path)
    files = generate(spec)
    assert files.notes["solver"] == "sparse" and files.notes["reason"].startswith("graph: rotation sweeps while they converge fast, otherwise Newton on")
    assert "SMG_SWEPT" in files["web.c"] and "SMG_SWEPT" not in generate(spec, solver="newton")["web.c"]


@pytest.mark.parametrize("energy", [EXCHANGE, LOG])
def test_the_steps_of_newton(tmp_path, energy):
    spec = web(tmp_path, energy=energy, more=', kappa = "1 + 0.1*mod(i, 3)"')
    models = [smidgen.build(spec, solver=solver).start("random", h=0.05).steps(200) for solver in ("auto", "newton")]
    assert np.abs(models[0].w - models[1].w).max() <= 1e-12


def taken(model, h):
    """w after a step; None where it is refused."""
    try:
        return model.start("random", h=h).steps(1).w.copy()
    except RunError:
        return None


@pytest.mark.parametrize("energy", [EXCHANGE, LOG])
def test_the_same_steps_are_refused(tmp_path, energy):
    """From steps that sweeps settle to those beyond the fold."""
    spec = web(tmp_path, 30, 80, energy)
    auto, newton = (smidgen.build(spec, solver=solver) for solver in ("auto", "newton"))
    refused = []
    for h in np.geomspace(0.05, 4, 24):
        found, wanted = taken(auto, h), taken(newton, h)
        assert (found is None) == (wanted is None), h
        assert found is None or np.abs(found - wanted).max() <= 1e-11, h
        refused.append(found is None)
    assert any(refused) and not all(refused)


# The norm in which sweeps are shown to contract

@pytest.mark.quick
@pytest.mark.parametrize("edges", [random_edges(300, 900), np.array([(0, k) for k in range(1, 101)]), np.array([(k, k + 1) for k in range(50)])])
def test_the_norm_fits_the_graph(edges):
    """Row sums in it are at least the spectral radius, as those of any norm, and little more."""
    d, n = shares(edges), edges.max() + 1
    A = np.zeros((n, n))
    np.add.at(A, (edges[:, 0], edges[:, 1]), 1)
    A += A.T
    radius = np.abs(np.linalg.eigvalsh(A)).max()
    assert (d > 0).all() and radius - 1e-9 <= (A @ d / d).max() <= 1.05 * radius


# The generator's time

@pytest.mark.quick
def test_a_plain_table_is_read_as_it_is_cell_by_cell():
    assert plain_rows("i,j\n0,1\n1,2\n", 2) == [(0, 1), (1, 2)] and plain_rows("0,1,0.5\n1,2,-1e-3", 2) == [(0, 1, 0.5), (1, 2, -1e-3)]
    assert plain_rows("0,1,.5\n1,2,-1.e-3", 2) == [(0, 1, 0.5), (1, 2, -1e-3)]
    for odd in ("1;2\n3;4\n", "0,1\n\n1,2\n", "0,1\n1\n", "0, 1\n", "", "i,j\n", "0,1,nan\n", "0,9999999999999999999\n", "0,1,1e400\n", "0,9007199254740993\n1,0.5\n", "0,,1\n", "0,1 # c\n", "0\n"):
        assert plain_rows(odd, 2) is None, odd


@pytest.mark.quick
def test_graphs_share_tables_if_their_edges_and_weights_are_the_same():
    edges, one = ((0, 1), (1, 2)), ("K", (0.5, -1.0))
    graphs = [Graph("i", "j", *given) for given in ((edges,), (edges[::-1],), (edges, (one,)), (edges, (("L", one[1]),)), (edges, (("K", (0.5, 1.0)),)), (edges, (one, ("L", one[1]))))]
    assert len(set(map(graph_name, graphs))) == len(graphs)
    assert graph_name(Graph("a", "b", edges, (one,), "w")) == graph_name(graphs[2])


@pytest.mark.quick
@pytest.mark.parametrize("rows, ends", [("0,1\n1,1\n", "1 to 1"), ("0,1\n1,-2\n", "1 to -2"), ("0,1\n1.5,2\n", "1.5 to 2"), ("0,1\n3,2.0\n", "3 to 2.0")])
def test_an_edge_that_is_none_is_named(tmp_path, rows, ends):
    (tmp_path / "edges.csv").write_text(rows)
    (tmp_path / "web.toml").write_text(TEXT.format(n=9, energy=EXCHANGE.replace("K*", ""), more="").replace("(i, j, K)", "(i, j)"))
    with pytest.raises(smidgen.SpecError, match=f"has an edge from {ends}"):
        smidgen.load(tmp_path / "web.toml")


@pytest.mark.quick
def test_very_many_columns_take_no_longer_than_as_many_rows(monkeypatch):
    """A file of 64 MB in one line, which is refused later, took minutes with a list for each column."""
    seen, found = [], files.plain_numbers
    monkeypatch.setattr(files, "plain_numbers", lambda cells: seen.append(len(cells)) or found(cells))
    line = ",".join(["1", "0.5"]*50_000)
    assert plain_rows(f"{line}\n{line}\n", 2) == [(1, 0.5)*50_000]*2 and len(seen) <= files.WIDEST
    assert plain_rows(f"{line},x\n", 2) is None


@pytest.mark.quick
def test_fill_that_does_not_fit_is_found_soon():
    """The limit is that of the whole; nothing is eliminated for long once it is passed."""
    edges = random_edges(300, 600)
    pattern = symbolic(300, edges)
    assert symbolic(300, edges, pattern.blocks).blocks == pattern.blocks
    with pytest.raises(TooMuchFill):
        symbolic(300, edges, pattern.blocks - 1)
    start = time.process_time()
    with pytest.raises(TooMuchFill):
        symbolic(10_000, random_edges(10_000, 30_000), 400_000)
    assert time.process_time() - start < 10


@pytest.mark.long
def test_a_million_edges(tmp_path):
    rng = np.random.default_rng(4)
    edges = rng.integers(100_000, size=(1_000_100, 2))
    edges = edges[edges[:, 0] != edges[:, 1]][:1_000_000]
    (tmp_path / "edges.csv").write_text("\n".join(f"{i},{j}" for i, j in edges.tolist()))
    (tmp_path / "web.toml").write_text(TEXT.format(n=100_000, energy=EXCHANGE.replace("K*", ""), more="").replace("(i, j, K)", "(i, j)"))
    start = time.process_time()
    files = generate(smidgen.load(tmp_path / "web.toml"))
    assert files.notes["solver"] == "rotation" and time.process_time() - start < 30     # ten on a machine with no other work
