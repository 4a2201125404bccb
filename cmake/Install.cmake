# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0

# What `cmake --install` puts where: the program, libstillray with its C and C++ headers, the static
# libraries with the C++ engine's headers, the documents, and how CMake and pkg-config find them.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(stillray_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/stillray)

# stillray_install_modules(<export set> modules...)  those that were built
function(stillray_install_modules set)
  foreach(module IN LISTS ARGN)
    if(TARGET stillray_${module})
      install(TARGETS stillray_${module} EXPORT ${set} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
      set_target_properties(stillray_${module} PROPERTIES EXPORT_NAME ${module})
    endif()
  endforeach()
  install(EXPORT ${set} NAMESPACE stillray:: DESTINATION ${stillray_cmake_dir})
endfunction()

install(TARGETS stillray_shared EXPORT stillrayTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT stillrayTargets NAMESPACE stillray:: DESTINATION ${stillray_cmake_dir})
stillray_install_modules(stillrayStaticTargets capi denoise gpu core)
if(STILLRAY_BUILD_APPS)
  stillray_install_modules(stillrayDoctorTargets doctor sequence motion io pictures)
  install(TARGETS stillray RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

# Shaders for engines without the library, on request: cmake --install build --component shaders
if(STILLRAY_BUILD_APPS AND STILLRAY_VULKAN)
  install(CODE "
    set(folder \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/stillray/shaders\")
    execute_process(COMMAND \"$<TARGET_FILE:stillray>\" shaders -o \"\${folder}\" COMMAND_ERROR_IS_FATAL ANY)"
    COMPONENT shaders EXCLUDE_FROM_ALL)
endif()

set(headers
  camera.h core.h denoise.hpp frame.h image.h parameter.h reflections.h shared_picture.h status.h stillray.h stillray.hpp
  two_way.hpp vec.h)
if(STILLRAY_VULKAN)
  list(APPEND headers vulkan.h vulkan.hpp)
endif()
if(STILLRAY_BUILD_APPS)
  list(APPEND headers aov.h doctor.h io.h sequence.h)
endif()
list(TRANSFORM headers PREPEND include/stillray/)
install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stillray)

install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs examples DESTINATION ${CMAKE_INSTALL_DOCDIR})

configure_package_config_file(cmake/stillrayConfig.cmake.in
  ${PROJECT_BINARY_DIR}/cmake/stillrayConfig.cmake
  INSTALL_DESTINATION ${stillray_cmake_dir})
# Until 1.0 a minor version may change the API.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cmake/stillrayConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/cmake/stillrayConfig.cmake
  ${PROJECT_BINARY_DIR}/cmake/stillrayConfigVersion.cmake
  DESTINATION ${stillray_cmake_dir})

# Relative, so that an installation can be moved.
file(RELATIVE_PATH stillray_pc_prefix
  ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
# What libstillray.a needs, users before what they use.
set(stillray_pc_private "-lstillray_denoise")
if(TARGET stillray_gpu)
  string(APPEND stillray_pc_private " -lstillray_gpu")
endif()
string(APPEND stillray_pc_private " -lstillray_core -lstdc++ -lm -l${CMAKE_DL_LIBS}")
configure_file(cmake/stillray.pc.in ${PROJECT_BINARY_DIR}/cmake/stillray.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/cmake/stillray.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
