"""Parameter spaces that property tests draw from."""

from __future__ import annotations

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from pt_engine.scene.snapshot import LightData

from .lamps import placed

EXAMPLES = settings(max_examples=40, deadline=None, derandomize=True)
SIZE = st.one_of(st.floats(1e-3, 5), st.sampled_from([0.0, 1e-20, 1e-9, 1e-4, 1e4]))
ANGLE = st.one_of(st.floats(0.02, np.pi), st.sampled_from([0.0, 1e-6, np.pi, 4.0]))
UNIT = st.floats(0, 1)
COORDINATE = st.one_of(st.floats(-5, 5), st.sampled_from([0.0, 1e-6, 1e3]))
PLACE = st.tuples(COORDINATE, COORDINATE, COORDINATE)
SCALE = st.tuples(*[st.one_of(st.floats(0.1, 3), st.sampled_from([0.0, -1.0, 1e-3]))] * 3)
WEIGHT = st.one_of(st.just(0.0), st.floats(1e-30, 1e30), st.floats(0.5, 2))
UNIFORMS = np.random.default_rng(4).random((3, 64), np.float32)


@st.composite
def lamps(draw):
    """Any lamp."""
    kind = draw(st.sampled_from(["POINT", "SPOT", "SUN", "AREA"]))
    matrix = placed(*draw(PLACE), tilt=draw(st.floats(0, 6.3)), scale=draw(SCALE))
    return LightData(
        kind,
        "lamp",
        matrix,
        draw(st.floats(1e-3, 1e3)),
        radius=draw(SIZE),
        soft_falloff=draw(st.booleans()),
        spot_size=draw(ANGLE),
        spot_blend=draw(UNIT),
        angle=draw(ANGLE),
        shape=draw(st.sampled_from(["SQUARE", "RECTANGLE", "DISK", "ELLIPSE"])),
        size=(draw(SIZE), draw(SIZE)),
        spread=draw(ANGLE),
        normalize=draw(st.booleans()),
    )
