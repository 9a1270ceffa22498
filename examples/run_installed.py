# SPDX-License-Identifier: MIT
"""Builds and runs the examples as a user would: installed libntp, pkg-config, a plain compiler.

usage: run_installed.py BUILD SOURCE PREFIX CC [CXX]

Nothing of the build tree is on any search path; what the examples print is checked.
"""

import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"]


def command_output(command, **kwargs):
    done = subprocess.run(command, check=False, stdout=subprocess.PIPE, text=True, **kwargs)
    if done.returncode != 0:
        sys.exit(f"{shlex.join(map(str, command))}: exit {done.returncode}\n{done.stdout}")
    return done.stdout


def installed_environment(build, prefix, root):
    """Installs below root; the environment in which pkg-config finds that, and only that."""
    install = [
        "meson",
        "install",
        "-C",
        build,
        "--destdir",
        root,
        "--no-rebuild",
        "--quiet",
    ]
    command_output(install + ["--tags", "devel,runtime"])
    pc = next(root.rglob("libntp.pc"))
    env = dict(os.environ, PKG_CONFIG_SYSROOT_DIR=str(root), PKG_CONFIG_LIBDIR=str(pc.parent))
    env.pop("PKG_CONFIG_PATH", None)
    assert (root / prefix.relative_to("/") / "include" / "libntp.h").is_file()
    return env


def link_flags(env):
    """What pkg-config says, and where the shared library is at run time."""
    flags = shlex.split(command_output(["pkg-config", "--cflags", "--libs", "libntp"], env=env))
    libdir = next(Path(flag[2:]) for flag in flags if flag.startswith("-L"))
    if list(libdir.glob("libntp.so*")):
        return flags, [f"-Wl,-rpath,{libdir}"]
    static = ["pkg-config", "--static", "--cflags", "--libs", "libntp"]
    return shlex.split(command_output(static, env=env)), []


def main():
    build, source, prefix = (Path(arg) for arg in sys.argv[1:4])
    compilers = [[sys.argv[4], "-std=c99"]]
    compilers += [[cxx, "-x", "c++", "-std=c++11"] for cxx in sys.argv[5:6]]
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        env = installed_environment(build, prefix, scratch / "root")
        flags, rpath = link_flags(env)
        for compiler in compilers:
            for name in ("clean_texture", "check_buffer"):
                program = scratch / name
                tail = ["-x", "none", *flags, *rpath, "-o", program]
                command_output([*compiler, *WARNINGS, source / f"{name}.c", *tail])
                text = command_output([program])
                print(f"-- {name}, {compiler[0]}\n{text}", end="")
                want = "3 of 512 texels are bad" if name == "check_buffer" else "texels changed"
                assert want in text, text
            check_files(scratch)


def slope(u, v):
    """A texel whose z was truncated, not rounded."""
    x, y = (2 * u - 255) / 255, (2 * v - 255) / 255
    return u, v, int(((1 - x * x - y * y) ** 0.5 + 1) / 2 * 255)


def check_files(scratch):
    """clean_texture on files: a second run finds nothing to change."""
    dirty = bytes(c for i in range(64) for c in slope(40 + 20 * (i % 8), 40 + 20 * (i // 8)))
    (scratch / "in.rgb").write_bytes(dirty)
    paths = [scratch / name for name in ("in.rgb", "once.rgb", "twice.rgb")]
    program = scratch / "clean_texture"
    first = command_output([program, paths[0], "8", "8", paths[1]])
    assert "texels changed" in first and "cleaned: 0 " not in first, first
    second = command_output([program, paths[1], "8", "8", paths[2]])
    assert "cleaned: 0 texels changed" in second, second
    assert paths[1].read_bytes() == paths[2].read_bytes()


main()
