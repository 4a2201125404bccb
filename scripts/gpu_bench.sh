#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Measures and tests stillray on this machine's GPU, from a checkout: packs what scripts/gpu_bundle.sh
# packs, and runs it. Results are written to the folder in OUT, default ./out.
#   scripts/gpu_bench.sh [options of gpu_run.sh]     such as --quick, --only filter,traces, --device vulkan:1
# STILLRAY_GPU_BUILD: a build folder to use in place of build-gpu-bundle.
set -euo pipefail
root="$(cd "$(dirname "$0")/.." && pwd)"
build="${STILLRAY_GPU_BUILD:-$root/build-gpu-bundle}"
options=()
[ -z "${STILLRAY_GPU_BUILD:-}" ] || options=(--build "$build")
"$root/scripts/gpu_bundle.sh" "${options[@]}"
exec "$build"/packages/gpu/stillray-gpu-*/gpu_run.sh "$@"
