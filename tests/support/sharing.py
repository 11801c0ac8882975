"""Scenes in which all that may share records does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pt_engine.scene import instancing
from pt_engine.scene.prepare import prepare


def joined(snapshot):
    """The same with each mesh once."""
    once = list({id(mesh): mesh for mesh in snapshot.meshes}.values())
    number = np.array(
        [next(k for k, m in enumerate(once) if m is mesh) for mesh in snapshot.meshes], np.int32
    )
    instances = replace(snapshot.instances, random=np.linspace(0, 1, len(number), dtype=np.float32))
    return replace(snapshot, meshes=tuple(once), instances=replace(instances, mesh=number))


def shared(snapshot, way: str, monkeypatch):
    """Prepare with all sharing that there can be."""
    with monkeypatch.context() as patch:
        patch.setattr(instancing, "MANY", 0)

        def all_alike(*args):
            found = instancing.candidates(*args)
            return found._replace(nested=np.full(len(found.nested), way == "nested"))

        patch.setattr("pt_engine.scene.placing.candidates", all_alike)
        return prepare(snapshot)
