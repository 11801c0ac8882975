"""Text as wide as its panel: Blender breaks no lines, and leaves out the middle of what is too long."""

from __future__ import annotations

import textwrap

CHARACTER = 6.0  # pixels, about, where the interface has scale 1
MARGINS = 70  # of a box in a panel, with an icon
LEAST = 16  # characters in a line


def wrapped(text: str, context) -> list[str]:
    """The lines of `text` in the region that is drawn."""
    scale = context.preferences.system.ui_scale
    room = (context.region.width / scale - MARGINS) / CHARACTER
    return textwrap.wrap(text, max(int(room), LEAST))


def listing(layout, context, lines, icon="NONE") -> None:
    """Lines of text in a box, close together; those that go on are indented."""
    column = layout.box().column(align=True)
    for number, line in enumerate(lines):
        first, *rest = wrapped(line, context) or [""]
        column.label(text=first, icon=icon if number == 0 else "NONE")
        for more in rest:
            column.label(text="    " + more)
