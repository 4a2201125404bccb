# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0

# Text files as C++ constants, made at build time whenever the file changes.
#
# stillray_embed_file(<output variable> <file> <namespace> <symbol>)
# <file>, relative to the current source folder, becomes a generated source that defines
# `extern const char <symbol>[]`, with a final zero, and `extern const std::size_t <symbol>Size`,
# without it. The path of the generated source is appended to the output variable.
#
# This file is also the script that the build runs to do it:
# cmake -D INPUT= -D OUTPUT= -D NAMESPACE= -D SYMBOL= -P EmbedFile.cmake

if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  file(READ "${INPUT}" hex HEX)
  string(LENGTH "${hex}" digits)
  math(EXPR size "${digits} / 2")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${hex}")
  string(REPEAT "'....'," 16 line)
  string(REGEX REPLACE "(${line})" "\\1\n" bytes "${bytes}")
  file(WRITE "${OUTPUT}"
"// Made from ${INPUT}
#include <cstddef>

namespace ${NAMESPACE} {
extern const char ${SYMBOL}[] = {
${bytes}'\\0'};
extern const std::size_t ${SYMBOL}Size = ${size};
}  // namespace ${NAMESPACE}
")
  return()
endif()

set(STILLRAY_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_FILE})

function(stillray_embed_file output file namespace symbol)
  get_filename_component(name ${file} NAME)
  set(input ${CMAKE_CURRENT_SOURCE_DIR}/${file})
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/embedded/${name}.cpp)
  add_custom_command(
    OUTPUT ${generated}
    COMMAND ${CMAKE_COMMAND} -D INPUT=${input} -D OUTPUT=${generated} -D NAMESPACE=${namespace}
            -D SYMBOL=${symbol} -P ${STILLRAY_EMBED_SCRIPT}
    DEPENDS ${input} ${STILLRAY_EMBED_SCRIPT}
    COMMENT "Embedding ${file}"
    VERBATIM)
  set(${output} ${${output}} ${generated} PARENT_SCOPE)
endfunction()
