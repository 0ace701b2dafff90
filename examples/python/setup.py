"""What pip runs (see pyproject.toml): CMake builds the module in build/python, as cmake/python.sh
does, so that what is built there already is not built again."""

import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import sysconfig

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

TOP = pathlib.Path(__file__).resolve().parents[2]
BUILT = TOP / "build/python/examples/python/gelight"


class BuildByCMake(build_py):
    def run(self):
        options = [f"-DPython_EXECUTABLE={sys.executable}"]
        try:
            import pybind11

            options.append(f"-Dpybind11_DIR={pybind11.get_cmake_dir()}")
        except ImportError:
            pass  # the system's
        options += shlex.split(os.environ.get("CMAKE_ARGS", ""))
        self.cmake("--preset", "python", *options)
        self.cmake("--build", "--preset", "python", "--target", "gelight_python",
                   "--parallel", str(os.cpu_count() or 1))
        library = "_gelight" + sysconfig.get_config_var("EXT_SUFFIX")
        package = pathlib.Path(self.build_lib) / "gelight"
        package.mkdir(parents=True, exist_ok=True)
        for name in ("__init__.py", "__init__.pyi", "py.typed", library):
            shutil.copy(BUILT / name, package / name)

    @staticmethod
    def cmake(*arguments):
        subprocess.run(["cmake", *arguments], cwd=TOP, check=True)


class BinaryDistribution(Distribution):
    def has_ext_modules(self):
        return True  # a wheel for one interpreter


work = TOP / "build/pip"
work.mkdir(parents=True, exist_ok=True)
setup(
    distclass=BinaryDistribution,
    cmdclass={"build_py": BuildByCMake},
    packages=["gelight"],
    package_dir={"gelight": "package"},
    options={"build": {"build_base": str(work)}, "egg_info": {"egg_base": str(work)}},
)
