#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Tests the Blender add-on: its parts, then the installed zip in a fresh user folder of Blender, in
# background mode and (with xvfb-run) in a window. Exit code 77: Blender is not installed.
#   scripts/test_blender.sh [PROGRAM [TEST ...]]    default: build/apps/stillray/stillray
set -euo pipefail
root="$(cd "$(dirname "$0")/.." && pwd)"
program="$(realpath "${1:-$root/build/apps/stillray/stillray}")"
shift || true
python=/usr/bin/python3
[ -x "$python" ] || python=python3

if [ $# -eq 0 ]; then
  "$python" -B "$root/tests/blender/parts_test.py"
  "$python" -B "$root/tests/blender/versions_test.py"
fi
if ! command -v blender >/dev/null; then
  echo "Skipped: Blender is not installed"
  exit 77
fi

blender="$(command -v blender)"
# Debian's Blender takes its modules from the first python3 on the PATH.
PATH="/usr/bin:$PATH"

folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
export BLENDER_USER_SCRIPTS="$folder/scripts" BLENDER_USER_CONFIG="$folder/config"
export BLENDER_USER_EXTENSIONS="$folder/extensions" BLENDER_USER_DATAFILES="$folder/datafiles"
mkdir -p "$BLENDER_USER_SCRIPTS" "$BLENDER_USER_CONFIG"
unset STILLRAY
"$root/scripts/blender_addon.sh" "$folder/stillray_addon.zip"

# Blender's own lines of progress, one per step of a frame, hide the tests.
quiet() { grep -av -e '^Fra:' -e '^Saved:' -e '^ Time:' -e '^$' || true; }

"$blender" -b --factory-startup --python-exit-code 1 \
  --python "$root/tests/blender/in_blender_test.py" -- "$folder/stillray_addon.zip" "$program" \
  "$folder/work" "$@" 2>&1 | quiet
# in_window NAME [BLENDER'S OPTIONS] -- [TEST'S ARGUMENTS]
in_window() {
  local name="$1" options=()
  shift
  while [ "$1" != -- ]; do options+=("$1"); shift; done
  shift
  LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s "-screen 0 1600x900x24" "$blender" --factory-startup \
    "${options[@]}" --python-exit-code 1 --python "$root/tests/blender/window_test.py" -- \
    "$folder/stillray_addon.zip" "$program" "$folder/$name" "$@" 2>&1 | quiet
}

if [ $# -eq 0 ]; then
  if ! command -v xvfb-run >/dev/null; then
    echo "Skipped: the tests in a window (xvfb-run is not installed)"
    exit
  fi
  in_window window --enable-event-simulate --
  if command -v xdotool >/dev/null; then
    in_window keyboard -- keyboard
  else
    echo "Skipped: the test with the keyboard (xdotool is not installed)"
  fi
fi
