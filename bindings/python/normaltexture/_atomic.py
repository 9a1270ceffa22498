# SPDX-License-Identifier: MIT
"""Files that exist completely or not at all."""

import contextlib
import errno
import os
import tempfile
from pathlib import Path

from ._named import RefusedFileError, Version, is_inside, version


def write_atomically(path: Path, data: bytes, expected: Version | None = None) -> None:
    """Puts a file in place when it is complete; an older file stays unchanged until then.

    `expected` is the version of the older file that was read: any other is left as it is.

    Raises
    ------
    RefusedFileError
        The older file changed meanwhile, or is no regular file.
    """
    target = path.resolve()
    handle, temporary = tempfile.mkstemp(
        dir=target.parent, prefix=f".{target.name}.", suffix=".tmp"
    )
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if target.exists() and not target.is_file():
            raise RefusedFileError(path, "is no regular file")
        if target.exists():
            _copy_rights(target, temporary)
        else:
            os.chmod(temporary, 0o666 & ~_umask())
        if expected is not None and version(target.stat()) != expected:
            raise RefusedFileError(path, "changed meanwhile; it is left as it is")
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise


def write_inside(folder: Path, path: Path, data: bytes, expected: Version | None = None) -> None:
    """As `write_atomically`, where no link leads out of `folder`."""
    target = Path(os.path.realpath(path))
    if not is_inside(str(target), os.path.realpath(folder)):
        raise RefusedFileError(path, f"is a link that leads out of {folder}")
    write_atomically(target, data, expected)


def _copy_rights(source: Path, target: str) -> None:
    """Mode, access lists and other extended attributes; without them nothing is replaced."""
    os.chmod(target, source.stat().st_mode & 0o7777)
    if not hasattr(os, "listxattr"):
        return
    try:
        names = os.listxattr(source)
    except OSError as error:
        if error.errno in (errno.ENOTSUP, errno.ENOSYS):
            return
        raise
    for name in names:
        with contextlib.suppress(FileNotFoundError):
            os.setxattr(target, name, os.getxattr(source, name))


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
