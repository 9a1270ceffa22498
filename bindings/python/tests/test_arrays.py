# SPDX-License-Identifier: MIT
"""Memory of every kind gives the same bytes, nothing is copied that need not be, threads agree."""

import gc
import pickle
import threading
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given

import normaltexture as nt
from normaltexture import _arrays, _threads
from pysupport.drawn import heights, layouts, textures


def standard(function):
    """Of noise no texel says what it is."""
    return partial(function, type="standard")


clean, validate, heatmap, shade, compare, resize, transform, blend, height_from_normals = map(
    standard,
    (
        nt.clean,
        nt.validate,
        nt.heatmap,
        nt.shade,
        nt.compare,
        nt.resize,
        nt.transform,
        nt.blend,
        nt.height_from_normals,
    ),
)

GREENS = {"y": "up", "detail_y": "up"}

# (name, function of a texture, may it work in place?)
FUNCTIONS = {
    "clean": (clean, True),
    "validate": (validate, False),
    "heatmap": (heatmap, True),
    "shade": (shade, True),
    "convert": (lambda a, **how: nt.convert(a, type="standard", y="down", **how), True),
    "deepen": (lambda a, **how: nt.convert(a, type="standard", depth=16, **how), False),
    "decode": (nt.decode, False),
    "resize": (lambda a, **how: resize(a, size=(5, 4), filter="lanczos3", **how), False),
    "transform": (lambda a, **how: transform(a, rotate=90, strength=1.5, y="up", **how), False),
    "blend": (lambda a, **how: blend(a, a[:2, :3].copy(), strength=0.5, **GREENS, **how), True),
    "normals_from_height": (
        lambda a, **how: nt.normals_from_height(a, scale=3, kernel="sobel5", **how),
        False,
    ),
    "height_from_normals": (
        lambda a, **how: height_from_normals(a, decode="unorm", y="up", **how),
        False,
    ),
}
MEASURES = {
    "measure": nt.measure,
    "classify": nt.classify,
    "compare": lambda a, **how: compare(a, a[..., ::-1].copy(), **how),
    "detect_orientation": nt.detect_orientation,
}


def texture_of(dtype, shape=(9, 14, 4), seed=1):
    rng = np.random.default_rng(seed)
    if dtype == np.float32:
        return rng.random(shape, np.float32)
    return rng.integers(0, np.iinfo(dtype).max + 1, shape).astype(dtype)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_layouts_and_out(name, dtype):
    function, in_place = FUNCTIONS[name]
    texture = texture_of(dtype)
    before = texture.copy()
    want = function(texture)
    assert np.array_equal(texture, before)
    for kind, array in layouts(texture):
        assert np.array_equal(array, texture), kind
        assert np.array_equal(function(array), want), kind
        assert np.array_equal(array, texture), kind
    for kind, out in list(layouts(np.zeros_like(want))):  # all of them zero before the first
        if kind == "read-only":
            continue
        assert function(texture, out=out) is out, kind
        assert np.array_equal(out, want), kind
    if in_place and want.shape == texture.shape and want.dtype == texture.dtype:
        same = texture.copy()
        assert function(same, out=same) is same
        assert np.array_equal(same, want)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("name", MEASURES)
def test_layouts_of_measures(name, dtype):
    texture = texture_of(dtype, (20, 30, 4))
    want = MEASURES[name](texture)
    for kind, array in layouts(texture):
        assert MEASURES[name](array) == want, kind


@pytest.mark.parametrize("shape", [(37, 25, 3), (1300, 900, 3)])
@pytest.mark.parametrize("name", [*FUNCTIONS, *MEASURES])
def test_threads_give_the_same_bytes(name, shape):
    """Small textures stay with the caller; of the large ones all functions make strips."""
    function = (FUNCTIONS | {n: (f, False) for n, f in MEASURES.items()})[name][0]
    texture = texture_of(np.uint8, shape)
    want = function(texture)
    for threads in (0, 2, 5) if shape[0] > 100 else (0, 2, 64):
        got = function(texture, threads=threads)
        assert np.array_equal(got, want) if isinstance(want, np.ndarray) else got == want


def recorded(threads, width, height, grain, before=lambda: None):
    """What run() hands out: for each that worked, its thread and the rows of its strips."""

    def work(areas):
        rows = []
        for area in areas:
            before()
            rows.append((area.x0, area.y0, area.x1, area.y1) if area else None)
        return threading.get_ident(), rows

    return _threads.run(threads, width, height, work, grain)


def test_strips_cover_the_image_once():
    for width, height, threads, grain in ((7, 64, 3, 7), (640, 3, 2, 1), (10, 99, 5, 55)):
        parts = recorded(threads, width, height, grain)
        strips = sorted(strip for _, rows in parts for strip in rows)
        assert 2 <= len(strips) <= threads * 8 and 1 <= len(parts) <= threads
        assert strips[0][1] == 0 and strips[-1][3] == height
        assert all((x0, x1) == (0, width) for x0, _, x1, _ in strips)
        assert all(a[3] == b[1] for a, b in pairwise(strips))
        assert min((y1 - y0 + 1) * width for _, y0, _, y1 in strips) > grain


def test_what_is_too_small_stays_with_the_caller():
    for threads, width, height, grain in ((1, 999, 999, 1), (8, 10, 10, 51), (8, 10**4, 1, 1)):
        assert recorded(threads, width, height, grain) == [(threading.get_ident(), [None])]


def test_helpers_take_part_and_all_have_ended():
    """Three strips can only be under way at once where three threads work on them."""
    meeting = threading.Barrier(3)
    parts = recorded(3, 1, 3, 1, before=meeting.wait)
    assert len({thread for thread, _ in parts}) == 3
    assert sorted(len(rows) for _, rows in parts) == [1, 1, 1]


@pytest.mark.parametrize("who", ["caller", "helper"])
def test_exceptions_of_strips_are_raised(who):
    caller, both = threading.get_ident(), threading.Barrier(2)
    written = []

    def work(areas):
        for area in areas:
            if len(written) < 2:
                written.append(area.y0)
                both.wait()
            if (threading.get_ident() == caller) == (who == "caller"):
                raise KeyError(who)
        return 1

    with pytest.raises(KeyError, match=who):
        _threads.run(2, 1, 16, work, 1)
    assert sorted(written) == [0, 1]


def test_nobody_waits_for_a_helper_that_has_not_begun(monkeypatch):
    """And then it does nothing any more."""
    waiting, called = [], []
    monkeypatch.setattr(_threads, "start_new_thread", lambda run, arguments: waiting.append(run))
    helpers = _threads.Helpers(2, lambda: called.append(1))
    waiting.pop()()
    helpers.wait()
    waiting.pop()()
    assert called == [1] and helpers.results() == [None]


def test_without_more_threads_the_caller_does_it_all(monkeypatch):
    def none(function, arguments):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(_threads, "start_new_thread", none)
    parts = recorded(4, 10, 64, 1)
    assert len(parts) == 1 and len(parts[0][1]) == 32
    texture = texture_of(np.uint8, (300, 300, 3))
    one, three = (height_from_normals(texture, y="up", threads=n) for n in (1, 3))
    assert np.array_equal(three, one)


def test_crops_are_what_the_whole_is():
    """What looks at one texel only does not care what lies around it."""
    texture = texture_of(np.uint16)
    crop = np.s_[2:7, 3:11]
    for name in ("clean", "validate", "heatmap", "convert", "deepen", "decode"):
        function = FUNCTIONS[name][0]
        assert np.array_equal(function(texture[crop]), function(texture)[crop]), name


@given(textures(), textures())
def test_pure_functions(texture, other):
    """The same result again, also with other calls between; the arguments are as they were."""
    copies = texture.copy(), other.copy()
    first = clean(texture), heatmap(texture), validate(texture)
    clean(other, out=other)
    nt.measure(other)
    again = clean(texture), heatmap(texture), validate(texture)
    assert all(np.array_equal(a, b) for a, b in zip(first, again))
    assert np.array_equal(texture, copies[0])
    assert np.array_equal(other, clean(copies[1]))


@given(heights())
def test_height_arrays_of_two_and_three_dimensions(height):
    flat = nt.normals_from_height(height, scale=2)
    assert np.array_equal(nt.normals_from_height(height[:, :, None], scale=2), flat)
    assert flat.shape == (*height.shape, 3)


# --------------------------------------------------------------------------------- copies


def test_views_are_the_memory_itself():
    texture = texture_of(np.uint8, (8, 8, 4))
    for array in (texture, texture[1:5, 2:], texture[::-1, ::-2], texture[..., 1:]):
        assert _arrays.pixels("src", array) is array
        view = _arrays.view("src", array, 2)
        address = int(_arrays.ffi.cast("uintptr_t", view.data))
        assert address == array.__array_interface__["data"][0]
        assert (view.row_stride, view.pixel_stride) == array.strides[:2]
    gray = texture_of(np.uint16, (8, 8))
    assert _arrays.pixels("height", gray.T) is not None
    assert _arrays.view("height", gray.T, 4).pixel_stride == gray.strides[0]  # Fortran order


def peak_of(call):
    """Bytes that a call holds at once, beyond those held before; numpy's arrays count."""
    call()  # caches
    gc.collect()
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    call()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak - before


@pytest.mark.parametrize("kind", ["contiguous", "crop", "read-only", "memory-mapped"])
@pytest.mark.parametrize("name", ["clean", "validate", "heatmap", "shade", "convert", "decode"])
def test_nothing_is_copied(name, kind, tmp_path):
    texture = texture_of(np.uint8, (700, 900, 3))
    if kind == "memory-mapped":
        texture.tofile(tmp_path / "texture.raw")
        array = np.memmap(tmp_path / "texture.raw", np.uint8, "r", shape=texture.shape)
    else:
        array = dict(layouts(texture))[kind]
    function = FUNCTIONS[name][0]
    out = function(array)
    small = 64 << 10
    assert peak_of(lambda: function(array, out=out)) < small
    assert peak_of(lambda: function(array)) < out.nbytes + small


def test_measure_holds_no_image():
    small, large = texture_of(np.uint8, (16, 16, 3)), texture_of(np.uint8, (1500, 1500, 3))
    assert peak_of(lambda: nt.measure(large)) < peak_of(lambda: nt.measure(small)) + (64 << 10)


# -------------------------------------------------------------------------------- threads


def test_many_threads_on_the_same_arrays():
    """One source, results and tables shared by 8 threads that work at once."""
    texture = texture_of(np.uint8, (400, 400, 3))
    functions = [FUNCTIONS[name][0] for name in ("clean", "heatmap", "shade", "validate")]
    functions += [nt.measure, nt.classify, lambda a: clean(a, type="zzero")]
    functions += [nt.detect_orientation, lambda a: compare(a, a[::-1])]
    functions += [lambda a: nt.convert(a, type="standard", depth=16, threads=2)]
    functions += [lambda a: blend(a, a[:64, :64], **GREENS), lambda a: resize(a, size="50%")]
    functions += [lambda a: transform(a, rotate=90, y="up")]
    functions += [lambda a: nt.normals_from_height(a[..., 0], scale=3.0)]
    functions += [lambda a: height_from_normals(a, kernel="central", y="up", threads=2)]
    want = [function(texture) for function in functions]
    out = np.zeros_like(texture)

    def work(turn):
        function = functions[turn % len(functions)]
        rows = slice(turn % 8 * 50, turn % 8 * 50 + 50)
        clean(texture[rows], out=out[rows])  # parts of one array
        return function(texture)

    with ThreadPoolExecutor(8) as pool:
        for turn, got in enumerate(pool.map(work, range(4 * len(functions)))):
            expected = want[turn % len(functions)]
            same = np.array_equal(got, expected) if isinstance(got, np.ndarray) else got == expected
            assert same, turn
    assert np.array_equal(out, want[0])


def test_results_travel_between_processes():
    texture = texture_of(np.uint8)
    for result in (nt.measure(texture), nt.classify(texture), compare(texture, texture)):
        assert pickle.loads(pickle.dumps(result)) == result
    error = pickle.loads(pickle.dumps(nt.ArgumentError("what", nt.Status.SHAPE)))
    assert (str(error), error.status) == ("what", nt.Status.SHAPE)
