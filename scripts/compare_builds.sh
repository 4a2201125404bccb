#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Compares the output of two builds bit by bit over a list of runs: every preset of `render` at one
# sample per pixel and below, kernels, windows and passes of `denoise`, saved histories. For changes
# that must not change a picture.
#   scripts/compare_builds.sh BASE_BUILD NEW_BUILD [SEQUENCE]
#   SEQUENCE  noisy EXR frames of another renderer to denoise too, e.g. 'shots/frame_####.exr'
#   FILTER=render  only runs whose name contains this
# Example: scripts/compare_builds.sh ../before/build build
set -euo pipefail
if [ $# -lt 2 ]; then
  sed -n '5,12s/^# \{0,1\}//p' "$0"
  exit 2
fi
base="$(realpath "$1")"
new="$(realpath "$2")"
sequence="${3:-}"
out="$(mktemp -d)"
trap 'rm -rf "$out"' EXIT
failed=0
count=0

# The same command with both builds, each in a folder of its own, so that no path differs.
both() { # NAME COMMAND...
  local name="$1" side
  shift
  case "$name" in *"${FILTER:-}"*) ;; *) return 0 ;; esac
  count=$((count + 1))
  for side in base new; do
    mkdir -p "$out/$side"
    if ! (cd "$out/$side" && BUILD="${!side}" "$@" >"$out/$side.log" 2>&1); then
      echo "FAILED    $name ($side): $(tail -n 1 "$out/$side.log")"
      failed=1
      return 0
    fi
  done
  local different
  different="$(cd "$out/base" && find . -type f \( -name '*.exr' -o -name '*.png' -o -name '*.bin' \) | sort |
    while read -r file; do cmp -s "$file" "$out/new/$file" || echo "$file"; done)"
  local files
  files="$(find "$out/base" -type f \( -name '*.exr' -o -name '*.png' -o -name '*.bin' \) | wc -l)"
  if [ -n "$different" ] || [ "$files" = 0 ]; then
    echo "DIFFERENT $name: $(echo "$different" | wc -l) of $files files, first $(echo "$different" | head -n 1)"
    failed=1
  else
    echo "same      $name ($files files)"
  fi
}
fresh() { rm -rf "$out/base" "$out/new"; }
stillray() { "$BUILD/apps/stillray/stillray" "$@"; }
export -f stillray

render() { # NAME OPTIONS...: five frames of a small scene in motion
  local name="$1"
  shift
  both "render $name" bash -c 'stillray render "$@"' - builtin:spheres -o . --size 97x61 --frames 1-5 \
    --device cpu --format exr --save-inputs "$@"
  fresh
}

for preset in default svgf psvgf eaw temporal; do
  render "$preset" --preset "$preset"
done
render "outputs" --preset default --aov temporal,variance,history,disocclusion
render "all outputs of svgf" --preset svgf --aov temporal,noisy,accumulated,filtered,filtered_variance,moment_mean
for preset in default svgf psvgf; do
  render "$preset, 1/8 sample per pixel, sparse guides" --preset "$preset" --spp 1/8 --guides sparse
  render "$preset, 1/4 sample per pixel" --preset "$preset" --spp 1/4
  render "$preset, 5x5" --preset "$preset" --set kernel=5x5
  render "$preset, one signal" --preset "$preset" --set signals=single
  render "$preset, all in one" --preset "$preset" --set firefly=clamp --set antialias=taa --set fxaa=on
done
render "svgf, compressed fireflies" --preset svgf --set firefly=compress
render "psvgf, blended feedback" --preset psvgf --spp 1/4 --set feedback_when=blend
render "default, rec601, constant weights" --set luminance=rec601 --set history_weight=constant

denoise() { # NAME OPTIONS...: noisy frames of a scene in motion
  local name="$1"
  shift
  both "denoise $name" bash -c 'stillray render builtin:lights -o noisy --size 96x64 --frames 1-20 --device cpu \
    --format exr --save-inputs >/dev/null 2>&1
    rm -f noisy/denoised*
    stillray denoise "noisy/noisy.####.exr" -o clean --device cpu --no-check "$@"' - "$@"
  fresh
}
denoise "both windows"
denoise "past" --window past
denoise "svgf, past, passes" --preset svgf --window past --passes
denoise "both windows, passes" --window both --passes
denoise "each frame alone" --set temporal=off

if [ -n "$sequence" ]; then
  sequence="$(realpath "$(dirname "$sequence")")/$(basename "$sequence")"
  for options in "--window past" "--window both" "--window both --passes" "--preset svgf --window past" \
    "--set temporal=off"; do
    # shellcheck disable=SC2086
    both "$(basename "$sequence") $options" bash -c 'sequence="$1"; shift; stillray denoise "$sequence" -o clean \
      --device cpu --no-check "$@"' - "$sequence" $options
    fresh
  done
fi

history_script='
import sys, numpy as np
import stillray
rng = np.random.default_rng(7)
h, w = 53, 71
for preset in ("default", "svgf", "psvgf"):
    d = stillray.Denoiser(preset=preset)
    for frame in range(4):
        rgb = rng.random((h, w, 3), dtype=np.float32)
        y, x = np.mgrid[0:h, 0:w].astype(np.float32)
        d.denoise(dict(direct_diffuse=rgb, albedo=0.2 + 0.6 * rng.random((h, w, 3), dtype=np.float32).round(),
                  normal=np.dstack([x * 0, x * 0, x * 0 + 1]).astype(np.float32), depth=1 + x / w + y / h,
                  motion=np.dstack([x * 0 + 0.5, y * 0]).astype(np.float32)))
    open("history_" + preset + ".bin", "wb").write(bytes(d.save_history()))
'
export history_script
# The modules are made for the interpreter that CMake found, as a rule the system's.
python="${PYTHON:-/usr/bin/python3}"
modules="$(find "$base/python" "$new/python" -name '_stillray*.so' 2>/dev/null | wc -l)"
if [ "$modules" = 2 ] && "$python" -c 'import numpy' 2>/dev/null; then
  export python
  both "saved histories" bash -c 'PYTHONPATH="$BUILD/python" "$python" -c "$history_script"'
else
  echo "skipped   saved histories: needs the Python module in both builds, and NumPy ($python)"
fi

echo "$count runs compared"
exit "$failed"
