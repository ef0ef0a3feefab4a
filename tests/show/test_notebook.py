"""What a notebook shows: a few words and a picture of every object, equations typeset, and no stray file."""
import base64
import html
import os
import re

import pytest
import smidgen
from smidgen.language.expr import Num, Op, Par, Spin
from smidgen.show.equations import equations, symbol, text

x = Op("x", (Spin("w", "i"),))


@pytest.fixture(scope="module")
def result():
    return smidgen.run("free_rigid_body", steps=20)


def words_of(shown: str) -> str:
    """Without the pictures."""
    return re.sub(r'<img [^>]*src="data:image/png;base64,[^"]*">', "", shown)


def test_a_result_shows_words_and_a_picture(result):
    shown = result._repr_html_()
    (image,) = re.findall(r'src="data:image/png;base64,([^"]*)"', shown)
    assert base64.b64decode(image).startswith(b"\x89PNG") and len(words_of(shown)) < 2048
    assert html.escape("<Result free_rigid_body demo: spherical-midpoint") in shown


def test_plot_and_play_write_no_file(result, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "data:image/png;base64," in result.plot("energy")._repr_html_() and repr(result.plot("energy")).startswith("<picture of <Result")
    page = html.unescape(result.play()._repr_html_().split('srcdoc="')[1].split('"')[0])
    assert page.lstrip().startswith("<!") and "http:" not in page
    assert os.listdir(tmp_path) == []
    with pytest.raises(smidgen.UsageError, match="no kind of picture 'energi'; did you mean 'energy'"):
        result.plot("energi")
    with pytest.raises(smidgen.UsageError, match=r"the player is an HTML page, not a picture: use result.play\(\)"):
        result.plot("player")


def test_a_result_without_states_shows_what_it_has():
    assert "<pre>" in smidgen.run("free_rigid_body", steps=3, what=[])._repr_html_()


def test_reports_show_their_words():
    for one in (smidgen.explain("free_rigid_body"), smidgen.validate("free_rigid_body", steps=3)):
        shown = one._repr_html_()
        assert shown.startswith("<pre>") and len(shown.encode()) < 3000


@pytest.mark.parametrize("name", sorted(smidgen.read.shipped.shipped()))
def test_every_spec_shows_its_equations(name):
    shown = smidgen.load(name)._repr_markdown_()
    assert len(shown.encode()) <= 2048 and shown.count("$$") == 2 and shown.count("{") == shown.count("}")
    assert shown.count(r"\left") == shown.count(r"\right")


@pytest.mark.quick
@pytest.mark.parametrize("e, said", [
    (Op("*", (Op("neg", (Par("J"),)), Op("dot", (Spin("w", "i"), Spin("w", "j"))))), r"-J \, w_{i} \cdot w_{j}"),
    (Op("^", (x, Num(2))), "w_{i, x}^{2}"), (Op("^", (Op("+", (Par("a"), Num(1))), Num(2))), r"\left(a + 1\right)^{2}"),
    (Op("/", (Par("kappa"), Num(2.5e-7))), r"\frac{\kappa}{2.5 \cdot 10^{-7}}"), (Op("*", (Num(2), Num(3.141592653589793))), r"2 \cdot \pi"),
    (Op("if", (Op("<=", (x, Num(0))), Num(1), Num(-1))), r"\begin{cases} 1 & w_{i, x} \le 0 \\ -1 & \text{else} \end{cases}"),
    (Op("-", (Par("a"), Op("-", (Par("b"), Par("c"))))), r"a - \left(b - c\right)"), (Op("sqrt", (Par("a"),)), r"\sqrt{a}"),
    (Op("atan2", (Par("a"), Par("b"))), r"\operatorname{atan2}\left(a, b\right)")])
def test_formulas(e, said):
    assert text(e) == said


@pytest.mark.quick
def test_names():
    assert [symbol(name) for name in ("J", "alpha", "I1", "k_max", "spin", "Omega_0")] == ["J", r"\alpha", r"I_{\mathrm{1}}", r"k_{\mathrm{max}}", r"\mathrm{spin}", r"\Omega_{\mathrm{0}}"]


@pytest.mark.quick
def test_a_sign_before_a_sum_is_that_of_all_of_it():
    spec = smidgen.load_text('[model]\nname = "m"\n[space]\nw = { sphere = 1 }\n[effects.e]\nenergy = "-(w[0].x + (1e-5)^2)"\n')
    assert equations(spec)[0].endswith(r"H = \underbrace{- \left(w_{0, x} + \left(1 \cdot 10^{-5}\right)^{2}\right)}_{\text{e}}")


@pytest.mark.quick
def test_the_heisenberg_chain():
    assert equations(smidgen.load("heisenberg_chain")) == [
        r"\dot w_i = w_i \times \frac{\partial H}{\partial w_i}, \qquad H = \underbrace{\sum_{\langle i, j \rangle} w_{i} \cdot w_{j}}_{\text{exchange}}"]


@pytest.mark.quick
def test_every_family_has_its_equation():
    """On Nambu leaves, with a strength, the other orientation, and a damping beside the energy."""
    spec = smidgen.load_text('''
[model]
name = "two"
orientation = -1
[space]
w = { sphere = 2, kappa = 3 }
f = { nambu = 1, C = "f.x^2 - f.y^2" }
[effects.pair]
over = "each(i of w, j of f)"
energy = "dot(w[i], f[j])"
[effects.bath]
over = "site(i) of w"
damping = 0.1
''')
    first, bath = equations(spec)
    assert first.startswith(r"\dot w_i = -\frac{1}{\kappa_i} w_i \times \frac{\partial H}{\partial w_i} + \dots, \quad "
                            r"\dot f_i = -\nabla C(f_i) \times \frac{\partial H}{\partial f_i}, \qquad H = ")
    assert bath == r"\text{bath: } \mathrm{damping} = 0.1"


CELLS = ("import smidgen", 'smidgen.load("point_vortices")', 'result = smidgen.run("point_vortices", steps=50)\nresult', 'result.plot("energy")', "result.play()",
         'smidgen.explain("point_vortices")', 'smidgen.advise("point_vortices")', 'smidgen.verify("free_rigid_body", tier="quick")',
         'smidgen.cost("free_rigid_body", methods=["spherical-midpoint"], long=False)', 'smidgen.average("heisenberg_chain", steps=20)',
         'smidgen.spectrum("heisenberg_chain", steps=64, every=1)')


@pytest.mark.long
def test_a_notebook_shows_every_object(tmp_path):
    """As its reader sees it: a picture or words of each, and nothing on the disk."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in CELLS])
    nbclient.NotebookClient(book, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    data = [output["data"] for cell in book.cells[1:] for output in cell["outputs"] if output["output_type"] == "execute_result"]
    assert len(data) == len(CELLS) - 1 and os.listdir(tmp_path) == []
    assert "$$" in data[0]["text/markdown"] and all("text/html" in one for one in data[1:])
    pictures = [n for n, one in enumerate(data) if "data:image/png" in one.get("text/html", "")]
    assert pictures == [1, 2, 7, 9]
