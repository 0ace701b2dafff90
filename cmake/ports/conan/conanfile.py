"""The recipe of the tree it stands in: conan create cmake/ports/conan"""

import os
import re

from conan import ConanFile
from conan.tools.files import copy, load


class Gelight(ConanFile):
    name = "gelight"
    license = "MIT"
    description = "Geodesics on triangle meshes and the images of optical tactile sensors"
    package_type = "header-library"
    no_copy_source = True

    @property
    def tree(self):
        return os.path.join(self.recipe_folder, "..", "..", "..")

    def set_version(self):
        text = load(self, os.path.join(self.tree, "include/gelight/version.hpp"))
        self.version = ".".join(re.findall(r"GELIGHT_VERSION_\w+ (\d+)", text))

    def export_sources(self):
        copy(self, "include/*", self.tree, self.export_sources_folder)
        copy(self, "LICENSE", self.tree, self.export_sources_folder)

    def requirements(self):
        self.requires("eigen/3.4.0", transitive_headers=True)

    def package(self):
        copy(self, "include/*", self.source_folder, self.package_folder)
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))

    def package_info(self):
        self.cpp_info.bindirs = []
        self.cpp_info.libdirs = []
        self.cpp_info.set_property("cmake_file_name", "gelight")
        self.cpp_info.set_property("cmake_target_name", "gelight::gelight")
        self.cpp_info.system_libs = ["pthread"] if self.settings.get_safe("os") == "Linux" else []
