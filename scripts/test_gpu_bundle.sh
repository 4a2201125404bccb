#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Unpacks what scripts/gpu_bundle.sh has made into a root that has glibc, a shell with a few tools, and Mesa's
# software driver where no loader looks for it, and runs `gpu_run.sh --quick` there. As root, with
# bubblewrap, in about two minutes.
#   scripts/test_gpu_bundle.sh ARCHIVE [OPTIONS of gpu_run.sh]
set -euo pipefail
source "$(dirname "$0")/../packaging/common.sh"
[ $# -ge 1 ] && [ -e "$1" ] || fail "the argument is '${1:-}', expected the archive of scripts/gpu_bundle.sh"
need bwrap bubblewrap
driver=/usr/lib/x86_64-linux-gnu/libvulkan_lvp.so
[ -e "$driver" ] || fail "$driver is missing (Debian: mesa-vulkan-drivers)"
archive="$1"
shift
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
bare="$work/root"
mkdir -p "$bare"/{bin,sbin,lib64,lib/x86_64-linux-gnu,proc,dev,tmp,results,opt/driver/vulkan/icd.d}
tools=(bash timeout env mkdir cat grep sed head tail tr sort date uname nproc basename dirname rm mv find stat sleep)
for tool in "${tools[@]}"; do cp -L "$(command -v "$tool")" "$bare/bin/"; done
cp -L "$driver" "$bare/opt/driver/"
for file in "$bare"/bin/* "$driver"; do
  ldd "$file" | sed -n 's/.* => \(\/[^ ]*\) .*/\1/p'
done | sort -u | while read -r library; do cp -L "$library" "$bare/lib/x86_64-linux-gnu/"; done
cp -L /lib64/ld-linux-x86-64.so.2 "$bare/lib64/"
for library in libc libm libdl libpthread librt; do
  cp -L "/lib/x86_64-linux-gnu/$library".so.? "$bare/lib/x86_64-linux-gnu/"
done
rm -f "$bare"/lib/x86_64-linux-gnu/libvulkan.so*
echo '{"file_format_version": "1.0.0", "ICD": {"library_path": "/opt/driver/libvulkan_lvp.so", "api_version": "1.3.0"}}' \
  >"$bare/opt/driver/vulkan/icd.d/software.json"
mkdir "$bare/opt/bundle"
tar -C "$bare/opt/bundle" --strip-components=1 -xf "$archive"
sed -n '3,$p' "$bare/opt/bundle/MANIFEST" | while read -r sum bytes file; do
  [ "$(sha256sum "$bare/opt/bundle/$file" | cut -d' ' -f1)" = "$sum" ] || fail "$file is not that of the MANIFEST ($bytes bytes)"
done
out="${OUT:-$work/results}"
mkdir -p "$out"
code=0
bwrap --ro-bind "$bare" / --proc /proc --dev /dev --tmpfs /tmp --bind "$out" /results --clearenv \
  --setenv PATH /bin --setenv OUT /results /bin/bash /opt/bundle/gpu_run.sh --quick "$@" || code=$?
/usr/bin/python3 -c 'import json, sys; json.load(open(sys.argv[1]))' "$out/results.json" ||
  fail "results.json is not JSON"
exit "$code"
