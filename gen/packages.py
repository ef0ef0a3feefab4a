"""Packages that smidgen does without until they are asked for."""
from __future__ import annotations

import importlib
from types import ModuleType

from .errors import MissingTool

EXTRAS = {"ase.io": "crystals", "scipy.sparse": "crystals", "scipy.io": "crystals", "h5py": "hdf5", "matplotlib": "pictures", "pandas": "data", "shtab": "completion", "xarray": "data"}    # package -> the extra that brings it


def needed(package: str, what: str) -> ModuleType:
    """The package that `what` needs. Raises MissingTool, which says how to install it."""
    try:
        return importlib.import_module(package)
    except ImportError:
        raise MissingTool(f"{what} needs the package `{package}`: pip install 'smidgen[{EXTRAS[package]}]'") from None
