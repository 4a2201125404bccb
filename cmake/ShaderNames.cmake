# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0

# Names in the interfaces of shaders, as a C++ constant: optimised SPIR-V has none.
#
# stillray_embed_shader_names(<output variable> <namespace> <symbol> SHADERS entries... NOTES files...)
# Each entry is `<name> <file> [defines...]`, in one argument, with the file relative to the current source folder. A
# generated source defines `extern const char <symbol>[]`, with lines as below, for each shader after one with its name
# and that of its file: `shader Atrous atrous`. `NOTES` are sources whose comments describe what they declare.
#
# This file is also the script that the build runs to do it:
# cmake -D OUTPUT= -D NAMESPACE= -D SYMBOL= -D ASSEMBLY=<list of .s files> -D NOTES=<list of files> -P ShaderNames.cmake

# Lines of names from disassembled SPIR-V:
#   constant <id> <name>            a specialisation constant
#   image <set> <binding> <name>    block <set> <binding> <structure>    push <structure>
#   struct <structure> <name> <member>:<type>...       a type is another structure, or any other word
function(stillray_read_names output file)
  file(STRINGS ${file} lines
    REGEX "OpName |OpMemberName |OpTypeStruct|OpMemberDecorate %[^ ]+ 0 Offset|OpDecorate %[^ ]+ (SpecId|Binding|DescriptorSet) |= OpVariable ")
  string(REPLACE ";" "," lines "${lines}\n")  # the list as text
  string(REPLACE "," "\n" text "${lines}")
  set(found "")
  string(REGEX MATCHALL "OpDecorate %[^ ]+ SpecId [0-9]+" decorations "${text}")
  foreach(decoration IN LISTS decorations)
    string(REGEX MATCH "%([^ ]+) SpecId ([0-9]+)" ignored "${decoration}")
    set(id ${CMAKE_MATCH_1})
    set(number ${CMAKE_MATCH_2})
    string(REGEX MATCH "OpName %${id} \"([^\"]*)\"" ignored "${text}")
    list(APPEND found "constant ${number} ${CMAKE_MATCH_1}")
  endforeach()
  string(REGEX MATCHALL "OpDecorate %[^ ]+ Binding [0-9]+" decorations "${text}")
  foreach(decoration IN LISTS decorations)
    string(REGEX MATCH "%([^ ]+) Binding ([0-9]+)" ignored "${decoration}")
    set(id ${CMAKE_MATCH_1})
    set(binding ${CMAKE_MATCH_2})
    string(REGEX MATCH "OpDecorate %${id} DescriptorSet ([0-9]+)" ignored "${text}")
    set(set ${CMAKE_MATCH_1})
    string(REGEX MATCH "%${id} = OpVariable %_ptr_([A-Za-z]+)_([^ ]+)" ignored "${text}")
    if(CMAKE_MATCH_1 STREQUAL "UniformConstant")
      string(REGEX MATCH "OpName %${id} \"([^\"]*)\"" ignored "${text}")
      list(APPEND found "image ${set} ${binding} ${CMAKE_MATCH_1}")
    else()
      list(APPEND found "block ${set} ${binding} ${CMAKE_MATCH_2}")
    endif()
  endforeach()
  if(text MATCHES "= OpVariable %_ptr_PushConstant_([^ \n]+) ")
    list(APPEND found "push ${CMAKE_MATCH_1}")
  endif()
  string(REGEX MATCHALL "%[^ ]+ = OpTypeStruct[^\n]*" structures "${text}")
  foreach(structure IN LISTS structures)
    string(REGEX MATCH "%([^ ]+) = OpTypeStruct(.*)" ignored "${structure}")
    set(id ${CMAKE_MATCH_1})
    string(REGEX MATCHALL "[^ %]+" types "${CMAKE_MATCH_2}")
    if(NOT text MATCHES "OpMemberDecorate %${id} 0 Offset")
      continue()  # of no block
    endif()
    string(REGEX MATCH "OpName %${id} \"([^\"]*)\"" ignored "${text}")
    set(line "struct ${id} ${CMAKE_MATCH_1}")
    string(REGEX MATCHALL "OpMemberName %${id} [0-9]+ \"[^\"]*\"" names "${text}")
    foreach(name type IN ZIP_LISTS names types)
      string(REGEX MATCH "\"([^\"]*)\"" ignored "${name}")
      string(APPEND line " ${CMAKE_MATCH_1}:${type}")
    endforeach()
    list(APPEND found "${line}")
  endforeach()
  set(${output} "${found}" PARENT_SCOPE)
endfunction()

# Comments behind declarations of a source:
#   note <block> <member> <text>
#   note <file's name without ending> <image, constant or push constant> <text>
function(stillray_read_notes output file)
  get_filename_component(block ${file} NAME_WE)
  set(of_file ${block})
  set(found "")
  file(READ ${file} text)
  string(REGEX REPLACE "[][;]" "|" text "${text}")  # what would end or join entries of lists
  string(REPLACE "\n" ";" lines "${text}")
  foreach(line IN LISTS lines)
    if(line MATCHES "^layout.push_constant")
      set(block ${of_file})
    elseif(line MATCHES "^(SHARED_BLOCK.|layout.*(uniform|buffer) |struct )([A-Za-z]+)[ )]*{")
      set(block ${CMAKE_MATCH_3})
    elseif(line MATCHES "^}")
      set(block ${of_file})
    elseif(line MATCHES "^layout.constant_id[^=]*=[^=]* ([A-Za-z0-9]+) = [^/]*// (.*)$")
      list(APPEND found "note ${of_file} ${CMAKE_MATCH_1} ${CMAKE_MATCH_2}")
    elseif(line MATCHES "^layout.set[^/]* ([a-z0-9_]+)[|] *// (.*)$")
      list(APPEND found "note ${of_file} ${CMAKE_MATCH_1} ${CMAKE_MATCH_2}")
    elseif(line MATCHES "^  (int|uint|float|vec[234]) ([a-z0-9_]+)[|0-9A-Z_a-z+* ]*// (.*)$")
      list(APPEND found "note ${block} ${CMAKE_MATCH_2} ${CMAKE_MATCH_3}")
    endif()
  endforeach()
  set(${output} "${found}" PARENT_SCOPE)
endfunction()

if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  set(text "")
  set(common "")
  foreach(file IN LISTS ASSEMBLY)
    get_filename_component(name ${file} NAME)
    string(REGEX MATCH "^([^.]*)[.]([^.]*)" ignored ${name})  # Atrous.atrous.s
    set(name "${CMAKE_MATCH_1} ${CMAKE_MATCH_2}")
    stillray_read_names(lines ${file})
    # What shaders have in common is kept with the first one.
    if(common STREQUAL "")
      set(common "${lines}")
    else()
      list(REMOVE_ITEM lines ${common})
    endif()
    list(JOIN lines "\n" lines)
    string(APPEND text "R\"names(shader ${name}\n${lines}\n)names\"\n")
  endforeach()
  foreach(file IN LISTS NOTES)
    stillray_read_notes(lines ${file})
    list(JOIN lines "\n" lines)
    string(REPLACE "|" ";" lines "${lines}")
    if(NOT lines STREQUAL "")
      string(APPEND text "R\"names(${lines}\n)names\"\n")
    endif()
  endforeach()
  file(WRITE "${OUTPUT}"
"// Names in the interfaces of shaders
namespace ${NAMESPACE} {
extern const char ${SYMBOL}[];
const char ${SYMBOL}[] = ${text};
}  // namespace ${NAMESPACE}
")
  return()
endif()

set(STILLRAY_SHADER_NAMES_SCRIPT ${CMAKE_CURRENT_LIST_FILE})

function(stillray_embed_shader_names output namespace symbol)
  cmake_parse_arguments(ARG "" "" "SHADERS;NOTES" ${ARGN})
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/shader_names)
  file(MAKE_DIRECTORY ${folder})
  set(assembly "")
  foreach(entry IN LISTS ARG_SHADERS)
    separate_arguments(parts UNIX_COMMAND "${entry}")
    list(POP_FRONT parts name file)
    set(input ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    get_filename_component(stem ${file} NAME_WE)
    set(base ${folder}/${name}.${stem})
    add_custom_command(
      OUTPUT ${base}.s
      COMMAND ${STILLRAY_GLSLC} -S --target-env=vulkan1.1 -I ${PROJECT_SOURCE_DIR}/src ${parts}
              -MD -MF ${base}.d -MT ${base}.s -o ${base}.s ${input}
      DEPENDS ${input}
      DEPFILE ${base}.d
      COMMENT "Names of shader ${name}"
      VERBATIM)
    list(APPEND assembly ${base}.s)
  endforeach()
  set(generated ${folder}/${symbol}.cpp)
  add_custom_command(
    OUTPUT ${generated}
    COMMAND ${CMAKE_COMMAND} -D OUTPUT=${generated} -D NAMESPACE=${namespace} -D SYMBOL=${symbol}
            "-DASSEMBLY=${assembly}" "-DNOTES=${ARG_NOTES}" -P ${STILLRAY_SHADER_NAMES_SCRIPT}
    DEPENDS ${assembly} ${ARG_NOTES} ${STILLRAY_SHADER_NAMES_SCRIPT}
    COMMENT "Names of shaders"
    VERBATIM)
  set_source_files_properties(${generated} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
  set(${output} ${${output}} ${generated} PARENT_SCOPE)
endfunction()
