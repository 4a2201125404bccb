#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Compiles, without linking, with cross compilers, to see that it does: the denoiser's vector code for 64-bit ARM
# (NEON), since all else has no code of its own for any processor, and the library that engines embed for Windows.
# Needs g++-aarch64-linux-gnu and g++-mingw-w64-x86-64-posix. Headers of the libraries are those of this machine: they
# hold no code of its own kind.
set -euo pipefail
cd "$(dirname "$0")/.."

arm=aarch64-linux-gnu-g++
windows=x86_64-w64-mingw32-g++-posix
for needed in "$arm g++-aarch64-linux-gnu" "$windows g++-mingw-w64-x86-64-posix"; do
  read -r compiler package <<< "$needed"
  if ! command -v "$compiler" > /dev/null; then
    echo "error: no $compiler; it is in the package $package" >&2
    exit 1
  fi
done
headers=$(mktemp -d)
trap 'rm -rf "$headers"' EXIT
for library in hwy fmt tbb oneapi glm vulkan vk_video; do
  if [ -e "/usr/include/$library" ]; then
    ln -s "/usr/include/$library" "$headers/$library"
  fi
done
# The same instruction sets as in cmake/StillrayTargets.cmake.
targets=$(sed -n 's/^  "\(HWY_DISABLED_TARGETS=.*\)")$/\1/p' cmake/StillrayTargets.cmake)

# Reads file names that end with 0.
compile() {
  xargs -0 -P "$(nproc)" -I{} "$1" -std=c++20 -O1 -fsyntax-only -Wall -Wextra -Werror -ffp-contract=off \
    "-D$targets" '-DSTILLRAY_VERSION=""' -DGLM_FORCE_CTOR_INIT -DGLM_FORCE_XYZW_ONLY -Iinclude -Isrc \
    -isystem "$headers" {}
}
grep -rlZE '"hwy/|<hwy/|-inl\.h"' src/core src/denoise --include='*.cpp' | compile "$arm"
echo "The denoiser's vector code compiles for 64-bit ARM."
find src/core src/gpu src/denoise src/capi -name '*.cpp' -print0 | compile "$windows"
echo "The library compiles for Windows."
