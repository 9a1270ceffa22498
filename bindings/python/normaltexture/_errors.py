# SPDX-License-Identifier: MIT
"""Exceptions: each inherits the builtin that fits and keeps the status of the C library."""

from enum import IntEnum

from ._native import ffi, lib


class Status(IntEnum):
    """Why libntp refused a call: `ntp_status` of libntp.h."""

    OK = lib.NTP_OK
    ARGUMENT = lib.NTP_ERR_ARGUMENT
    SHAPE = lib.NTP_ERR_SHAPE
    FORMAT = lib.NTP_ERR_FORMAT
    OVERLAP = lib.NTP_ERR_OVERLAP
    SCRATCH = lib.NTP_ERR_SCRATCH
    CANCELLED = lib.NTP_ERR_CANCELLED
    NOT_CONVERGED = lib.NTP_ERR_NOT_CONVERGED


class FileStatus(IntEnum):
    """Why a file could not be read or written: `ntpio_status` of ntpio.h."""

    OK = lib.NTPIO_OK
    OPEN = lib.NTPIO_ERR_OPEN
    FORMAT = lib.NTPIO_ERR_FORMAT
    CORRUPT = lib.NTPIO_ERR_CORRUPT
    LIMIT = lib.NTPIO_ERR_LIMIT
    MEMORY = lib.NTPIO_ERR_MEMORY
    WRITE = lib.NTPIO_ERR_WRITE
    USAGE = lib.NTPIO_ERR_USAGE


class NormalTextureError(Exception):
    """What all exceptions of this package inherit.

    Attributes
    ----------
    status : Status or FileStatus
        The status of the C library.
    """

    status: Status | FileStatus

    def __init__(self, message: str, status: Status | FileStatus = Status.ARGUMENT) -> None:
        super().__init__(message)
        self.status = status

    def __reduce__(self) -> tuple[type, tuple[str, Status | FileStatus]]:
        return type(self), (str(self), self.status)


class ArgumentError(NormalTextureError, ValueError):
    """An argument has an invalid value, shape or layout; the message names it."""


class SampleTypeError(NormalTextureError, TypeError):
    """An array holds samples of a type other than uint8, uint16 and float32."""

    def __init__(self, message: str, status: Status | FileStatus = Status.FORMAT) -> None:
        super().__init__(message, status)


class CancelledError(NormalTextureError, RuntimeError):
    """The progress callback asked to stop."""

    def __init__(self, message: str, status: Status | FileStatus = Status.CANCELLED) -> None:
        super().__init__(message, status)


class NotConvergedError(NormalTextureError, ArithmeticError):
    """An iteration ended before it reached its tolerance."""

    def __init__(self, message: str, status: Status | FileStatus = Status.NOT_CONVERGED) -> None:
        super().__init__(message, status)


class FileError(NormalTextureError, OSError):
    """A file is missing, damaged, too large, not an image, or cannot be written."""

    def __init__(self, message: str, status: Status | FileStatus = FileStatus.OPEN) -> None:
        super().__init__(message, status)


def check(status: int, function: str) -> None:
    """Raises for a status other than OK: what the checks before the call did not catch."""
    if status != lib.NTP_OK:
        text = ffi.string(lib.ntp_status_string(status)).decode()
        kinds = {Status.CANCELLED: CancelledError, Status.NOT_CONVERGED: NotConvergedError}
        raise kinds.get(Status(status), ArgumentError)(f"{function}: {text}", Status(status))
