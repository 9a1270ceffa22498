# SPDX-License-Identifier: MIT
"""The check as a validator of UsdValidation, beside those that USD brings.

Programs that read PXR_PLUGINPATH_NAME, such as usdchecker, find it by the plugInfo.json in this
folder:  PXR_PLUGINPATH_NAME=$(python -m normaltexture.usd.validator) usdchecker scene.usda
In Python `register` does the same without a plugin.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

from ._check import check_scene
from ._read import Scene

Plug: Any = import_module("pxr.Plug")
UsdValidation: Any = import_module("pxr.UsdValidation")

PLUGIN = "normaltexture.usd.plugin"
NAME = "NormalsTextureValidator"
DOC = (
    "Normals textures hold well-formed normals, are read as raw data, and scale and bias fit what "
    "they store."
)
KEYWORD = "NormalsTextures"
_LEVELS = {
    "error": UsdValidation.ValidationErrorType.Error,
    "warning": UsdValidation.ValidationErrorType.Warn,
    "info": UsdValidation.ValidationErrorType.Info,
}


def _errors(stage: Any, *_: Any) -> list[Any]:
    """The findings of a stage as errors; notes are left out."""
    path = Path(stage.GetRootLayer().realPath or ".")
    scene = Scene(path, stage, path.parent, 1 << 30)
    errors = []
    for entry in check_scene(scene):
        sites = [UsdValidation.ValidationErrorSite(stage, use["shader"]) for use in entry["uses"]]
        found = entry["findings"]
        if entry["status"] == "unreadable":
            found = [{"id": "unreadable", "level": "error", "message": entry["message"]}]
        for one in found:
            if one["level"] != "info":
                message = f"{entry['image']}: {one['id']} {one['message']}"
                level = _LEVELS[one["level"]]
                errors.append(UsdValidation.ValidationError(one["id"], level, sites, message))
    return errors


def register() -> str:
    """Registers the validator with UsdValidation; gives its name.  Twice does no harm."""
    registry = UsdValidation.ValidationRegistry()
    if Plug.Registry().GetPluginWithName(PLUGIN):
        return f"{PLUGIN}:{NAME}"  # USD loads it when it is asked for
    name = NAME
    if not registry.HasValidator(name):
        metadata = UsdValidation.ValidatorMetadata(name=name, doc=DOC, keywords=[KEYWORD])
        registry.RegisterStageValidator(metadata, _errors)
    return name


def register_plugin() -> None:
    """What USD's plugin system calls for: the validator that plugInfo.json announces."""
    registry = UsdValidation.ValidationRegistry()
    registry.RegisterPluginStageValidator(f"{PLUGIN}:{NAME}", _errors)


def folder() -> Path:
    """The folder of plugInfo.json, for PXR_PLUGINPATH_NAME."""
    return Path(__file__).parent


if __name__ == "__main__":
    print(folder())
