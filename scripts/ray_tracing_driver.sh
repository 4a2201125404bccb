#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Fetches a software driver that offers ray tracing (Mesa of Debian 12's backports) for the tests and
# unpacks it into a folder; nothing of the system changes. Where it cannot, it says why and succeeds:
# the tests of hardware ray tracing are skipped then.
#   scripts/ray_tracing_driver.sh [FOLDER, default build/ray_tracing_driver]
# To run a program with it:
#   VK_DRIVER_FILES=FOLDER/driver.json stillray info --devices
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p "${1:-build/ray_tracing_driver}"
folder="$(cd "${1:-build/ray_tracing_driver}" && pwd)"
suite=bookworm-backports
keyring=/usr/share/keyrings/debian-archive-keyring.gpg
package=mesa-vulkan-drivers

skip() { echo "skipped: no software driver that traces rays: $1"; exit 0; }

[ -e "$folder/driver.json" ] && exit 0
codename="$(. /etc/os-release 2>/dev/null && echo "${ID:-}-${VERSION_CODENAME:-}")"
[ "$codename" = debian-bookworm ] || skip "it is taken from Debian 12, this is ${codename:-another system}"
[ -r "$keyring" ] || skip "$keyring is missing"
# The mirror that this machine uses.
mirror="$(apt-get indextargets --format '$(REPO_URI) $(CODENAME)' 2>/dev/null |
  awk '$2 == "bookworm" {print $1; exit}')"
[ -n "$mirror" ] || skip "apt knows no mirror of Debian 12"

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/lists/partial" "$work/cache/archives/partial" "$work/root"
echo "deb [signed-by=$keyring] $mirror $suite main" >"$work/sources.list"
own=(-qq "-oDir::Etc::sourcelist=$work/sources.list" -oDir::Etc::sourceparts=/dev/null
  "-oDir::State::Lists=$work/lists" "-oDir::Cache=$work/cache" -oAPT::Sandbox::User=
  -oAcquire::Retries=2 -oAcquire::http::Timeout=30)
apt-get "${own[@]}" update >"$work/log" 2>&1 || skip "$(tail -n 1 "$work/log")"
(cd "$work" && apt-get "${own[@]}" download "$package/$suite") >"$work/log" 2>&1 ||
  skip "$(tail -n 1 "$work/log")"
dpkg -x "$work/$package"_*.deb "$work/root"
driver="$(find "$work/root/usr/lib" -name libvulkan_lvp.so)"
[ -n "$driver" ] || skip "$package holds no libvulkan_lvp.so"
missing="$(ldd "$driver" | awk '/not found/ {print $1; exit}')"
[ -z "$missing" ] || skip "$missing is not installed (scripts/install_packages.sh test)"
cp "$driver" "$folder/libvulkan_lvp.so"
# Last, and at once: tests look for this file.
printf '{"file_format_version": "1.0.0", "ICD": {"api_version": "1.4.0", "library_path": "%s"}}\n' \
  "$folder/libvulkan_lvp.so" >"$work/driver.json"
mv "$work/driver.json" "$folder/driver.json"
