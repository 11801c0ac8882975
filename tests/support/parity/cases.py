"""Every question that can be put to a node: its kind, its settings, one of its outputs.

The kinds are those of this Blender, their settings all enums and flags that the kind adds to
`bpy.types.Node`, in all combinations (`recipes` says which do nothing). A node that a later Blender
brings, or that we begin to understand, is asked about without a line here.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator
from typing import Any, NamedTuple

import bpy

from .recipes import RECIPES, Recipe

MOST = 1000  # combinations of a node without a recipe; beyond, one setting at a time
VALUES = {"VALUE", "VECTOR", "RGBA", "INT", "BOOLEAN", "ROTATION"}


class Case(NamedTuple):
    """One output of a node under some settings; `setup` is the name of one of its recipe's."""

    kind: str
    settings: tuple[tuple[str, Any], ...]
    setup: str
    output: str

    @property
    def name(self) -> str:
        """Kind, settings and output in words."""
        return " ".join(part for part in (self.kind, self.words, self.output) if part)

    @property
    def words(self) -> str:
        """Settings in words; a flag by its name."""
        flags = (
            key if value is True else "" if value is False else f"{value}" for key, value in self.settings
        )
        return " ".join(part for part in (*flags, self.setup) if part)


def recipe(kind: str) -> Recipe:
    """Its recipe, or one without hints."""
    return RECIPES.get(kind, Recipe())


def kinds() -> list[str]:
    """Kinds of shader nodes that can be made in this Blender."""
    return [name.removeprefix("ShaderNode") for name in dir(bpy.types) if is_node(name)]


def is_node(name: str) -> bool:
    """Whether a type is a shader node of its own, not a base class or a tree."""
    bases = ("ShaderNode", "ShaderNodeTree", "ShaderNodeCustomGroup", "ShaderNodeGroup")
    return name.startswith("ShaderNode") and name not in bases


def options(kind: str) -> dict[str, tuple[Any, ...]]:
    """Settings that can be enumerated, with their values."""
    inherited = bpy.types.Node.bl_rna.properties
    found: dict[str, tuple[Any, ...]] = {}
    for setting in getattr(bpy.types, "ShaderNode" + kind).bl_rna.properties:
        name = setting.identifier
        if name in inherited or setting.is_readonly:
            continue
        if setting.type == "ENUM":
            found[name] = tuple(item.identifier for item in setting.enum_items)
        elif setting.type == "BOOLEAN":
            found[name] = (False, True)
    return {name: values for name, values in (found | dict(recipe(kind).options)).items() if values}


def combinations(kind: str) -> Iterator[dict[str, Any]]:
    """Settings of a kind: all combinations that differ, or one change at a time where there are too many."""
    table, idle = options(kind), recipe(kind).idle
    first = {name: values[0] for name, values in table.items()}
    size = 1
    for values in table.values():
        size *= len(values)
    if size > MOST and kind not in RECIPES:
        yield first
        yield from (first | {name: v} for name, values in table.items() for v in values[1:])
        return
    for values in itertools.product(*table.values()):
        settings = dict(zip(table, values, strict=True))
        if all(settings[name] == first[name] for name in idle(settings)):
            yield settings


@functools.cache
def cases(kind: str) -> tuple[Case, ...]:
    """All questions about a kind; none where it has no outputs that are values."""
    tree = bpy.data.node_groups.new("questions", "ShaderNodeTree")
    node = tree.nodes.new("ShaderNode" + kind)
    found = []
    if any(s.type in VALUES for s in node.outputs) and not recipe(kind).elsewhere:
        for settings in combinations(kind):
            if not accepted(node, settings):
                continue
            outputs = [s.identifier for s in node.outputs if s.type in VALUES and not s.is_unavailable]
            for setup, output in itertools.product(recipe(kind).setups or ("",), outputs):
                found.append(Case(kind, tuple(settings.items()), setup, output))
    bpy.data.node_groups.remove(tree)
    return tuple(found)


def accepted(node: Any, settings: dict[str, Any]) -> bool:
    """Set a node; False where its tree has no such value (Mix has rotations in geometry nodes only)."""
    try:
        for name, value in settings.items():
            setattr(node, name, value)
    except TypeError:
        return False
    return True


def pairwise(every: tuple[Case, ...]) -> list[Case]:
    """The fewest questions, chosen greedily, that still meet each value of a setting with each of another."""
    missing = {pair for case in every for pair in pairs(case)}
    chosen = []
    for case in every:
        new = pairs(case) & missing
        if new:
            chosen.append(case)
            missing -= new
    return chosen


def pairs(case: Case) -> set[tuple[Any, ...]]:
    """Two settings at a time, the output and the set-up among them; one where there is only one."""
    facts = (*case.settings, ("setup", case.setup), ("output", case.output))
    return set(itertools.combinations(facts, 2))
