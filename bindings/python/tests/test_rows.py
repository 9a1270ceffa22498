# SPDX-License-Identifier: MIT
"""Heights row by row: the bytes of height_from_normals, and what the functions raise."""

import numpy as np
import pytest

import normaltexture as nt

CASES = [
    ("central", "wrap", "wrap"),
    ("central", "mirror", "clamp"),
    ("forward", "clamp", "wrap"),
    ("forward", "extrapolate", "mirror"),
    ("baked", "clamp", "clamp"),
    ("baked", "wrap", "wrap"),
]
KINDS = {
    8: {"depth": 8},
    16: {"depth": 16},
    "float": {"depth": "float"},
    "vector": {"depth": "float", "type": "vector"},
    "xy": {"depth": 8, "type": "xy"},
}


def bumps(height, width):
    rng = np.random.default_rng(height * width)
    y, x = np.mgrid[0:height, 0:width]
    waves = np.sin(x * 0.31 + np.cos(y * 0.17)) + rng.standard_normal((height, width)) * 0.05
    return waves.astype(np.float32)


def normals_of(kind, height, width):
    bump = bumps(height, width)
    if kind == "vector":
        return nt.normals_from_height(bump, scale=3, to="vector")
    normals = nt.normals_from_height(bump, scale=3, depth=KINDS[kind]["depth"])
    return normals[..., :2].copy() if kind == "xy" else normals


class Store:
    """The three functions over arrays; they note what they are asked for."""

    def __init__(self, normals):
        self.normals = normals
        self.heights = np.full(normals.shape[:2], np.nan, np.float32)
        self.calls = []
        self.kept = []

    def read_normals(self, y, count):
        self.calls.append(("normals", y, count))
        return self.normals[y : y + count]

    def write_heights(self, y, rows):
        assert rows.dtype == np.float32 and not rows.flags.writeable
        self.calls.append(("write", y, len(rows)))
        self.kept.append(rows)
        self.heights[y : y + len(rows)] = rows

    def read_heights(self, y, count):
        self.calls.append(("read", y, count))
        return self.heights[y : y + count]

    def solve(self, **how):
        functions = self.read_normals, self.write_heights, self.read_heights
        return nt.height_from_rows(*functions, shape=self.normals.shape, **how)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("kernel", "border_x", "border_y"), CASES)
def test_the_bytes_of_the_whole(kernel, border_x, border_y, kind):
    how = {"kernel": kernel, "border_x": border_x, "border_y": border_y, "dx": 2.0, **KINDS[kind]}
    normals = normals_of(kind, 83, 47)
    store = Store(normals)
    info = store.solve(**how)
    how.pop("depth")
    want, whole = nt.height_from_normals_with_info(
        normals, y="up", decode="unorm", z="stored", **({"type": "standard"} | how)
    )
    assert np.array_equal(store.heights, want)
    for name in ("method", "kernel", "border_x", "border_y", "y", "decode", "z", "scale", "offset",
                 "unused", "not_finite", "islands"):  # fmt: skip
        assert getattr(info, name) == getattr(whole, name), name


def test_the_arguments_mean_the_same():
    normals = normals_of(16, 64, 40)
    normals[10:12, 5:9] = 0
    same = {"kernel": "central", "border": "wrap"}
    for how in (
        {"y": "down"},
        {"dy": 0.5},
        {"decode": "neutral"},
        {"z": "derived"},
        {"touch_unused": True},
        {"method": "frankot-chellappa"},
    ):
        store = Store(normals)
        info = store.solve(depth=16, **same, **how)
        fixed = {"y": "up", "decode": "unorm", "z": "stored"} | same | how
        want = nt.height_from_normals(normals, **fixed)
        assert np.array_equal(store.heights, want), how
        assert info.unused == (0 if "touch_unused" in how else 8)


def test_threads_and_memory():
    """Large enough for several parts; a few rows at a time all the same."""
    normals = normals_of(8, 1500, 130)
    want = Store(normals)
    want.solve()
    assert max(count for _, _, count in want.calls) < 1500 / 4
    for threads in (0, 2, 3):
        store = Store(normals)
        shares = []
        store.solve(threads=threads, progress=shares.append)
        assert np.array_equal(store.heights, want.heights)
        assert shares and shares == sorted(shares) and 0 <= shares[0] and shares[-1] <= 1
    written = [y for name, y, _ in want.calls if name == "write"]
    middle = len(written) // 2
    assert written[:middle] == sorted(written[:middle])
    assert written[middle:] == sorted(written[middle:], reverse=True)


def test_rows_that_are_kept_are_no_danger():
    """Their numbers change, but the memory is there."""
    store = Store(normals_of(8, 400, 33))
    store.solve()
    kept = store.kept
    del store
    assert all(np.isfinite(rows).all() and rows.shape[1] == 33 for rows in kept)


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("name", ["read_normals", "write_heights", "read_heights"])
@pytest.mark.parametrize("error", [OSError("disk full"), KeyboardInterrupt()])
def test_what_a_function_raises_ends_the_work(name, error, threads):
    store = Store(normals_of(8, 1100, 140))
    function, calls = getattr(store, name), []

    def failing(*arguments):
        calls.append(arguments)
        if len(calls) == 3:
            raise error
        return function(*arguments)

    setattr(store, name, failing)
    with pytest.raises(type(error)) as raised:
        store.solve(threads=threads)
    assert raised.value is error
    assert len(calls) == 3


def test_progress_stops():
    store = Store(normals_of(8, 64, 64))
    with pytest.raises(nt.CancelledError):
        store.solve(progress=lambda share: False)

    def fails(share):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        store.solve(progress=fails)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"read_normals": lambda y, n: np.zeros((n, 9, 4), np.uint8)}, r"read_normals\(0, "),
        ({"read_normals": lambda y, n: np.zeros((n, 9, 3), np.uint16)}, "uint16"),
        ({"read_normals": lambda y, n: None}, "read_normals"),
        ({"read_heights": lambda y, n: np.zeros((n, 9))}, "read_heights.*float64"),
    ],
)
def test_rows_of_another_kind_are_refused(change, message):
    store = Store(normals_of(8, 30, 9))
    vars(store).update(change)
    with pytest.raises(nt.ArgumentError, match=message):
        store.solve()


def test_readers_may_return_what_is_an_array():
    """Floats of the other byte order are."""
    normals = normals_of("float", 12, 5)
    want = Store(normals)
    want.solve(depth="float")
    store = Store(normals)
    store.read_heights = lambda y, n: store.heights[y : y + n].astype(">f4")
    store.solve(depth="float")
    assert np.array_equal(store.heights, want.heights)


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"shape": (4, 4)}, "shape="),
        ({"shape": (4, 4, 2)}, "3..4"),
        ({"shape": (0, 4, 3)}, "shape="),
        ({"shape": (4, 70000, 3)}, "65535"),
        ({"depth": 12}, "depth=12"),
        ({"kernel": "sobel3"}, "kernel='sobel3'"),
        ({"method": "weighted"}, "method='weighted'"),
        ({"border": "extend"}, "border='extend'"),
        ({"border_y": "mirror"}, "row by row"),
        ({"method": "poisson-dct"}, "row by row"),
        ({"dx": 0}, "dx="),
        ({"threads": -1}, "threads=-1"),
        ({"type": "vector"}, "float"),
    ],
)
def test_arguments(how, message):
    def never(*arguments):
        raise AssertionError("called")

    with pytest.raises((nt.ArgumentError, nt.SampleTypeError), match=message):
        nt.height_from_rows(never, never, never, **{"shape": (8, 8, 3)} | how)
    with pytest.raises(nt.ArgumentError, match="read_heights"):
        nt.height_from_rows(never, never, None, shape=(8, 8, 3))
