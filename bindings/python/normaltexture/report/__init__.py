# SPDX-License-Identifier: MIT
"""Reports of a check: one HTML page with pictures, SARIF 2.1.0, or annotations of GitHub Actions.

Each starts from the JSON of ``ntp check``, which `check_json` runs; that of `normaltexture.gltf`
and `normaltexture.distributed` has the same shape.

>>> from normaltexture import report
>>> found = report.check_json(["wall_n.png"])
>>> page = report.build(found, title="Walls")
>>> report.to_sarif(found)["version"]
'2.1.0'
"""

from ._check import check_json
from ._page import build, save
from ._pictures import Pictures, draw
from .sarif import to_github, to_sarif

__all__ = ["Pictures", "build", "check_json", "draw", "save", "to_github", "to_sarif"]
