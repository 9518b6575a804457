"""Builds the extension with CMake, in build/ of the project or in $LEEWAY_BUILD, for setuptools to pack."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

PROJECT = pathlib.Path(__file__).resolve().parent.parent
BUILD = pathlib.Path(os.environ.get("LEEWAY_BUILD", PROJECT / "build"))


class CMakeExtension(build_ext):
    def build_extension(self, ext):
        if not (BUILD / "CMakeCache.txt").exists():
            subprocess.run(["cmake", "-S", PROJECT, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                            f"-DPython_EXECUTABLE={sys.executable}"], check=True)
        subprocess.run(["cmake", "--build", BUILD, "--target", "leeway_python"], check=True)
        target = pathlib.Path(self.get_ext_fullpath(ext.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(BUILD / "python" / "leeway" / target.name, target)


scratch = BUILD / "wheel"
scratch.mkdir(parents=True, exist_ok=True)
setup(
    version=re.search(r"project\(leeway VERSION (\S+)", (PROJECT / "CMakeLists.txt").read_text()).group(1),
    ext_modules=[Extension("leeway._leeway", sources=[])],
    cmdclass={"build_ext": CMakeExtension},
    # All that is written goes to the build.
    options={"build": {"build_base": str(scratch)}, "egg_info": {"egg_base": str(scratch)}, "bdist_wheel": {"bdist_dir": str(scratch / "pack")}},
)
