"""Which folder holds which package: the sources live in gen/, their data beside it."""
from setuptools import find_namespace_packages, setup

DATA = ("templates", "runtime", "specs")
CODE = [f"smidgen.{name}" for name in find_namespace_packages("gen", exclude=["*__pycache__*"])]

setup(
    packages=["smidgen", *CODE, *(f"smidgen.{name}" for name in DATA)],
    package_dir={"smidgen": "gen", **{f"smidgen.{name}": name for name in DATA}},
    package_data={"": ["*"], **{f"smidgen.{name}": ["**/*"] for name in DATA}},
)
