"""Random scenes: a spec of `fuzz.layouts` with effects by pieces and tables in files, cut into a scene and the files that it builds on.

    text = scene_text(random.Random(7))

The text is that of the scene; its comments hold the other files (`# file: base1.toml`) and, as `whole.toml`, the same spec written as one:
its C must be that of the scene, byte for byte. What stands in the whole is on every level in its place, but that a base may say something else,
which a nearer file mends, and that bases have effects, parameters and families that the scene does not call for.
"""
from __future__ import annotations

import copy
import json
import random
import re
import tomllib

from smidgen.errors import SpecError

from .differential import read
from .invent import WHOLE, files_of
from .layouts import responding, spec_text
from .pieces import DAMPED, HELD, MOVING, OF_SITES, ON_BONDS, drawn, own

HEAD = re.compile(r"^# (?:layout|build|features|define): .*\n", re.MULTILINE)
INLINE = ("scene", "model", "space", "parameters", "formulas")      # sections whose entries are lines, not tables


def scene_text(dice) -> str:
    text = spec_text(dice)
    whole, files = tomllib.loads(text), files_of(text)
    said = enriched(dice, text, whole, files)
    if "absent" in written(whole) and nobody_left(written(whole), files):
        return scene_text(dice)
    levels = cut(dice, whole, said)
    return headed(text, whole) + bundle(dice, levels, files | {WHOLE: written(whole)})


def nobody_left(text, files) -> bool:
    """Are all sites absent? That is refused, as it should be (tests/bad)."""
    try:
        read(text, files)
    except SpecError as refusal:
        return "every site is absent" in str(refusal)
    return False


def headed(text, whole) -> str:
    """The comments on how to build it; at a temperature there is no tangent map."""
    head = "".join(HEAD.findall(text))
    return re.sub(r"(# features: .*)tangent ?", r"\1", head) if any("kT" in e for e in whole["effects"].values()) else head


# What a scene has beside the spec that it comes from

def enriched(dice, text, whole, files) -> dict:
    """Adds to the whole spec; the same spec in the words of a scene: with pieces, and arrays in files."""
    families = responding(text)
    said = {}
    whole["parameters"]["s_k"] = {"default": 0.3, **({"fixed": True} if dice.randint(0, 1) else {})}
    for name in families:
        for kind, share in ((OF_SITES, 2), (ON_BONDS, 3), (MOVING, 3), (DAMPED, 3), (HELD, 4)):
            if dice.randint(0, share) == 0:
                add_piece(dice, whole, said, name, kind)
    named_all(whole)
    for name, effect in whole["effects"].items():
        if name not in said and dice.randint(0, 2) == 0:
            words, files_text = own(dice, effect)
            files[f"mine/{name}.toml"] = files_text
            said[name] = {"use": f"mine/{name}", **words}
    if any("kT" in e for e in whole["effects"].values()):
        whole["runs"]["fuzz"]["h"] = abs(whole["runs"]["fuzz"]["h"])
    given = copy.deepcopy(whole)
    given["effects"] = {name: said.get(name, effect) for name, effect in given["effects"].items()}
    given["parameters"] = {name: in_file(dice, name, p, files) for name, p in given["parameters"].items()}
    return given


def add_piece(dice, whole, said, family, kind):
    """One more effect on a family; there is one damping at most, and that of a piece on spheres, since its form is Gilbert's unless another is given."""
    space = whole["space"][family]
    if kind is DAMPED and ("sphere" not in space or any("damping" in e for e in whole["effects"].values())):
        return
    count = next(space[k] for k in ("sphere", "r3") if k in space)
    name = f"p{len(said)}"
    said[name], whole["effects"][name] = drawn(dice, kind, family, str(count))
    run = whole["runs"]["fuzz"]
    if "effects" in run:
        run["effects"].append(name)


def named_all(whole):
    """Every family is named by an effect: a scene that leaves something out has no others."""
    terms = " ".join(f"{v} " for e in whole["effects"].values() for v in e.values() if isinstance(v, str))
    for k, name in enumerate(whole["space"]):
        if not re.search(rf"(?<![.\w]){name}\b", terms):
            whole["effects"][f"keep{k}"] = {"over": f"site(i) of {name}", "energy": f"0.3*{name}[i].x"}


def in_file(dice, name, parameter, files):
    """An array with its numbers in a file, sometimes."""
    if not isinstance(parameter, dict) or not isinstance(parameter.get("default"), list) or "size" not in parameter or dice.randint(0, 1):
        return parameter
    place = f"{dice.choice(('', 'tables/'))}{name}.{dice.choice(('csv', 'npy'))}"
    files[place] = "\n".join(map(repr, parameter["default"])) + "\n"
    return {"file": place, **{k: v for k, v in parameter.items() if k != "default"}}


# Levels: tables, the scene's first

def cut(dice, whole, said) -> list[dict]:
    """The spec on several levels, whose merge it is."""
    levels = [{} for _ in range(dice.choice((2, 2, 3, 4)))]
    for section, table in said.items():
        places = sorted((dice.randrange(len(levels)) for _ in table), reverse=True)      # what comes first is farthest, so the order stays
        for (name, value), place in zip(table.items(), places):
            put(dice, levels, place, section, name, value)
    run = said["runs"]["fuzz"]
    for level in levels:
        level.get("runs", {}).get("fuzz", {}).pop("effects", None)
    if "effects" in run:
        levels[0].setdefault("runs", {}).setdefault("fuzz", {})["effects"] = run["effects"]
    model = levels[0].pop("model", {})
    levels[-1].setdefault("model", {}).setdefault("name", "random_base")
    levels[0]["scene"] = {"name": "random_model"}
    if "orientation" in model:
        levels[0]["model"] = {"orientation": model["orientation"]}
    idle(dice, levels, whole)
    calls(dice, levels, list(said["effects"]))
    return levels


def put(dice, levels, place, section, name, value):
    """One entry at its place; sometimes with something else there, which a nearer level mends."""
    if section == "model" and name == "name":
        return
    far = levels[place].setdefault(section, {})
    far[name] = copy.deepcopy(value)
    if place and dice.randint(0, 2) == 0:
        wrong, right = other(dice, section, value)
        if right is not None:
            far[name] = wrong
            levels[dice.randrange(place)].setdefault(section, {})[name] = right


def other(dice, section, value):
    """(what a base says in the place of a value, what a nearer file says to mend it); (.., None) where there is nothing to change."""
    if section == "effects" and "energy" in value and "use" not in value and dice.randint(0, 1):
        return {**{k: v for k, v in value.items() if k != "energy"}, "damping": 0.3}, {"energy": value["energy"]}
    if section == "starts" and isinstance(value, dict) and not any(isinstance(v, dict) for v in value.values()) and dice.randint(0, 1):
        return ({"theta": 0.3, "phi": 1} if "random" in value else {"random": 3}), value
    if not isinstance(value, dict):
        wrong = garbled(value)
        return wrong, None if wrong is None else value
    keys = [k for k, v in value.items() if garbled(v) is not None and k not in ("over", "use", "on", "size", "file", "bonds", "boundary", "sites", "method", "solver", "start")]
    if not keys:
        return value, None
    key = dice.choice(keys)
    short = section == "parameters" and key == "default" and not isinstance(value[key], list) and dice.randint(0, 1)
    return {**value, key: garbled(value[key])}, value[key] if short else {key: value[key]}


def garbled(value):
    """Another value of the same kind; None where there is none at hand."""
    if isinstance(value, bool) or isinstance(value, (dict, list)):
        return None
    return 2 * value + 1 if isinstance(value, (int, float)) else f"0.5*({value})" if re.search(r"[*+]", value) else None


def idle(dice, levels, whole):
    """Effects of bases that the scene does without, with a parameter and a family of their own."""
    known = whole["space"]
    plain = [f for f, says in known.items() if not says.get("tracer") and "nambu" not in says]
    joined = all(re.search(r" on \w+$|of \w+\)?$", e.get("over", " on w")) for e in whole["effects"].values())
    for k in range(dice.choice((0, 1, 1, 2, 3)) if plain else 0):
        level, family = levels[dice.randrange(1, len(levels))], dice.choice(plain)
        level.setdefault("parameters", {})[f"idle{k}"] = 0.7
        effect = dice.choice(({"energy": f"idle{k}*{family}[i].y"}, {"damping": f"idle{k}"}, {"torque": f"cross({family}[i], vec(idle{k}, 0, 1))"},
                              {"pinned": f"i < 2*idle{k}"}, {"absent": f"uniform(3, i) < idle{k}"}, {"energy": f"idle{k}*{family}[i].x^2*cos(t)"}))
        level.setdefault("effects", {})[f"idle{k}"] = {"over": f"site(i) of {family}", **effect}
        if joined and len(known) > 1 and dice.randint(0, 1):
            level.setdefault("space", {})["gone"] = {"sphere": 3}
            level["effects"][f"idle{k}"] = {"over": f"each(i of {family}, j of gone)", "energy": f"idle{k}*dot({family}[i], gone[j])"}
            level.setdefault("starts", {}).setdefault("s", {})["gone"] = {"random": 1}


def calls(dice, levels, wanted):
    """On each level [scene] says what it calls for, so that in the end it is what is wanted."""
    called, known = [], []
    for depth, level in reversed(list(enumerate(levels))):
        mine = list(level.get("effects", {}))
        called, known = [*called, *(n for n in mine if n not in called)], [*known, *(n for n in mine if n not in known)]
        idle = [n for n in called if n not in wanted]
        if depth == len(levels) - 1:
            continue
        says, have = level.setdefault("scene", {}), [n for n in known if n in wanted]
        if depth == 0 and set(have) - set(called) or have and dice.randint(0, 3) == 0:
            says["effects"], called = have, have
        elif idle and set(called) - set(idle) and (depth == 0 or dice.randint(0, 1)):
            says["without"], called = idle, [n for n in called if n not in idle]
        elif len(have) > 1 and depth and dice.randint(0, 4) == 0 and len(set(called)) > 1:
            says["without"] = called[:1]
            called = called[1:]


# Files

def bundle(dice, levels, files) -> str:
    """The text of the nearest level, with all others in comments before it, each in a folder where it is found."""
    folders, names, texts = [""], ["model.toml"], {}
    for depth in range(1, len(levels)):
        library = dice.randint(0, 5) == 0
        folder = "library/" if library else folders[-1] + dice.choice(("", "", f"below{depth}/"))
        name = f"base{depth}.toml"
        levels[depth - 1].setdefault("scene", {})["base"] = name[:-5] if library else (folder + name)[len(folders[-1]):] if folder.startswith(folders[-1]) else name[:-5]
        folders.append(folder)
        names.append(folder + name)
    for level, folder, name in zip(levels, folders, names):
        level.setdefault("scene", {}).setdefault("name", "random_model") if level.get("scene") else level.pop("scene", None)
        texts[name] = written(dict(sorted(level.items(), key=lambda item: item[0] != "scene")))
    nearest = texts.pop("model.toml")
    for name, content in files.items():
        for place in {""} | placed(levels, folders, name):
            texts[place + name] = content
    return "".join(commented(name, content) for name, content in texts.items()) + nearest


def placed(levels, folders, name) -> set:
    """The folders of the levels that name a file."""
    stem = name.removesuffix(".toml")
    return {folder for level, folder in zip(levels, folders) if f'"{name}"' in json.dumps(level) or f'"{stem}"' in json.dumps(level)}


def commented(name, content) -> str:
    return f"# file: {name}\n" + "".join(f"# {line}\n" for line in content.splitlines()) + "\n"


def written(spec) -> str:
    """TOML of a table of tables."""
    parts = []
    for section, table in spec.items():
        if section in INLINE:
            parts.append("\n".join([f"[{section}]", *lines(table)]))
        else:
            parts += ["\n".join([f"[{section}.{name}]", *lines(entries)]) for name, entries in table.items()]
    return "\n".join(parts) + "\n"


def lines(table):
    return [f"{key if re.fullmatch(r'[A-Za-z0-9_]+', key) else json.dumps(key)} = {value_of(value)}" for key, value in table.items()]


def value_of(value) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(lines(value)) + " }" if value else "{}"
    if isinstance(value, list):
        return "[" + ", ".join(map(value_of, value)) + "]"
    return str(value).lower() if isinstance(value, bool) else json.dumps(value) if isinstance(value, str) else repr(value)
