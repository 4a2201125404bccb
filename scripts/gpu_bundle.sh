#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Packs what measures and tests stillray on a GPU, for a machine that has a Vulkan driver and nothing
# else: no compiler, no libraries, no network. Made on Debian 12; docs/gpu.md describes it.
#   scripts/gpu_bundle.sh [--build FOLDER] [--scenes FOLDER] [--output FILE]
# --build: packs the programs of that build folder, after it was brought up to date. Default:
#   build-gpu-bundle, a release build whose vector code is chosen at run time, as in all packages.
# --scenes: adds the .glb files of a folder; without them the built-in scenes are traced.
# --output: default stillray-gpu-VERSION-linux-x86_64.tar.xz in the folder `packages` of the build.
set -euo pipefail
source "$(dirname "$0")/../packaging/common.sh"
most_bytes=$((56 * 1024 * 1024))
build="$root/build-gpu-bundle"
own_build=1 scenes="" archive=""
while [ $# -gt 0 ]; do
  [ $# -ge 2 ] || fail "$1 needs a value"
  case "$1" in
    --build) build="$(realpath "$2")" own_build=0 ;;
    --scenes) scenes="$2" ;;
    --output) archive="$2" ;;
    *) fail "'$1' is unknown, expected --build, --scenes or --output" ;;
  esac
  shift 2
done
[ -z "$scenes" ] || compgen -G "$scenes/*.glb" >/dev/null || fail "$scenes has no .glb file"
need cmake cmake
need ninja ninja-build
need patchelf patchelf
need xz xz-utils
[ "$(uname -m)" = x86_64 ] || fail "the bundle is made on x86-64, this machine is $(uname -m)"

# As gpu_run.sh starts them.
programs=(apps/stillray/stillray benchmarks/gpu_limits benchmarks/gpu_trace_benchmark
  tests/gpu/gpu_test tests/gpu/denoise_vulkan_test tests/gpu/denoise_vulkan_sequence_test
  tests/render_gpu/{gpu_formulas,gpu_accel,gpu_guides,gpu_virtual_guides,gpu_visibility,gpu_renderer,device_frame,wide_bvh}_test)
if [ "$own_build" = 1 ]; then
  (cd "$root" && cmake --preset release -B "$build" -DSTILLRAY_BUILD_TESTS=ON -DSTILLRAY_BUILD_PYTHON=OFF \
    -DSTILLRAY_STATIC_SIMD=OFF) >"$build.log" 2>&1 ||
    { tail -20 "$build.log" >&2; fail "CMake ends with an error"; }
elif grep -q "^STILLRAY_STATIC_SIMD:BOOL=ON" "$build/CMakeCache.txt"; then
  echo "warning: $build has vector code for this CPU alone" >&2
fi
cmake --build "$build" --target "${programs[@]##*/}" || fail "the build has failed"

# library NAME PACKAGE: its path
library() {
  local path
  path="$(/sbin/ldconfig -p | sed -n "s/^\t$1 .*x86-64.* => //p" | head -1)"
  [ -n "$path" ] || fail "$1 is missing (Debian: $2)"
  echo "$path"
}
layer=/usr/lib/x86_64-linux-gnu/libVkLayer_khronos_validation.so
layer_json=/usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json
[ -e "$layer" ] || fail "$layer is missing (Debian: vulkan-validationlayers)"
loader="$(library libvulkan.so.1 libvulkan1)"
xext="$(library libXext.so.6 libxext6)"
egl="$(library libEGL.so.1 libegl1)"
glx="$(library libGLX.so.0 libglx0)"

name="stillray-gpu-$version-linux-x86_64"
work="$build/packages/gpu"
folder="$work/$name"
archive="${archive:-$build/packages/$name.tar.xz}"
rm -rf "$folder"
mkdir -p "$folder/bin"
flags=(-std=c11 -O2 -Wall -Wextra -Werror -s)
cc "${flags[@]}" "$root/packaging/launcher.c" -ldl -o "$work/launcher"
cc "${flags[@]}" -shared -fPIC -Wl,-soname,libstillray_arc4random.so \
  "$root/packaging/arc4random.c" -o "$work/libstillray_arc4random.so"
# NVIDIA's driver needs libXext and GLVND's libraries, which a machine without a display may lack.
/usr/bin/python3 -B "$root/packaging/bundle.py" "$folder" "$work/libstillray_arc4random.so" \
  "${programs[@]/#/$build/}" lib/host/vulkan="$loader" lib/host/xext="$xext" \
  lib/host/glvnd="$egl" lib/host/glvnd="$glx" layers="$layer"
for program in "${programs[@]##*/}"; do cp "$work/launcher" "$folder/bin/$program"; done
sed 's|"library_path": *"[^"]*"|"library_path": "./libVkLayer_khronos_validation.so"|' \
  "$layer_json" >"$folder/layers/VkLayer_khronos_validation.json"
cp "$root/packaging/gpu_run.sh" "$root/LICENSE" "$folder/"
if [ -n "$scenes" ]; then
  mkdir "$folder/scenes"
  cp "$scenes"/*.glb "$folder/scenes/"
fi

commit="$(git -C "$root" rev-parse HEAD 2>/dev/null || echo unknown)"
git -C "$root" diff --quiet HEAD 2>/dev/null || commit="$commit, with changes"
{
  echo "stillray $version, commit $commit"
  echo "sha256, bytes, file:"
  (cd "$folder" && find . -type f ! -name MANIFEST -printf '%P\n' | sort | while read -r file; do
    echo "$(sha256sum "$file" | cut -d' ' -f1) $(stat -c %s "$file") $file"
  done)
} >"$folder/MANIFEST"

mkdir -p "$(dirname "$archive")"
tar -C "$work" --sort=name --owner=0 --group=0 --numeric-owner --mode=go=rX,u+rw,a-s \
  --mtime="@$SOURCE_DATE_EPOCH" -c "$name" | xz -6 -T0 >"$archive.part"
bytes="$(stat -c %s "$archive.part")"
[ "$bytes" -le "$most_bytes" ] ||
  fail "the archive has $bytes bytes, expected at most $most_bytes: leave scenes out ($archive.part)"
mv "$archive.part" "$archive"
echo "$archive ($(((bytes + 999999) / 1000000)) MB)"
