#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Builds the denoiser without the path tracer, checks it on this machine's GPU, and prints the times of
# its stages beside a copy of the least bytes that they must touch. Where the path tracer's libraries are
# installed: also frames per second of tracing alone, with the temporal stage, and with all of SVGF, of a
# scene whose camera, objects and light move, and the memory that they take; and rays per second and
# milliseconds of tracing, in both ways that the device offers.
#   scripts/gpu_bench.sh [DEVICE, default vulkan] [FRAMES, default 100] [SIZE ...]
# STILLRAY_GPU_BUILD: the build folder, default build-gpu.
set -euo pipefail
cd "$(dirname "$0")/.."
build="${STILLRAY_GPU_BUILD:-build-gpu}"

cmake -S . -B "$build" -DSTILLRAY_BUILD_APPS=OFF -DSTILLRAY_BUILD_PYTHON=OFF \
  -DSTILLRAY_BUILD_TESTS=ON -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$build" --parallel "$(nproc)" --target gpu_test denoise_vulkan_test gpu_bench >/dev/null ||
  { echo "error: the build failed; Vulkan's headers and glslc are needed" >&2; exit 2; }

echo "== checks"
for check in gpu_test denoise_vulkan_test; do
  "$build/tests/gpu/$check" --gtest_brief=1
done
echo "== times"
"$build/tests/gpu/gpu_bench" "$@"

echo "== frames per second"
if cmake -S . -B "$build-apps" -DSTILLRAY_BUILD_PYTHON=OFF -DSTILLRAY_BUILD_TESTS=OFF \
  -DCMAKE_BUILD_TYPE=Release >/dev/null 2>&1 &&
  cmake --build "$build-apps" --parallel "$(nproc)" --target stillray >/dev/null 2>&1; then
  sizes=("${@:3}")
  sizes=("${sizes[@]:-1920x1080}")
  "$build-apps/apps/stillray/stillray" bench --fps --device "${1:-vulkan}" --repeats 30 \
    --size "$(IFS=,; echo "${sizes[*]}")"
else
  echo "not measured: what the path tracer is built with is not installed here"
fi

echo "== rays per second, in compute shaders and by hardware"
if cmake -S . -B "$build-apps" -DSTILLRAY_BUILD_BENCHMARKS=ON >/dev/null 2>&1 &&
  cmake --build "$build-apps" --parallel "$(nproc)" --target gpu_trace_benchmark >/dev/null 2>&1; then
  "$build-apps/benchmarks/gpu_trace_benchmark" --device "${1:-vulkan}" --size "${3:-1920x1080}" --repeats 10
else
  echo "not measured: what the path tracer or the benchmarks are built with is not installed here"
fi
