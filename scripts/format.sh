#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Applies clang-format to all sources; with --check only names those that differ.
set -euo pipefail
cd "$(dirname "$0")/.."
mode=(-i)
[ "${1:-}" = --check ] && mode=(--dry-run -Werror)
git ls-files '*.cpp' '*.h' '*.hpp' | xargs clang-format "${mode[@]}"
