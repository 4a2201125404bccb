#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# install_test.sh SOURCE BUILD CMAKE WORK: installs the build into a folder and builds and runs the
# examples against it, as a stranger would.
set -euo pipefail
source="$1" build="$2" cmake="$3" work="$4"
prefix="$work/prefix"
rm -rf "$work"
mkdir -p "$work"

fail() { echo "FAILED: $*" >&2; exit 1; }

# check_errors FILE: the denoised error in an example's output is a quarter of the noisy one or less.
check_errors() {
  awk '/rms error/ {noisy = $4 + 0; denoised = $6 + 0}
       END {exit !(noisy > 0 && denoised > 0 && 4 * denoised < noisy)}' "$1" ||
    fail "no denoised picture: $(cat "$1")"
}

"$cmake" --install "$build" --prefix "$prefix" >"$work/install.txt"
# From elsewhere: nothing may point back to where it was installed first.
mv "$prefix" "$work/moved"
prefix="$work/moved"
pkgconfig="$(dirname "$(find "$prefix" -name stillray.pc)")"
libdir="$(dirname "$pkgconfig")"

echo "== what is there"
cmakedir="$libdir/cmake/stillray"
[ -s "$prefix/share/doc/stillray/LICENSE" ] || fail "no LICENSE"
[ -s "$prefix/share/doc/stillray/docs/library.md" ] || fail "no documents"
if grep -nE '(INCLUDE_DIRECTORIES|LINK_LIBRARIES) .*[";:]/' "$cmakedir"/*.cmake; then
  fail "a place of this machine is in the package"
fi
number="$(sed -n 's/^#define STILLRAY_ABI_VERSION \([0-9]*\)u$/\1/p' \
  "$prefix/include/stillray/stillray.h")"
[ -e "$libdir/libstillray.so.${number:?}" ] || fail "libstillray.so is not of ABI version $number"

echo "== CMake"
for language in c cpp cpp_engine; do
  "$cmake" -S "$source/examples/$language" -B "$work/$language" -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_BUILD_TYPE=Release >"$work/$language.txt"
  "$cmake" --build "$work/$language" >>"$work/$language.txt" || fail "$(cat "$work/$language.txt")"
  mkdir "$work/$language/out"
  "$work/$language/denoise_$language" "$work/$language/out" | tee "$work/$language/output.txt"
  check_errors "$work/$language/output.txt"
done
for language in c cpp_engine; do
  mkdir "$work/$language/sequence"
  "$work/$language/denoise_sequence_$language" "$work/$language/sequence" \
    >"$work/$language/sequence.txt" || fail "the sequence example of $language"
  check_errors "$work/$language/sequence.txt"
done
[ "$(head -c 2 "$work/c/out/denoised.ppm")" = P6 ] || fail "denoised.ppm is no picture"
[ "$(head -c 2 "$work/cpp_engine/out/denoised.ppm")" = P6 ] || fail "denoised.ppm is no picture"
[ "$(head -c 2 "$work/cpp/out/denoised.pfm")" = PF ] || fail "denoised.pfm is no picture"

if [ -e "$prefix/include/stillray/vulkan.hpp" ] && [ -x "$prefix/bin/stillray" ]; then
  echo "== shaders, on request"
  [ ! -e "$prefix/share/stillray/shaders" ] || fail "the shaders are there without being asked for"
  "$cmake" --install "$build" --prefix "$work/shaders" --component shaders >"$work/shaders.txt" 2>&1 ||
    fail "$(cat "$work/shaders.txt")"
  for file in shaders.json frames.json README.md AccumulateHalf.spv; do
    [ -s "$work/shaders/share/stillray/shaders/$file" ] || fail "the pack of shaders has no $file"
  done
fi

if [ -e "$prefix/include/stillray/vulkan.hpp" ]; then
  echo "== Vulkan, static"
  "$cmake" -S "$source/examples/vulkan" -B "$work/vulkan" -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_BUILD_TYPE=Release >"$work/vulkan.txt" 2>&1 || fail "$(cat "$work/vulkan.txt")"
  "$cmake" --build "$work/vulkan" >>"$work/vulkan.txt" || fail "$(cat "$work/vulkan.txt")"
  status=0
  "$work/vulkan/denoise_vulkan" "$work/vulkan" >"$work/vulkan/output.txt" || status=$?
  if [ "$status" -eq 77 ]; then
    echo "built, not run: there is no Vulkan driver here"
  else
    [ "$status" -eq 0 ] || fail "the Vulkan example ends with $status"
    check_errors "$work/vulkan/output.txt"
  fi
fi

echo "== pkg-config"
export PKG_CONFIG_PATH="$pkgconfig"
read -r -a flags < <(pkg-config --cflags --libs stillray)
gcc -std=c99 -Wall -Wextra -pedantic -Werror "$source/examples/c/denoise.c" "${flags[@]}" -lm \
  -o "$work/pkg_c"
g++ -std=c++17 -Wall -Wextra -pedantic -Werror "$source/examples/cpp/denoise.cpp" "${flags[@]}" \
  -o "$work/pkg_cpp"
for language in c cpp; do
  LD_LIBRARY_PATH="$libdir" "$work/pkg_$language" "$work" >"$work/pkg_$language.txt"
  diff "$work/$language/output.txt" "$work/pkg_$language.txt" || fail "pkg-config build differs"
done

# The static library in place of the shared one, which has the same name.
read -r -a flags < <(pkg-config --static --cflags --libs stillray |
  sed 's/-lstillray /-l:libstillray.a /')
gcc -std=c99 "$source/examples/c/denoise.c" "${flags[@]}" -o "$work/pkg_static"
"$work/pkg_static" "$work" >"$work/pkg_static.txt" || fail "the program with libstillray.a"
diff "$work/c/output.txt" "$work/pkg_static.txt" || fail "pkg-config --static build differs"

# try NAME LANGUAGES COMPONENT LIBRARIES SOURCE: builds a program against the package. No standard
# of the language is set.
try() {
  mkdir -p "$work/$1"
  cat >"$work/$1/CMakeLists.txt" <<END
cmake_minimum_required(VERSION 3.25)
project($1_user LANGUAGES $2)
find_package(stillray REQUIRED COMPONENTS $3)
add_executable(user $5)
target_link_libraries(user PRIVATE $4)
END
  "$cmake" -S "$work/$1" -B "$work/$1/build" -DCMAKE_PREFIX_PATH="$prefix" >"$work/$1.txt" 2>&1 &&
    "$cmake" --build "$work/$1/build" >>"$work/$1.txt" 2>&1
}

echo "== static libraries"
mkdir "$work/static"
cat >"$work/static/user.cpp" <<'END'
#include <cstdio>
#include <stillray/denoise.hpp>
#include <stillray/stillray.h>
int main() {
  const auto made = stillray::Denoiser::Create(stillray::Settings());
  std::printf("%s %d\n", stillray_version(), made.ok() ? 1 : 0);
  return made.ok() ? 0 : 1;
}
END
try static CXX static stillray::capi user.cpp || fail "$(cat "$work/static.txt")"
"$work/static/build/user"
try static_c "C CXX" static "stillray::capi m" "$source/examples/c/denoise.c" ||
  fail "$(cat "$work/static_c.txt")"
"$work/static_c/build/user" "$work" | diff "$work/c/output.txt" - || fail "C with libstillray.a"
if try c_alone C static "stillray::capi m" "$source/examples/c/denoise.c"; then
  fail "a project without C++ linked the static libraries"
fi
tr -s ' \n' ' ' <"$work/c_alone.txt" | grep 'expected CXX among the languages of project()' >/dev/null ||
  fail "no word on the language: $(cat "$work/c_alone.txt")"

if [ -e "$prefix/include/stillray/doctor.h" ]; then
  echo "== doctor"
  mkdir "$work/doctor"
  cat >"$work/doctor/user.cpp" <<'END'
#include <stillray/doctor.h>
int main() {
  const auto doctor = stillray::Doctor::Create(stillray::AovOptions());
  return doctor != nullptr ? 0 : 1;
}
END
  try doctor CXX doctor stillray::doctor user.cpp || fail "$(cat "$work/doctor.txt")"
  "$work/doctor/build/user"
  echo "== sequence"
  try sequence CXX sequence stillray::sequence "$source/examples/sequence/denoise_files.cpp" ||
    fail "$(cat "$work/sequence.txt")"
  "$work/sequence/build/user" "$work/none.####.exr" "$work" 2>"$work/sequence.txt" &&
    fail "a sequence without files was denoised"
  grep 'error: .*none.####.exr' "$work/sequence.txt" >/dev/null || fail "$(cat "$work/sequence.txt")"
fi

# Packages that only the program, the tests and the Python module need, as if not installed.
bare=()
for package in GTest OpenEXR embree Python pybind11 glfw3; do
  bare+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON")
done
# targets FOLDER: the files that a build there links
targets() { ninja -C "$1" -t targets all | sed -n 's/: .*LINKER.*//p'; }

echo "== the library alone"
"$cmake" -S "$source" -B "$work/alone" -G Ninja -DSTILLRAY_BUILD_APPS=OFF "${bare[@]}" \
  >"$work/alone.txt" 2>&1 || fail "$(cat "$work/alone.txt")"
if targets "$work/alone" | grep -v '/libstillray'; then
  fail "more than the library is built"
fi
"$cmake" -S "$source" -B "$work/tested" -G Ninja -DSTILLRAY_BUILD_APPS=OFF \
  -DSTILLRAY_BUILD_TESTS=ON >"$work/tested.txt" 2>&1 || fail "$(cat "$work/tested.txt")"
targets "$work/tested" | grep 'capi_test$' >/dev/null || fail "no tests although they were asked for"

echo "== as a part of another build"
mkdir "$work/part"
cat >"$work/part/CMakeLists.txt" <<END
cmake_minimum_required(VERSION 3.25)
project(engine LANGUAGES CXX)
add_subdirectory($source stillray)
add_library(engine OBJECT engine.cpp)
target_link_libraries(engine PRIVATE stillray::denoise)
END
echo '#include "stillray/denoise.hpp"' >"$work/part/engine.cpp"
"$cmake" -S "$work/part" -B "$work/part/build" -G Ninja -DSTILLRAY_BUILD_VULKAN=OFF "${bare[@]}" \
  >"$work/part.txt" 2>&1 || fail "$(cat "$work/part.txt")"
if targets "$work/part/build" | grep -v '/libstillray'; then
  fail "more than the library is built"
fi
"$cmake" --build "$work/part/build" --target engine >>"$work/part.txt" 2>&1 ||
  fail "$(cat "$work/part.txt")"
"$cmake" --install "$work/part/build" --prefix "$work/part/prefix" >>"$work/part.txt" 2>&1
if [ -e "$work/part/prefix" ]; then
  fail "another project's installation has stillray in it"
fi

package="$(find "$prefix" -type d -path '*dist-packages/stillray')"
if [ -n "$package" ]; then
  echo "== Python"
  PYTHONPATH="$(dirname "$package")" /usr/bin/python3 -B "$source/examples/python/denoise.py" \
    "$work" | tee "$work/python.txt"
  check_errors "$work/python.txt"
fi
echo "all good"
