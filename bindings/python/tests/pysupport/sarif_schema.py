# SPDX-License-Identifier: MIT
"""What SARIF 2.1.0 says of the objects that we write, as a JSON schema in our own words.

It is stricter than the standard's own: a property that is not listed here is an error, so that a
misspelled name cannot pass.  Section numbers are those of the OASIS standard.  The classes of
sarif_om are generated from the standard's own schema, and know all properties and which of them are
required.  That schema itself comes with an npm package of Microsoft's under the MIT license, which
`./dev python` installs into its virtual environment.
"""

import json
import sys
from pathlib import Path

import attr
import pytest
import sarif_om
from jsonschema import Draft7Validator, Draft202012Validator

OFFICIAL = "lib/node_modules/@microsoft/jest-sarif/lib/schemas/sarif-2.1.0-rtm.5.json"


def _object(required, **properties):
    return {
        "type": "object",
        "required": required,
        "properties": properties,
        "additionalProperties": False,
    }


TEXT = {"type": "string", "minLength": 1}
SENTENCE = {"type": "string", "pattern": r"\.$"}
URI = {"type": "string", "pattern": r"^(file://)?[A-Za-z0-9._~!$&'()*+,;=:@/%-]+$"}
LEVEL = {"enum": ["none", "note", "warning", "error"]}  # 3.27.10
MESSAGE = _object(["text"], text=TEXT, markdown=TEXT)  # 3.12
INDEX = {"type": "integer", "minimum": 0}

RULE = _object(  # reportingDescriptor, 3.49
    ["id"],
    id={"type": "string", "pattern": "^NT[0-9]{3}$"},
    shortDescription=MESSAGE,
    fullDescription=MESSAGE,
    help=MESSAGE,
    defaultConfiguration=_object([], level=LEVEL),
)
LOCATION = _object(  # 3.28
    ["physicalLocation"],
    physicalLocation=_object(  # 3.29
        ["artifactLocation"],
        artifactLocation=_object(["uri"], uri=URI, uriBaseId=TEXT),  # 3.4
        region=_object(["startLine"], startLine={"type": "integer", "minimum": 1}),  # 3.30
    ),
    logicalLocations={
        "type": "array",
        "items": _object([], fullyQualifiedName=TEXT, kind=TEXT),  # 3.33
    },
)
RESULT = _object(  # 3.27
    ["message", "ruleId"],
    ruleId=TEXT,
    ruleIndex=INDEX,
    level=LEVEL,
    message=_object(["text"], text=SENTENCE),
    locations={"type": "array", "minItems": 1, "items": LOCATION},
    partialFingerprints={"type": "object", "additionalProperties": TEXT},
    properties={"type": "object"},
)
DRIVER = _object(  # toolComponent, 3.19
    ["name"],
    name=TEXT,
    version=TEXT,
    semanticVersion={"type": "string", "pattern": r"^\d+\.\d+\.\d+$"},
    rules={"type": "array", "items": RULE, "uniqueItems": True},
)
RUN = _object(  # 3.14
    ["tool", "results"],
    tool=_object(["driver"], driver=DRIVER),
    invocations={
        "type": "array",
        "items": _object(
            ["executionSuccessful"],
            executionSuccessful={"type": "boolean"},
            toolExecutionNotifications={  # 3.58
                "type": "array",
                "items": _object(["message"], level=LEVEL, message=MESSAGE),
            },
        ),
    },
    originalUriBaseIds={
        "type": "object",
        "additionalProperties": _object([], uri=URI, description=MESSAGE),
    },
    columnKind={"enum": ["utf16CodeUnits", "unicodeCodePoints"]},
    results={"type": "array", "items": RESULT},
)
SCHEMA = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    **_object(  # sarifLog, 3.13
        ["version", "runs"],
        **{"$schema": {"type": "string", "pattern": "sarif-schema-2.1.0.json$"}},
        version={"const": "2.1.0"},
        runs={"type": "array", "items": RUN},
    ),
}

# Which class an object is of, or those in an array, by the property that holds it.
CLASSES = {
    "runs": sarif_om.Run,
    "tool": sarif_om.Tool,
    "driver": sarif_om.ToolComponent,
    "rules": sarif_om.ReportingDescriptor,
    "shortDescription": sarif_om.MultiformatMessageString,
    "fullDescription": sarif_om.MultiformatMessageString,
    "help": sarif_om.MultiformatMessageString,
    "defaultConfiguration": sarif_om.ReportingConfiguration,
    "invocations": sarif_om.Invocation,
    "toolExecutionNotifications": sarif_om.Notification,
    "originalUriBaseIds": sarif_om.ArtifactLocation,
    "results": sarif_om.Result,
    "message": sarif_om.Message,
    "description": sarif_om.Message,
    "locations": sarif_om.Location,
    "physicalLocation": sarif_om.PhysicalLocation,
    "artifactLocation": sarif_om.ArtifactLocation,
    "region": sarif_om.Region,
    "logicalLocations": sarif_om.LogicalLocation,
}
MAPS = {
    "originalUriBaseIds"
}  # objects whose property names are ours; their values are of the class
FREE = {"properties", "partialFingerprints"}


def check_properties(value, kind=sarif_om.SarifLog):
    """Each object has properties of its class only, and all that the class requires."""
    known = {a.metadata["schema_property_name"]: a.default for a in attr.fields(kind)}
    required = {name for name, default in known.items() if default is attr.NOTHING}
    assert required <= set(value) <= set(known), (kind.__name__, sorted(value))
    for name, held in value.items():
        values = list(held.values()) if name in MAPS else held if isinstance(held, list) else [held]
        for each in values:
            if isinstance(each, dict) and name not in FREE:
                check_properties(each, CLASSES[name])


def check_objects(log):
    """Each object is as SCHEMA says."""
    Draft202012Validator(SCHEMA).validate(log)


def check_officially(log):
    """The log is as the schema of OASIS says."""
    path = Path(sys.prefix) / OFFICIAL
    if not path.exists():
        pytest.skip("the schema of SARIF is not installed: ./dev python does it")
    schema = json.loads(path.read_text(encoding="utf-8"))
    validator = Draft7Validator(schema, format_checker=Draft7Validator.FORMAT_CHECKER)
    validator.validate(log)


def validate(log):
    check_objects(log)
    check_properties(log)
