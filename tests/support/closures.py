"""What a compiled material reflects in all, as it renders: its closures on one fake lane, added up."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from support import bsdf_checks as checks
from support.node_lanes import NodeLanes

from pt_engine.core import frames
from pt_engine.nodes.batch import Closure
from pt_engine.nodes.compile import compile_materials
from pt_engine.scene.snapshot import Graph

Float64 = NDArray[np.float64]


def compiled_closures(graph: Graph, wi: NDArray[np.float32], **lanes: Any) -> list[Closure]:
    """The closures of a material toward world directions `wi` (3, n), over the normal +Z."""
    return compile_materials([graph]).batches[0].closures(NodeLanes(n=wi.shape[1], wi=wi, **lanes))


def name_of(closure: Closure) -> str:
    """Its model's name."""
    return closure.bsdf.__name__.rpartition(".")[2]


def furnace_albedo(graph: Graph, wi: NDArray[np.float32], rows: int = 96, **lanes: Any) -> Float64:
    """(3,) what a material scatters in all, both sides together, toward the direction `wi` (3, 1)."""
    total: Float64 = np.zeros(3)
    for closure in compiled_closures(graph, wi, **lanes):
        total += closure.weight.mean(axis=-1) * closure_albedo(closure, wi, rows)
    return total


def closure_albedo(closure: Closure, wi: NDArray[np.float32], rows: int) -> Float64:
    """∫ f·|cosθo| dωo of a closure over the normal +Z, without its weight."""
    up = np.array([[0.0], [0.0], [1.0]], np.float32)
    if closure.tangent is not None:
        wi = frames.to_local(*frames.from_tangent(up, closure.tangent), up, wi)
    return checks.directional_albedo(closure.bsdf, closure.params, wi, rows=rows, choices=8)
