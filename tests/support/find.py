# SPDX-License-Identifier: MIT
"""What the library detects about the origin of normals, as dicts."""

from . import libntp_ffi as ntp


def find_kernel(n, y=ntp.UP, encoding=ntp.STANDARD, touch=0):
    origin = ntp.ffi.new("ntp_kernel_fit *")
    ntp.check(ntp.lib.ntp_find_kernel(origin, ntp.view(n, encoding, y, const=True), touch))
    return ntp.fields(origin)


def find_seams(n, encoding=ntp.STANDARD, touch=0):
    """(left and right edges, upper and lower ones)."""
    x, y = ntp.ffi.new("ntp_seam *"), ntp.ffi.new("ntp_seam *")
    ntp.check(ntp.lib.ntp_find_seams(x, y, ntp.view(n, encoding, const=True), touch))
    return ntp.fields(x), ntp.fields(y)


def find_border(n, heights, kernel, down, wraps=0, encoding=ntp.STANDARD, y=ntp.UP, **how):
    """What is found out along one axis."""
    how = ntp.ffi.new("ntp_height_options *", {"kernel": kernel, **how})
    fit = ntp.ffi.new("ntp_border_fit *")
    views = ntp.view(n, encoding, y, const=True), ntp.view(heights, ntp.HEIGHT, const=True)
    ntp.check(ntp.lib.ntp_find_border(fit, *views, how, down, wraps))
    return {"border": fit.border, "decided": fit.decided, "error": list(fit.error)}


def find_borders(n, kernel, open_=(1, 1), wraps=(0, 0), y=ntp.UP, hooks=None, **how):
    """(x, y): what is found out from bands of the texture."""
    how = ntp.ffi.new("ntp_height_options *", {"kernel": kernel, **how})
    h, w = n.shape[:2]
    parts = hooks.parts if hooks else 1
    size = ntp.lib.ntp_find_borders_scratch_size(how, w, h, parts)
    scratch = ntp.aligned(max(size, 1), 64)
    where = ntp.ffi.cast("void *", scratch.__array_interface__["data"][0])
    fits = ntp.ffi.new("ntp_border_fit[2]")
    src = ntp.view(n, ntp.STANDARD, y, const=True)
    hooks = hooks or ntp.ffi.NULL
    ntp.check(ntp.lib.ntp_find_borders(fits, src, how, open_, wraps, where, size, hooks))
    return [{"border": f.border, "decided": f.decided, "error": list(f.error)} for f in fits]
