# SPDX-License-Identifier: Apache-2.0
"""Finds the Python package `gnomon`, on which the add-on is built."""
from __future__ import annotations

import importlib
import os
import sys
from types import ModuleType
from typing import Optional

_problem = ""


def folders(preferred: str = "") -> list:
    """Where the package is looked for beside Python's own folders: the preferences, GNOMON_PYTHON, and the places of an
    installation that this file is part of."""
    here = os.path.dirname(os.path.abspath(__file__))
    found = [preferred, os.environ.get("GNOMON_PYTHON", ""), os.path.join(here, "lib")]
    # PREFIX/share/blender/scripts/addons/gnomon_render beside PREFIX/lib/python3.11/dist-packages
    prefix = os.path.abspath(os.path.join(here, *[os.pardir] * 5))
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    for site in ("dist-packages", "site-packages"):
        found.append(os.path.join(prefix, "lib", version, site))
    return [folder for folder in found if folder and os.path.isdir(os.path.join(folder, "gnomon"))]


def find(preferred: str = "") -> Optional[ModuleType]:
    """The package; None if it cannot be loaded, and problem() says why."""
    global _problem
    if "gnomon" in sys.modules:
        return sys.modules["gnomon"]
    added = [folder for folder in folders(preferred) if folder not in sys.path]
    sys.path[:0] = added
    try:
        return importlib.import_module("gnomon")
    except ImportError as error:
        for folder in added:
            sys.path.remove(folder)
        _problem = (f"the Python package gnomon cannot be loaded ({error}): install python3-gnomon, or give its folder in the "
                    "add-on's preferences")
        return None


def problem() -> str:
    return _problem
