#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Installs the packages that scripts/package_*.sh have made into clean roots, uses and removes them.
#   scripts/test_packages.sh [archive] [wheel] [deb]     default: all. As root
# The archive runs in a root that has nothing but glibc (with bubblewrap); the Debian packages in a
# minimal Debian 12 (with debootstrap, from the mirror in DEBIAN_MIRROR), which is made once.
set -euo pipefail
source "$(dirname "$0")/../packaging/common.sh"
work="$packages/test"
mkdir -p "$work"

broken() { echo "FAILED: $*" >&2; exit 1; }

# expect TEXT COMMAND...: the command succeeds, and its output has the text
expect() {
  local text="$1" output
  shift
  output="$("$@" 2>&1)" || broken "$*: $output"
  grep -F -- "$text" <<<"$output" >/dev/null || broken "$*: '$text' is not in its output: $output"
}

# refused TEXT COMMAND...: the command fails, and says why
refused() {
  local text="$1" output
  shift
  if output="$("$@" 2>&1)"; then broken "$*: succeeded"; fi
  grep -F -- "$text" <<<"$output" >/dev/null || broken "$*: '$text' is not in its output: $output"
}

# ---- archive ---------------------------------------------------------------------------------------

# A root with glibc and a folder to write to, and nothing else: not even a shell.
make_bare_root() {
  local root="$1" library
  rm -rf "$root"
  mkdir -p "$root"/{lib64,lib/x86_64-linux-gnu,proc,dev,tmp,opt}
  cp -L /lib64/ld-linux-x86-64.so.2 "$root/lib64/"
  for library in libc.so.6 libm.so.6 libdl.so.2 libpthread.so.0 librt.so.1; do
    cp -L "/lib/x86_64-linux-gnu/$library" "$root/lib/x86_64-linux-gnu/"
  done
}

test_archive() {
  local archive="$packages/stillray-$version-linux-x86_64.tar.xz" bare="$work/bare" folder before
  [ -e "$archive" ] || fail "$archive is missing: scripts/package_archive.sh makes it"
  need bwrap bubblewrap
  make_bare_root "$bare"
  mkdir "$bare/opt/a folder" "$bare/opt/a:b"
  tar -C "$bare/opt/a folder" --strip-components=1 -xf "$archive"
  cp -r "$bare/opt/a folder/." "$bare/opt/a:b/"
  folder="/opt/a folder"
  # Everything but /tmp is read-only.
  inside() { bwrap --ro-bind "$bare" / --proc /proc --dev /dev --bind "$work/out" /tmp --clearenv "$@"; }
  rm -rf "$work/out"
  mkdir "$work/out"
  before="$(cd "$bare$folder" && find . | sort)"

  echo "== archive: a root with glibc alone"
  expect "stillray $version" inside "$folder/stillray" --version
  expect "wrote 2 frames" inside "$folder/stillray" render "$folder/scenes/room.obj" -o /tmp/a --size 64x36 --frames 1-2 --save-inputs --format exr,png
  expect "wrote 1 frame" inside "$folder/bin/stillray" render "$folder/scenes/turntable.gltf" -o /tmp/b --size 64x36 --frames 1 --format exr
  expect "" inside "$folder/stillray" denoise '/tmp/a/noisy.####.exr' -o /tmp/c
  [ -s "$work/out/c/noisy.0002.exr" ] || broken "no denoised frame"
  refused "the loader libvulkan.so.1 is not on this machine" inside "$folder/stillray" render builtin:cornell -o /tmp/d --device vulkan --frames 1
  refused "ffmpeg" inside "$folder/stillray" render builtin:cornell -o /tmp/e --size 64x36 --frames 1 --format mp4
  echo "== archive: started by a link, other libraries in LD_LIBRARY_PATH"
  ln -s "/opt/a folder/stillray" "$bare/opt/link"
  expect "stillray $version" inside /opt/link --version
  refused "cannot be found by /proc/self/exe" bwrap --ro-bind "$bare" / --clearenv "$folder/stillray" --version
  mkdir "$bare/opt/other"
  echo "no library" >"$bare/opt/other/libtbb.so.12"
  expect "stillray $version" inside --setenv LD_LIBRARY_PATH /opt/other "$folder/stillray" --version
  refused "move the folder" inside "/opt/a:b/stillray" --version
  [ "$(cd "$bare$folder" && find . | sort)" = "$before" ] || broken "the program writes to its own folder"
  /usr/bin/python3 -B "$root/packaging/elf.py" check 2.35 "$bare$folder"/{bin,libexec}/stillray \
    "$bare$folder"/lib/*.so* "$bare$folder"/lib/host/*/*.so*
  if command -v qemu-x86_64 >/dev/null; then
    echo "== archive: a CPU without vector code beyond SSE2"
    expect "wrote 1 frame" env LD_LIBRARY_PATH= qemu-x86_64 -cpu qemu64 "$bare$folder/libexec/stillray" \
      render builtin:cornell -o "$work/out/q" --size 32x18 --frames 1 --format exr --device cpu
  else
    echo "skipped: a CPU without vector code (qemu-user is not installed)"
  fi
}

# ---- wheel -----------------------------------------------------------------------------------------

test_wheel() {
  local wheel environment="$work/venv" before test
  wheel="$packages/stillray-$version-py3-none-manylinux_2_35_x86_64.whl"
  [ -e "$wheel" ] || fail "$wheel is missing: scripts/package_wheel.sh makes it"
  rm -rf "$environment"
  /usr/bin/python3 -m venv --system-site-packages "$environment" ||
    fail "no virtual environment (Debian: python3-venv)"
  before="$(find "$environment" -not -name __pycache__ -not -name '*.pyc' | sort)"
  echo "== wheel: in a virtual environment"
  "$environment/bin/pip" install -q --no-index --disable-pip-version-check "$wheel"
  for test in test_stillray test_frames test_ctypes test_example test_notebook; do
    (cd / && env -u PYTHONPATH "$environment/bin/python" -B "$root/tests/python/$test.py") \
      >"$work/wheel.txt" 2>&1 || broken "$test: $(cat "$work/wheel.txt")"
  done
  refused "this package of stillray denoises arrays, not files" \
    "$environment/bin/python" -c 'import stillray; stillray.denoise_files("a.####.exr", "b")'
  /usr/bin/python3 -B "$root/packaging/elf.py" check 2.35 \
    "$environment"/lib/python3*/site-packages/stillray{,.libs}/*.so*
  "$environment/bin/pip" uninstall -q -y stillray
  [ "$(find "$environment" -not -name __pycache__ -not -name '*.pyc' | sort)" = "$before" ] ||
    broken "uninstalled, the wheel leaves files"
}

# ---- Debian packages -------------------------------------------------------------------------------

test_deb() {
  local system="$work/debian" debs=("$packages"/*_"$version"-1_*.deb) inside prefix
  [ "${#debs[@]}" -eq 4 ] || fail "the packages are missing: scripts/package_deb.sh makes them"
  if command -v lintian >/dev/null; then
    echo "== deb: lintian"
    lintian --allow-root --fail-on error "${debs[@]}" || broken "lintian has errors"
  else
    echo "skipped: lintian is not installed"
  fi

  echo "== deb: programs built against the development files"
  prefix="$work/prefix"
  rm -rf "$prefix" "$work/consumer"
  for deb in "${debs[@]}"; do dpkg-deb -x "$deb" "$prefix"; done
  for language in c cpp cpp_engine; do
    cmake -S "$root/examples/$language" -B "$work/consumer/$language" -DCMAKE_BUILD_TYPE=Release \
      -DCMAKE_PREFIX_PATH="$prefix/usr" >"$work/consumer.txt" 2>&1 &&
      cmake --build "$work/consumer/$language" >>"$work/consumer.txt" 2>&1 ||
      broken "$language: $(cat "$work/consumer.txt")"
    expect "rms error" "$work/consumer/$language/denoise_$language" "$work/consumer"
  done
  local flags
  read -r -a flags < <(PKG_CONFIG_PATH="$(dirname "$(find "$prefix" -name stillray.pc)")" pkg-config --cflags --libs stillray)
  cc "$root/examples/c/denoise.c" "${flags[@]}" -lm -o "$work/consumer/pkg_config"
  expect "rms error" env LD_LIBRARY_PATH="$(dirname "$(find "$prefix" -name "libstillray.so.$abi")")" \
    "$work/consumer/pkg_config" "$work/consumer"

  if ! command -v debootstrap >/dev/null; then
    echo "skipped: installing them in a clean Debian (debootstrap is not installed)"
    return
  fi
  echo "== deb: in a clean Debian"
  if [ ! -e "$system.made" ]; then
    rm -rf "$system"
    debootstrap --variant=minbase bookworm "$system" "${DEBIAN_MIRROR:-http://deb.debian.org/debian}" \
      >"$work/debootstrap.txt" 2>&1 || fail "debootstrap: $(tail -3 "$work/debootstrap.txt")"
    touch "$system.made"
  fi
  inside=(chroot "$system" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive)
  # What the packages need comes first, so that only their own files are compared.
  mkdir -p "$system/packages"
  cp "${debs[@]}" "$system/packages/"
  "${inside[@]}" sh -c 'apt-get update -qq && apt-get install -y -qq --no-install-recommends /packages/*.deb && dpkg --purge stillray python3-stillray libstillray-dev '"libstillray$abi" \
    >"$work/apt.txt" 2>&1 || broken "apt: $(tail -5 "$work/apt.txt")"
  files() { (cd "$system" && find usr etc opt var/lib/dpkg/info -not -name '*.pyc' | sort); }
  local before
  before="$(files)"
  "${inside[@]}" sh -c 'dpkg -i /packages/*.deb' >"$work/apt.txt" 2>&1 || broken "dpkg: $(cat "$work/apt.txt")"
  expect "stillray $version" "${inside[@]}" stillray --version
  expect "wrote 1 frame" "${inside[@]}" stillray render builtin:cornell -o /tmp/out --size 64x36 --frames 1 --format exr
  expect "render" "${inside[@]}" bash -c '. /usr/share/bash-completion/completions/stillray; COMP_LINE="stillray ren"; COMP_POINT=12; _stillray; echo "${COMPREPLY[@]}"'
  mkdir -p "$system/tests"
  cp "$root/tests/python/test_stillray.py" "$root/tests/python/test_frames.py" "$system/tests/"
  for test in test_stillray test_frames; do
    "${inside[@]}" python3 "/tests/$test.py" >"$work/python.txt" 2>&1 || broken "$test: $(tail -20 "$work/python.txt")"
  done
  "${inside[@]}" dpkg --purge stillray python3-stillray libstillray-dev "libstillray$abi" >"$work/apt.txt" 2>&1 ||
    broken "dpkg: $(cat "$work/apt.txt")"
  diff <(echo "$before") <(files) || broken "purged, the packages leave files"
  [ -z "$(find "$system/usr" -path '*stillray*')" ] || broken "purged, files named stillray are left"
}

[ "$(id -u)" -eq 0 ] || fail "installing packages into roots needs root"
for part in "${@:-archive wheel deb}"; do
  for name in $part; do
    case "$name" in
      archive | wheel | deb) "test_$name" ;;
      *) fail "unknown part '$name', expected archive, wheel or deb" ;;
    esac
  done
done
echo "all good"
