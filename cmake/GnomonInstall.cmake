# SPDX-License-Identifier: Apache-2.0
# Installs the program, its manual page and completions, and the library as a CMake package and for pkg-config.
#
# The library is one shared library, so that its users need only the public headers and none of its dependencies.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

add_library(gnomon_shared SHARED $<TARGET_OBJECTS:gnomon_api> $<TARGET_OBJECTS:gnomon_video>)
add_library(gnomon::gnomon ALIAS gnomon_shared)
set_target_properties(gnomon_shared PROPERTIES OUTPUT_NAME gnomon EXPORT_NAME gnomon VERSION "${PROJECT_VERSION}"
    SOVERSION "${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}")
target_link_libraries(gnomon_shared PRIVATE gnomon_video)   # the dependencies of its objects; private, so that users do not need them
target_include_directories(gnomon_shared INTERFACE "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>"
    "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
target_compile_features(gnomon_shared INTERFACE cxx_std_20)

add_executable(gnomon_documents cli/documents_main.cpp)
target_link_libraries(gnomon_documents PRIVATE gnomon_cli)
set(documents "${PROJECT_BINARY_DIR}/documents")
file(MAKE_DIRECTORY "${documents}")
set(made "${documents}/gnomon.1" "${documents}/gnomon.bash" "${documents}/_gnomon" "${documents}/gnomon.fish")
add_custom_command(OUTPUT ${made} COMMAND gnomon_documents "${documents}" DEPENDS gnomon_documents VERBATIM)
add_custom_target(documents ALL DEPENDS ${made})

install(TARGETS gnomon)
install(TARGETS gnomon_shared EXPORT gnomonTargets)
install(DIRECTORY include/gnomon DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
install(FILES "${documents}/gnomon.1" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1")
install(FILES "${documents}/gnomon.bash" DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" RENAME gnomon)
install(FILES "${documents}/_gnomon" DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/site-functions")
install(FILES "${documents}/gnomon.fish" DESTINATION "${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d")
set(package "${CMAKE_INSTALL_LIBDIR}/cmake/gnomon")
install(EXPORT gnomonTargets NAMESPACE gnomon:: DESTINATION "${package}")
configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/gnomonConfig.cmake.in"
    "${PROJECT_BINARY_DIR}/gnomonConfig.cmake" INSTALL_DESTINATION "${package}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/gnomonConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/gnomonConfig.cmake" "${PROJECT_BINARY_DIR}/gnomonConfigVersion.cmake"
    DESTINATION "${package}")

# For pkg-config. The prefix is relative to the installed file, so that the installed copy can be moved. Only the
# library itself is named, because it is shared and its headers need no others.
if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}")
    set(GNOMON_PC_PREFIX "${CMAKE_INSTALL_PREFIX}")
else()
    file(RELATIVE_PATH up "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
    string(REGEX REPLACE "/$" "" up "${up}")
    cmake_path(APPEND GNOMON_PC_PREFIX "\${pcfiledir}" "${up}")
endif()
cmake_path(APPEND GNOMON_PC_LIBDIR "\${prefix}" "${CMAKE_INSTALL_LIBDIR}")   # the second alone if it is absolute
cmake_path(APPEND GNOMON_PC_INCLUDEDIR "\${prefix}" "${CMAKE_INSTALL_INCLUDEDIR}")
configure_file("${CMAKE_CURRENT_LIST_DIR}/gnomon.pc.in" "${PROJECT_BINARY_DIR}/gnomon.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/gnomon.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
