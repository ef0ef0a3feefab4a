"""Where the data that travels with the code lies: in a wheel inside the package, in a
checkout beside it."""
import re
from functools import cache
from pathlib import Path

# The floors of runtime/, from the lowest: no header includes one that lies above it, or that of another family of methods.
ROOMS = ("core", "newton", "lattice", "method/tables", "method/midpoint", "method/gauss", "method/explicit", "members")
NUMBER = re.compile(r"^[ \t]*#define (SMG_\w+) \(?(\d+)\b", re.MULTILINE)
HERE = Path(__file__).resolve().parent


def folder(name: str) -> Path:
    """The folder `templates`, `runtime` or `specs`."""
    inside = HERE / name
    return inside if inside.is_dir() else HERE.parent / name


def runtime_folders() -> list[Path]:
    """The folders of runtime/ whose headers generated C includes by name alone."""
    return [folder("runtime") / name for name in ROOMS]


def include_flags() -> list[str]:
    """`-I` for each of them."""
    return [f"-I{place}" for place in runtime_folders()]


def runtime_header(name: str) -> Path | None:
    """The file of a header of runtime/, whatever its folder; None where there is no such."""
    found = (place / name for place in runtime_folders())
    return next((path for path in found if path.is_file()), None)


@cache
def runtime_numbers() -> dict:
    """Macro of runtime/ -> the integers that headers define it as; of a product the first factor."""
    found: dict = {}
    for path in (p for place in runtime_folders() for p in sorted(place.glob("*.h"))):
        for name, value in NUMBER.findall(path.read_text()):
            found.setdefault(name, []).append(int(value))
    return found


def shipped() -> dict[str, Path]:
    """name -> path of every spec that comes with smidgen."""
    return {p.stem: p for p in sorted(folder("specs").glob("*.toml"))}


def scenes() -> dict[str, Path]:
    """name -> path of every scene that comes with smidgen: specs that use pieces, or build on another spec."""
    return {p.stem: p for p in sorted((folder("specs") / "scenes").glob("*.toml"))}


def pieces() -> dict[str, Path]:
    """name, such as spins/exchange -> path of every piece that comes with smidgen."""
    home = folder("specs") / "pieces"
    return {p.relative_to(home).with_suffix("").as_posix(): p for p in sorted(home.rglob("*.toml"))}
