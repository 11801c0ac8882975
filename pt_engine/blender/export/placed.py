"""What graphs ask of single instances: properties, the particle behind it, its place on the instancer.

The rows of `Instances.attributes`, all (x, y, z, w):

``object:NAME``, ``instancer:NAME``   a property as a colour
``instancer generated``, ``instancer uv``   where on the instancer's surface it stands
``particle``                          index, random number, age, lifetime
``particle location``                 and the size as w
``particle velocity``, ``particle angular velocity``
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .instance_layers import InstanceLayers
from .needs import PARTICLE_ROWS
from .properties import NOTHING, Rgba, first_of, object_rgba, rgba_of
from .random_id import MASK, jenkins


class PlacedAttributes:
    """Collects a row for each of the `wanted` names and each instance."""

    def __init__(self, wanted: Iterable[str], frame: float) -> None:
        self.frame = frame
        self.rows: dict[str, list[Rgba]] = {name: [] for name in sorted(wanted)}
        self._layers = InstanceLayers()

    def add(self, instance) -> None:
        """The next instance, within its loop step."""
        particle = None
        if any(name.startswith("particle") for name in self.rows):
            particle = self.particle(instance)
        for name, rows in self.rows.items():
            kind, _, prop = name.partition(":")
            if kind == "object":
                rows.append(object_rgba(instance.object, prop))
            elif kind == "instancer":
                rows.append(self.instancer_rgba(instance, prop))
            elif kind.startswith("instancer"):
                rows.append(on_instancer(instance, kind))
            else:
                rows.append(NOTHING if particle is None else particle[name])

    def table(self) -> dict:
        """(I, 4) float32 by name."""
        return {name: np.array(rows, np.float32).reshape(-1, 4) for name, rows in self.rows.items()}

    def instancer_rgba(self, instance, name: str) -> Rgba:
        """Of the particle settings, the instance itself, the instancer, else of the object."""
        if instance.is_instance:
            system, parent = instance.particle_system, instance.parent
            found = None if system is None else rgba_of(system.settings, name)
            if found is None:
                found = self._layers.rgba(instance, name)
            if found is None:
                found = rgba_of(parent, name)
            if found is not None:
                return found
        return first_of((instance.object, instance.object.data), name)

    def particle(self, instance) -> dict[str, Rgba]:
        """The particle that an instance was made from; all 0 but the random number where there is none."""
        system = instance.particle_system
        number = instance.persistent_id[0]
        if system is None or number >= len(system.particles):
            return NO_PARTICLE
        one = system.particles[number]
        return {
            "particle": (number, jenkins(number) / MASK, self.frame - one.birth_time, one.lifetime),
            "particle location": (*one.location, one.size),
            "particle velocity": (*one.velocity, 0.0),
            "particle angular velocity": (*one.angular_velocity, 0.0),
        }


NO_PARTICLE = dict.fromkeys(PARTICLE_ROWS, NOTHING) | {"particle": (0.0, jenkins(0) / MASK, 0.0, 0.0)}


def on_instancer(instance, kind: str) -> Rgba:
    """Generated coordinates or uv of the instancer where the instance stands."""
    if not instance.is_instance:
        return NOTHING
    if kind == "instancer uv":
        return (*instance.uv, 0.0, 0.0)
    x, y, z = (0.5 * part - 0.5 for part in instance.orco)
    return x, y, z, 0.0
