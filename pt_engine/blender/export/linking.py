"""Light and shadow linking: who is in whose collections, as sets (see `snapshot.Linking`).

An emitter whose collection includes anyone reaches those alone, one whose collection only excludes reaches
all others. What lies in a collection within the collection counts as that one is marked.
"""

from __future__ import annotations

import numpy as np

from ...scene.snapshot import Linking

NONE = (None, None)


class Links:
    """Sets of objects; found for the whole depsgraph, then asked for each object."""

    def __init__(self, depsgraph) -> None:
        self.groups: list[tuple] = [NONE]  # the collections of receivers and blockers of each set of emitters
        self._members: list[tuple[dict, dict]] = [({}, {})]
        self._receivers: dict[tuple, int] = {}
        self._blockers: dict[tuple, int] = {}
        self._group: dict[int, int] = {}
        for owner in depsgraph.objects:
            self._add(owner.original)
        self._known = set(self._group).union(*(states for both in self._members for states in both))
        self._set_of(self._receivers, 0, 0)
        self._set_of(self._blockers, 1, 0)

    def __bool__(self) -> bool:
        return len(self.groups) > 1

    def _add(self, owner) -> None:
        links = owner.light_linking
        both = links.receiver_collection, links.blocker_collection
        if both == NONE:
            return
        if both not in self.groups:
            self.groups.append(both)
            self._members.append(tuple(members(collection) for collection in both))
        self._group[owner.as_pointer()] = self.groups.index(both)

    def sets(self, owner, parent) -> tuple[int, int, int]:
        """Sets of receivers, blockers and emitters of an object; an instance that has none of its own
        has its instancer's."""
        key = owner.original.as_pointer()
        if key not in self._known and parent is not None:
            key = parent.original.as_pointer()
        receiver, blocker = self._set_of(self._receivers, 0, key), self._set_of(self._blockers, 1, key)
        return receiver, blocker, self._group.get(key, 0)

    def _set_of(self, sets: dict, side: int, key: int) -> int:
        """The set of an object in the collections of receivers (side 0) or of blockers (1)."""
        row = tuple(reached(both[side], key) for both in self._members)
        return sets.setdefault(row, len(sets))

    def table(self, sets) -> Linking | None:
        """For instances with these `sets`; None where nothing is linked."""
        if not self:
            return None
        receiver, blocker, emitter = np.array(sets, np.int32).reshape(-1, 3).T.copy()
        receives, blocks = (np.array(list(rows), np.uint8) for rows in (self._receivers, self._blockers))
        return Linking(receives, blocks, receiver, blocker, emitter)


def members(collection) -> dict[int, bool]:
    """Object -> whether it is included; one that is both is excluded."""
    states: dict[int, bool] = {}
    if collection is None:
        return states
    marked = list(zip(collection.collection_objects, collection.objects, strict=True))
    for child, within in zip(collection.collection_children, collection.children, strict=True):
        marked += [(child, owner) for owner in within.all_objects]
    for mark, owner in marked:
        key = owner.original.as_pointer()
        states[key] = states.get(key, True) and mark.light_linking.link_state == "INCLUDE"
    return states


def reached(states: dict[int, bool], key: int) -> bool:
    """Whether the light or shadow that a collection is for is there for an object."""
    if key in states:
        return states[key]
    return not any(states.values())
