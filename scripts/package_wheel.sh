#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Makes the Python wheel, one for every Python 3.8 or later on Linux with glibc 2.35 or later.
# docs/packages.md describes it.
set -euo pipefail
source "$(dirname "$0")/../packaging/common.sh"
need patchelf patchelf
[ "$(uname -m)" = x86_64 ] || fail "the wheel is made on x86-64, this machine is $(uname -m)"
build_release
mkdir -p "$packages"
# The installed file: without the folders of the build.
install_release "$packages/wheel"
/usr/bin/python3 -B "$root/packaging/make_wheel.py" "$version" \
  "$(find "$packages/wheel" -name "libstillray.so.$abi")" "$packages"
