"""Where the data that travels with the code lies: in a wheel inside the package, in a
checkout beside it."""
from pathlib import Path

HERE = Path(__file__).resolve().parent


def folder(name: str) -> Path:
    """The folder `templates`, `runtime` or `specs`."""
    inside = HERE / name
    return inside if inside.is_dir() else HERE.parent / name
