# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0

# Settings that every stillray target shares, and the functions that declare modules and tests.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
# Packages are found by the module that uses them and are seen by its tests too.
set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL ON)

add_library(stillray_options INTERFACE)
target_compile_options(stillray_options INTERFACE -Wall -Wextra)
if(STILLRAY_WARNINGS_AS_ERRORS)
  target_compile_options(stillray_options INTERFACE -Werror)
endif()
# The same expression must give the same bits on every machine: no contraction into fused
# multiply-adds behind our back. SIMD code asks for them by name.
target_compile_options(stillray_options INTERFACE -ffp-contract=off)
if(STILLRAY_SANITIZE)
  # Null pointers and pointers past an object are found where they are used, by the address sanitizer;
  # these checks of every pointer double the time to compile and to run.
  target_compile_options(stillray_options INTERFACE
    -fsanitize=${STILLRAY_SANITIZE} -fno-sanitize=null,object-size,pointer-overflow
    -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(stillray_options INTERFACE -fsanitize=${STILLRAY_SANITIZE})
endif()

# Instruction sets that vector code is compiled for, one definition for all of its targets. x86
# machines have the baseline, AVX2 or AVX-512; the steps between them only cost build time. Vectors of
# SVE have no size that a struct could hold: ARM machines run NEON.
set(STILLRAY_HWY_TARGETS
  "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3_DL|HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128)")
if(STILLRAY_SCALAR_SIMD)
  set(STILLRAY_HWY_TARGETS HWY_COMPILE_ONLY_SCALAR)
elseif(STILLRAY_STATIC_SIMD)
  set(STILLRAY_HWY_TARGETS HWY_COMPILE_ONLY_STATIC)
endif()

# Headers that most sources include are a third of what they cost to compile: they are compiled once.
# -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON turns it off.
set(STILLRAY_COMMON_HEADERS
  <algorithm> <array> <chrono> <cmath> <cstdint> <filesystem> <functional> <map> <memory> <mutex> <optional>
  <span> <string> <string_view> <utility> <vector>
  <fmt/format.h> <fmt/ranges.h> <tbb/enumerable_thread_specific.h> <tbb/parallel_for.h> <stillray/vec.h>)

# -O0 takes a third of the time of -O1 to compile under the sanitizers, which clang inserts first and optimises then,
# and half of that of -O2 elsewhere. With STILLRAY_QUICK_COMPILE only the modules that tests spend their time in are
# optimised.
set(STILLRAY_OPTIMISED_MODULES core denoise doctor io motion pictures post quality ray_bench render scene sequence)

# stillray_may_stay_unoptimised(<target>)
# With STILLRAY_QUICK_COMPILE the target is not optimised.
function(stillray_may_stay_unoptimised target)
  if(STILLRAY_QUICK_COMPILE)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O0>)
  endif()
endfunction()

# stillray_add_common_headers()
# Compiles them for all modules above core, with the flags that these have in common.
function(stillray_add_common_headers)
  set(targets stillray_common_headers)
  if(STILLRAY_QUICK_COMPILE)
    list(APPEND targets stillray_common_headers_unoptimised)
  endif()
  file(WRITE ${CMAKE_BINARY_DIR}/common_headers.cpp "")
  foreach(target IN LISTS targets)
    add_library(${target} OBJECT ${CMAKE_BINARY_DIR}/common_headers.cpp)
    target_link_libraries(${target} PRIVATE stillray_options stillray_core fmt::fmt)
    target_precompile_headers(${target} PRIVATE ${STILLRAY_COMMON_HEADERS})
  endforeach()
  if(STILLRAY_QUICK_COMPILE)
    stillray_may_stay_unoptimised(stillray_common_headers_unoptimised)
  endif()
endfunction()

# stillray_use_common_headers(<target> [OPTIMISED])
# For a library that links fmt::fmt and has no flags of its own. Without OPTIMISED it is not optimised with
# STILLRAY_QUICK_COMPILE.
function(stillray_use_common_headers target)
  if(STILLRAY_QUICK_COMPILE AND NOT "OPTIMISED" IN_LIST ARGN)
    stillray_may_stay_unoptimised(${target})
    target_precompile_headers(${target} REUSE_FROM stillray_common_headers_unoptimised)
  else()
    target_precompile_headers(${target} REUSE_FROM stillray_common_headers)
  endif()
endfunction()

# What reads files of unknown origin: see tests/fuzz. The C API, which fuzzer capi_fuzz calls, is instrumented in
# its own folder.
set(STILLRAY_FUZZED_MODULES pictures scene io)

# stillray_instrument_for_fuzzing(<target>)
# The fuzzers see which branches of this target's sources an input takes. Without any such target a fuzzer finds
# no input interesting and stops with an error.
function(stillray_instrument_for_fuzzing target)
  if(STILLRAY_BUILD_FUZZERS)
    target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link)
  endif()
endfunction()

# stillray_compile_together(<target> [APART sources...])
# Compiles the sources of a target sixteen at a time, which takes less than half of the time: most of it is for
# headers and templates that they have in common. APART: sources that have a translation unit of their
# own, because of a name in an unnamed namespace or since each instruction set compiles them again.
# The sources of a test program have helpers of the same names: each source x_test.cpp is in a
# namespace x_test of its own. What two of them need is in a header of their folder.
function(stillray_compile_together target)
  if(STILLRAY_UNITY_BUILD)
    cmake_parse_arguments(ARG "" "" "APART" ${ARGN})
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 16)
    set_source_files_properties(${ARG_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()

# stillray_compile_group(<target> <group> sources...)
# Compiles these sources of a target as one, and those in no group by themselves.
function(stillray_compile_group target group)
  if(STILLRAY_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
    set_source_files_properties(${ARGN} PROPERTIES UNITY_GROUP ${group})
  endif()
endfunction()

# stillray_add_module(<name> SOURCES ... [PUBLIC targets...] [PRIVATE targets...] [OWN_FLAGS])
# Declares the static library stillray_<name> with the alias stillray::<name>. With OWN_FLAGS it may get
# flags that other modules do not have.
function(stillray_add_module name)
  cmake_parse_arguments(ARG "OWN_FLAGS" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(stillray_${name} STATIC ${ARG_SOURCES})
  add_library(stillray::${name} ALIAS stillray_${name})
  target_include_directories(stillray_${name}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>
    PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_compile_features(stillray_${name} PUBLIC cxx_std_20)  # the headers need it too
  target_link_libraries(stillray_${name}
    PUBLIC ${ARG_PUBLIC}
    PRIVATE $<BUILD_INTERFACE:stillray_options> ${ARG_PRIVATE})
  if(STILLRAY_BUILD_FUZZERS AND "${name}" IN_LIST STILLRAY_FUZZED_MODULES)
    stillray_instrument_for_fuzzing(stillray_${name})
    set(ARG_OWN_FLAGS ON)
  endif()
  set(optimised "")
  if("${name}" IN_LIST STILLRAY_OPTIMISED_MODULES)
    set(optimised OPTIMISED)
  endif()
  if(TARGET stillray_common_headers AND fmt::fmt IN_LIST ARG_PRIVATE AND NOT ARG_OWN_FLAGS)
    stillray_use_common_headers(stillray_${name} ${optimised})
  elseif(NOT optimised)
    stillray_may_stay_unoptimised(stillray_${name})
  endif()
endfunction()

# GoogleTest's headers are half of what a test costs to compile: they are compiled once, for all test
# programs, and once more for those that are OPTIMISED. Their flags must be those of the tests.
# -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON turns it off.
function(stillray_add_test_headers)
  file(WRITE ${CMAKE_BINARY_DIR}/test_headers.cpp "int main() { return 0; }\n")
  set(kinds stillray_test_headers)
  if(NOT STILLRAY_SANITIZE)
    list(APPEND kinds stillray_test_headers_optimised)
  endif()
  foreach(kind IN LISTS kinds)
    add_executable(${kind} ${CMAKE_BINARY_DIR}/test_headers.cpp)
    target_precompile_headers(${kind} PRIVATE
      <algorithm> <cmath> <cstdint> <functional> <memory> <span> <string> <vector>
      <gmock/gmock.h> <gtest/gtest.h>)
  endforeach()
  stillray_set_test_flags(stillray_test_headers)
  if(NOT STILLRAY_SANITIZE)
    stillray_set_test_flags(stillray_test_headers_optimised OPTIMISED)
  endif()
endfunction()

# Tests are compiled more often than run, and what they test is in libraries of other flags: -O0 takes two thirds of
# the time of -O1, and under the sanitizers, which clang inserts first and optimises then, half. OPTIMISED: -O1.
function(stillray_set_test_flags name)
  target_link_libraries(${name} PRIVATE stillray_options GTest::gmock GTest::gtest_main)
  set(level -O0)
  if("OPTIMISED" IN_LIST ARGN)
    set(level -O1)
  endif()
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:${level}>)
endfunction()

# Mesa's software drivers compile shaders in half of the time without optimising them, and in three
# quarters of that with vectors of 128 bits; tests run each shader for few pixels.
set(STILLRAY_DRIVER_ENVIRONMENT "GALLIVM_PERF=nopt" "LP_NATIVE_VECTOR_WIDTH=128")

# stillray_add_test(<name> SOURCES ... LINK targets... [LABELS labels...] [TIMEOUT seconds] [SHARDS count]
#                   [UNSANITIZED patterns...] [EACH_CHANGE patterns...] [COST number] [OPTIMISED])
# Declares a GoogleTest program. CTest runs it as a whole, or in SHARDS parts of its cases side by side:
# most cases take less time than the start of a process, or than a device's shaders. With
# STILLRAY_TEST_CASES it runs each case by itself. An odd number of parts divides cases of two kinds
# (/Compute and /Hardware, say) evenly. LABELS: "fast" programs also run under the sanitizers,
# "slow" ones do not, "long" ones exist with STILLRAY_LONG_TESTS only. Default: fast. TIMEOUT: of a part,
# default 900. UNSANITIZED: cases that do not run under the sanitizers, because others run the same code in less
# time; patterns of --gtest_filter. EACH_CHANGE: the cases of a "long" program that run without STILLRAY_LONG_TESTS,
# too. OPTIMISED: the program's own loops take longer without than it takes to compile them with. COST: see
# stillray_add_runs.
function(stillray_add_test name)
  cmake_parse_arguments(ARG "OPTIMISED" "COST;TIMEOUT;SHARDS" "SOURCES;LINK;LABELS;UNSANITIZED;EACH_CHANGE" ${ARGN})
  if(NOT ARG_LABELS)
    set(ARG_LABELS fast)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 900)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/tests)
  set(headers stillray_test_headers)
  set(optimised "")
  if(ARG_OPTIMISED AND NOT STILLRAY_SANITIZE)
    set(headers stillray_test_headers_optimised)
    set(optimised OPTIMISED)
  endif()
  stillray_set_test_flags(${name} ${optimised})
  target_link_libraries(${name} PRIVATE ${ARG_LINK})
  target_precompile_headers(${name} REUSE_FROM ${headers})
  set(filter "*")
  set(run TRUE)
  if("long" IN_LIST ARG_LABELS AND NOT STILLRAY_LONG_TESTS)
    list(JOIN ARG_EACH_CHANGE ":" filter)
    list(LENGTH ARG_EACH_CHANGE run)
    set(ARG_LABELS slow)
  endif()
  if(STILLRAY_SANITIZE)
    list(JOIN ARG_UNSANITIZED ":" patterns)
    set(filter "-${patterns}")
    math(EXPR ARG_TIMEOUT "4 * ${ARG_TIMEOUT}")
  endif()
  if(NOT run OR (STILLRAY_SANITIZE AND NOT "fast" IN_LIST ARG_LABELS))
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL TRUE)
    return()
  endif()
  stillray_add_runs(${name} LABELS ${ARG_LABELS} FILTER "${filter}" TIMEOUT ${ARG_TIMEOUT} SHARDS ${ARG_SHARDS}
    COST ${ARG_COST} ENVIRONMENT ${STILLRAY_TEST_ENVIRONMENT})
endfunction()

# stillray_add_runs(<program> LABELS labels... TIMEOUT seconds [FILTER patterns] [PREFIX text] [SHARDS count]
#                   [COST number] [ENVIRONMENT variables...])
# Declares the tests <PREFIX><program>, or <PREFIX><program>.1 and so on, that run the cases of a GoogleTest
# program, with the environment of all tests and these variables. Those of the highest COST start first: long
# ones, so that no processor waits for the last one, and before all others one program with the shaders of
# the denoiser and one with those of the path tracer. Drivers keep compiled shaders on disk, and what starts at
# the same time compiles them twice.
function(stillray_add_runs program)
  cmake_parse_arguments(ARG "" "COST;TIMEOUT;FILTER;PREFIX;SHARDS" "LABELS;ENVIRONMENT" ${ARGN})
  set(environment ${STILLRAY_DRIVER_ENVIRONMENT} ${ARG_ENVIRONMENT})
  if(NOT ARG_FILTER)
    set(ARG_FILTER "*")
  endif()
  set(cost 1)
  if(ARG_COST)
    set(cost ${ARG_COST})
  elseif(NOT "fast" IN_LIST ARG_LABELS)
    set(cost 10)
  endif()
  if(STILLRAY_TEST_CASES)
    # Three expansions on the way to the test split the list or take half of the backslashes.
    string(REPEAT "\\" 7 escape)
    string(JOIN "${escape};" environment ${environment})
    include(GoogleTest)
    gtest_discover_tests(${program} DISCOVERY_MODE PRE_TEST NO_PRETTY_VALUES
      TEST_FILTER "${ARG_FILTER}" TEST_PREFIX "${ARG_PREFIX}"
      PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT} COST ${cost} ENVIRONMENT "${environment}"
      WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    return()
  endif()
  if(NOT ARG_SHARDS)
    set(ARG_SHARDS 1)
  endif()
  foreach(shard RANGE 1 ${ARG_SHARDS})
    set(test "${ARG_PREFIX}${program}")
    set(part "")
    if(ARG_SHARDS GREATER 1)
      string(APPEND test ".${shard}")
      math(EXPR index "${shard} - 1")
      set(part GTEST_TOTAL_SHARDS=${ARG_SHARDS} GTEST_SHARD_INDEX=${index})
    endif()
    add_test(NAME ${test} COMMAND ${program} --gtest_brief=1 "--gtest_filter=${ARG_FILTER}"
      WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    set_tests_properties(${test} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT} COST ${cost}
      ENVIRONMENT "${environment};${part}")
  endforeach()
endfunction()
