# SPDX-License-Identifier: MIT
"""One file, by one thread or by several: decoded ahead, packed side by side, and always the same.

Pictures are larger than what `ntp` reads without a second thread, and some than what it packs
without one.  Damaged files are cut at many places, or wrong in one: the report, the message, the exit
code and what was written are those of one thread.
"""

import os
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from support import textures
from support.pngs import SIGNATURE, chunk

JOBS = (1, 2, 3, 4)
WIDE, HIGH = 700, 620  # blocks of 64 rows, of which two are held
VERBS = {
    "check": ("check", "--format", "json"),
    "clean": ("clean", "--format", "json", "-o", "out.png"),
    "convert": ("convert", "--format", "json", "--force", "--to", "zzero", "-o", "out.png"),
    "transform": ("transform", "--format", "json", "--flip", "x", "--force", "-o", "out.png"),
}


def uneven(width, height, dtype=np.uint8):
    """Normals whose blue is wrong in some rows, all of them different."""
    picture = textures.wrong_blue(textures.standard(height, width, 5), 0.02)
    if dtype == np.uint16:
        noise = np.random.default_rng(6).integers(0, 200, picture.shape)
        picture = np.minimum(picture.astype(np.int64) * 257 + noise, 65535)
    return picture.astype(dtype)


def rows_of(picture):
    """Filters of all kinds: what is not None, Sub or Up is left to the reader as it is."""
    data = picture.astype(picture.dtype.newbyteorder(">")).view(np.uint8)
    data = data.reshape(len(picture), -1)
    above = np.vstack([np.zeros_like(data[:1]), data[:-1]])
    up = (np.arange(len(data)) % 3 != 0)[:, None]
    kinds = np.where(up, 2, 0).astype(np.uint8)
    return np.hstack([kinds, np.where(up, data - above, data)]).tobytes()


def png(picture, size=None, packed=None, after=b"", part=9000):
    width, height = size or picture.shape[1::-1]
    depth = 8 * picture.dtype.itemsize
    packed = zlib.compress(rows_of(picture), 1) if packed is None else packed
    data = SIGNATURE + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, 2, 0, 0, 0))
    for at in range(0, len(packed), part):
        data += chunk(b"IDAT", packed[at : at + part])
    return data + after + chunk(b"tEXt", b"Author\0somebody") + chunk(b"IEND")


@pytest.fixture
def same(run, tmp_path):
    """same(NAME, VERB..): runs each verb with each number of threads; returns what one thread did."""

    def compare(name, *verbs):
        seen = []
        for verb in verbs:
            results = []
            for jobs in JOBS:
                out = tmp_path / "out.png"
                out.unlink(missing_ok=True)
                done = run(*VERBS[verb], name, "--jobs", jobs)
                made = out.read_bytes() if out.exists() else None
                results.append((done.returncode, done.stdout, done.stderr, made))
            assert all(result == results[0] for result in results), (name, verb)
            seen.append(results[0])
        return seen

    return compare


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_good_files(same, tmp_path, dtype):
    picture = uneven(1500, 1500, dtype)
    (tmp_path / "a_n.png").write_bytes(png(picture))
    seen = same("a_n.png", *VERBS)
    assert all(made is not None for *_, made in seen[1:])
    assert seen[1][3].count(b"Author") == 1


def threads_of(program, tmp_path, jobs, *args):
    """The most threads that were seen at a time."""
    command = [program, *args, "--jobs", str(jobs), "-q"]
    most = 0
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL) as process:
        tasks = Path(f"/proc/{process.pid}/task")
        while process.poll() is None:
            most = max(most, len(os.listdir(tasks)))
        assert process.returncode in (0, 1)
    return most


@pytest.mark.skipif(
    sys.platform != "linux" or "NTP_PROGRAM" in os.environ, reason="threads are counted in /proc"
)
def test_no_more_threads_than_jobs(program, tmp_path):
    """Beside those that a program with one job has, as a sanitizer's may."""
    picture = np.tile(uneven(700, 700), (4, 4, 1))
    (tmp_path / "a_n.png").write_bytes(png(picture))
    for verb in ("check", "clean", "transform"):
        args = [*VERBS[verb][:1], "a_n.png", *VERBS[verb][3:], *(["--force"] * (verb != "check"))]
        alone = threads_of(program, tmp_path, 1, *args)
        for jobs in (2, 3, 4):
            seen = max(threads_of(program, tmp_path, jobs, *args) for _ in range(2))
            assert seen - alone <= jobs - 1, (verb, jobs, seen, alone)
            assert seen > alone, (verb, jobs)


def test_other_formats(same, tmp_path):
    picture = Image.fromarray(uneven(WIDE, HIGH))
    picture.save(tmp_path / "a_n.tga")
    picture.save(tmp_path / "b_n.jpg", quality=95)
    picture.save(tmp_path / "c_n.png", interlace=1)
    for name in ("a_n.tga", "b_n.jpg", "c_n.png"):
        same(name, "check", "clean")
        data = (tmp_path / name).read_bytes()
        for cut in (200, len(data) // 3, len(data) - 100):
            (tmp_path / f"cut_{name}").write_bytes(data[:cut])
            same(f"cut_{name}", "check", "clean")


def test_no_file_of_these_passes_for_another(same, tmp_path):
    """The comparison sees a single row that is not the same."""
    picture = uneven(WIDE, HIGH)
    (tmp_path / "a_n.png").write_bytes(png(picture))
    first = same("a_n.png", "check", "clean")
    picture[HIGH - 1, WIDE - 1] = (0, 255, 255)
    (tmp_path / "a_n.png").write_bytes(png(picture))
    assert all(a != b for a, b in zip(first, same("a_n.png", "check", "clean"), strict=True))


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_truncated_files(same, tmp_path, dtype):
    data = png(uneven(WIDE, HIGH, dtype))
    places = [*range(1, 60, 17), *np.linspace(60, len(data) - 30, 12).astype(int)]
    places += [len(data) - left for left in (29, 20, 12, 8, 1)]
    for place in places:
        (tmp_path / "a_n.png").write_bytes(data[:place])
        for code, *_, made in same("a_n.png", "check", "clean"):
            assert code == 3 and made is None, place


def broken_files():
    """(name, file, whether it is refused)."""
    picture = uneven(WIDE, HIGH)
    good = png(picture)
    packed = zlib.compress(rows_of(picture), 1)
    for share in (0.02, 0.5, 0.999):
        data = bytearray(good)
        place = data.index(b"IDAT", int(share * len(good)) - 9100) + 200
        data[place] ^= 4
        yield f"changed byte at {share}", bytes(data), True
        wrong = bytearray(packed)
        wrong[int(share * len(packed))] ^= 4
        yield f"changed byte with right checksums at {share}", png(picture, packed=wrong), True
    last = packed[:-4] + bytes(4)
    yield "wrong adler", png(picture, packed=last), True
    yield "no adler", png(picture, packed=packed[:-4]), True
    yield "too few rows", png(picture, size=(WIDE, HIGH + 1)), True
    yield "far too few rows", png(picture, size=(WIDE, 9 * HIGH)), True
    yield "more rows", png(picture, size=(WIDE, HIGH - 1)), False
    yield "many more rows", png(picture, size=(WIDE, HIGH // 2)), False
    yield "other width", png(picture, size=(WIDE + 1, HIGH - 1)), None
    yield "pixels after the pixels", png(picture, after=chunk(b"IDAT", bytes(50))), False
    stray = chunk(b"tEXt", b"a\0b") + chunk(b"IDAT", bytes(9000))
    yield "pixels after other chunks", png(picture, after=stray), None
    rows = bytearray(rows_of(picture))
    rows[(3 * WIDE + 1) * (HIGH // 2)] = 7
    yield "filter 7", png(picture, packed=zlib.compress(bytes(rows), 1)), True
    yield "nothing unpacked", png(picture, packed=zlib.compress(b"")), True
    yield "no pixels", png(picture, packed=b""), True


@pytest.mark.parametrize(
    ("data", "refused"), [pytest.param(data, no, id=name) for name, data, no in broken_files()]
)
def test_broken_files(same, tmp_path, data, refused):
    (tmp_path / "a_n.png").write_bytes(data)
    for code, out, err, _ in same("a_n.png", "check", "clean"):
        assert refused is None or (code == 3) == refused, (out, err)
