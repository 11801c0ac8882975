"""Which images are held whole and which are looked up through a pool of tiles, so that all stay in a limit.

Where everything fits, everything is whole. Otherwise the smallest images are whole, up to half of the limit,
and the others share what is left in proportion to their size.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

WHOLE_SHARE: Final = 0.5  # of the limit, for images held whole when not all can be


def pools(sizes: Mapping[int, int], limit: int) -> dict[int, int]:
    """Bytes of the pool of each image that is not held whole.

    Parameters
    ----------
    sizes : mapping of int to int
        Bytes of each image's texels.
    limit : int
        Bytes for all; 0 for no limit.
    """
    if not limit or sum(sizes.values()) <= limit:
        return {}
    whole, tiled = 0, dict(sizes)
    for index, size in sorted(sizes.items(), key=lambda item: item[1]):
        if whole + size > WHOLE_SHARE * limit:
            break
        whole += size
        del tiled[index]
    total = sum(tiled.values())
    return {index: (limit - whole) * size // total for index, size in tiled.items()}
