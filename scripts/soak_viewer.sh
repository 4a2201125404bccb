#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Builds the viewer under the address and undefined-behaviour sanitizers and lets random events loose
# on it, on a display of its own.
#   scripts/soak_viewer.sh [SECONDS, default 120] [SEED]
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install_packages.sh all
CC=clang CXX=clang++ cmake -S . -B build-soak -G Ninja -DSTILLRAY_BUILD_TESTS=OFF \
  -DSTILLRAY_BUILD_PYTHON=OFF -DCMAKE_BUILD_TYPE=RelWithDebInfo \
  -DSTILLRAY_SANITIZE=address,undefined >/dev/null
cmake --build build-soak --target stillray
# Leaks are seen as growth: the OpenGL driver is gone before a leak check could tell its memory from
# ours. Freed memory is kept for a while to find late uses of it; it must not look like growth.
export ASAN_OPTIONS=detect_leaks=0:quarantine_size_mb=16
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
python3 -B tests/view/soak.py build-soak/apps/stillray/stillray "${1:-120}" ${2:+"$2"}
