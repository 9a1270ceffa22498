# SPDX-License-Identifier: MIT
"""tests/elsewhere: its sums, which other processors must give too, are of every operation."""

import re
from pathlib import Path

from support import libntp_ffi

HERE = Path(__file__).resolve().parent / "elsewhere"

# Text, sizes in texels, what only adds integers that others counted, and what is another way to the
# bytes of an operation that has a sum.
WITHOUT_SUM = {
    "ntp_version",
    "ntp_status_string",
    "ntp_class_name",
    "ntp_reason_text",
    "ntp_kernel_name",
    "ntp_border_name",
    "ntp_height_method_name",
    "ntp_filter_name",
    "ntp_blend_mode_name",
    "ntp_mip_levels",
    "ntp_mip_side",
    "ntp_quarter_turns",
    "ntp_normals_reach",
    "ntp_resize_rows",
    "ntp_free_border",
    "ntp_find_border",
    "ntp_orientation_row",
    "ntp_tally_clear",
    "ntp_tally_merge",
    "ntp_diff_clear",
    "ntp_diff_merge",
    "ntp_orientation_clear",
    "ntp_orientation_merge",
    "ntp_clean_plan_size",
    "ntp_clean_plan_init",
    "ntp_height_rows_scratch_size",
    "ntp_height_from_rows",
}


def test_every_operation_has_a_sum():
    text = "".join(path.read_text(encoding="utf-8") for path in HERE.glob("*.c"))
    called = set(re.findall(r"\b(ntp_\w+)\(", text))
    assert libntp_ffi.public_functions() - called == WITHOUT_SUM
