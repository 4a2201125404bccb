# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0

# What `cmake --install` puts where: the program, libstillray with its C and C++ headers, the static
# libraries with the C++ engine's headers, and how CMake and pkg-config find them.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(stillray_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/stillray)

install(TARGETS stillray_shared EXPORT stillrayTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS stillray_capi stillray_denoise stillray_core EXPORT stillrayStaticTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(module IN ITEMS capi denoise core)
  set_target_properties(stillray_${module} PROPERTIES EXPORT_NAME ${module})
endforeach()
if(TARGET stillray_gpu)
  install(TARGETS stillray_gpu EXPORT stillrayStaticTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  set_target_properties(stillray_gpu PROPERTIES EXPORT_NAME gpu)
endif()
if(TARGET stillray)
  install(TARGETS stillray RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

install(FILES
  include/stillray/stillray.h include/stillray/stillray.hpp
  include/stillray/core.h include/stillray/denoise.hpp include/stillray/frame.h
  include/stillray/image.h include/stillray/shared_picture.h include/stillray/status.h
    include/stillray/vec.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stillray)

if(STILLRAY_VULKAN)
  install(FILES include/stillray/vulkan.h include/stillray/vulkan.hpp
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stillray)
endif()

install(EXPORT stillrayTargets NAMESPACE stillray:: DESTINATION ${stillray_cmake_dir})
install(EXPORT stillrayStaticTargets NAMESPACE stillray:: DESTINATION ${stillray_cmake_dir})
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
configure_file(cmake/stillray.pc.in ${PROJECT_BINARY_DIR}/cmake/stillray.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/cmake/stillray.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
