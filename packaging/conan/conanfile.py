# SPDX-License-Identifier: MIT
"""The library alone, which needs nothing but a C compiler."""

from pathlib import Path

from conan import ConanFile
from conan.tools.files import copy, get, rmdir
from conan.tools.layout import basic_layout
from conan.tools.meson import Meson, MesonToolchain

required_conan_version = ">=2.0"


class Libntp(ConanFile):
    name = "libntp"
    version = "0.0.0"
    description = (
        "Normals textures (normal maps): exact conversion, checking, cleaning, from and to heights"
    )
    license = "MIT"
    url = homepage = "https://example.com/libntp"
    topics = ("normal-map", "normals-texture", "heightfield", "graphics")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False], "fPIC": [True, False]}
    default_options = {"shared": False, "fPIC": True}
    implements = ["auto_shared_fpic"]
    languages = ["C"]

    def layout(self):
        basic_layout(self, src_folder="src")

    def build_requirements(self):
        self.tool_requires("meson/[>=1.3 <2]")

    def source(self):
        get(self, **self.conan_data["sources"][self.version], strip_root=True)

    def generate(self):
        toolchain = MesonToolchain(self)
        for part in ("io", "cli", "gegl", "gimp"):
            toolchain.project_options[part] = "disabled"
        toolchain.project_options["tests"] = False
        toolchain.generate()

    def build(self):
        meson = Meson(self)
        meson.configure()
        meson.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, Path(self.package_folder) / "licenses")
        Meson(self).install()
        rmdir(self, Path(self.package_folder) / "lib" / "pkgconfig")

    def package_info(self):
        self.cpp_info.libs = ["ntp"]
        self.cpp_info.set_property("pkg_config_name", "libntp")
        if not self.options.shared:
            self.cpp_info.defines = ["NTP_STATIC"]
        if self.settings.os in ("Linux", "FreeBSD"):
            self.cpp_info.system_libs = ["m"]
