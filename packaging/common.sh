# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# What the scripts/package_*.sh share: the release build that all packages are made from, and its
# folder. Sourced. STILLRAY_PACKAGE_BUILD names another build folder.
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build="${STILLRAY_PACKAGE_BUILD:-$root/build-package}"
version="$(sed -n 's/^project(stillray VERSION \([0-9.]*\) .*/\1/p' "$root/CMakeLists.txt")"
abi="$(sed -n 's/^#define STILLRAY_ABI_VERSION \([0-9]*\)u$/\1/p' "$root/include/stillray/stillray.h")"
packages="$build/packages"
# The same files, whenever they are packed.
SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(git -C "$root" log -1 --format=%ct 2>/dev/null || date +%s)}"
export SOURCE_DATE_EPOCH LC_ALL=C.UTF-8

fail() { echo "error: $*" >&2; exit 2; }

# need COMMAND PACKAGE: a tool that packages are made with
need() { command -v "$1" >/dev/null || fail "$1 is missing (Debian: $2)"; }

# Builds everything that is packed: the release preset, which dispatches vector code at run time.
build_release() {
  need cmake cmake
  need ninja ninja-build
  local options=(-DSTILLRAY_BUILD_TESTS=OFF -DCMAKE_INSTALL_PREFIX=/usr
    -DSTILLRAY_STATIC_SIMD=OFF -DSTILLRAY_BUILD_APPS=ON -DSTILLRAY_BUILD_PYTHON=ON
    -DSTILLRAY_PYTHON_DIR=lib/python3/dist-packages)
  (cd "$root" && cmake --preset release -B "$build" "${options[@]}") >"$build.log" 2>&1 ||
    { tail -20 "$build.log" >&2; fail "CMake ends with an error; scripts/install_packages.sh build installs what is needed"; }
  cmake --build "$build" || fail "the build has failed"
}

# install_release FOLDER: the installation of the release build below FOLDER, stripped
install_release() {
  rm -rf "$1"
  DESTDIR="$1" cmake --install "$build" --strip >/dev/null
  find "$1" -name '*.a' -exec strip --strip-debug --remove-section=.comment --remove-section=.note {} +
}
