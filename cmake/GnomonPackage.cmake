# SPDX-License-Identifier: Apache-2.0
# Makes Debian packages with CPack, `./dev package`: gnomon, and python3-gnomon and blender-gnomon where the Python package
# is built.
#
# A package has the same bytes wherever it is built from the same sources with the same packages of Debian: the paths
# of the machine are left out of the code (GnomonTargets.cmake), and files have the time SOURCE_DATE_EPOCH. It contains a
# list of what is linked, in the format of SPDX 2.3.
if(NOT GNOMON_INSTALL OR NOT GNOMON_PROGRAM)
    message(FATAL_ERROR "GNOMON_PACKAGE needs GNOMON_INSTALL and GNOMON_PROGRAM")
endif()
find_package(Python3 REQUIRED COMPONENTS Interpreter)

install(FILES cmake/package/copyright CHANGELOG.md DESTINATION "${CMAKE_INSTALL_DOCDIR}")
install(DIRECTORY examples/slurm examples/openjd DESTINATION "${CMAKE_INSTALL_DOCDIR}/examples" USE_SOURCE_PERMISSIONS)
# The list is made when the package is, because Ninja can say only then which headers were compiled in.
set(sbom "${PROJECT_BINARY_DIR}/gnomon.spdx.json")
install(CODE "execute_process(COMMAND_ERROR_IS_FATAL ANY COMMAND \"${Python3_EXECUTABLE}\" -B
    \"${PROJECT_SOURCE_DIR}/tools/sbom.py\" \"${PROJECT_BINARY_DIR}\" \"${PROJECT_VERSION}\" \"${sbom}\")")
install(FILES "${sbom}" DESTINATION "${CMAKE_INSTALL_DOCDIR}")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME gnomon)
set(CPACK_PACKAGE_VENDOR "Gnomon")
set(CPACK_PACKAGE_CONTACT "The authors of Gnomon")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "renderer of animated 3D scenes that recomputes only what changed")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL gnomon)
set(CPACK_DEBIAN_GNOMON_PACKAGE_NAME gnomon)
set(CPACK_DEBIAN_GNOMON_PACKAGE_SHLIBDEPS ON)   # dependencies of the libraries that are linked
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_GNOMON_PACKAGE_RECOMMENDS "ffmpeg, libvulkan1, mesa-vulkan-drivers")   # videos, the rasteriser
set(CPACK_COMPONENT_GNOMON_DESCRIPTION "Program, library and headers.")
if(TARGET gnomon_python)
    list(APPEND CPACK_COMPONENTS_ALL python)
    set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-gnomon)
    set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
    set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Package of Python 3: scenes from numpy arrays, images as numpy arrays.")
    # The module is made for one version of Python, and for the library of the same build.
    math(EXPR next_python "${Python_VERSION_MINOR} + 1")
    string(CONCAT CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "gnomon (= ${PROJECT_VERSION}), "
        "python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy, "
        "libc6, libgcc-s1, libstdc++6")
    set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${CMAKE_CURRENT_LIST_DIR}/package/python/postinst"
        "${CMAKE_CURRENT_LIST_DIR}/package/python/prerm")
    set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
    install(FILES cmake/package/copyright DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/python3-gnomon" COMPONENT python)
    install(DIRECTORY examples/python DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/python3-gnomon/examples"
        COMPONENT python PATTERN __pycache__ EXCLUDE)
endif()
if(GNOMON_BLENDER)
    list(APPEND CPACK_COMPONENTS_ALL blender)
    set(CPACK_DEBIAN_BLENDER_PACKAGE_NAME blender-gnomon)
    set(CPACK_DEBIAN_BLENDER_PACKAGE_SECTION graphics)
    set(CPACK_DEBIAN_BLENDER_PACKAGE_ARCHITECTURE all)
    set(CPACK_COMPONENT_BLENDER_DESCRIPTION "Add-on for Blender: the render engine Gnomon.")
    set(CPACK_DEBIAN_BLENDER_PACKAGE_DEPENDS "python3-gnomon (= ${PROJECT_VERSION}), blender (>= 3.4)")
    install(FILES cmake/package/copyright DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/blender-gnomon" COMPONENT blender)
endif()
set(CPACK_PRE_BUILD_SCRIPTS "${CMAKE_CURRENT_LIST_DIR}/package/set_times.cmake")
include(CPack)
