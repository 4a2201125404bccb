#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# From a bare Debian 12 to clean pictures in some minutes: installs, builds the program for this
# machine's CPU, renders a built-in scene at one sample per pixel, denoises it, and compares the last
# frames with converged ones. Needs root or sudo for what is missing.
#   scripts/demo.sh [FOLDER]     default: out/demo
set -euo pipefail
cd "$(dirname "$0")/.."
out="${1:-out/demo}"

scripts/install_packages.sh program
echo "building the program for this machine's CPU: about four minutes on two cores"
cmake --preset quick >/dev/null
cmake --build --preset quick

stillray=build-quick/apps/stillray/stillray
"$stillray" render builtin:cornell -o "$out" --size 640x360 --frames 1-60 --save-inputs \
  --reference 64 --reference-frames 59-60
"$stillray" report "$out"

echo
echo "noisy:      $out/noisy.0060.png"
echo "denoised:   $out/denoised.0060.png"
echo "converged:  $out/reference.0060.png"
if [ -f "$out/denoised.mp4" ]; then
  echo "video:      $out/denoised.mp4"
fi
echo "all side by side, in a browser: $out/report.html"
echo
echo "The program is $PWD/$stillray; begin with:"
echo "  $stillray"
echo "It runs on this machine's CPU. With GPUs (Vulkan), libstillray and Python, for any machine:"
echo "  scripts/install_packages.sh build && cmake --preset release -DSTILLRAY_BUILD_TESTS=OFF && cmake --build build"
