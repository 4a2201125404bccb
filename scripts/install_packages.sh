#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Installs what stillray needs on Debian 12 or newer, as root or through sudo.
#   scripts/install_packages.sh program  compilers, and libraries of the program on the CPU
#   scripts/install_packages.sh build    also what Vulkan and Python need
#   scripts/install_packages.sh test     also what the tests and checks of every change use
#   scripts/install_packages.sh all      also what the long tests use: a browser and windows
set -euo pipefail

program_packages=(
  build-essential cmake ninja-build pkg-config
  libcli11-dev libdeflate-dev libembree-dev libfmt-dev libglm-dev libhwy-dev libopenexr-dev libspng-dev libstb-dev
  libtbb-dev libtinyobjloader-dev libwebp-dev nlohmann-json3-dev
  ffmpeg
  libglfw3-dev libimgui-dev libgl-dev
)
build_packages=(
  "${program_packages[@]}"
  pybind11-dev python3-dev python3-numpy
  libvulkan-dev glslc
)
test_packages=(
  libgtest-dev libgmock-dev python3
  clang clang-format libclang-rt-14-dev g++-aarch64-linux-gnu
  mesa-vulkan-drivers vulkan-validationlayers
)
long_test_packages=(
  chromium chromium-driver
  g++-mingw-w64-x86-64-posix
  bubblewrap patchelf xz-utils
  xvfb xdotool libgl1-mesa-dri
)

case "${1:-}" in
  program) wanted=("${program_packages[@]}") ;;
  build) wanted=("${build_packages[@]}") ;;
  test) wanted=("${build_packages[@]}" "${test_packages[@]}") ;;
  all) wanted=("${build_packages[@]}" "${test_packages[@]}" "${long_test_packages[@]}") ;;
  *) sed -n 's/^# \?//; 5,9p' "$0" >&2; exit 2 ;;
esac

missing=()
for package in "${wanted[@]}"; do
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$' ||
    missing+=("$package")
done
[ "${#missing[@]}" -eq 0 ] && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "error: these packages are missing, and neither root nor sudo is here: ${missing[*]}" >&2; exit 2; }
  as_root=(sudo)
fi
echo "installing: ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
