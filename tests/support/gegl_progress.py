# SPDX-License-Identifier: MIT
"""gegl_progress.py IN.png OPERATION: runs an operation, and prints the progress that it tells."""

import ctypes
import sys


def main(path, operation):
    gegl, gobject = ctypes.CDLL("libgegl-0.4.so.0"), ctypes.CDLL("libgobject-2.0.so.0")
    gegl.gegl_init(None, None)
    gegl.gegl_node_new.restype = gegl.gegl_node_new_child.restype = ctypes.c_void_p
    pointer, text = ctypes.c_void_p, ctypes.c_char_p

    def child(name, *properties):
        words = [text(b"operation"), text(name.encode()), *properties, pointer()]
        return pointer(gegl.gegl_node_new_child(graph, *words))

    graph = pointer(gegl.gegl_node_new())
    read = child("gegl:png-load", text(b"path"), text(path.encode()))
    made = child(operation)
    gegl.gegl_node_connect_to(read, text(b"output"), made, text(b"input"))
    kind = ctypes.CFUNCTYPE(None, pointer, ctypes.c_double, pointer)
    tell = kind(lambda _node, share, _data: print(share))
    gobject.g_signal_connect_data.restype = ctypes.c_ulong
    gobject.g_signal_connect_data(made, text(b"progress"), tell, None, None, 0)
    gegl.gegl_node_process(made)


if __name__ == "__main__":
    main(*sys.argv[1:])
