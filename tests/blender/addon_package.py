# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Makes the modules of the add-on that need no Blender importable without it."""
import pathlib
import sys
import types

ROOT = pathlib.Path(__file__).resolve().parents[2]

if "stillray_addon" not in sys.modules:
    package = types.ModuleType("stillray_addon")
    package.__path__ = [str(ROOT / "blender/stillray_addon")]
    sys.modules["stillray_addon"] = package
