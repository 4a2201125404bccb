#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# From a bare Debian 12: installs, builds everything and runs every test. Needs root or sudo for
# what is missing.
#   scripts/test.sh [ctest arguments, such as -R denoise or -L fast]
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install_packages.sh test
cmake --preset release >/dev/null
cmake --build build
scripts/ray_tracing_driver.sh build/ray_tracing_driver
if ! ctest --test-dir build --output-on-failure --no-tests=error -j "$(nproc)" "$@"; then
  # Windows and software drivers answer late on a busy machine. What fails alone as well has failed.
  echo "tests that failed run once more, one at a time" >&2
  ctest --test-dir build --output-on-failure --no-tests=error --rerun-failed
fi
