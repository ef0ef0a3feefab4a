"""`plot --width` and `--open`."""
import webbrowser

import pytest
from PIL import Image

from smidgen.cli import main
from smidgen.errors import UsageError
from smidgen.show.plot import draw, style


@pytest.fixture(scope="module")
def top():
    import smidgen
    return smidgen.run("free_rigid_body", steps=40, what=["states", "energy"])


@pytest.mark.quick
@pytest.mark.parametrize("kind", ["energy", "sphere"])
def test_a_picture_has_the_width_asked_for(top, tmp_path, kind):
    inches = []
    for width in (3, 6):
        with Image.open(draw.plot(top, kind=kind, out=tmp_path / f"{width}.png", width=width)) as picture:
            inches.append(picture.width / style.STYLE["savefig.dpi"])
    assert inches == pytest.approx([3, 6], abs=0.02)


DRIVEN = """[model]
name = "driven"
title = "A top whose third moment of inertia is modulated, with a title that is longer than the picture is wide"
[space]
w = { r3 = 1 }
[parameters]
eps = 0.2
[effects.body]
energy = "w.x^2/2 + w.y^2/3.4 + w.z^2/(5.8*(1 + eps*cos(2*t)))"
[starts.first]
vectors = [[0.05, 1.2, 0.1]]
"""


@pytest.fixture(scope="module")
def driven():
    import smidgen
    return smidgen.run(smidgen.load_text(DRIVEN), h=0.05, steps=40, what=["states", "energy"])


@pytest.mark.quick
@pytest.mark.parametrize("kind, inches", [("energy", 6.4), ("sphere", 4.6), ("components", 6.4)])
def test_a_long_title_does_not_widen_a_picture(driven, tmp_path, kind, inches):
    with Image.open(draw.plot(driven, kind=kind, out=tmp_path / "a.png")) as picture:
        assert picture.width / style.STYLE["savefig.dpi"] < inches + 0.25


@pytest.mark.quick
def test_the_energy_that_is_not_conserved_is_drawn_without_its_logarithm(driven, top):
    one, two = draw.figure(driven, "energy"), draw.figure(top, "energy")
    assert [ax.get_yscale() for ax in one.axes] == ["linear"] and [ax.get_yscale() for ax in two.axes] == ["linear", "symlog"]
    assert "H may depend on time: its formula contains t" in " ".join(one.axes[0].get_title("left").split())


@pytest.mark.quick
def test_starts_and_ends_are_marked_on_the_sphere(top):
    figure = draw.figure(top, "sphere")
    marks = [mark for mark in figure.axes[0].collections if len(mark.get_offsets())]
    assert figure._supxlabel.get_text().split() == "rings: start; discs: end; pale: behind the sphere".split()
    assert len(marks) == 2 and sum(tuple(mark.get_facecolor()[0][:3]) == (1, 1, 1) or mark.get_facecolor()[0][:3].min() > 0.9 for mark in marks) == 1


@pytest.mark.quick
@pytest.mark.parametrize("out, width, reason", [("a.png", 0, "inches wide"), ("a.png", 41, "inches wide"), ("a.png", float("nan"), "inches wide"), ("a.html", 3, "adapts")])
def test_a_width_that_cannot_be_is_refused(top, tmp_path, out, width, reason):
    with pytest.raises(UsageError, match=reason):
        draw.plot(top, out=tmp_path / out, width=width)


@pytest.mark.quick
def test_a_picture_is_opened_on_request(tmp_path, monkeypatch, capsys):
    seen = []
    monkeypatch.setattr(webbrowser, "open", lambda place: seen.append(place) or len(seen) == 1)
    words = ["plot", "free_rigid_body", "--kind", "energy", "--out", str(tmp_path / "a.png")]
    assert main(words) == 0 and seen == []
    assert main([*words, "--open"]) == 0 and seen == [(tmp_path / "a.png").as_uri()]
    assert "no browser" not in capsys.readouterr().err
    assert main([*words, "--open"]) == 0 and "no browser" in capsys.readouterr().err
