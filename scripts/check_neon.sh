#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Compiles the denoiser's vector code for 64-bit ARM (NEON) with a cross compiler, to see that it
# does. All else has no code of its own for any processor.
# Needs g++-aarch64-linux-gnu. Headers of the libraries are those of this machine: they hold no
# code of its own kind.
set -euo pipefail
cd "$(dirname "$0")/.."

compiler=aarch64-linux-gnu-g++
if ! command -v "$compiler" > /dev/null; then
  echo "error: no $compiler; it is in the package g++-aarch64-linux-gnu" >&2
  exit 1
fi
headers=$(mktemp -d)
trap 'rm -rf "$headers"' EXIT
for library in hwy fmt tbb oneapi glm; do
  if [ -e "/usr/include/$library" ]; then
    ln -s "/usr/include/$library" "$headers/$library"
  fi
done
# The same instruction sets as in cmake/StillrayTargets.cmake.
targets=$(sed -n 's/^  "\(HWY_DISABLED_TARGETS=.*\)")$/\1/p' cmake/StillrayTargets.cmake)
grep -rlZE '"hwy/|<hwy/|-inl\.h"' src/core src/denoise --include='*.cpp' |
  xargs -0 -P "$(nproc)" -I{} "$compiler" -std=c++20 -O1 -fsyntax-only -Wall -Wextra -Werror \
    -ffp-contract=off "-D$targets" -DGLM_FORCE_CTOR_INIT -DGLM_FORCE_XYZW_ONLY -Iinclude -Isrc \
    -isystem "$headers" {}
echo "The denoiser's vector code compiles for 64-bit ARM."
