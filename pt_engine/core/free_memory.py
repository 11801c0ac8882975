"""How much more memory this process may take, as far as the system tells."""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path

GROUPS = Path("/sys/fs/cgroup")
# limit, use and what of the use is only cached files, in the two versions of control groups
VERSIONS = (
    ("memory.max", "memory.current", "memory.stat", "inactive_file"),
    (
        "memory/memory.limit_in_bytes",
        "memory/memory.usage_in_bytes",
        "memory/memory.stat",
        "total_inactive_file",
    ),
)


def free_memory() -> int | None:
    """Bytes that can be had without swapping; None where the system does not say."""
    if sys.platform == "win32":
        return _windows()
    if sys.platform == "darwin":
        return _macos()
    return smallest(_meminfo(), group_room(GROUPS))


def smallest(*bytes_: int | None) -> int | None:
    """Of those that are known."""
    return min((b for b in bytes_ if b is not None), default=None)


def _meminfo() -> int | None:
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    except OSError:
        return None
    return next((int(line.split()[1]) << 10 for line in lines if line.startswith("MemAvailable:")), None)


def group_room(root: Path) -> int | None:
    """What the control group that a container runs in leaves; None without a limit."""
    for limit, use, stat, cached in VERSIONS:
        try:
            room = int((root / limit).read_text(encoding="ascii")) - int(
                (root / use).read_text(encoding="ascii")
            )
            numbers = dict(line.split() for line in (root / stat).read_text(encoding="ascii").splitlines())
            return max(0, room + int(numbers.get(cached, 0)))
        except (OSError, ValueError):  # not there, or "max"
            continue
    return None


def _macos() -> int | None:
    """Physical memory: macOS compresses and swaps what others hold, and tells nobody how much it could."""
    size, length = ctypes.c_uint64(), ctypes.c_size_t(8)
    libc = ctypes.CDLL(None)
    failed = libc.sysctlbyname(b"hw.memsize", ctypes.byref(size), ctypes.byref(length), None, 0)
    return None if failed else int(size.value)


class MemoryStatus(ctypes.Structure):
    """MEMORYSTATUSEX of <sysinfoapi.h>."""

    _fields_ = [
        ("length", ctypes.c_uint32),
        ("load", ctypes.c_uint32),
        *((name, ctypes.c_uint64) for name in ("total", "available", "total_page", "available_page")),
        *((name, ctypes.c_uint64) for name in ("total_virtual", "available_virtual", "extended")),
    ]


def _windows() -> int | None:
    status = MemoryStatus(length=ctypes.sizeof(MemoryStatus))
    kernel = ctypes.WinDLL("kernel32")  # type: ignore[attr-defined,unused-ignore]
    return int(status.available) if kernel.GlobalMemoryStatusEx(ctypes.byref(status)) else None
