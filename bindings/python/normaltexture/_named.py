# SPDX-License-Identifier: MIT
"""Opens files whose names come out of other files: a glTF file, the JSON of a check.

Such a name can say anything: a device that never ends, a pipe that never begins, a file that is
none of the reader's business.  So only regular files are opened, only up to a size, and only inside
a folder.  Where a file lies is asked of what was opened, not of its name: links are followed first,
and a name that changes its meaning in between does no harm.
"""

import errno
import os
import stat
import sys

# The most that is read on behalf of one file, with all that it names.
MAX_BYTES = 1 << 30

# A pipe is opened without waiting for its other end; a terminal never becomes ours.
_FLAGS = os.O_RDONLY | sum(
    getattr(os, name, 0) for name in ("O_NONBLOCK", "O_CLOEXEC", "O_NOCTTY", "O_BINARY")
)

Version = tuple[int, int, int, int]


class RefusedFileError(OSError):
    """A file that is there and is not read; `strerror` says why."""

    def __init__(self, path: str | os.PathLike[str], reason: str) -> None:
        super().__init__(errno.EPERM, reason, os.fspath(path))


def version(status: os.stat_result) -> Version:
    """What changes when a file is replaced or written."""
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns


def place(descriptor: int, path: str | os.PathLike[str]) -> str:
    """The true path, without links, of what is open.

    Raises
    ------
    RefusedFileError
        The file was moved or deleted meanwhile.
    """
    found = os.path.realpath(path)
    if os.path.isdir("/proc/self/fd"):
        found = os.readlink(f"/proc/self/fd/{descriptor}")
    elif sys.platform == "darwin":
        import fcntl

        found = os.fsdecode(fcntl.fcntl(descriptor, fcntl.F_GETPATH, bytes(1024)).rstrip(b"\0"))
    try:
        same = os.path.samestat(os.stat(found), os.fstat(descriptor))
    except OSError:
        same = False
    if not same:
        raise RefusedFileError(path, "was moved while it was opened")
    return found


def folder_place(folder: str | os.PathLike[str]) -> str:
    """The true path of a folder."""
    if os.name == "nt":  # which opens no folders
        return os.path.realpath(folder)
    descriptor = os.open(folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
    try:
        return place(descriptor, folder)
    finally:
        os.close(descriptor)


def is_inside(path: str, folder: str) -> bool:
    """Whether a true path lies below the true path of a folder."""
    try:
        return os.path.commonpath([path, folder]) == folder
    except ValueError:  # another drive
        return False


def _refuse_irregular(path: str | os.PathLike[str], status: os.stat_result) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
    if not stat.S_ISREG(status.st_mode):
        raise RefusedFileError(path, "is no regular file")


def open_regular(path: str | os.PathLike[str]) -> int:
    """A descriptor of a regular file.

    Raises
    ------
    OSError
        There is none, or it is of another kind.
    """
    _refuse_irregular(path, os.stat(path))  # merely opening a device can do something
    descriptor = os.open(path, _FLAGS)
    try:
        _refuse_irregular(path, os.fstat(descriptor))
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def open_named(
    path: str | os.PathLike[str],
    root: str | os.PathLike[str] | None = None,
    max_bytes: int = MAX_BYTES,
) -> int:
    """A descriptor of a regular file inside `root`, of at most `max_bytes`.

    Raises
    ------
    OSError
        There is none, or it is refused.
    """
    descriptor = open_regular(path)
    try:
        if root is not None:
            folder = folder_place(root)
            if not is_inside(place(descriptor, path), folder):
                raise RefusedFileError(
                    path, f"lies outside of {folder}; root (--root) can name a larger folder"
                )
        size = os.fstat(descriptor).st_size
        if size > max_bytes:
            raise too_large(path, size, max_bytes)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def too_large(path: str | os.PathLike[str], size: int, most: int) -> RefusedFileError:
    return RefusedFileError(
        path, f"has {size:,} bytes; max_bytes (--max-bytes) leaves room for {most:,}"
    )


def read_named(
    path: str | os.PathLike[str],
    root: str | os.PathLike[str] | None = None,
    max_bytes: int = MAX_BYTES,
) -> tuple[bytes, os.stat_result]:
    """The content of a regular file inside `root`, and its status when it was read.

    Parameters
    ----------
    path
        Its name; links are followed.
    root
        The folder that it has to lie in.  None: it may lie anywhere.
    max_bytes
        A larger file is refused.

    Raises
    ------
    OSError
        There is none, or it is refused.
    """
    with os.fdopen(open_named(path, root, max_bytes), "rb") as file:
        status = os.fstat(file.fileno())
        data = file.read(max_bytes + 1)
    if len(data) > max_bytes:  # it grows, or its size is not what it says
        raise too_large(path, len(data), max_bytes)
    return data, status
