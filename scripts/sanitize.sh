#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Builds with clang under the address and undefined-behaviour sanitizers, runs the fast tests, and lets each
# fuzzer look for new failures for a while.
#   scripts/sanitize.sh [--all] [SECONDS per fuzzer, default 30]
#   --all  everything: the tracer, the program and the viewer too, not only the library and what reads frames
set -euo pipefail
cd "$(dirname "$0")/.."
programs=(core_test denoise_test capi_test io_test)
fuzzers=(image_fuzz)
selection=(-R "^($(IFS='|'; echo "${programs[*]}"))|^fuzz.image")
targets=(--target "${programs[@]}" "${fuzzers[@]}")
everything=OFF
if [ "${1:-}" = --all ]; then
  selection=(-L 'fast|fuzz')
  targets=()
  fuzzers+=(gltf_fuzz obj_fuzz)
  everything=ON
  shift
fi
seconds="${1:-30}"

scripts/install_packages.sh test
# One instruction set: with three of them clang takes ten minutes for the wavelet alone. The tests of
# the other build run on all.
flags='-O1 -DNDEBUG'
if grep -qw avx2 /proc/cpuinfo && grep -qw aes /proc/cpuinfo; then
  flags+=' -march=haswell -maes'
fi
cmake --preset asan -DCMAKE_CXX_FLAGS_RELEASE="$flags" \
  -DSTILLRAY_BUILD_VULKAN="$everything" -DSTILLRAY_LONG_TESTS="$everything" >/dev/null
cmake --build build-sanitize "${targets[@]}"
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
ctest --test-dir build-sanitize "${selection[@]}" --output-on-failure --no-tests=error -j "$(nproc)"

# One fuzzer per processor at a time.
fuzz() { # PROGRAM
  local name new corpus
  name="$(basename "$1" _fuzz)"
  new="$(mktemp -d)"
  corpus=("$new")
  [ -d "tests/fuzz/corpus/$name" ] && corpus+=("tests/fuzz/corpus/$name")
  if ! "$1" -max_total_time="$seconds" -rss_limit_mb=4096 -print_final_stats=1 \
    -artifact_prefix="build-sanitize/$name-" "${corpus[@]}" >"$new.log" 2>&1; then
    cat "$new.log"
    return 255  # ends xargs
  fi
  echo "fuzzed $name for $seconds s: $(grep -o 'number_of_executed_units: .*' "$new.log")"
  rm -rf "$new" "$new.log"
}
export -f fuzz
export seconds
printf '%s\0' "${fuzzers[@]/#/build-sanitize/tests/fuzz/}" | xargs -0 -n 1 -P "$(nproc)" bash -c 'fuzz "$0"'
