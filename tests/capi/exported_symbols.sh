#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# exported_symbols.sh LIBRARY HEADER: fails unless the library exports exactly what the header
# declares with STILLRAY_API.
set -euo pipefail
declared="$(tr '\n' ' ' <"$2" | grep -o 'STILLRAY_API [^(]*(' | grep -o 'stillray_[a-z0-9_]*(' |
  tr -d '(' | sort -u)"
exported="$(nm -D --defined-only "$1" | awk '$2 == "T" || $2 == "D" || $2 == "B" || $2 == "W" || $2 == "V" {print $3}' |
  grep -v -E '^(_init|_fini|__(asan|ubsan|odr|sanitizer)|___asan)' | sort -u)"
[ -n "$declared" ] || { echo "no declarations found in $2"; exit 1; }
if [ "$declared" != "$exported" ]; then
  echo "declared in $2 (<) and exported by $1 (>) differ:"
  diff <(echo "$declared") <(echo "$exported")
  exit 1
fi
