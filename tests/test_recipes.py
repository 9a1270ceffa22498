# SPDX-License-Identifier: MIT
"""The recipes of packaging/, filled in; `./dev recipes` and `./dev deb` run them."""

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FILL = ROOT / "packaging" / "recipes.py"
ADDRESS = "https://github.example/owner/libntp"


def fill(archive, out):
    command = [sys.executable, FILL, archive, ADDRESS + "/", out]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_filled(tmp_path):
    archive = tmp_path / "libntp-12.3.45.tar.gz"
    archive.write_bytes(b"\x1f\x8babc")
    out = tmp_path / "out"
    done = fill(archive, out)
    assert done.returncode == 0, done.stderr
    texts = {p.relative_to(out).as_posix(): p.read_text() for p in out.rglob("*") if p.is_file()}
    for name, text in texts.items():
        assert "example.com" not in text and "0.0.0" not in text, name
    sums = {kind: subprocess.check_output([f"{kind}sum", archive], text=True).split()[0]
            for kind in ("sha256", "sha512")}  # fmt: skip
    assert f"SHA512 {sums['sha512']}\n" in texts["vcpkg/portfile.cmake"]
    assert f'sha256 "{sums["sha256"]}"\n' in texts["homebrew/libntp.rb"]
    assert f'sha256: "{sums["sha256"]}"\n' in texts["conan/conandata.yml"]
    assert json.loads(texts["vcpkg/vcpkg.json"])["version"] == "12.3.45"
    address = f"{ADDRESS}/releases/download/v12.3.45/libntp-12.3.45.tar.gz"
    assert address in texts["homebrew/libntp.rb"] and address in texts["conan/conandata.yml"]
    assert "normaltexture == 12.3.45" in texts["pre-commit/pyproject.toml"]
    assert ".pre-commit-hooks.yaml" in {Path(name).name for name in texts}


def test_an_archive_without_a_version_is_refused(tmp_path):
    (tmp_path / "libntp.tar.gz").write_bytes(b"")
    done = fill(tmp_path / "libntp.tar.gz", tmp_path / "out")
    assert done.returncode != 0 and "libntp-VERSION.tar.gz" in done.stderr


def test_options_exist():
    """Those that recipes give to Meson are there, and say what they may say."""
    declared = (ROOT / "meson.options").read_text()
    known = dict(re.findall(r"option\('(\w+)', type: '(\w+)'", declared))
    used = re.findall(
        r"-D([a-z_]+)=(\w+)",
        "".join((ROOT / "packaging" / name).read_text()
                for name in ("vcpkg/portfile.cmake", "homebrew/libntp.rb", "debian/rules")),
    )  # fmt: skip
    assert len(used) > 10
    values = {"feature": {"enabled", "disabled"}, "boolean": {"true", "false"}}
    for name, value in used:
        if name not in ("optimization", "default_library"):
            assert value in values[known[name]], (name, value)


def test_debian_has_this_version():
    version = re.search(r"version: '([\d.]+)'", (ROOT / "meson.build").read_text())[1]
    first = (ROOT / "packaging" / "debian" / "changelog").read_text().splitlines()[0]
    assert first.startswith(f"libntp ({version}-")
    soname = version.split(".")[1]
    assert f"Package: libntp{soname}\n" in (ROOT / "packaging" / "debian" / "control").read_text()


def test_placeholders_are_listed():
    """Each file that names no real address is filled by recipes.py, or a maintainer's to replace."""
    page = (ROOT / "docs" / "releasing.md").read_text()
    looked_at = [ROOT / "pyproject.toml", ROOT / "action.yml", ROOT / "bindings/js/package.json"]
    looked_at += [p for folder in ("packaging", "docs") for p in (ROOT / folder).rglob("*")]
    filled = {ROOT / "packaging" / name for name in ("vcpkg", "conan", "homebrew", "pre-commit")}
    found = 0
    for path in looked_at:
        placeholder = path.is_file() and b"example.com/libntp" in path.read_bytes()
        mail = path.is_file() and b"@example.com" in path.read_bytes()
        name = path.relative_to(ROOT).as_posix()
        if not (placeholder or mail) or filled & set(path.parents):
            continue
        if name not in ("packaging/recipes.py", "docs/releasing.md"):
            assert f"`{name}`" in page, name
            found += 1
    assert found >= 4
