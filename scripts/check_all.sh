#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# What a release must pass, well above an hour on two cores: all tests, formatting, a syntax check for ARM and Windows,
# the library without Vulkan and without vector instructions, all fast tests and fuzzers under clang's sanitizers, and
# the bundle for GPUs from an empty root. Needs root or sudo for packages that are missing.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/test.sh --all
scripts/format.sh --check
scripts/check_cross.sh
cmake --preset scalar >/dev/null
cmake --build --preset scalar
ctest --preset scalar -j "$(nproc)"
scripts/sanitize.sh --all
scripts/gpu_bundle.sh
scripts/test_gpu_bundle.sh build-gpu-bundle/packages/stillray-gpu-*.tar.xz
