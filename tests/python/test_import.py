"""Packages that do not fit their Python or their numpy say for which they were built, when they are imported."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import sft

PACKAGE = Path(sft.__file__).parent


def error_of_import(*folders):
    """Imports sft where these folders come first."""
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(map(str, folders)))
    done = subprocess.run([sys.executable, "-c", "import sft"], env=environment, capture_output=True, text=True)
    assert done.returncode == 1
    return done.stderr


def test_a_package_for_another_python_names_both(tmp_path):
    (tmp_path / "sft").mkdir()
    for file in PACKAGE.glob("*.py"):
        shutil.copy(file, tmp_path / "sft")
    (tmp_path / "sft" / "_sft.cpython-27-x86_64.so").touch()
    error = error_of_import(tmp_path)
    assert f"this is {sys.implementation.cache_tag} ({sys.executable})" in error
    assert "the package was built as ['_sft.cpython-27-x86_64.so']: use that Python" in error


@pytest.mark.skipif(sft._sft.knows_numpy_2, reason="this package works with numpy 2")
def test_a_package_for_numpy_1_names_the_numpy_that_it_found(tmp_path):
    (tmp_path / "numpy.py").write_text("__version__ = '2.1.3'")
    assert "works with numpy 1 only, and this is numpy 2.1.3: install 'numpy<2'" in error_of_import(tmp_path,
                                                                                                   PACKAGE.parent)
