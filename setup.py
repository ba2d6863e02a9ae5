# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Builds the Python package with CMake: pip install --no-build-isolation . (docs/python.md)."""
import os
import pathlib
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent


class CMakeBuild(build_ext):
    """The extension is a target of the project's own build, which is kept in build/python."""

    def build_extension(self, ext):
        build = ROOT / "build/python"
        package = pathlib.Path(self.get_ext_fullpath(ext.name)).resolve().parent
        parts = [f"-DPANOPTIC_{part}=OFF" for part in ("APPS", "VIEWER", "TESTS", "EXAMPLES")]
        try:
            subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-Wno-dev", "-DCMAKE_BUILD_TYPE=Release",
                            "-DPANOPTIC_UNITY=ON", "-DPANOPTIC_PYTHON=ON", f"-DPython_EXECUTABLE={sys.executable}", *parts], check=True)
            subprocess.run(["cmake", "--build", build, "--target", "panoptic_python"], check=True)
            subprocess.run(["cmake", "--install", build, "--component", "python", "--prefix", package.parent], check=True)
        except (OSError, subprocess.CalledProcessError) as error:
            sys.exit(f"panoptic could not be built: {error}; scripts/setup --packages-only installs what it needs (docs/python.md)")
        if not os.path.exists(self.get_ext_fullpath(ext.name)):
            sys.exit("panoptic was built without its Python module: see what CMake said of it above")


setup(ext_modules=[Extension("panoptic._core", sources=[])], cmdclass={"build_ext": CMakeBuild})
