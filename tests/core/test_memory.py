"""Memory for work."""

import subprocess
import sys

import numpy as np
import pytest

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


ARENAS = """
import ctypes, threading
import numpy as np
from pt_engine.core.memory import kept_buffers

def work(barrier):
    arrays = [np.ones(1 << 20) for _ in range(3)]
    barrier.wait()

with kept_buffers():
    barrier = threading.Barrier(3)
    threads = [threading.Thread(target=work, args=(barrier,)) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
libc = ctypes.CDLL(None)
libc.malloc_info(0, ctypes.c_void_p.in_dll(libc, "stdout"))
libc.fflush(None)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="of glibc")
def test_threads_that_render_share_their_memory():
    told = subprocess.run([sys.executable, "-c", ARENAS], check=True, capture_output=True, text=True).stdout
    if "<malloc" not in told:
        pytest.skip("not glibc")
    assert told.count("<heap nr=") == 1
