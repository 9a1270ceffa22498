# SPDX-License-Identifier: MIT
"""Writes the C source of normaltexture._native: cdef.py libntp.h ntpio.h OUTPUT

The headers are the only declarations: libntp.h is cut between its cdef marks, ntpio.h loses its
preprocessor lines.  cffi (API mode) has the C compiler check every one of them.
"""

import re
import sys
from pathlib import Path

import cffi

# Python functions that C calls: the hooks of ntp_height_from_normals, those that move rows, and
# those that make the mips and blocks of a DDS or KTX2.
CALLBACKS = """
extern "Python" int32_t ntp_py_progress(void *user, double share);
extern "Python" void ntp_py_parallel_for(void *user, int32_t count,
                                         void (*task)(void *work, int32_t index), void *work);
extern "Python" int32_t ntp_py_read_normals(void *user, void *rows, int32_t y, int32_t count);
extern "Python" int32_t ntp_py_read_heights(void *user, float *rows, int32_t y, int32_t count);
extern "Python" int32_t ntp_py_write_heights(void *user, const float *rows, int32_t y,
                                             int32_t count);
extern "Python" bool ntp_py_make_mip(void *context, void *dst, uint32_t width, uint32_t height,
                                     const void *whole);
extern "Python" bool ntp_py_compress(void *context, uint8_t *dst, const void *src, uint32_t width,
                                     uint32_t height);
"""

# stdlib.h: alloca, which cffi's code uses; Python.h of the limited API does not include it.
SOURCE = """
#include <stdlib.h>
#include <libntp.h>
#include <ntpio.h>
"""


def library(header: str) -> str:
    """What stands between the marks of libntp.h, without the export macro."""
    begin = header.index("\n", header.index("cdef begin"))
    end = header.index("/* --- cdef end")
    return header[begin:end].replace("NTP_API ", "")


def files(header: str) -> str:
    """ntpio.h without its preprocessor lines."""
    return re.sub(r"^#.*$", "", header, flags=re.MULTILINE)


def main(libntp_h: str, ntpio_h: str, output: str) -> None:
    ffi = cffi.FFI()
    ffi.cdef(library(Path(libntp_h).read_text(encoding="utf-8")))
    ffi.cdef(files(Path(ntpio_h).read_text(encoding="utf-8")))
    ffi.cdef(CALLBACKS)
    ffi.set_source("normaltexture._native", SOURCE)
    ffi.emit_c_code(output)
    # The code of cffi 1.17 uses memset, for which Python.h of the limited API includes nothing.
    code = Path(output).read_text(encoding="utf-8")
    if "#include <string.h>" not in code:
        stddef = "#include <stddef.h>\n"
        code = code.replace(stddef, stddef + "#include <string.h>\n", 1)
        Path(output).write_text(code, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
