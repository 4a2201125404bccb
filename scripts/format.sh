#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Applies clang-format to all sources and shaders; with --check only names those that differ.
set -euo pipefail
cd "$(dirname "$0")/.."
mode=(-i)
[ "${1:-}" = --check ] && mode=(--dry-run -Werror)
git ls-files '*.cpp' '*.h' '*.hpp' | xargs clang-format "${mode[@]}"
# GLSL reads as C++ does, but for its includes: one may use what the one before it declares.
git ls-files '*.comp' '*.glsl' '*.vert' | xargs clang-format --sort-includes=0 "${mode[@]}"
