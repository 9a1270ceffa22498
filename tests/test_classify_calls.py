# SPDX-License-Identifier: MIT
"""Names of classes, texts of reasons, and errors of classification."""

import re

import numpy as np

from support import libntp_ffi as ntp
from support import maps
from support.judged import tally_of


def reason_codes():
    text = ntp.HEADER.read_text(encoding="utf-8")
    return {name: int(n) for name, n in re.findall(r"(NTP_REASON_\w+) = (\d+)", text)}


def text_of(code, value, room=400):
    reason = ntp.ffi.new("ntp_reason *", [code, value])
    buffer = ntp.ffi.new("char[]", max(room, 1))
    return ntp.lib.ntp_reason_text(buffer, room, reason), ntp.ffi.string(buffer).decode()


def test_reason_texts():
    codes = reason_codes()
    texts = {name: text_of(code, 0.5)[1] for name, code in codes.items()}
    assert len(set(texts.values())) == len(texts) == max(codes.values()) + 1
    for text in texts.values():
        assert text[0].islower() or text[0].isdigit()
        assert not text.endswith(".") and "  " not in text
    for code in (-1, max(codes.values()) + 1, 2**31 - 1):
        assert text_of(code, 1)[1] == text_of(0, 1)[1]


def test_reason_numbers():
    code = reason_codes()["NTP_REASON_NEAR_UNIT"]
    tail = " of the used texels have about unit length"
    for value, shown in [
        (0, "0 %"), (1, "100 %"), (0.5, "50.0 %"), (0.97349, "97.3 %"), (0.99999, ">99.9 %"),
        (1e-6, "<0.1 %"), (0.001, "0.1 %"), (2.5, "250.0 %"),
    ]:  # fmt: skip
        assert text_of(code, value)[1] == shown + tail
    code = reason_codes()["NTP_REASON_XY_CENTERED"]
    for value, shown in [(0.126, "0.13"), (0, "0.00"), (1.999, "2.00"), (-0.5, "-0.50")]:
        assert text_of(code, value)[1].endswith(f"off by {shown}")
    for value in (float("nan"), float("inf"), -float("inf"), 1e300):
        assert "000000000.00" in text_of(code, value)[1]


def test_reason_text_is_cut_like_snprintf():
    code = reason_codes()["NTP_REASON_UNIT"]
    length, whole = text_of(code, 0.25)
    assert length == len(whole)
    for room in (0, 1, 2, 10, length, length + 1):
        got_length, got = text_of(code, 0.25, room)
        assert got_length == length
        assert got == whole[: max(room - 1, 0)]
    assert (
        ntp.lib.ntp_reason_text(ntp.ffi.NULL, 0, ntp.ffi.new("ntp_reason *", [code, 0.25]))
        == length
    )
    assert ntp.lib.ntp_reason_text(ntp.ffi.NULL, 9, ntp.ffi.NULL) > 0


def test_class_names():
    names = [ntp.ffi.string(ntp.lib.ntp_class_name(i)).decode() for i in range(7)]
    assert names == maps.CLASSES
    assert ntp.ffi.string(ntp.lib.ntp_class_name(99)) == b"unknown"


def test_errors():
    new = ntp.Tally()
    tally = tally_of(maps.Case("", np.full((4, 4, 3), 128, np.uint8), maps.STANDARD))
    empty, good = new.pointer, tally.pointer
    result = ntp.ffi.new("ntp_classification *")
    method = ntp.ffi.new("ntp_clean_method *")
    null = ntp.ffi.NULL
    assert ntp.lib.ntp_classify(result, empty) == ntp.ERR_ARGUMENT
    assert ntp.lib.ntp_classify(null, good) == ntp.ERR_ARGUMENT
    assert ntp.lib.ntp_classify(result, null) == ntp.ERR_ARGUMENT
    assert ntp.lib.ntp_choose_method(method, null, empty, 0, 0) == ntp.ERR_ARGUMENT
    assert ntp.lib.ntp_choose_method(method, null, good, 0, 0) == ntp.OK
    assert ntp.lib.ntp_choose_method(null, null, good, 0, 0) == ntp.ERR_ARGUMENT
    assert ntp.lib.ntp_choose_method(method, null, null, 0, 0) == ntp.ERR_ARGUMENT
    for encoding in (ntp.VECTOR, ntp.HEIGHT, 9):
        assert ntp.lib.ntp_choose_method(method, null, good, encoding, 0) == ntp.ERR_ARGUMENT
