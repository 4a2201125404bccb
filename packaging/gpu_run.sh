#!/bin/bash
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
#
# Measures and tests stillray on this machine's GPU. Needs bash, coreutils, grep, sed and a Vulkan driver.
#   gpu_run.sh [--quick] [--only STEP[,STEP...]] [--device vulkan:N] [--list]
# Writes to the folder in OUT (default ./out): results.json, results.txt, and a log of each step.
# No step ends another: each has a time limit, and its failure is a line of the results. The most
# useful steps come first, for machines that are lent for minutes.
# --quick: small pictures and few tests, for a software driver. Exit code: 0, or 1 if a step failed.
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
quick=0 only="" device=vulkan list=0
while [ $# -gt 0 ]; do
  case "$1" in
    --quick) quick=1 ;;
    --list) list=1 ;;
    --only) only="$2"; shift ;;
    --device) device="$2"; shift ;;
    *) echo "gpu_run.sh: '$1' is unknown, expected --quick, --only, --device or --list" >&2; exit 2 ;;
  esac
  shift
done
out="${OUT:-$PWD/out}"
bin="$here/bin"

# ---- the driver ------------------------------------------------------------------------------------

# has_library NAME: the machine's linker finds it
has_library() {
  /sbin/ldconfig -p 2>/dev/null | grep -q "$1" || compgen -G "/usr/lib*/$1" >/dev/null ||
    compgen -G "/lib*/$1" >/dev/null || compgen -G "/usr/lib/*/$1" >/dev/null ||
    compgen -G "/lib/*/$1" >/dev/null
}

# Of the bundle's own libraries only those that the machine lacks.
add_missing_libraries() {
  has_library libvulkan.so.1 || LD_LIBRARY_PATH="$here/lib/host/vulkan${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
  has_library libXext.so.6 || LD_LIBRARY_PATH="${LD_LIBRARY_PATH:+$LD_LIBRARY_PATH:}$here/lib/host/xext:$here/lib/host/x11"
  has_library libEGL.so.1 ||
    LD_LIBRARY_PATH="${LD_LIBRARY_PATH:+$LD_LIBRARY_PATH:}$here/lib/host/glvnd:$here/lib/host/gl:$here/lib/host/x11"
  [ -z "${LD_LIBRARY_PATH:-}" ] || export LD_LIBRARY_PATH
}

# Descriptions of drivers where the loader does not look.
find_driver() {
  [ -z "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] || return 0
  compgen -G "/usr/share/vulkan/icd.d/*.json" >/dev/null && return 0
  compgen -G "/etc/vulkan/icd.d/*.json" >/dev/null && return 0
  compgen -G "/usr/local/share/vulkan/icd.d/*.json" >/dev/null && return 0
  local file library
  file="$(timeout 20 find / -xdev -path '*/icd.d/*.json' 2>/dev/null | head -1)"
  [ -n "$file" ] || file="$(timeout 20 find / -xdev -name 'nvidia_icd*.json' 2>/dev/null | head -1)"
  if [ -z "$file" ]; then
    library="$(timeout 20 find / -xdev -name 'libGLX_nvidia.so.0' 2>/dev/null | head -1)"
    [ -n "$library" ] || return 0
    file="$out/nvidia_icd.json"
    echo "{\"file_format_version\": \"1.0.0\", \"ICD\": {\"library_path\": \"$library\", \"api_version\": \"1.3.0\"}}" >"$file"
  fi
  export VK_DRIVER_FILES="$file" VK_ICD_FILENAMES="$file"
}

# ---- the steps -------------------------------------------------------------------------------------

# In order of worth. limit NAME: its seconds.
steps=(device filter parity filter_all fps fps_downloaded traces tracer_parity validation)
limit() {
  case "$1" in
    device) echo 30 ;;
    filter) echo 60 ;;
    parity) echo 240 ;;
    filter_all) echo 300 ;;
    fps | fps_downloaded) echo 90 ;;
    traces) echo 300 ;;
    tracer_parity) echo 400 ;;
    validation) echo 240 ;;
  esac
}

# Tests that replace the loader by one of the build folder, or fill the device, stay at home.
not_here='-*Failures.*:*RayFailures.*:*FramesThatDoNotFit*:*Failing*'

# tests SUFFIX PROGRAM [FILTER]: with a report that holds measured deviations
tests() {
  local suffix="$1" program="$2" filter="${3:-*}"
  "$bin/$program" --gtest_brief=1 --gtest_filter="$filter$not_here" \
    --gtest_output="json:$out/$program$suffix.report.json"
}

run_device() {
  if command -v nvidia-smi >/dev/null; then
    nvidia-smi
    nvidia-smi -q -d CLOCK,POWER,TEMPERATURE,PERFORMANCE
  fi
  "$bin/stillray" info --devices
  "$bin/gpu_limits" >"$out/device.json"
}
run_filter() {
  if [ "$quick" = 1 ]; then
    set -- --size 96x54 --repeats 2
  else
    set -- --size 1920x1080 --repeats 20
  fi
  "$bin/stillray" bench --device "$device" --preset svgf --set signals=single --kernel 3x3,5x5 \
    --inputs packed,float "$@" --json "$out/filter.json"
}
run_filter_all() {
  if [ "$quick" = 1 ]; then
    set -- --size 64x36 --preset svgf,default --precision half,float --repeats 1
  else
    set -- --size 1920x1080,3840x2160 --preset all --precision half,float --repeats 10
  fi
  "$bin/stillray" bench --device "$device" --kernel 5x5 --inputs packed "$@" \
    --json "$out/filter_all.json"
}
run_fps() { frames_per_second fps --no-download; }
run_fps_downloaded() { frames_per_second fps_downloaded --download; }
frames_per_second() {
  local size=1920x1080 repeats=100 warm_up=10
  [ "$quick" = 0 ] || { size=32x18 repeats=2 warm_up=1; }
  "$bin/stillray" bench --fps --device "$device" --size "$size" --repeats "$repeats" --warm-up "$warm_up" "$2" \
    --json "$out/$1.json"
}
run_parity() {
  local bad=0
  if [ "$quick" = 1 ]; then
    tests "" gpu_test '*Formulas*:*Octahedral*:*Ground*' || bad=1
    tests "" denoise_vulkan_test 'Stages.*Presets*:*Embedding.InC' || bad=1
  else
    tests "" gpu_test || bad=1
    tests "" denoise_vulkan_test || bad=1
  fi
  return "$bad"
}
run_traces() {
  local scenes=() size=1920x1080 repeats=10
  if [ "$quick" = 1 ]; then
    scenes=(builtin:cornell) size=32x18 repeats=1
  elif compgen -G "$here/scenes/*.glb" >/dev/null; then
    scenes=(builtin:cornell builtin:lights builtin:spheres "$here"/scenes/*.glb)
  fi
  "$bin/gpu_trace_benchmark" --device "$device" --size "$size" --repeats "$repeats" \
    --json "$out/traces.json" "${scenes[@]}"
}
run_tracer_parity() {
  local bad=0 program
  if [ "$quick" = 1 ]; then
    tests "" wide_bvh_test || bad=1
    tests "" gpu_visibility_test '*Builtin*' || bad=1
    return "$bad"
  fi
  for program in wide_bvh gpu_formulas gpu_accel gpu_guides gpu_virtual_guides gpu_visibility gpu_renderer device_frame denoise_vulkan_sequence; do
    tests "" "${program}_test" || bad=1
  done
  return "$bad"
}
run_validation() {
  local bad=0
  export VK_LAYER_PATH="$here/layers"
  tests _validated denoise_vulkan_test 'Embedding.*' || bad=1
  if [ "$quick" = 0 ]; then
    tests _validated gpu_test || bad=1
    tests _validated denoise_vulkan_test 'Stages.*' || bad=1
    tests _validated gpu_visibility_test || bad=1
    tests _validated device_frame_test || bad=1
  fi
  grep -q '"watches"' "$out/denoise_vulkan_test_validated.report.json" ||
    { echo "the validation layer was not loaded from $VK_LAYER_PATH"; bad=1; }
  return "$bad"
}

# ---- results ---------------------------------------------------------------------------------------

# json_text TEXT: as a string of JSON
json_text() {
  local text="${1//\\/\\\\}"
  text="${text//\"/\\\"}"
  printf '"%s"' "${text//[$'\t\r\n']/ }"
}

# Whole files only: a step that was ended may leave half of one.
json_files() {
  local file last separator=""
  for file in "$out"/*.json; do
    case "$file" in */results.json | */*_icd.json) continue ;; esac
    [ -s "$file" ] || continue
    last="$(tail -c 3 "$file" | tr -d ' \n')"
    [ "${last: -1}" = "}" ] || continue
    printf '%s\n    %s: ' "$separator" "$(json_text "$(basename "$file" .json)")"
    cat "$file"
    separator=","
  done
}

write_json() {
  {
    printf '{\n  "bundle": %s,\n' "$(json_text "$(head -1 "$here/MANIFEST" 2>/dev/null)")"
    printf '  "machine": %s,\n' "$(json_text "$(uname -srm), $(nproc) processors")"
    printf '  "date": %s,\n  "quick": %s,\n  "steps": [' "$(json_text "$(date -u +%FT%TZ)")" "$quick"
    local separator="" row
    for row in "${rows[@]}"; do
      read -r name code seconds <<<"$row"
      printf '%s\n    {"name": "%s", "exit_code": %s, "seconds": %s}' "$separator" "$name" "$code" "$seconds"
      separator=","
    done
    printf '\n  ],\n  "results": {'
    json_files
    printf '\n  }\n}\n'
  } >"$out/results.json.part" && mv "$out/results.json.part" "$out/results.json"
}

# The lines of a log that hold figures.
figures() {
  case "$1" in
    device) grep -E "vulkan:[0-9]|Driver Version|SM  |Graphics  |Memory  " "$2" | head -20 ;;
    filter*) grep -E "kernel|^svgf|^[a-z_]+, [0-9]x[0-9]:|whole frame|copy|times the|[0-9]+x[0-9]+, [0-9] signal" "$2" ;;
    fps*) grep -vE "^$" "$2" ;;
    traces) cat "$2" ;;
    *) grep -E "FAILED|PASSED|Failure|tests? ran|SKIPPED|error|was not" "$2" | head -40 ;;
  esac
}

# Measured deviations beside their bounds, largest of each name over all tests of a program.
deviations() {
  local report
  for report in "$out"/*.report.json; do
    [ -s "$report" ] || continue
    echo "  $(basename "$report" .report.json)"
    sed -n 's/^ *"\([^"]*\)": "\([0-9.e+-]* of [0-9.e+-]*\)",*$/\1|\2/p' "$report" | sort -t'|' -k1,1 -k2,2gr |
      sort -t'|' -k1,1 -u -s | sed 's/^\(.*\)|\(.*\)$/    \1: \2/'
  done
}

write_text() {
  {
    head -1 "$here/MANIFEST" 2>/dev/null
    printf '%s, %s processors, %s\n\n' "$(uname -srm)" "$(nproc)" "$(date -u +%FT%TZ)"
    printf '%-16s%10s%10s\n' step result seconds
    local row
    for row in "${rows[@]}"; do
      read -r name code seconds <<<"$row"
      case "$code" in
        0) code=ok ;;
        124 | 137) code="time limit" ;;
        *) code="failed $code" ;;
      esac
      printf '%-16s%10s%10s\n' "$name" "$code" "$seconds"
    done
    for row in "${rows[@]}"; do
      read -r name code seconds <<<"$row"
      printf '\n== %s\n' "$name"
      figures "$name" "$out/$name.log"
    done
    printf '\n== largest deviations, of their bounds\n'
    deviations
  } >"$out/results.txt.part" 2>/dev/null && mv "$out/results.txt.part" "$out/results.txt"
}

# ---- the run ---------------------------------------------------------------------------------------

# The script starts itself for a step, so that `timeout` ends all of it.
if [ -n "${STILLRAY_GPU_STEP:-}" ]; then
  "run_$STILLRAY_GPU_STEP"
  exit
fi
if [ "$list" = 1 ]; then
  for name in "${steps[@]}"; do echo "$name, at most $(limit "$name") s"; done
  exit 0
fi
chosen=()
for name in ${only//,/ }; do
  [ -n "$(limit "$name")" ] ||
    { echo "gpu_run.sh: --only has '$name', expected some of: ${steps[*]}" >&2; exit 2; }
  chosen+=("$name")
done
[ -n "$only" ] || chosen=("${steps[@]}")
mkdir -p "$out" || exit 2
out="$(cd "$out" && pwd)"
rm -f "$out"/*.json "$out"/*.log "$out"/results.txt
add_missing_libraries
find_driver
clocks=""
if command -v nvidia-smi >/dev/null; then
  nvidia-smi --query-gpu=timestamp,clocks.sm,clocks.mem,power.draw,temperature.gpu,utilization.gpu \
    --format=csv -lms 500 >"$out/clocks.csv" 2>/dev/null &
  clocks=$!
fi
rows=() bad=0
options=(--device "$device")
[ "$quick" = 0 ] || options+=(--quick)
for name in "${chosen[@]}"; do
  echo "== $name"
  start="$SECONDS"
  OUT="$out" STILLRAY_GPU_STEP="$name" timeout --kill-after=10 "$(limit "$name")" \
    "$BASH" "$here/gpu_run.sh" "${options[@]}" >"$out/$name.log" 2>&1
  code=$?
  rows+=("$name $code $((SECONDS - start))")
  [ "$code" = 0 ] || { bad=1; echo "   exit code $code: $(tail -1 "$out/$name.log")"; }
  write_json
  write_text
done
[ -z "$clocks" ] || kill "$clocks" 2>/dev/null
cat "$out/results.txt"
exit "$bad"
