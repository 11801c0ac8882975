"""Light groups: the view layer's names, and who is in them."""

from __future__ import annotations


class LightGroups:
    """The groups of a view layer, numbered from 1 on."""

    def __init__(self, view_layer) -> None:
        self.names = tuple(group.name for group in getattr(view_layer, "lightgroups", ()))

    def number(self, instance) -> int:
        """Of a depsgraph instance, 0 for none: that of what is placed, not of who places it, as in Cycles."""
        return self.of(instance.object)

    def of(self, owner) -> int:
        """Of an object or a world."""
        name = getattr(owner, "lightgroup", "")
        return self.names.index(name) + 1 if name in self.names else 0
