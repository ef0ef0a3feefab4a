"""Scenes: specs that build on others. The files of a chain become one table, in which the nearest file counts.

    [scene]
    base = "film.toml"              # beside this file, or the name of a shipped spec
    effects = ["exchange", "bath"]  # these and nothing else; or
    without = ["pulse"]             # all but these

What is read afterwards is that table; its places lie in several files.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import PurePath

from ..language import limits
from ..language import codes
from .files import Files
from .marks import Mark
from .merge import Merge, merged
from .problems import Bad, Problems, nearest
from .recover import Aside
from .source import Source, Text
from .names import IDENTIFIER
from .pieces import Pieces
from .toml import document
from .tree import LOST, Node

KEYS = ("base", "name", "title", "effects", "without")


@dataclass(frozen=True)
class Scene:
    """The table of all files.

    aside: what could not be read; called: the effects that it calls for; known: all effects, each with the number of the farthest file
    that has it, 0 for the scene's own.
    """
    root: Node
    aside: Aside
    called: frozenset
    known: dict[str, int]

    @property
    def left_out(self) -> frozenset:
        return frozenset(self.known) - self.called

    def inherited(self, section: str) -> set[str]:
        """What stands in a section of a base, and not in the scene's own file."""
        problems = self.root.problems
        own = problems.sources.files[0]
        return {node.name for node in tables(self.root, section, all_kinds=True) if problems.sources.of(node.key.start) is not own}


def flat(problems: Problems, files: Files, sections) -> Scene:
    """The scene of the first file of `problems`. Raises Bad."""
    scene = level(problems.sources.files[0], problems, files, sections, ())
    drop(scene)
    Pieces(problems, files).expand(scene.root)
    for node in tables(scene.root, "runs"):
        if problems.tried(lambda run=node: alike(scene.root, run, ())) == [Bad]:
            scene.root.raw["runs"][node.name] = LOST
    return scene


def level(file: Source, problems: Problems, files: Files, sections, above: tuple) -> Scene:
    """One file over those that it builds on; above: the files that build on it."""
    root, aside = document(file, problems, sections)
    own = {node.name: len(above) for node in tables(root, "effects", all_kinds=True)}
    scene = Scene(root, aside, frozenset(own), own)
    if not root.has("scene"):
        return scene
    says = root.get("scene")
    says.table(*KEYS)
    if says.has("base"):
        scene = on_base(scene, base_of(says.get("base"), files, (*above, file)), problems, files, sections, (*above, file))
        named(scene.root, says, file)
    title(scene.root, says)
    scene.root.raw.pop("scene")
    return chosen(scene, says)


def base_of(node: Node, files: Files, above: tuple) -> Source:
    """The file that `base` names, as one more source."""
    name, folder, text = files.spec(node)
    if (name, folder) in ((file.name, file.folder) for file in above):
        node.wrong(codes.RECURSION, f"`{node.raw}` builds on this file, directly or through others", "bases must not refer to each other in a circle")
    if len(above) > limits.BASES:
        node.wrong(codes.LIMIT, f"a chain of more than {limits.BASES} bases", "merge some of them")
    return node.problems.sources.add(text, name, folder)


def on_base(own: Scene, base: Source, problems: Problems, files: Files, sections, above: tuple) -> Scene:
    far = level(base, problems, files, sections, above)
    aside = Aside(names=far.aside.names | own.aside.names)
    for node in tables(own.root, "runs"):       # a run like the one that it stands over
        if node.raw.get("like") == node.name and far.root.get("runs") and node.name in far.root.raw["runs"]:
            del node.raw["like"]
    return Scene(merged(far.root, own.root), aside, far.called | own.called, {**own.known, **far.known})


def tables(root: Node, section: str, all_kinds: bool = False) -> list[Node]:
    """The tables of a section."""
    found = root.get(section)
    nodes = list(found.items()) if found and isinstance(found.raw, dict) else []
    return [node for node in nodes if all_kinds or isinstance(node.raw, dict)]


# What [scene] says of the model and of the effects

def named(root: Node, says: Node, file: Source) -> None:
    """The model has the name that [scene] or its own [model] gives, else that of the file: its functions are not those of the base."""
    model, path = table_at(root, "model"), ("model", "name")
    if says.has("name"):
        model["name"], root.marks[path] = says.raw["name"], root.marks[("scene", "name")]
    elif "name" not in model or says.problems.sources.of(root.marks[path].key.start) is not file:
        stem, mark = PurePath(file.name).stem, says.get("base").marks[("scene", "base")]
        if not IDENTIFIER.match(stem):
            says.problems.fail(codes.MISSING, says.key, f"the name of the file, `{stem}`, cannot be the name of a model", 'give the model a name in [scene]: `name = "..."`')
        model["name"], root.marks[path] = stem, Mark(mark.key, mark.value, Text(stem, (mark.value.start,) * (len(stem) + 1)))


def title(root: Node, says: Node) -> None:
    if says.has("title"):
        table_at(root, "model")["title"], root.marks[("model", "title")] = says.raw["title"], root.marks[("scene", "title")]


def table_at(root: Node, section: str) -> dict:
    """A section of the root, made where it is not there."""
    table = root.raw.setdefault(section, {})
    return table if isinstance(table, dict) else {}


def chosen(scene: Scene, says: Node) -> Scene:
    """The scene with the effects that [scene] calls for."""
    called = frozenset(effect_names(scene, says.get("effects"))) if says.has("effects") else scene.called
    called -= frozenset(effect_names(scene, says.get("without"))) if says.has("without") else frozenset()
    if scene.known and not called:
        (says.get("effects") or says.get("without") or says).wrong(codes.MISSING, "this scene selects no effect", "add at least one energy")
    return replace(scene, called=called)


def effect_names(scene: Scene, node: Node) -> list[str]:
    """A list of effects of the scene or of its bases."""
    names = []
    for entry in node.entries("list of effects"):
        if entry.string() not in scene.known.keys() | scene.aside.names:
            entry.wrong(codes.UNKNOWN_NAME, f"there is no effect `{entry.raw}`", nearest(entry.raw, scene.known))
        names.append(entry.raw)
    return names


def drop(scene: Scene) -> None:
    """Take out of the table what the scene does not call for."""
    for name in scene.left_out:
        scene.root.raw["effects"].pop(name, None)


# Runs that are like others

def alike(root: Node, node: Node, above: tuple) -> None:
    """`like = "demo"`: the run is that run, but for what it says itself."""
    if "like" not in node.raw:
        return
    far = other_run(root, node, above)
    alike(root, far, (*above, node.name))
    mine = {key: value for key, value in node.raw.items() if key != "like"}
    theirs = {key: value for key, value in root.raw["runs"][far.name].items() if key != "meaning"}
    moved = {node.path + path[2:]: mark for path, mark in root.marks.items() if path[:2] == far.path}
    merge = Merge(moved, dict(root.marks))
    root.raw["runs"][node.name] = merge.over(theirs, mine, node.path)
    root.marks.update(merge.marks)


def other_run(root: Node, node: Node, above: tuple) -> Node:
    """The run that `like` names."""
    like, runs = node.get("like"), [run.name for run in tables(root, "runs")]
    word = like.string()
    if word in (*above, node.name):
        like.wrong(codes.RECURSION, f"`{word}` refers to itself with `like`, directly or through other runs", "name a run without `like`")
    if word not in runs:
        like.wrong(codes.UNKNOWN_NAME, f"there is no run `{word}`", nearest(word, set(runs) - {node.name}))
    return root.get("runs").get(word)
