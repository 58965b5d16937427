# SPDX-License-Identifier: Apache-2.0
# Installs the add-on for Blender, which is Python alone, where the Python package is built.
#
# Debian's Blender looks for add-ons in share/blender/scripts/addons below /usr. GNOMON_BLENDER_DIR is where it is
# installed, relative to the prefix. An archive of it, for Blender's own way to install add-ons, is made by the target
# `blender_archive`.
set(GNOMON_BLENDER OFF)
if(TARGET gnomon_python)
    set(GNOMON_BLENDER ON)
    set(GNOMON_BLENDER_DIR share/blender/scripts/addons CACHE STRING
        "Where the add-on for Blender is installed, relative to the prefix")
    install(DIRECTORY "${PROJECT_SOURCE_DIR}/blender/gnomon_render" DESTINATION "${GNOMON_BLENDER_DIR}" COMPONENT blender
        PATTERN __pycache__ EXCLUDE)
    add_custom_target(blender_archive
        COMMAND "${CMAKE_COMMAND}" -E tar cf "${PROJECT_BINARY_DIR}/gnomon_render.zip" --format=zip gnomon_render
        WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}/blender" VERBATIM)
endif()
