# SPDX-License-Identifier: MIT
"""normaltexture.distributed on a real cluster of processes, also while a worker is killed."""

import contextlib
import itertools
import json
import os
import shutil
import signal
import subprocess
import sys
from typing import get_args

import dask
import dask.array as da
import numpy as np
import pytest
from distributed import Client, LocalCluster, WorkerPlugin, get_client

import normaltexture as nt
from normaltexture import _ntp, distributed
from support import textures
from support.pngs import write_png

KERNELS = get_args(nt.typing.Kernel)
BORDERS = get_args(nt.typing.Border)


# -------------------------------------------------------------------------- heightfields


def same(heights, chunks, **how):
    tiles = distributed.normals_from_height(da.from_array(heights, chunks=chunks), **how)
    with dask.config.set(scheduler="synchronous"):
        made = tiles.compute()
    whole = nt.normals_from_height(heights, **how)
    assert made.dtype == whole.dtype == tiles.dtype and made.shape == whole.shape == tiles.shape
    assert made.tobytes() == whole.tobytes(), (chunks, how)


@pytest.mark.parametrize("kernel", KERNELS)
def test_every_border_and_kernel(kernel):
    heights = np.random.default_rng(1).random((45, 38)).astype(np.float32)
    for border in BORDERS:
        same(heights, (16, 13), scale=3, kernel=kernel, border=border)
    for x, y in itertools.permutations(BORDERS, 2):
        same(heights, (20, 19), scale=3, kernel=kernel, border_x=x, border_y=y)


@pytest.mark.parametrize("border", BORDERS)
def test_every_size_and_cut(border):
    rng = np.random.default_rng(2)
    for _ in range(40):
        h, w = (int(n) for n in rng.integers(1, 40, 2))
        kernel = KERNELS[int(rng.integers(len(KERNELS)))]
        cuts = tuple(cut(rng, side) for side in (h, w))
        heights = rng.integers(0, 65536, (h, w)).astype(np.uint16)
        same(heights, cuts, scale=20, kernel=kernel, border=border, depth=8)


def cut(rng, side):
    """Any way to cut a side, chunks of one texel included."""
    ends = np.flatnonzero(rng.random(side - 1) < rng.choice([0.1, 0.5, 0.95])) + 1
    return tuple(int(n) for n in np.diff([0, *ends, side]))


def test_channels_types_and_options():
    rng = np.random.default_rng(3)
    image = rng.integers(0, 256, (30, 40, 4)).astype(np.uint8)
    same(image, (15, 20, 2), scale=4, source="luma", alpha="height", to="xy", depth=16)
    same(image[..., :3], (15, 40, 3), scale=4, source="green", to_y="down", min_z=0.2)
    same(image[..., 0], (15, 20), scale=4, invert=True, dx=2, dy=0.5, to="vector")
    same(rng.random((30, 40)).astype(np.float32), (30, 10), scale=-2, depth="float")


def test_arguments():
    tiles = da.zeros((20, 20), chunks=10, dtype=np.uint8)
    for wrong in (
        {"border": "none"},
        {"kernel": "gauss"},
        {"dither": "integrable"},
        {"threads": 2},
        {"scale": "auto"},
    ):
        with pytest.raises(nt.ArgumentError):
            distributed.normals_from_height(tiles, **({"scale": 1} | wrong))
    with pytest.raises(nt.ArgumentError):
        distributed.normals_from_height(da.zeros(20), scale=1)
    assert [distributed.reach(name) for name in KERNELS] == [1, 1, 1, 1, 1, 2, 2, 2, 3, 4]


def test_nothing_is_computed_early():
    def explode(block):
        raise AssertionError("computed")

    tiles = da.zeros((64, 64), chunks=32, dtype=np.uint8).map_blocks(explode, dtype=np.uint8)
    assert distributed.normals_from_height(tiles, scale=1).shape == (64, 64, 3)


# -------------------------------------------------------------------------------- files


def test_without_a_cluster(many, tmp_path):
    """In a plain script, which has no guard for processes that start it anew."""
    _, paths = many
    script = tmp_path / "script.py"
    script.write_text(
        "import json, sys\nfrom normaltexture import distributed\n"
        "print(json.dumps(distributed.check(sys.argv[1:], batch=2)))\n"
    )
    command = [sys.executable, str(script), *paths]
    done = subprocess.run(command, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    assert json.loads(done.stdout) == _ntp.run_json("check", paths)[0]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Two workers, each a process of its own.

    Whether Dask starts another for a dead one, and how it ends then, is left to Dask.
    """
    place = tmp_path_factory.mktemp("dask")
    settings = {
        "distributed.comm.timeouts.connect": "600s",
        "distributed.comm.timeouts.tcp": "600s",
        "distributed.scheduler.allowed-failures": 20,
        "distributed.scheduler.worker-ttl": None,  # silent for long on a busy machine is not dead
        "distributed.nanny.preload": [],
        "temporary-directory": str(place),
    }
    with dask.config.set(settings):
        running = LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            memory_limit=0,  # none: what else the machine does is no reason to pause
            host="127.0.0.1",
        )
        client = Client(running, timeout="600s", set_as_default=True)
        client.wait_for_workers(2, timeout=600)
        yield client
        with contextlib.suppress(Exception):
            client.close()
        with contextlib.suppress(Exception):
            running.close()


@pytest.fixture
def many(tmp_path):
    """(directory, paths): textures, some wrong, one no image, names that are no UTF-8."""
    place = tmp_path / "in"
    (place / "deep").mkdir(parents=True)
    paths = []
    for i in range(14):
        path = place / ("deep" if i % 3 else "") / f"{i}_n.png"
        write_png(path, textures.wrong_blue(textures.standard(24, 24, seed=i), 0.1 * (i % 2)))
        paths.append(str(path))
    odd = os.fsdecode(os.fsencode(place) + b"/caf\xe9_n.png")
    write_png(odd, textures.standard(24, 24))
    broken = place / "broken_n.png"
    broken.write_bytes(b"no image")
    return place, [*paths, odd, str(broken)]


def test_check_is_that_of_one_machine(cluster, many):
    _, paths = many
    report = distributed.check(paths, batch=3, options=("--y", "up"))
    alone, _ = _ntp.run_json("check", paths, ["--y", "up"])
    assert report == alone
    assert distributed.check([])["files"] == []
    with pytest.raises(nt.ArgumentError, match="twice"):
        distributed.check([paths[0], paths[0]])
    with pytest.raises(_ntp.ProgramError, match="--frob"):
        distributed.check(paths, options=("--frob",))


def contents(folder):
    files = (file for file in folder.rglob("*") if file.is_file())
    return {str(file.relative_to(folder)): file.read_bytes() for file in files}


def alone(place, paths, output):
    """What one ntp makes of the same files."""
    relative = [os.path.relpath(path, place) for path in paths]
    _ntp.run_json("clean", relative, ["-o", str(output)], cwd=place)
    return contents(output)


def test_clean_while_a_worker_is_killed(cluster, many, tmp_path):
    """Nothing is lost and nothing written twice, whatever the worker was doing."""
    place, paths = many
    log = tmp_path / "log"
    before = set(worker_processes())
    cluster.register_plugin(Logged(str(log)), name="logged")
    report = distributed.clean(paths, tmp_path / "out", base=place, batch=1)
    killed = int((tmp_path / "log.killed").read_text(encoding="ascii"))
    assert killed in before
    assert [entry["path"] for entry in report["files"]] == [shown(path) for path in paths]
    states = [entry["status"] for entry in report["files"]]
    assert states == ["ok"] * (len(paths) - 1) + ["unreadable"]
    assert contents(tmp_path / "out") == alone(place, paths, tmp_path / "alone")
    published = [entry.get("published") for entry in report["files"]]
    assert set(published) <= {"now", "earlier", None} and published.count(None) == 1
    lines = [line.split(b" ", 2) for line in log.read_bytes().splitlines()]
    written = [target for _, state, target in lines if state == b"now"]
    assert len(written) == len(set(written)) == len(paths) - 1
    # What the killed worker had written is made once more, found, and not written again.
    of_killed = {target for pid, _, target in lines if int(pid) == killed}
    again = {target for pid, state, target in lines if state == b"earlier"}
    assert again and again <= of_killed
    for file in (tmp_path / "out").rglob("*_n.png"):
        assert file.stat().st_nlink == 1


def worker_processes():
    return list(get_client().run(os.getpid).values())


class Logged(WorkerPlugin):
    """In a worker: each file that gets its name is logged, and the worker that logs the fifth is
    killed before it can tell anybody."""

    FIFTH = 5

    def __init__(self, log):
        self.log = log

    def setup(self, worker):
        self.publish = distributed._publish

        def publish(made, target):
            state = self.publish(made, target)
            line = f"{os.getpid()} {state} {target}".encode("utf-8", "surrogateescape") + b"\n"
            handle = os.open(self.log, os.O_RDWR | os.O_APPEND | os.O_CREAT)
            os.write(handle, line)
            count = os.pread(handle, 1 << 20, 0).count(b"\n")
            os.close(handle)
            if count >= self.FIFTH and self.is_first():
                os.kill(os.getpid(), signal.SIGKILL)
            return state

        distributed._publish = publish

    def is_first(self):
        """Of all that would be killed; leaves a file with its number."""
        try:
            with open(f"{self.log}.killed", "x", encoding="ascii") as file:
                file.write(str(os.getpid()))
        except FileExistsError:
            return False
        return True


def shown(path):
    return os.fsencode(path).decode("utf-8", "replace")


def test_clean_again_writes_nothing(cluster, many, tmp_path):
    _, paths = many
    out = tmp_path / "out"
    first = distributed.clean(paths[:4], out, batch=2)
    assert [entry["published"] for entry in first["files"]] == ["now"] * 4
    times = {file: file.stat().st_mtime_ns for file in out.rglob("*_n.png")}
    (out / "2_n.png").unlink(missing_ok=True)
    (out / "deep" / "2_n.png").unlink(missing_ok=True)
    again = distributed.clean(paths[:4], out, batch=2)
    assert [entry["published"] for entry in again["files"]] == ["earlier"] * 2 + ["now", "earlier"]
    for file, stamp in times.items():
        assert "2_n" in file.name or file.stat().st_mtime_ns == stamp
    write_png(out / "0_n.png", textures.zzero())
    clash = distributed.clean(paths[:1], out)["files"][0]
    assert clash["status"] == "failed" and "exists" in clash["message"]
    assert not list(out.glob(".ntp-*"))


def test_clean_arguments(many, tmp_path):
    place, paths = many
    with pytest.raises(nt.ArgumentError, match="outside"):
        distributed.clean(paths, tmp_path / "o", base=place / "deep")
    shutil.copy(paths[0], place / "0_n.tga")
    with pytest.raises(nt.ArgumentError, match="both"):
        distributed.clean([paths[0], str(place / "0_n.tga")], tmp_path / "o")
    assert not (tmp_path / "o").exists()


def test_terrain_on_the_cluster(cluster):
    heights = np.random.default_rng(6).random((200, 300)).astype(np.float32)
    tiles = da.from_array(heights, chunks=(64, 100))
    made = distributed.normals_from_height(tiles, scale=9, kernel="gimp9").compute()
    assert made.tobytes() == nt.normals_from_height(heights, scale=9, kernel="gimp9").tobytes()


def test_arrays_are_not_paths():
    """Each mistake gets a sentence that names the argument and the way out."""
    texels = np.zeros((4, 4, 3), np.uint8)
    for call in (distributed.check, lambda paths: distributed.clean(paths, "out")):
        for wrong in (texels, "wall_n.png", [texels], 3):
            with pytest.raises(nt.ArgumentError, match="^paths"):
                call(wrong)
    with pytest.raises(nt.ArgumentError, match="height: must be a Dask array, not ndarray"):
        distributed.normals_from_height(np.zeros((4, 4)), scale=1)
