# SPDX-License-Identifier: MIT
"""Work on the rows of an image, distributed among threads.

Strips of rows lie in a queue; the caller and its helpers take one after the other, so a thread
whose processor is slow or busy does fewer.  A helper that starts late finds nothing left to do, and
nobody waits for it.  Work that is too small to split stays with the caller.  So threads that do not
help cost almost nothing.
"""

import os
from _thread import start_new_thread
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from threading import Condition
from typing import Any, Generic, TypeVar

import numpy as np

from ._errors import ArgumentError
from ._native import ffi

T = TypeVar("T")

MOST_THREADS = 1024
_STRIPS_EACH = 8  # the last of them to end keeps the others waiting an eighth of their work

# Texels of a strip, by what is done with each: about what one processor does in a tenth of
# a millisecond, for it takes almost as long to start a thread.  Fewer than two strips are one.
COPYING, QUICK, THOROUGH = 1 << 18, 1 << 16, 1 << 12


class Helpers(Generic[T]):
    """Threads that call a function, each once; fewer if the system has no more.

    Low-level threads, because `threading` waits for its threads until they have started.
    """

    def __init__(self, count: int, function: Callable[[], T]) -> None:
        self._function = function
        self._changed = Condition()
        self._late = False
        self._running = 0
        self._results: list[T] = []
        self._raised: list[BaseException] = []
        try:
            for _ in range(count):
                start_new_thread(self._run, ())
        except RuntimeError:  # no more threads, or the interpreter is ending
            pass

    def _run(self) -> None:
        with self._changed:
            if self._late:
                return
            self._running += 1
        try:
            result = [self._function()]
        except BaseException as raised:  # noqa: BLE001  raised again by the caller
            self._raised.append(raised)
            result = []
        with self._changed:
            self._results += result
            self._running -= 1
            self._changed.notify()

    def wait(self) -> None:
        """Waits until those that have started are done; the others do nothing any more."""
        with self._changed:
            self._late = True
            while self._running > 0:
                self._changed.wait()

    def results(self) -> list[T]:
        """What they returned, after `wait`; or raises what one has raised."""
        if self._raised:
            raise self._raised[0]
        return self._results


def thread_count(threads: int) -> int:
    """The argument `threads`: 0 means one for each processor."""
    if not isinstance(threads, (int, np.integer)) or not 0 <= threads <= MOST_THREADS:
        raise ArgumentError(
            f"threads={threads!r}: must be an integer 0..{MOST_THREADS}; 0: all processors"
        )
    if threads == 0 and hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return int(threads) or os.cpu_count() or 1


def _taken(queue: deque[Any]) -> Iterator[Any]:
    """Item after item, until none is left."""
    try:
        while True:
            yield queue.popleft()
    except IndexError:
        return


def _share(queue: deque[Any], work: Callable[[Iterable[Any]], T]) -> list[T]:
    """Does the work that the others leave in the queue, if any."""
    areas = _taken(queue)
    try:
        for first in areas:
            return [work(chain((first,), areas))]
    except BaseException:
        queue.clear()
        raise
    return []


def run(
    threads: int,
    width: int,
    height: int,
    work: Callable[[Iterable[Any]], T],
    grain: int = QUICK,
) -> list[T]:
    """work(areas) for strips of about `grain` texels or more, at once; libntp runs without the GIL."""
    if threads == 1:
        return [work((ffi.NULL,))]
    count = thread_count(threads)
    strips = min(height, width * height // grain, count * _STRIPS_EACH)
    if count == 1 or strips < 2:
        return [work((ffi.NULL,))]
    edges = [height * i // strips for i in range(strips + 1)]
    queue = deque(ffi.new("ntp_rect *", (0, edges[i], width, edges[i + 1])) for i in range(strips))
    helpers = Helpers(min(count, strips) - 1, lambda: _share(queue, work))
    try:
        parts = _share(queue, work)
        helpers.wait()
    except BaseException:  # Ctrl-C among them: nobody writes any more when it is told of
        queue.clear()
        helpers.wait()
        raise
    return parts + [part for some in helpers.results() for part in some]
