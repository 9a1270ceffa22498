# SPDX-License-Identifier: MIT
"""Runs operations of GEGL on PNG files, all in one process: `python in_gegl.py JOBS`.

JOBS is a JSON file of [input, chain, output, bits], where a chain is what the program `gegl` takes
after `--`.  The first problem is told, and ends it.
"""

import ctypes
import json
import sys


def declared(lib):
    """The few functions that are used."""
    pointer, text = ctypes.c_void_p, ctypes.c_char_p
    lib.gegl_node_new.restype = pointer
    lib.gegl_node_create_child.restype = pointer
    lib.gegl_node_create_child.argtypes = [pointer, text]
    for name in ("gegl_node_link", "gegl_node_process"):
        getattr(lib, name).restype = None
    lib.gegl_node_link.argtypes = [pointer, pointer]
    lib.gegl_node_process.argtypes = [pointer]
    lib.gegl_create_chain.restype = None
    lib.gegl_create_chain.argtypes = [
        *(text, pointer, pointer, ctypes.c_double, ctypes.c_int, text),
        ctypes.POINTER(pointer),
    ]
    return lib


class Error(ctypes.Structure):
    """GError."""

    _fields_ = (("domain", ctypes.c_uint32), ("code", ctypes.c_int), ("message", ctypes.c_char_p))


def run(gegl, gobject, source, chain, made, bits):
    graph = gegl.gegl_node_new()
    load = gegl.gegl_node_create_child(graph, b"gegl:png-load")
    end = gegl.gegl_node_create_child(graph, b"gegl:nop")
    save = gegl.gegl_node_create_child(graph, b"gegl:png-save")
    none = ctypes.c_void_p(None)

    def set_(node, name, value):
        gegl.gegl_node_set(ctypes.c_void_p(node), name, value, none)

    set_(load, b"path", ctypes.c_char_p(source.encode()))
    set_(save, b"path", ctypes.c_char_p(made.encode()))
    set_(save, b"bitdepth", ctypes.c_int(bits))
    set_(save, b"compression", ctypes.c_int(1))
    error = ctypes.c_void_p(None)
    gegl.gegl_create_chain(chain.encode(), load, end, 0.0, 0, b"", ctypes.byref(error))
    if error.value is not None:
        message = ctypes.cast(error, ctypes.POINTER(Error)).contents.message.decode()
        raise SystemExit(f"{chain}: {message}")
    gegl.gegl_node_link(end, save)
    gegl.gegl_node_process(save)
    gobject.g_object_unref(ctypes.c_void_p(graph))


def main():
    gegl = declared(ctypes.CDLL("libgegl-0.4.so.0"))
    gobject = ctypes.CDLL("libgobject-2.0.so.0")
    gegl.gegl_init(ctypes.c_void_p(None), ctypes.c_void_p(None))
    with open(sys.argv[1], encoding="utf-8") as file:
        jobs = json.load(file)
    for job in jobs:
        run(gegl, gobject, *job)


if __name__ == "__main__":
    main()
