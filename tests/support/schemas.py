# SPDX-License-Identifier: MIT
"""Reports of the program against the schemas in docs.

A schema is read and checked once: jsonschema.validate would check it at each call, which takes
longer than the program does.
"""

import functools
import json

import jsonschema

from .libntp_ffi import ROOT


@functools.cache
def _validator(name):
    schema = json.loads((ROOT / f"docs/schema/{name}.json").read_text(encoding="utf-8"))
    kind = jsonschema.validators.validator_for(schema)
    kind.check_schema(schema)
    return kind(schema)


def validate(report, name):
    """Fails unless the report is as docs/schema/NAME.json says."""
    _validator(name).validate(report)
