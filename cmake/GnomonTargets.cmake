# SPDX-License-Identifier: Apache-2.0
# What every target of ours has in common, and gnomon_library(): one static library a folder of src/.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

find_program(GNOMON_CCACHE ccache)
if(GNOMON_CCACHE)
    set(CMAKE_CXX_COMPILER_LAUNCHER "${GNOMON_CCACHE}")
endif()

# Flags are in one interface target. Never -ffast-math: results are compared to the bit. No contraction to fused
# multiply-add either: whether it happens would depend on the compiler's mood, and with it the last bit.
add_library(gnomon_flags INTERFACE)
target_include_directories(gnomon_flags INTERFACE
    "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>" "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>")
target_compile_options(gnomon_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -ffp-contract=off
    $<$<BOOL:${GNOMON_WERROR}>:-Werror>)
# SSE4.2 is in every x86-64 processor since 2009, and rounding is one instruction there instead of a call. What needs more
# (Embree, vectorised loops) chooses at run time.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(GNOMON_ARCH "x86-64-v2" CACHE STRING "Instruction set to compile for, as -march takes it")
    target_compile_options(gnomon_flags INTERFACE -march=${GNOMON_ARCH})
endif()
if(GNOMON_SANITIZE)
    target_compile_options(gnomon_flags INTERFACE -fsanitize=${GNOMON_SANITIZE} -fno-omit-frame-pointer
        -fno-sanitize-recover=all)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
        # gcc warns of what its own instrumentation makes of the standard library.
        target_compile_options(gnomon_flags INTERFACE
            -Wno-stringop-overflow -Wno-array-bounds -Wno-maybe-uninitialized)
    endif()
    target_link_options(gnomon_flags INTERFACE -fsanitize=${GNOMON_SANITIZE})
endif()

# gnomon_library(NAME [FOLDER f] [SHADERS] [LINK targets...] [PRIVATE targets...]): all .cpp files of src/NAME, or of
# src/FOLDER, and of the folders in it, but for vulkan/, which is a target of its own; shaders of the folder itself with
# SHADERS; public and private needs.
function(gnomon_library name)
    cmake_parse_arguments(ARG "SHADERS" "FOLDER" "LINK;PRIVATE" ${ARGN})
    if(NOT ARG_FOLDER)
        set(ARG_FOLDER "${name}")
    endif()
    set(from "${PROJECT_SOURCE_DIR}/src/${ARG_FOLDER}")
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${from}/*.cpp" "${from}/*.h")
    list(FILTER sources EXCLUDE REGEX "^${from}/vulkan/")
    add_library(gnomon_${name} STATIC ${sources})
    set_target_properties(gnomon_${name} PROPERTIES LINKER_LANGUAGE CXX)
    target_link_libraries(gnomon_${name} PUBLIC gnomon_flags ${ARG_LINK} PRIVATE ${ARG_PRIVATE})
    if(ARG_SHADERS)
        gnomon_shaders(gnomon_${name} "src/${ARG_FOLDER}")
    endif()
endfunction()

# gnomon_program_library(NAME [LINK targets...] [PRIVATE targets...]): the same of the folder NAME beside src/, whose
# programs' own sources (main.cpp, NAME_main.cpp) are left out; its headers go by "NAME/file.h".
function(gnomon_program_library name)
    cmake_parse_arguments(ARG "" "" "LINK;PRIVATE" ${ARGN})
    set(from "${PROJECT_SOURCE_DIR}/${name}")
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${from}/*.cpp" "${from}/*.h")
    list(FILTER sources EXCLUDE REGEX "[/_]main\\.cpp$")
    add_library(gnomon_${name} STATIC ${sources})
    target_include_directories(gnomon_${name} PUBLIC "${PROJECT_SOURCE_DIR}")
    target_link_libraries(gnomon_${name} PUBLIC gnomon_flags ${ARG_LINK} PRIVATE ${ARG_PRIVATE})
endfunction()

# gnomon_shaders(TARGET FOLDER): every shader of FOLDER (src/ROOM, say) as SPIR-V words, to be included as
# "ROOM/NAME.STAGE.inc". The target environment is Vulkan 1.2's: 1.3's would put work group sizes where reflection
# cannot read them. Not optimised here: that would take the names that bindings go by, and drivers do it anyway.
function(gnomon_shaders target folder)
    string(REGEX REPLACE "^(src|tests)/" "" room "${folder}")
    set(from "${PROJECT_SOURCE_DIR}/${folder}")
    set(to "${PROJECT_BINARY_DIR}/shaders/${room}")
    file(GLOB shaders CONFIGURE_DEPENDS "${from}/*.vert" "${from}/*.frag" "${from}/*.comp"
        "${from}/*.rgen" "${from}/*.rmiss" "${from}/*.rahit")
    file(MAKE_DIRECTORY "${to}")
    set(outputs "")
    foreach(shader ${shaders})
        get_filename_component(name "${shader}" NAME)
        set(output "${to}/${name}.inc")
        add_custom_command(OUTPUT "${output}"
            COMMAND "${GNOMON_GLSLC}" --target-env=vulkan1.2 -Werror -mfmt=c -MD -MF "${output}.d" -MT "${output}"
                -I "${PROJECT_SOURCE_DIR}/src" -o "${output}" "${shader}"
            DEPENDS "${shader}" DEPFILE "${output}.d" VERBATIM COMMENT "Compiling shader ${room}/${name}")
        list(APPEND outputs "${output}")
    endforeach()
    target_sources(${target} PRIVATE ${outputs})
    target_include_directories(${target} PRIVATE "${PROJECT_BINARY_DIR}/shaders")
endfunction()

# gnomon_write_link_graph(FILE): a line for each target of ours, "NAME: what it links", from the targets' properties; for
# tools/check_targets.py.
function(gnomon_write_link_graph file)
    set(graph "")
    set(folders "${PROJECT_SOURCE_DIR}")
    while(folders)
        list(POP_FRONT folders folder)
        get_property(more DIRECTORY "${folder}" PROPERTY SUBDIRECTORIES)
        list(APPEND folders ${more})
        get_property(targets DIRECTORY "${folder}" PROPERTY BUILDSYSTEM_TARGETS)
        foreach(target ${targets})
            set(all "")
            foreach(property LINK_LIBRARIES INTERFACE_LINK_LIBRARIES)
                get_target_property(links ${target} ${property})
                if(links)
                    list(APPEND all ${links})
                endif()
            endforeach()
            list(REMOVE_DUPLICATES all)
            string(REPLACE ";" " " all "${all}")
            string(APPEND graph "${target}: ${all}\n")
        endforeach()
    endwhile()
    file(WRITE "${file}" "${graph}")
endfunction()
