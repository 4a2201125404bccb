#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# From a bare Debian 12: installs what is missing (as root or with sudo), builds, and runs tests.
#   scripts/test.sh [ctest arguments, such as -R denoise or -L fast]
#     What every change must pass, in build-test: vector code for this machine's CPU only.
#   scripts/test.sh --all [ctest arguments]
#     All tests, in build: vector code of all instruction sets, every part of the Vulkan code, windows, a browser,
#     packages. Twice as long.
set -euo pipefail
cd "$(dirname "$0")/.."

packages=test
preset=test
folder=build-test
if [ "${1:-}" = --all ]; then
  packages=all
  preset=release
  folder=build
  shift
fi
scripts/install_packages.sh "$packages"
cmake --preset "$preset" >/dev/null
cmake --build "$folder"
[ "$folder" != build ] || scripts/ray_tracing_driver.sh build/ray_tracing_driver
if ! ctest --test-dir "$folder" --output-on-failure --no-tests=error -j "$(nproc)" "$@"; then
  # Windows and software drivers answer late on a busy machine. What fails alone as well has failed.
  echo "tests that failed run once more, one at a time" >&2
  ctest --test-dir "$folder" --output-on-failure --no-tests=error --rerun-failed
fi
