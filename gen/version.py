"""The version: a module that imports nothing, for every stage."""
__version__ = "0.2.0"
