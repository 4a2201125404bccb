#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Makes the zip of the Blender add-on, for Preferences > Add-ons > Install from Disk in every
# version of Blender since 3.4. The same sources give the same bytes.
#   scripts/blender_addon.sh [FILE.zip]     default: out/stillray_addon.zip
set -euo pipefail
cd "$(dirname "$0")/.."
file="${1:-out/stillray_addon.zip}"

python3 -B - "$file" <<'PYTHON'
import os
import pathlib
import sys
import zipfile

target = pathlib.Path(sys.argv[1])
source = pathlib.Path("blender/stillray_addon")
target.parent.mkdir(parents=True, exist_ok=True)
temporary = target.with_name(target.name + ".tmp")
with zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
    for path in [*sorted(source.glob("*.py")), source / "blender_manifest.toml",
                 pathlib.Path("LICENSE")]:
        name = f"stillray_addon/{path.name}"
        archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), path.read_bytes(),
                         zipfile.ZIP_DEFLATED)
os.replace(temporary, target)
print(target)
PYTHON
