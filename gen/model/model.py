"""A model gathered in Python."""
from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import sympy
import tomli_w

from .. import read
from ..errors import UsageError
from ..language.spec import Spec
from ..public import public
from .crystals import edges_of, lattice_of, loaded, shells_within
from .text import formula
from .vectors import Indexed, Vector, function, vec

INLINE = 1000       # entries of an array that stand in the text; more of them go to a file beside it


class Model:
    """A spec written in Python instead of TOML.

        model = smidgen.Model("ring", title="Spins on a ring")
        n, J = model.parameter("n", 8), model.parameter("J", 1.0)
        w = model.sphere("w", n)
        i, j = model.indices("i j")
        model.energy("exchange", "bond(i, j) of chain(n, periodic)", -J*w[i].dot(w[j]))
        model.start("random", random=1)
        model.run("demo", start="random", h=0.1, steps=100)
        result = smidgen.run(model)

    A formula is a string in the spec language, a number, or a sympy expression in the objects returned by `parameter`, `indices` and the
    families. Formulas are checked when the model is first used: by `spec()`, or by any function of smidgen that takes the model in place
    of a spec.
    """

    def __init__(self, name: str, *, title: str = "", orientation: int | None = None):
        """orientation: of w' = o w x grad H: 1 (the default of specs) or -1."""
        head = {"name": name, "title": title, "orientation": orientation}
        self._tables = {"model": {key: value for key, value in head.items() if value not in ("", None)}}
        self._arrays = {}

    def __repr__(self) -> str:
        return f"<Model {self._tables['model']['name']}: {', '.join(f'{len(table)} in [{name}]' for name, table in self._tables.items() if name != 'model') or 'empty'}>"

    # -- what is named in formulas --------------------------------------------------------------
    @public
    def parameter(self, name: str, default, *, size=None, unit: str = "", meaning: str = "", fixed: bool = False, vector: bool | None = None):
        """Declare a parameter and return an object that represents it in formulas: a symbol, a vector, or, for an array, something to
        index, `K[i]`.

        :param default: an int, a float, a string with a unit ("1.5 meV"), or an array of shape (size,) for numbers or (size, 3) for
            vectors.
        :param size: the length of an array, as a formula of integer parameters. With a single number as default, every entry has that
            value.
        :param vector: whether the entries are vectors; needed for a single vector, of shape (3,).
        :raises UsageError: for an array of another shape, or a name that is already in use.
        """
        says = {key: value for key, value in (("unit", unit), ("meaning", meaning)) if value} | ({"fixed": True} if fixed else {})
        if np.ndim(default) == 0:
            self._add("parameters", name, {"default": plain(default), **({} if size is None else {"size": counted(size)}), **says})
            return sympy.Symbol(name, real=True) if size is None else Indexed(name, False)
        rows = np.asarray(default, float)
        vectors = rows.ndim == 2 if vector is None else vector
        if rows.shape[1:] != ((3,) if vectors and rows.ndim == 2 else ()) or vectors and rows.ndim == 1 and rows.shape != (3,):
            raise UsageError(f"parameter '{name}' has the shape {rows.shape}; an array must have (size,), an array of vectors (size, 3), a vector (3,)")
        several = not (vectors and rows.ndim == 1)
        self._add("parameters", name, {"default": rows, **({"size": len(rows) if size is None else counted(size)} if several else {}), **({"vector": True} if vectors else {}), **says})
        return Indexed(name, vectors) if several else Vector(sympy.Symbol(name, real=True))

    def indices(self, names: str) -> tuple:
        """Symbols for bound indices: `i, j = model.indices("i j")`. For a single name the symbol itself is returned, not a tuple."""
        return sympy.symbols(names, integer=True)

    @staticmethod
    def call(name: str, *arguments):
        """Call a function of the spec language that sympy does not have: `model.call("uniform", 7, i)`, `model.call("triple", w[i], w[j],
        w[k])`.
        """
        return function(name, *arguments)

    @staticmethod
    def vec(x, y, z) -> Vector:
        """A vector with these three components."""
        return vec(x, y, z)

    @property
    def t(self):
        """The time t, for effects and observables."""
        return sympy.Symbol("t", real=True)

    def sphere(self, name: str, count=1, **says):
        """Declare a family of unit vectors and return an object that represents them in formulas, `w[i]`.

        :param count: the number of vectors: an int, or a formula of integer parameters.
        :param says: further keys of a family in `[space]`: `kappa`, `radius`, `tracer`, `fixed`.
        """
        return self._family("sphere", name, count, says)

    def r3(self, name: str, count=1, **says):
        """Declare a family of vectors of R^3, each of which keeps its length. The arguments are those of `sphere`."""
        return self._family("r3", name, count, says)

    def nambu(self, name: str, count=1, *, C, **says):
        """Declare a single vector of R^3 that obeys w' = grad C x grad H; C is a formula of the vector, as a string. Otherwise like
        `sphere`.
        """
        return self._family("nambu", name, count, {"C": C, **says})

    def _family(self, kind, name, count, says):
        self._add("space", name, {kind: counted(count), **{key: plain(value) for key, value in says.items()}})
        return Indexed(name, True)

    # -- what is said of them -------------------------------------------------------------------
    def energy(self, name: str, over: str, value, **says) -> None:
        """Add an energy for each term of `over`, such as "site(i) of w" or "bond(i, j) of chain(n)"."""
        self.effect(name, over=over, energy=value, **says)

    def effect(self, name: str, **says) -> None:
        """Add an effect of any kind, with the keys of an `[effects]` section: `damping=0.1`, `torque=...`, `use="spins/exchange"`."""
        self._add("effects", name, {key: plain(value) for key, value in says.items()})

    def observable(self, name: str, over: str, value, **says) -> None:
        """Add an observable: a sum over the terms of `over`. Optional keys: `meaning`, `unit`."""
        self._add("observables", name, {"over": over, "value": plain(value), **says})

    def formula(self, name: str, value) -> None:
        """Add a formula that other formulas may refer to by name."""
        self._add("formulas", name, formula(value))

    def lattice(self, name: str, **says) -> None:
        """Add a lattice, with the keys of a `[lattices]` section."""
        self._add("lattices", name, {key: plain(value) for key, value in says.items()})

    @public
    def graph(self, name: str, couplings, positions=None) -> None:
        """Add a graph, for `edge(i, j, J) of name`.

        :param couplings: a square matrix (dense or scipy.sparse) whose entries J_ij couple sites i and j; an array of rows i, j, J; or the
            path of a matrix file (.npz of scipy.sparse, .mtx or .npy). A symmetric matrix gives each pair once.
        :param positions: the positions of the sites, shape (sites, 2) or (sites, 3).
        :raises UsageError: if a matrix is not square, is neither symmetric nor triangular, or couples a site to itself.
        """
        says = {} if positions is None else {"positions": np.asarray(positions, float).tolist()}
        self._add("graphs", name, {"edges": edges_of(name, loaded(couplings)), **says})

    @public
    def crystal(self, name: str, atoms, size, couplings=(), *, cutoff: float | None = None, elements=None, family: str = "w"):
        """Add unit vectors on the atoms of a crystal, with exchange for each shell of neighbours, E = -J w_i.w_j; return what represents
        the vectors.

        :param atoms: an `ase.Atoms`, or the path of a file that ASE reads, such as a .cif. Directions that are not periodic in it are
            open.
        :param size: the number of cells in each direction.
        :param couplings: J of the first shell, the second, and so on.
        :param cutoff: the largest distance of neighbours, in the unit of length of the atoms.
        :param elements: the elements that carry a vector; by default all.
        :raises UsageError: if the atoms cannot be read or do not have these shells.

        The lattice is called `name`, and the effects `NAME_first`, `NAME_second`, ...
        """
        says = lattice_of(name, atoms, elements)
        cells = [counted(n) for n in size]
        shells = shells_within(name, says, cells, couplings, cutoff) if len(couplings) else {}
        self.lattice(name, size=cells, **says)
        vectors = self.sphere(family, name)
        for shell, J in shells.items():
            self.effect(f"{name}_{shell}", over=f"bond(i, j) of {name}.{shell}", energy=f"-({plain(J)})*dot({family}[i], {family}[j])")
        return vectors

    def start(self, name: str, family: str | None = None, **says) -> None:
        """Add a start, given by one of: `vectors=array` of shape (count, 3); `theta=..., phi=...`; `x=..., y=..., z=...`; `random=seed`.

        :param family: the family that it is for, if there are several.
        """
        table = self._tables.setdefault("starts", {})
        says = {key: value if isinstance(value, np.ndarray) else plain(value) for key, value in says.items()}
        if family is None:
            return self._add("starts", name, says)
        if family in table.setdefault(name, {}):
            raise UsageError(f"there is already a start '{name}' of {family}")
        table[name][family] = says

    def run(self, name: str, **says) -> None:
        """Add a run, with the keys of a `[runs]` section: `start`, `h`, `time` or `steps`, `method`, `output={...}`."""
        self._add("runs", name, {key: plain(value) for key, value in says.items()})

    def units(self, **says) -> None:
        """Declare units, with the keys of the `[units]` section."""
        self._tables.setdefault("units", {}).update({key: plain(value) for key, value in says.items()})

    def _add(self, table, name, value):
        found = self._tables.setdefault(table, {})
        if name in found:
            raise UsageError(f"[{table}] of this model already has '{name}'")
        found[name] = value

    # -- what becomes of it ---------------------------------------------------------------------
    def spec(self) -> Spec:
        """The model as a Spec.

        :raises SpecError: if it has errors; their lines refer to the text returned by `to_toml`.
        """
        if not self.outside() and not self.outside("graphs", "edges"):
            return read.load_text(self.to_toml())
        with tempfile.TemporaryDirectory(prefix="smidgen-model-") as folder:
            return read.load(self.save(Path(folder) / f"{self._tables['model']['name']}.toml"))

    def to_toml(self) -> str:
        """The text of the spec.

        :raises UsageError: if an array has more than 1000 numbers; `save` writes such arrays to files.
        """
        large = [*self.outside(), *self.outside("graphs", "edges")]
        if large:
            raise UsageError(f"{', '.join(large)}: an array of more than {INLINE} numbers must be in a separate file; use save(path)")
        return tomli_w.dumps(inlined(self._tables))

    def save(self, path: str | os.PathLike) -> Path:
        """Write the spec to a file, and each large array to NAME.npy in the same folder; return the path of the spec."""
        path, tables = Path(path), inlined(self._tables)
        for name, rows in self.outside("graphs", "edges").items():
            np.savetxt(path.with_name(f"{path.stem}_{name}.csv"), rows, "%.17g", delimiter=",", header="i,j,J", comments="")
            tables["graphs"][name] = {"file": f"{path.stem}_{name}.csv", **{key: value for key, value in self._tables["graphs"][name].items() if key != "edges"}}
        for name, rows in self.outside().items():
            np.save(path.with_name(f"{path.stem}_{name}.npy"), rows, allow_pickle=False)
            says = self._tables["parameters"][name]
            tables["parameters"][name] = {"file": f"{path.stem}_{name}.npy", **{key: value for key, value in says.items() if key != "default"}}
        path.write_text(tomli_w.dumps(tables), encoding="utf-8")
        return path

    def outside(self, table: str = "parameters", key: str = "default") -> dict:
        """The arrays that `save` writes to files, by name: parameters, and edges of graphs."""
        arrays = {name: says[key] for name, says in self._tables.get(table, {}).items()}
        return {name: rows for name, rows in arrays.items() if isinstance(rows, np.ndarray) and rows.size > INLINE}


def counted(count):
    """A number of sites: an int, or the text of a formula."""
    return int(count) if isinstance(count, (int, np.integer)) else formula(count)


def plain(value):
    """What TOML can hold: tables and lists of texts, numbers and truths; expressions become texts."""
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    return value if isinstance(value, (str, bool, int, float)) else formula(value)


def inlined(tables: dict) -> dict:
    """A copy in which arrays are lists."""
    return {key: inlined(value) if isinstance(value, dict) else value.tolist() if isinstance(value, np.ndarray) else value for key, value in tables.items()}
