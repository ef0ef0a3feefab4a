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
