"""Ranges of sample numbers, as (first, count)."""

from __future__ import annotations

Ranges = tuple[tuple[int, int], ...]


def overlapping(a: Ranges, b: Ranges) -> tuple[int, int] | None:
    """The first range (first, count) that is in both, or None."""
    for first, count in a:
        for other_first, other_count in b:
            low, high = max(first, other_first), min(first + count, other_first + other_count)
            if low < high:
                return low, high - low
    return None


def joined(ranges: Ranges) -> Ranges:
    """Sorted, merged where they touch or overlap."""
    result: list[tuple[int, int]] = []
    for first, count in sorted(ranges):
        if result and first <= sum(result[-1]):
            start = result[-1][0]
            result[-1] = start, max(sum(result[-1]), first + count) - start
        elif count:
            result.append((first, count))
    return tuple(result)
