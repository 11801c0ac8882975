"""Memory for work: freed buffers kept, and buffers in large pages.

On Linux, malloc gives arrays above a threshold back to the system at once. A wavefront frees and allocates
hundreds of arrays per bounce; each then costs a page fault per 4 KiB when it is filled again. Measured on a
Cornell box with 65,536 lanes: 75,000 faults and 11 % of the time per million camera samples. glibc can be
told to keep them; elsewhere nothing is done.

It also gives each thread an arena of its own, where three times as much is taken as is in use: pieces of
all sizes do not fit into each other's gaps. Threads share one instead: 60 MB each in place of 100, for 2 to
3 % of the time of two. None waits for another, since numpy allocates while it holds the interpreter's lock.
"""

from __future__ import annotations

import ctypes
import math
import mmap
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

TRIM_THRESHOLD, TOP_PAD, MMAP_THRESHOLD, ARENA_MAX = -1, -2, -3, -8  # <malloc.h>
LARGEST_KEPT = 1 << 25  # glibc refuses more than 32 MiB
KEEP, PAD = 1 << 28, 1 << 24
PAGE = 1 << 21  # a large one


@contextmanager
def kept_buffers() -> Iterator[None]:
    """Within this context freed memory is reused; at its end what is unused goes back to the system."""
    libc = _glibc()
    if libc is None:
        yield
        return
    libc.mallopt(MMAP_THRESHOLD, LARGEST_KEPT)
    libc.mallopt(TRIM_THRESHOLD, KEEP)
    libc.mallopt(TOP_PAD, PAD)
    libc.mallopt(ARENA_MAX, 1)  # stays so
    try:
        yield
    finally:
        libc.mallopt(TRIM_THRESHOLD, 1 << 17)
        libc.mallopt(TOP_PAD, 1 << 17)
        libc.malloc_trim(0)


def in_large_pages(size: int) -> NDArray[np.uint8]:
    """So many zeros, in large pages where the system has them.

    What is worked on again and again in a core's own cache is read up to a fifth faster: that cache goes by
    physical addresses, and small pages lie anywhere, so that some get in each other's way before it is full.
    """
    if not hasattr(mmap, "MADV_HUGEPAGE"):
        return np.zeros(size, np.uint8)
    # what is mapped to be shared, as by default, has small ones
    memory = mmap.mmap(-1, size + PAGE, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    with suppress(OSError):  # a system without them
        memory.madvise(mmap.MADV_HUGEPAGE)
    whole = np.frombuffer(memory, np.uint8)
    start = -whole.ctypes.data % PAGE
    return whole[start : start + size]


class Memory:
    """Room for arrays, one behind the other."""

    def __init__(self, memory: NDArray[np.uint8]) -> None:
        self._memory, self._used = memory, 0

    def array(self, shape: tuple[int, ...], kind: type[np.generic]) -> NDArray[Any]:
        """An array of what is not used yet; what is in it is left over from before."""
        start, size = self._used, math.prod(shape) * np.dtype(kind).itemsize
        self._used += -(-size // 64) * 64  # a line of cache
        return self._memory[start : start + size].view(kind).reshape(shape)


def _glibc() -> Any:
    """The C library, if it is glibc."""
    if not sys.platform.startswith("linux"):
        return None
    libc = ctypes.CDLL(None)
    return libc if hasattr(libc, "gnu_get_libc_version") and hasattr(libc, "mallopt") else None
