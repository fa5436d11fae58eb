"""Builds the extension module of the Python package by CMake, with further arguments from the environment variable
CMAKE_ARGS. pyproject.toml says everything else."""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent


class BuildByCMake(build_ext):
    def build_extension(self, ext):
        build = pathlib.Path(self.build_temp).resolve()
        off = [f"-DSFT_{part}=OFF" for part in
               ("BUILD_TESTS", "BUILD_BENCH", "BUILD_EXAMPLES", "BUILD_TOOLS", "INSTALL")]
        subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                        f"-DPython_EXECUTABLE={sys.executable}", *off, *shlex.split(os.environ.get("CMAKE_ARGS", ""))],
                       check=True)
        subprocess.run(["cmake", "--build", build, "--target", "sft_python", "sftd"], check=True)
        made = build / "python" / "sft"
        to = pathlib.Path(self.get_ext_fullpath(ext.name)).resolve().parent
        to.mkdir(parents=True, exist_ok=True)
        for file in [*made.glob("_sft*.so"), made / "sftd"]:
            shutil.copy2(file, to / file.name)
        shutil.copytree(ROOT / "typesupport" / "interfaces", to / "interfaces", dirs_exist_ok=True,
                        ignore=lambda _, names: [name for name in names if name.endswith((".txt", ".idl"))])


version = re.search(r"project\(sft VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
setup(version=version, ext_modules=[Extension("sft._sft", [])], cmdclass={"build_ext": BuildByCMake})
