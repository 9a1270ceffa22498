# SPDX-License-Identifier: MIT
# The cffi module: `lib` has the functions and constants of libntp.h and ntpio.h.
from typing import Any

ffi: Any
lib: Any
