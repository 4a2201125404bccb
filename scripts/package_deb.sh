#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Makes the Debian packages: stillray (program, manual page, completion, documents), libstillrayN,
# libstillray-dev and python3-stillray. docs/packages.md describes them. DEBFULLNAME and DEBEMAIL
# name who packs, as for Debian's own tools.
set -euo pipefail
source "$(dirname "$0")/../packaging/common.sh"
need dpkg-deb dpkg
need dpkg-shlibdeps dpkg-dev
build_release

maintainer="${DEBFULLNAME:-the stillray developers} <${DEBEMAIL:-stillray@users.noreply.invalid}>"
revision="$version-1"
architecture="$(dpkg --print-architecture)"
triplet="$(dpkg-architecture -qDEB_HOST_MULTIARCH)"
work="$packages/deb"
installed="$work/installed"
library="libstillray$abi"
rm -rf "$work"
mkdir -p "$work"
install_release "$installed"

# move PACKAGE PATHS...: parts of the installation, relative to /usr, that become those of a package
move() {
  local package="$1" path
  shift
  for path in "$@"; do
    mkdir -p "$work/$package/usr/$(dirname "$path")"
    mv "$installed/usr/$path" "$work/$package/usr/$path"
  done
}
cd "$installed/usr"
move "$library" lib/"$triplet"/libstillray.so.*
move python3-stillray lib/python3/dist-packages/stillray
move libstillray-dev lib/"$triplet" include
move stillray bin share
cd "$work"
[ -z "$(find "$installed" -type f)" ] || fail "not packed: $(find "$installed" -type f)"
mv stillray/usr/share/doc/stillray/CHANGELOG.md "$work/upstream_changelog"
rm stillray/usr/share/doc/stillray/LICENSE
gzip -9n stillray/usr/share/man/man1/stillray.1

# dependencies PACKAGE FILES...: the packages of the libraries that the files are linked with
dependencies() {
  mkdir -p "$work/shlibs/debian"
  printf 'Source: stillray\n\nPackage: %s\nArchitecture: any\n' "$1" >"$work/shlibs/debian/control"
  shift
  (cd "$work/shlibs" && dpkg-shlibdeps -O "$@" 2>"$work/shlibs.log") | sed 's/^shlibs:Depends=//'
}

# documents PACKAGE: copyright and changelogs
documents() {
  local folder="$work/$1/usr/share/doc/$1"
  mkdir -p "$folder"
  sed "s/@YEAR@/$(date -u -d "@$SOURCE_DATE_EPOCH" +%Y)/" "$root/packaging/copyright" >"$folder/copyright"
  gzip -9nc "$work/upstream_changelog" >"$folder/changelog.gz"
  printf 'stillray (%s) unstable; urgency=medium\n\n  * See changelog.gz.\n\n -- %s  %s\n' \
    "$revision" "$maintainer" "$(date -Ru -d "@$SOURCE_DATE_EPOCH")" |
    gzip -9n >"$folder/changelog.Debian.gz"
}

# pack PACKAGE SECTION SUMMARY [FIELDS...], with the description on standard input
pack() {
  local package="$1" section="$2" summary="$3" folder="$work/$1"
  shift 3
  documents "$package"
  mkdir -p "$folder/DEBIAN"
  find "$folder" -type d -exec chmod 755 {} +
  (cd "$folder" && find usr -type f -print0 | sort -z | xargs -0 md5sum) >"$folder/DEBIAN/md5sums"
  {
    printf 'Package: %s\nSource: stillray\nVersion: %s\nArchitecture: %s\nMaintainer: %s\n' \
      "$package" "$revision" "$architecture" "$maintainer"
    printf 'Installed-Size: %s\nSection: %s\nPriority: optional\n' \
      "$(du -sk --exclude=DEBIAN "$folder" | cut -f1)" "$section"
    printf '%s\n' "$@"
    printf 'Description: %s\n' "$summary"
    sed 's/^$/./; s/^/ /'
  } >"$folder/DEBIAN/control"
  find "$folder" -newermt "@$SOURCE_DATE_EPOCH" -exec touch -h -d "@$SOURCE_DATE_EPOCH" {} +
  dpkg-deb --root-owner-group -Zxz --build "$folder" "$packages/${package}_${revision}_$architecture.deb" >/dev/null
  echo "$packages/${package}_${revision}_$architecture.deb"
}

common="stillray denoises path-traced animation: it accumulates light over frames,
forward and backward in time, and filters what noise remains with the
renderer's normals, depth and albedo. There is no network and no training; it
runs on the CPU alone, or on GPUs with Vulkan."

library_needs="$(dependencies "$library" "$work/$library"/usr/lib/"$triplet"/libstillray.so."$abi")"
python_needs="$(dependencies python3-stillray "$work"/python3-stillray/usr/lib/python3/dist-packages/stillray/*.so)"
program_needs="$(dependencies stillray "$work/stillray/usr/bin/stillray")"

mkdir -p "$work/$library/DEBIAN"
echo "libstillray $abi $library (>= $version)" >"$work/$library/DEBIAN/shlibs"
echo "activate-noawait ldconfig" >"$work/$library/DEBIAN/triggers"
pack "$library" libs "denoiser for path-traced animation - library" \
  "Multi-Arch: same" \
  "Depends: $library_needs" \
  "Recommends: libvulkan1" <<END
$common

This package has the shared library with the C API.
END

# The static libraries and the headers of the C++ engine need those of what they use.
pack libstillray-dev libdevel "denoiser for path-traced animation - development files" \
  "Multi-Arch: same" \
  "Depends: $library (= $revision), libdeflate-dev, libfmt-dev, libglm-dev, libhwy-dev, libopenexr-dev, libspng-dev, libstb-dev, libtbb-dev" \
  "Suggests: libvulkan-dev, stillray" <<END
$common

This package has the headers, the static libraries, and the files for CMake and
pkg-config.
END

# What Python compiles is removed with the package.
mkdir -p "$work/python3-stillray/DEBIAN"
cat >"$work/python3-stillray/DEBIAN/postinst" <<'END'
#!/bin/sh
set -e
if [ "$1" = configure ] && command -v py3compile >/dev/null 2>&1; then
  py3compile -p python3-stillray
fi
END
cat >"$work/python3-stillray/DEBIAN/prerm" <<'END'
#!/bin/sh
set -e
if command -v py3clean >/dev/null 2>&1; then
  py3clean -p python3-stillray
else
  find /usr/lib/python3/dist-packages/stillray -name __pycache__ -exec rm -rf {} +
fi
END
chmod 755 "$work"/python3-stillray/DEBIAN/postinst "$work"/python3-stillray/DEBIAN/prerm
# The compiled modules are for one version of Python.
minor="$(sed -n 's/.*\.cpython-3\([0-9]*\)-.*/\1/p' <<<"$(ls "$work"/python3-stillray/usr/lib/python3/dist-packages/stillray)" | head -1)"
pack python3-stillray python "denoiser for path-traced animation - Python 3 module" \
  "Depends: python3 (>= 3.$minor), python3 (<< 3.$((minor + 1))), python3-numpy, $python_needs" \
  "Recommends: libvulkan1" <<END
$common

This package has the module for Python, with NumPy arrays in and out.
END

pack stillray graphics "path tracer and denoiser for path-traced animation" \
  "Depends: $program_needs" \
  "Recommends: ffmpeg, libvulkan1, libgl1" \
  "Suggests: libstillray-dev, python3-stillray" <<END
$common

This package has the program, which renders scenes, denoises sequences of EXR
files of Blender, Arnold and other renderers, shows scenes live and measures
results; its manual page, completion for bash, zsh and fish, and the documents.
END
