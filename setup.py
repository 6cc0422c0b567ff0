"""Builds the Python module by CMake: `pip install . --no-build-isolation --no-deps` (docs/python.md).

VIEWPEEL_BUILD_DIR=build/release uses the library of an existing build tree instead of compiling it again.
CMAKE_ARGS has further arguments for CMake, such as -DCMAKE_CXX_FLAGS_RELEASE=-O1.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = Path(__file__).parent.resolve()


def configure(tree, *settings):
    parts = [f"-DVIEWPEEL_BUILD_{part}=OFF" for part in ("PROGRAM", "TESTS", "BENCH", "REFERENCE", "C")]
    subprocess.run(
        ["cmake", "-S", ROOT, "-B", tree, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DVIEWPEEL_UNITE_FILES=ON", "-DVIEWPEEL_INSTALL=OFF",
         "-DVIEWPEEL_BUILD_PYTHON=ON", f"-DPython_EXECUTABLE={sys.executable}", *parts, *shlex.split(os.environ.get("CMAKE_ARGS", "")), *settings],
        check=True)  # fmt: skip


def build(tree, target):
    return subprocess.run(["cmake", "--build", tree, "--target", target]).returncode == 0


class CMakeBuild(build_ext):
    """Builds the CMake target viewpeel_python, and copies the module to where setuptools expects it."""

    def build_extension(self, extension):
        given = os.environ.get("VIEWPEEL_BUILD_DIR")
        tree = (ROOT / given).resolve() if given else Path(self.build_temp).resolve()
        if not given:
            configure(tree, "-DVIEWPEEL_BUILD_REPORT=ON")
            # The page of Result.report() takes packages from npm. Without a network the module is built without it.
            if "viewpeel_page" in (tree / "build.ninja").read_text() and not build(tree, "viewpeel_page"):
                print("setup.py: npm cannot get the packages of the page; Result.report() will say that it has none")
                configure(tree, "-DVIEWPEEL_BUILD_REPORT=OFF")
        if not build(tree, "viewpeel_python"):
            sys.exit("setup.py: the module cannot be compiled; the lines above say why, with `pip install -v`")
        built = tree / "python" / ("_core" + sysconfig.get_config_var("EXT_SUFFIX"))
        if not built.exists():
            sys.exit(f"setup.py: {tree} builds the module for another Python than {sys.executable}; unset VIEWPEEL_BUILD_DIR")
        target = Path(self.get_ext_fullpath(extension.name)).resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(built, target)


version = re.search(r"project\(viewpeel VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
setup(version=version, ext_modules=[Extension("viewpeel._core", sources=[])], cmdclass={"build_ext": CMakeBuild})
