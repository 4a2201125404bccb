#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Makes the pictures of docs/blender.md: Blender in a window of its own, with a fresh user folder.
# Needs blender and xvfb-run.
#   scripts/blender_pictures.sh [PROGRAM [FOLDER]]
#   default: build/apps/stillray/stillray docs/images
set -euo pipefail
root="$(cd "$(dirname "$0")/.." && pwd)"
program="$(realpath "${1:-$root/build/apps/stillray/stillray}")"
images="$(realpath "${2:-$root/docs/images}")"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
export BLENDER_USER_SCRIPTS="$folder/scripts" BLENDER_USER_CONFIG="$folder/config"
mkdir -p "$BLENDER_USER_SCRIPTS" "$BLENDER_USER_CONFIG"
"$root/scripts/blender_addon.sh" "$folder/stillray_addon.zip"
LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s "-screen 0 1360x900x24" blender --factory-startup \
  --python "$root/scripts/blender_pictures.py" -- "$folder/stillray_addon.zip" "$program" \
  "$folder/work" "$images" 2>&1 | { grep -a -e '^blender_pictures' -e Error -e '^  File' || true; }
