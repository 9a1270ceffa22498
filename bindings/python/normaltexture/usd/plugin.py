# SPDX-License-Identifier: MIT
"""What USD's plugin system imports, as plugInfo.json says, when the validator is asked for."""

from .validator import register_plugin

register_plugin()
