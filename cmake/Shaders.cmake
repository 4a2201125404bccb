# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0

# Compute shaders as C++ constants, compiled to SPIR-V at build time.
#
# stillray_find_vulkan()
# Sets STILLRAY_VULKAN to whether Vulkan's headers and glslc are there and wanted.
#
# stillray_embed_shader(<output variable> <file> <namespace> <symbol> [defines...])
# <file>, relative to the current source folder, becomes a generated source that defines
# `extern const std::uint32_t <symbol>[]` and `extern const std::size_t <symbol>Words`, and registers
# the shader's name: the symbol without its k (gpu/embedded_shader.h). Its path is appended to the
# output variable.
#
# This file is also the script that the build runs to do it:
# cmake -D INPUT= -D OUTPUT= -D NAMESPACE= -D SYMBOL= -P Shaders.cmake

if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  # glslc -mfmt=num writes the words of the module as a list of numbers.
  file(READ "${INPUT}" words)
  string(SUBSTRING ${SYMBOL} 1 -1 name)
  file(WRITE "${OUTPUT}"
"// Made from ${INPUT}
#include \"gpu/embedded_shader.h\"

namespace ${NAMESPACE} {
extern const std::uint32_t ${SYMBOL}[] = {
${words}};
extern const std::size_t ${SYMBOL}Words = sizeof(${SYMBOL}) / sizeof(${SYMBOL}[0]);
static const stillray::gpu::EmbeddedShader embedded(\"${name}\", ${SYMBOL});
}  // namespace ${NAMESPACE}
")
  return()
endif()

set(STILLRAY_SHADER_SCRIPT ${CMAKE_CURRENT_LIST_FILE})

macro(stillray_find_vulkan)
  find_path(STILLRAY_VULKAN_HEADERS vulkan/vulkan_core.h DOC "Folder of Vulkan's headers")
  find_program(STILLRAY_GLSLC glslc DOC "Compiler of shaders")
  set(STILLRAY_VULKAN OFF)
  if(STILLRAY_BUILD_VULKAN AND STILLRAY_VULKAN_HEADERS AND STILLRAY_GLSLC)
    set(STILLRAY_VULKAN ON)
  elseif(STILLRAY_BUILD_VULKAN)
    message(STATUS "Without Vulkan: its headers (libvulkan-dev) or glslc are not installed")
  endif()
endmacro()

# some_name -> SomeName
function(stillray_camel_case output name)
  string(REPLACE "_" ";" words ${name})
  set(joined "")
  foreach(word IN LISTS words)
    string(SUBSTRING ${word} 0 1 first)
    string(SUBSTRING ${word} 1 -1 rest)
    string(TOUPPER ${first} first)
    string(APPEND joined ${first}${rest})
  endforeach()
  set(${output} ${joined} PARENT_SCOPE)
endfunction()

function(stillray_embed_shader output file namespace symbol)
  set(input ${CMAKE_CURRENT_SOURCE_DIR}/${file})
  set(base ${CMAKE_CURRENT_BINARY_DIR}/shaders/${symbol})
  set(optimise -O)
  if(STILLRAY_QUICK_COMPILE)
    set(optimise "")  # it takes most of the time, and drivers do the same once more
  endif()
  file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/shaders)
  add_custom_command(
    OUTPUT ${base}.spv.txt
    COMMAND ${STILLRAY_GLSLC} ${optimise} --target-env=vulkan1.1 -Werror -mfmt=num -I ${PROJECT_SOURCE_DIR}/src
            ${ARGN} -MD -MF ${base}.d -MT ${base}.spv.txt -o ${base}.spv.txt ${input}
    DEPENDS ${input}
    DEPFILE ${base}.d
    COMMENT "Shader ${symbol}"
    VERBATIM)
  add_custom_command(
    OUTPUT ${base}.cpp
    COMMAND ${CMAKE_COMMAND} -D INPUT=${base}.spv.txt -D OUTPUT=${base}.cpp -D NAMESPACE=${namespace}
            -D SYMBOL=${symbol} -P ${STILLRAY_SHADER_SCRIPT}
    DEPENDS ${base}.spv.txt ${STILLRAY_SHADER_SCRIPT}
    VERBATIM)
  set_source_files_properties(${base}.cpp PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
  set(${output} ${${output}} ${base}.cpp PARENT_SCOPE)
endfunction()
