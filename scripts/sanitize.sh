#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Builds everything with clang under the address and undefined-behaviour sanitizers, runs the fast
# tests, and lets each fuzzer look for new failures for a while.
#   scripts/sanitize.sh [SECONDS per fuzzer, default 30]
set -euo pipefail
cd "$(dirname "$0")/.."
seconds="${1:-30}"

scripts/install_packages.sh test
# One instruction set: with three of them clang takes ten minutes for the wavelet alone. The tests of
# the other build run on all.
flags='-O1 -DNDEBUG'
if grep -qw avx2 /proc/cpuinfo && grep -qw aes /proc/cpuinfo; then
  flags+=' -march=haswell -maes'
fi
cmake --preset asan -DCMAKE_CXX_FLAGS_RELEASE="$flags" >/dev/null
cmake --build build-sanitize
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
ctest --test-dir build-sanitize -L 'fast|fuzz' --output-on-failure --no-tests=error -j "$(nproc)"

for fuzzer in build-sanitize/tests/fuzz/*_fuzz; do
  name="$(basename "$fuzzer" _fuzz)"
  new="$(mktemp -d)"
  corpus=("$new")
  [ -d "tests/fuzz/corpus/$name" ] && corpus+=("tests/fuzz/corpus/$name")
  echo "fuzzing $name for $seconds s"
  "$fuzzer" -max_total_time="$seconds" -rss_limit_mb=4096 -print_final_stats=1 \
    -artifact_prefix="build-sanitize/$name-" "${corpus[@]}" 2>&1 | tail -n 12
  rm -rf "$new"
done
