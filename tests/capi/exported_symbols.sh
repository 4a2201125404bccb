#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# exported_symbols.sh LIBRARY HEADER...: fails unless the library exports exactly what the headers
# declare with STILLRAY_API.
set -euo pipefail
library="$1"
shift
declared="$(cat "$@" | tr '\n' ' ' | grep -o 'STILLRAY_API [^(]*(' | grep -o 'stillray_[a-z0-9_]*(' |
  tr -d '(' | sort -u)"
exported="$(nm -D --defined-only "$library" | awk '$2 == "T" || $2 == "D" || $2 == "B" || $2 == "W" || $2 == "V" {print $3}' |
  grep -v -E '^(_init|_fini|__(asan|ubsan|odr|sanitizer)|___asan)' | sort -u)"
[ -n "$declared" ] || { echo "no declarations found in $*"; exit 1; }
if [ "$declared" != "$exported" ]; then
  echo "declared in $* (<) and exported by $library (>) differ:"
  diff <(echo "$declared") <(echo "$exported")
  exit 1
fi
