"""What of a file's shading is understood: one entry per reachable node that says so."""

from __future__ import annotations

from typing import Final, NamedTuple

EXACT: Final = "exact"
APPROXIMATE: Final = "approximate"
IGNORED: Final = "ignored"


class Coverage(NamedTuple):
    """How faithfully a node is rendered.

    Attributes
    ----------
    material : str
        Material, world or light.
    node : str
        The node's name (`Group/Noise Texture`).
    state : str
        exact, approximate or ignored.
    effect : str
        What that means in the image; "" for most that is exact.
    """

    material: str
    node: str
    state: str
    effect: str = ""


class CoverageLog:
    """Collects the entries of one graph, keeping the worst state of each node."""

    _RANK: Final = {EXACT: 0, APPROXIMATE: 1, IGNORED: 2}

    def __init__(self, material: str) -> None:
        self.material = material
        self._entries: dict[str, Coverage] = {}

    def note(self, node: str, state: str, effect: str = "") -> None:
        """Record `state` for a node; a second, different effect of the same node is appended."""
        old = self._entries.get(node)
        if old is None:
            self._entries[node] = Coverage(self.material, node, state, effect)
            return
        worst = max((old.state, state), key=self._RANK.__getitem__)
        effects = [e for e in (old.effect, effect) if e]
        joined = effects[0] if len(set(effects)) == 1 else "; ".join(effects)
        if effect and effect in old.effect:
            joined = old.effect
        self._entries[node] = Coverage(self.material, node, worst, joined)

    def entries(self) -> list[Coverage]:
        """In the order in which the nodes were met."""
        return list(self._entries.values())
