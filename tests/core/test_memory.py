"""Memory for work."""

import numpy as np

from pt_engine.core.memory import PAGE, Memory, in_large_pages


def test_memory_in_large_pages_is_zeros_to_write_on():
    memory = in_large_pages(PAGE + 12345)
    assert memory.shape == (PAGE + 12345,)
    assert not memory.any()
    memory[:] = 255
    assert memory.min() == 255


def test_arrays_lie_one_behind_the_other_on_lines_of_cache():
    whole = in_large_pages(4096)
    memory = Memory(whole)
    arrays = [
        memory.array(shape, kind)
        for shape, kind in (((3,), np.uint8), ((2, 5), np.float32), ((7,), np.int64))
    ]
    for k, array in enumerate(arrays):
        array[:] = k + 1
    for k, array in enumerate(arrays):
        assert (array == k + 1).all()
    assert [a.ctypes.data - whole.ctypes.data for a in arrays] == [0, 64, 128]
