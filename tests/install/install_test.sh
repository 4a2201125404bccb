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

echo "== CMake"
for language in c cpp; do
  "$cmake" -S "$source/examples/$language" -B "$work/$language" -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_BUILD_TYPE=Release >"$work/$language.txt"
  "$cmake" --build "$work/$language" >>"$work/$language.txt" || fail "$(cat "$work/$language.txt")"
  mkdir "$work/$language/out"
  "$work/$language/denoise_$language" "$work/$language/out" | tee "$work/$language/output.txt"
  check_errors "$work/$language/output.txt"
done
[ "$(head -c 2 "$work/c/out/denoised.ppm")" = P6 ] || fail "denoised.ppm is no picture"
[ "$(head -c 2 "$work/cpp/out/denoised.pfm")" = PF ] || fail "denoised.pfm is no picture"

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

echo "== static libraries"
mkdir "$work/static"
cat >"$work/static/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(static_user LANGUAGES CXX)
set(CMAKE_CXX_STANDARD 20)
find_package(stillray REQUIRED COMPONENTS static)
add_executable(user user.cpp)
target_link_libraries(user PRIVATE stillray::capi)
END
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
"$cmake" -S "$work/static" -B "$work/static/build" -DCMAKE_PREFIX_PATH="$prefix" >"$work/static.txt"
"$cmake" --build "$work/static/build" >>"$work/static.txt" || fail "$(cat "$work/static.txt")"
"$work/static/build/user"
package="$(find "$prefix" -type d -path '*dist-packages/stillray')"
if [ -n "$package" ]; then
  echo "== Python"
  PYTHONPATH="$(dirname "$package")" /usr/bin/python3 -B "$source/examples/python/denoise.py" \
    "$work" | tee "$work/python.txt"
  check_errors "$work/python.txt"
fi
echo "all good"
