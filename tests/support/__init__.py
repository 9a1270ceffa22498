# SPDX-License-Identifier: MIT
"""What tests share: oracles and models, made textures, readers and writers, callers of GIMP.

A module here holds no test.  Oracles and models use nothing from the code that they check.
"""
