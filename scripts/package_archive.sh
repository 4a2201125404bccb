#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Makes the relocatable archive stillray-VERSION-linux-x86_64.tar.xz: the program with all its
# libraries but glibc's, for every Linux with glibc 2.35 or later. docs/packages.md describes it.
set -euo pipefail
source "$(dirname "$0")/../packaging/common.sh"
need patchelf patchelf
need xz xz-utils
[ "$(uname -m)" = x86_64 ] || fail "the archive is made on x86-64, this machine is $(uname -m)"
build_release

name="stillray-$version-linux-x86_64"
work="$packages/archive"
folder="$work/$name"
installed="$work/installed"
install_release "$installed"
rm -rf "$folder"
mkdir -p "$folder/bin" "$packages"

flags=(-std=c11 -O2 -Wall -Wextra -Werror -s)
cc "${flags[@]}" "$root/packaging/launcher.c" -ldl -o "$folder/bin/stillray"
cc "${flags[@]}" -shared -fPIC -Wl,-soname,libstillray_arc4random.so \
  "$root/packaging/arc4random.c" -o "$work/libstillray_arc4random.so"
/usr/bin/python3 -B "$root/packaging/bundle.py" "$folder" \
  "$work/libstillray_arc4random.so" "$installed/usr/bin/stillray"
/usr/bin/python3 -B "$root/packaging/elf.py" check 2.35 "$folder/bin/stillray"
ln -s bin/stillray "$folder/stillray"

cp -r "$installed/usr/share" "$folder/share"
cp -r "$root/examples/scenes" "$folder/scenes"
cp "$root/LICENSE" "$folder/"
cp "$root/packaging/archive_readme.txt" "$folder/README.txt"

archive="$packages/$name.tar.xz"
tar -C "$work" --sort=name --owner=0 --group=0 --numeric-owner --mode=go=rX,u+rw,a-s \
  --mtime="@$SOURCE_DATE_EPOCH" -c "$name" | xz -9 -T0 >"$archive.part"
mv "$archive.part" "$archive"
bytes="$(stat -c %s "$archive")"
[ "$bytes" -le 40000000 ] || fail "$archive has $bytes bytes, expected at most 40 MB"
echo "$archive ($((bytes / 1000000)) MB)"
