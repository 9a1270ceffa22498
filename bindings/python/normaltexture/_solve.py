# SPDX-License-Identifier: MIT
"""The solver of libntp on Python threads.

libntp runs the parts of the work through two callbacks: one hands them to threads, the other
reports progress and can stop, also for Ctrl-C.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from typing import Any, Self

from ._arrays import memory, thread_count
from ._errors import Status
from ._native import ffi, lib

_SCRATCH_ALIGNMENT = 64


class Solver:
    """Heights of one texture, into one array, as often as is asked; a context manager."""

    def __init__(
        self, dst: Any, src: Any, threads: int, progress: Callable[[float], object] | None
    ) -> None:
        self._dst, self._src = dst, src
        self._parts = min(thread_count(threads), int(lib.NTP_MAX_PARTS))
        self.pool = ThreadPoolExecutor(self._parts) if self._parts > 1 else None
        self.progress = progress
        self.raised: BaseException | None = None
        self.begin, self.end = 0.0, 1.0
        self._handle = ffi.new_handle(self)
        self._hooks = ffi.new("ntp_hooks *")
        self._hooks.user = self._handle
        self._hooks.progress = lib.ntp_py_progress
        if self.pool is not None:
            self._hooks.parallel_for = lib.ntp_py_parallel_for
        self._hooks.parts = self._parts

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self.pool is not None:
            self.pool.shutdown()

    def solve(self, how: Any, result: Any, begin: float, end: float) -> int:
        """The status; what a callback raised is raised here."""
        size = lib.ntp_height_scratch_size(how, self._src.width, self._src.height, self._parts)
        if size == 0:
            return int(Status.FORMAT)
        self.begin, self.end = begin, end
        scratch, owner = memory(size, _SCRATCH_ALIGNMENT)
        status: int = lib.ntp_height_from_normals(
            self._dst, self._src, how, scratch, size, self._hooks, result
        )
        del owner
        if self.raised is not None:
            raise self.raised
        return status


def _stop(exception: Any, value: Any, traceback: Any) -> int:
    """An exception in the progress callback, Ctrl-C included: kept, and libntp is told to stop."""
    del exception
    solver: Solver = ffi.from_handle(traceback.tb_frame.f_locals["user"])
    solver.raised = value
    return 1


@ffi.def_extern(name="ntp_py_progress", onerror=_stop)  # type: ignore[untyped-decorator]
def _progress(user: Any, share: float) -> int:
    solver: Solver = ffi.from_handle(user)
    if solver.raised is not None:
        return 1
    told = solver.begin + (solver.end - solver.begin) * share
    return int(solver.progress is not None and solver.progress(told) is False)


@ffi.def_extern(name="ntp_py_parallel_for")  # type: ignore[untyped-decorator]
def _parallel_for(user: Any, count: int, task: Any, work: Any) -> None:
    solver: Solver = ffi.from_handle(user)
    assert solver.pool is not None
    running = [solver.pool.submit(task, work, index) for index in range(count)]
    while running:  # libntp relies on all being done, so Ctrl-C waits as well
        try:
            wait(running)
            running = []
        except BaseException as raised:  # noqa: BLE001  raised again by solve()
            solver.raised = raised
