# SPDX-License-Identifier: MIT
"""What a Mac's loader reads of ntp and of libntp: mach_o.py NTP LIBRARY (needs macholib).

Nothing but the system's own library is loaded, the library is found by @rpath, both run from macOS
11 on, and for arm64, which starts nothing without, they have a signature.
"""

import sys

from macholib.MachO import MachO

SYSTEM = "/usr/lib/libSystem.B.dylib"
PROGRAM, LIBRARY = 2, 6
ARM64 = 0x0100000C


def commands(path):
    (header,) = MachO(path).headers
    found = {}
    for load, command, data in header.commands:
        value = command.minos if hasattr(command, "minos") else data
        if isinstance(value, bytes):
            value = value.rstrip(b"\0").decode(errors="replace")
        found.setdefault(load.get_cmd_name(), []).append(value)
    return header.header, found


def main(program, library):
    for path, kind in ((program, PROGRAM), (library, LIBRARY)):
        header, found = commands(path)
        assert header.filetype == kind, path
        assert found["LC_LOAD_DYLIB"] == [SYSTEM], found["LC_LOAD_DYLIB"]
        assert found["LC_BUILD_VERSION"] == [11 << 16], found["LC_BUILD_VERSION"]
        assert "LC_CODE_SIGNATURE" in found or header.cputype != ARM64, path
    (name,) = found["LC_ID_DYLIB"]
    assert name == f"@rpath/{library.rpartition('/')[2]}", name
    print(f"{program}, {library}: as a Mac wants them")


if __name__ == "__main__":
    main(*sys.argv[1:])
