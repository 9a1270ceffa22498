# SPDX-License-Identifier: MIT
"""symbols.py SHARED STATIC: what the library exports and what it needs from outside.

The shared library exports exactly the functions that libntp.h declares.  The core's objects need
nothing but the functions below: no allocation, no stdio, no locale, of libm only square roots.
"""

import subprocess
import sys

from support import libntp_ffi

ALLOWED = {"memcpy", "memset", "memmove", "memcmp", "strcmp", "strlen", "sqrt", "sqrtf"}
# What compilers, sanitizers and coverage add by themselves; bcmp is clang's memcmp that asks for
# equality only.
GENERATED = ("__stack_chk", "__asan", "__ubsan", "__tsan", "__msan", "__gcov", "__sanitizer")
GENERATED += ("__memcpy_chk", "__memset_chk", "__memmove_chk")  # _FORTIFY_SOURCE
GENERATED += (
    "_GLOBAL_OFFSET_TABLE_",
    "bcmp",
    "__cpu_",
    "__x86_get_cpuid_feature_leaf",  # the same in glibc
    "__llvm",
    "__cxa_finalize",
    "_ITM_",
    "__gmon_start",
)


WRITABLE = (".data", ".bss", ".tdata", ".tbss", "*COM*")


def names(*command):
    """{name: (class letter, section)} as nm sees them."""
    command = ["nm", "--format=sysv", *command]
    out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    rows = [[cell.strip() for cell in line.split("|")] for line in out.splitlines()]
    return {row[0].split("@")[0]: (row[2], row[6]) for row in rows if len(row) == 7}


def is_state(section):
    """Permanently writable, not only until the dynamic linker has filled in addresses."""
    return section.startswith(WRITABLE) and not section.startswith(".data.rel.ro")


def main(shared, static):
    exported = {n for n, (kind, _) in names("-D", "--defined-only", shared).items() if kind != "A"}
    declared = libntp_ffi.public_functions()
    good = True
    for name in sorted(exported - declared):
        print(f"exported, but not declared in libntp.h: {name}")
        good = False
    for name in sorted(declared - exported):
        print(f"declared in libntp.h, but not exported: {name}")
        good = False
    defined = names("--defined-only", static)
    for name, (kind, section) in sorted(defined.items()):
        if kind.isupper() and not name.startswith(("ntp_", *GENERATED)):
            print(f"a global name without the prefix ntp: {name}")
            good = False
        if is_state(section) and not name.startswith(GENERATED):
            print(f"the core keeps state: {name} ({section})")
            good = False
    for name in sorted(names("--undefined-only", static).keys() - defined.keys()):
        if name not in ALLOWED and not name.startswith(GENERATED):
            print(f"the core may not use: {name}")
            good = False
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))
