# SPDX-License-Identifier: MIT
"""The solver of libntp on Python threads.

libntp runs the parts of the work through two callbacks: one hands them to threads, the other
reports progress and can stop, also for Ctrl-C.
"""

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from ._arrays import memory
from ._errors import Status, check
from ._native import ffi, lib
from ._threads import Helpers, thread_count

SCRATCH_ALIGNMENT = 64
_GRAIN = 1 << 16  # texels of a part: its work comes in pieces, for each of which threads are woken
_AT_ONCE = 1 << 14  # texels up to which nobody waits for a solution, and Ctrl-C can


class Callbacks:
    """What libntp may call while it works."""

    def __init__(self, threads: int, texels: int, progress: Callable[[float], object] | None):
        self.progress = progress
        self.raised: BaseException | None = None
        self.begin, self.end = 0.0, 1.0
        self.parts = 1
        if threads != 1:
            most = min(thread_count(threads), lib.NTP_MAX_PARTS)
            self.parts = max(1, min(most, texels // _GRAIN))
        self._is_long = progress is not None or texels > _AT_ONCE

    def hooks(self, handle: Any, is_long: bool) -> Any:
        """An ntp_hooks, if any are of use; the caller keeps `handle`, of this object, alive."""
        if self.parts == 1 and not (is_long or self._is_long):
            return ffi.NULL
        return ffi.new(
            "ntp_hooks *",
            (
                handle,
                lib.ntp_py_progress if is_long or self._is_long else ffi.NULL,
                lib.ntp_py_parallel_for if self.parts > 1 else ffi.NULL,
                self.parts,
            ),
        )

    def check(self) -> None:
        """Raises what a callback raised."""
        if self.raised is not None:
            raise self.raised


class Solver(Callbacks):
    """Heights of one texture, into one array, as often as requested."""

    def __init__(
        self, dst: Any, src: Any, threads: int, progress: Callable[[float], object] | None
    ) -> None:
        super().__init__(threads, src.width * src.height, progress)
        self._dst, self._src = dst, src

    def solve(self, how: Any, result: Any, begin: float, end: float) -> int:
        """The status; what a callback raised is raised here.

        Ctrl-C within the rounds of refine only ends them.
        """
        size = lib.ntp_height_scratch_size(how, self._src.width, self._src.height, self.parts)
        if size == 0:
            return int(Status.FORMAT)
        self.begin, self.end = begin, end
        handle = ffi.new_handle(self)
        scratch, owner = memory(size, SCRATCH_ALIGNMENT)
        status: int = lib.ntp_height_from_normals(
            self._dst, self._src, how, scratch, size, self.hooks(handle, how.refine > 0), result
        )
        del owner
        if status == Status.CANCELLED and how.refine > 0 and result.method != lib.NTP_HEIGHT_AUTO:
            # Stopped within the rounds of refine: the array holds the best heights so far.
            if isinstance(self.raised, KeyboardInterrupt):
                self.raised = None
            status = int(Status.OK)
        self.check()
        return status

    def find_borders(
        self, how: Any, open_: tuple[bool, bool], wraps: tuple[int, int], begin: float, end: float
    ) -> Any:
        """Two ntp_border_fit; what a callback raised is raised here."""
        size = lib.ntp_find_borders_scratch_size(how, self._src.width, self._src.height, self.parts)
        self.begin, self.end = begin, end
        handle = ffi.new_handle(self)
        scratch, owner = memory(max(size, 1), SCRATCH_ALIGNMENT)
        fits = ffi.new("ntp_border_fit[2]")
        hooks = self.hooks(handle, False)
        status = lib.ntp_find_borders(fits, self._src, how, open_, wraps, scratch, size, hooks)
        del owner
        self.check()
        check(status, "height_from_normals")
        return fits


def stop(exception: Any, value: Any, traceback: Any) -> int:
    """An exception in a callback, Ctrl-C included: it is kept, and libntp is told to stop."""
    del exception
    solver: Callbacks = ffi.from_handle(traceback.tb_frame.f_locals["user"])
    solver.raised = value
    return 1


@ffi.def_extern(name="ntp_py_progress", onerror=stop)  # type: ignore[untyped-decorator]
def _progress(user: Any, share: float) -> int:
    solver: Callbacks = ffi.from_handle(user)
    if solver.raised is not None:
        return 1
    told = solver.begin + (solver.end - solver.begin) * share
    return int(solver.progress is not None and solver.progress(told) is False)


def _rest(task: Callable[[int], object], queue: deque[int]) -> None:
    """Does the work that the others leave in the queue.  This is not a loop of Python: if Ctrl-C
    came between taking an index and using it, the index would be lost."""
    with suppress(IndexError):
        deque(map(task, iter(queue.popleft, None)), 0)


@ffi.def_extern(name="ntp_py_parallel_for")  # type: ignore[untyped-decorator]
def _parallel_for(user: Any, count: int, task: Any, work: Any) -> None:
    solver: Callbacks = ffi.from_handle(user)
    queue = deque(range(count))
    rest = partial(_rest, partial(task, work), queue)
    helpers = Helpers(count - 1, rest)
    while True:  # libntp relies on all being done, so Ctrl-C waits as well
        try:
            rest()
            helpers.wait()
            return
        except BaseException as raised:  # noqa: BLE001  raised again by the solver
            solver.raised = raised
