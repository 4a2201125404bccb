#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# example_test.sh PROGRAM: the example denoises: a tenth of the noisy error or less is left, and the
# validation layer, where it is installed, has nothing to say. 77: there is no Vulkan driver here.
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
status=0
VK_LOADER_LAYERS_ENABLE='*validation' VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation \
  "$1" "$work" >"$work/output.txt" 2>&1 || status=$?
if [ "$status" -ne 0 ] && grep -q 'failed: -6' "$work/output.txt"; then  # no such layer
  status=0
  "$1" "$work" >"$work/output.txt" 2>&1 || status=$?
fi
cat "$work/output.txt"
[ "$status" -eq 0 ] || exit "$status"
if grep -q -i 'validation' "$work/output.txt"; then
  echo "FAILED: the validation layer complains"
  exit 1
fi
awk '/rms error/ {noisy = $4 + 0; denoised = $6 + 0}
     END {exit !(noisy > 0 && denoised > 0 && 10 * denoised < noisy)}' "$work/output.txt" ||
  { echo "FAILED: the picture is not denoised"; exit 1; }
[ "$(head -c 2 "$work/denoised.ppm")" = P6 ] || { echo "FAILED: no picture"; exit 1; }
