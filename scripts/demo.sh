#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# From a bare Debian 12 to clean pictures: installs, builds, renders a built-in scene at one sample
# per pixel, denoises it, and compares the last frames with converged ones. Needs root or sudo.
#   scripts/demo.sh [FOLDER]     default: out/demo
set -euo pipefail
cd "$(dirname "$0")/.."
out="${1:-out/demo}"

scripts/install_packages.sh build
cmake --preset release -DSTILLRAY_BUILD_TESTS=OFF >/dev/null
cmake --build build  # all of it, so that `cmake --install build` works afterwards

stillray=build/apps/stillray/stillray
"$stillray" render builtin:cornell -o "$out" --size 640x360 --frames 1-60 --save-inputs --aov temporal \
  --reference 256 --reference-frames 59-60 --timings
"$stillray" compare "$out/denoised.####.exr" "$out/reference.####.exr"
"$stillray" report "$out"

echo
echo "noisy:      $out/noisy.0060.png"
echo "denoised:   $out/denoised.0060.png"
echo "converged:  $out/reference.0060.png"
echo "video:      $out/denoised.mp4"
echo "all side by side, in a browser: $out/report.html"
