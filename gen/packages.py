"""Packages that smidgen does without until they are asked for."""
from __future__ import annotations

import importlib
from types import ModuleType

from .errors import MissingTool

EXTRAS = {"ase": "crystals", "scipy": "crystals", "h5py": "hdf5", "matplotlib": "pictures", "pandas": "data", "shtab": "completion", "xarray": "data"}    # package -> the extra that brings it


def needed(module: str, what: str) -> ModuleType:
    """The package, or a module of one, that `what` needs. Raises MissingTool, which says how to install it."""
    package = module.partition(".")[0]
    try:
        return importlib.import_module(module)
    except ImportError:
        raise MissingTool(f"{what} needs the package `{package}`: pip install 'smidgen[{EXTRAS[package]}]'") from None
