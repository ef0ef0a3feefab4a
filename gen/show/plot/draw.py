"""`plot`: from a result, a result's file or a spec to a picture file."""
from __future__ import annotations

import difflib
from pathlib import Path

from ...errors import UsageError
from .facts import with_facts
from .film import is_film, write_film, writer_for
from .part import part_of
from .pictures import KINDS, drawable, film_parts, kinds, suitable
from .style import FORMATS, fit_titles, resized, save, styled


def plot(source, run: str | None = None, *, kind: str = "auto", out=None, part=None, width=None, chose=lambda kind: None) -> Path:
    """The path of the picture; `smidgen.plot` says what the arguments mean. chose: called with the kind that "auto" has become."""
    wanted(kind, out)
    piece = part_of(part)
    if is_film(out):
        return filmed(source, run, kind, Path(out), piece, width)
    result = shown(result_of(source, run))
    chosen = kind if kind != "auto" else "places" if piece else suitable(result, is_page(out))
    if kind == "auto" and chosen != "player":
        chose(chosen)
    path = Path(out) if out is not None else default_path(result, chosen)
    check_pair(chosen, path)
    if piece and chosen != "places":
        raise UsageError(f"a part can be drawn with the kind 'places' and in films, not with '{chosen}'")
    if width is not None and chosen == "player":
        raise UsageError("the player adapts to the size of its window: omit the width")
    picture = styled(KINDS[chosen][0])(result, **({"part": piece} if piece else {}))
    return write_page(picture, path) if chosen == "player" else save(resized(picture, width), path, exact=width is not None)


def filmed(source, run, kind: str, path: Path, piece: dict, width: float | None) -> Path:
    """A film; whether it can be written is asked before anything is run."""
    if kind not in ("auto", "places", "sphere"):
        raise UsageError(f"a film ({path.suffix}) shows a lattice or spheres, not '{kind}': omit --kind")
    writer_for(path)
    result = shown(result_of(source, run))
    picture, draw_frame, frames = styled(film_parts)(result, piece)
    return write_film(resized(picture, width), draw_frame, frames, path)


def shown(result):
    """What of a result can be drawn. Raises UsageError when nothing can."""
    if len(result.t) == 0:
        raise UsageError("there is nothing to draw: the result contains no outputs")
    return drawable(result)


def figure(result, kind: str = "auto"):
    """The picture of a result as a figure. Raises UsageError for a kind that is none, or that a result has not."""
    wanted(kind, None)
    result = shown(with_facts(result))
    chosen = suitable(result, False) if kind == "auto" else kind
    if chosen == "player":
        raise UsageError("the player is an HTML page, not a picture: use result.play()")
    return fit_titles(styled(KINDS[chosen][0])(result))


def page(result) -> str:
    """The player of a result, as HTML text. Raises UsageError for one that cannot be drawn."""
    return styled(KINDS["player"][0])(shown(with_facts(result)))


def wanted(kind: str, out) -> None:
    """Refuse a wrong kind or ending before anything is run."""
    if kind not in kinds():
        close = difflib.get_close_matches(kind, kinds(), 1)
        hint = f"; did you mean '{close[0]}'?" if close else ""
        raise UsageError(f"there is no kind of picture '{kind}'{hint} There are: {', '.join(kinds())}"
                         if hint else f"there is no kind of picture '{kind}'; there are: {', '.join(kinds())}")
    if out is not None and kind != "auto" and not is_film(out):
        check_pair(kind, Path(out))
    elif out is not None and not is_page(out) and not is_film(out):
        check_ending(Path(out))


def is_page(out) -> bool:
    return out is not None and Path(out).suffix.lower() in (".html", ".htm")


def check_pair(kind: str, path: Path) -> None:
    """Only the player is a page, and it is nothing else."""
    if (kind == "player") != is_page(path):
        raise UsageError(f"the kind 'player' is written to .html, not '{path.name}'"
                         if kind == "player" else
                         f"the kind '{kind}' is a picture ({', '.join('.' + f for f in FORMATS)}); "
                         "only 'player' is written to .html")
    if kind != "player":
        check_ending(path)


def check_ending(path: Path) -> None:
    if path.suffix.lower().lstrip(".") not in FORMATS:
        raise UsageError(f"cannot draw into '{path.name}': the name must end in one of "
                         + ", ".join("." + f for f in FORMATS) + ", or .html for the player, .gif or .mp4 for a film")


def result_of(source, run: str | None):
    """The Result that `source` means; a spec is run for it. Raises UsageError for a run of what is a result."""
    from ...run.files.output import FORMATS as RESULTS, load_result
    given = hasattr(source, "values") and hasattr(source, "t")
    if given or not hasattr(source, "families") and Path(source).suffix in RESULTS:
        if run is not None:
            hint = "" if not isinstance(run, str) else f": to name the picture, use --out {run}" if Path(run).suffix else f": to choose the kind of picture, use --kind {run}, or kind='{run}'" if run in kinds() else ""
            raise UsageError(f"a result contains a single run; '{run}' cannot select another{hint}")
        return with_facts(source if given else load_result(source))
    from ...run.run import run as run_spec
    spec = loaded(source)
    return with_facts(run_spec(spec, run, what=outputs_for(spec)))


def loaded(source):
    """A Spec from a path, a name or a Spec."""
    if hasattr(source, "families"):
        return source
    from ...read.shipped import load_spec
    return load_spec(str(source))


def outputs_for(spec) -> list[str]:
    """All that a picture may need."""
    return ["states", "energy", "momentum", "casimirs", *(o.name for o in spec.observables)]


def default_path(result, kind: str) -> Path:
    """<spec>_<kind>.png or .html in the present directory."""
    name = "".join(c for c in str(result.meta.get("spec", "result")) if c.isalnum() or c in "_-")
    return Path(f"{name or 'result'}_{kind}.{'html' if kind == 'player' else 'png'}")


def write_page(text: str, path: Path) -> Path:
    """Write HTML. Raises UsageError where it cannot be written."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as e:
        raise UsageError(f"cannot write '{path}': {e.strerror or e}") from None
    return path
