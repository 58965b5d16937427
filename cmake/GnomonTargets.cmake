# SPDX-License-Identifier: Apache-2.0
# Defines the compiler flags of all targets, and functions that make a static library of a folder and compile shaders.

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

# All flags are in one interface target. Do not use -ffast-math, because results are compared to the bit. Contraction to
# fused multiply-add is off, because the compiler would decide where it happens and so change the last bit.
add_library(gnomon_flags INTERFACE)
target_include_directories(gnomon_flags INTERFACE
    "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>" "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>")
target_compile_options(gnomon_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -ffp-contract=off
    $<$<BOOL:${GNOMON_WERROR}>:-Werror>)
# Every x86-64 processor since 2009 has SSE4.2, which rounds with one instruction instead of a call. Code that uses later
# instruction sets (Embree, vectorised loops) selects them at run time.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(GNOMON_ARCH "x86-64-v2" CACHE STRING "Instruction set to compile for, as -march takes it")
    target_compile_options(gnomon_flags INTERFACE -march=${GNOMON_ARCH})
endif()
if(GNOMON_PACKAGE)
    # Checks name their file: relative to the sources, so that a build has the same bytes in any folder.
    target_compile_options(gnomon_flags INTERFACE "-ffile-prefix-map=${PROJECT_BINARY_DIR}/=build/"
        "-ffile-prefix-map=${PROJECT_SOURCE_DIR}/=")
endif()
if(GNOMON_SANITIZE)
    target_compile_options(gnomon_flags INTERFACE -fsanitize=${GNOMON_SANITIZE} -fno-omit-frame-pointer
        -fno-sanitize-recover=all)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
        # Disable warnings that gcc gives for the standard library when it is instrumented.
        target_compile_options(gnomon_flags INTERFACE
            -Wno-stringop-overflow -Wno-array-bounds -Wno-maybe-uninitialized)
    endif()
    target_link_options(gnomon_flags INTERFACE -fsanitize=${GNOMON_SANITIZE})
endif()

# gnomon_library(NAME [FOLDER f] [SHADERS] [LINK targets...] [PRIVATE targets...]): the static library gnomon_NAME of all
# .cpp files in src/NAME, or src/FOLDER, and its subfolders except vulkan/, which is a separate target. SHADERS adds the
# shaders of the folder itself. LINK and PRIVATE list public and private dependencies.
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

# gnomon_program_library(NAME [LINK targets...] [PRIVATE targets...]): the same for the folder NAME beside src/, without
# its programs' main files (main.cpp, *_main.cpp). Headers are included as "NAME/file.h".
function(gnomon_program_library name)
    cmake_parse_arguments(ARG "" "" "LINK;PRIVATE" ${ARGN})
    set(from "${PROJECT_SOURCE_DIR}/${name}")
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${from}/*.cpp" "${from}/*.h")
    list(FILTER sources EXCLUDE REGEX "[/_]main\\.cpp$")
    add_library(gnomon_${name} STATIC ${sources})
    target_include_directories(gnomon_${name} PUBLIC "${PROJECT_SOURCE_DIR}")
    target_link_libraries(gnomon_${name} PUBLIC gnomon_flags ${ARG_LINK} PRIVATE ${ARG_PRIVATE})
endfunction()

# gnomon_shaders(TARGET FOLDER): compiles every shader in FOLDER (src/ROOM or tests/ROOM) to SPIR-V words that are
# included as "ROOM/NAME.STAGE.inc". The target environment is Vulkan 1.2, because with 1.3 reflection cannot read work
# group sizes. Shaders are not optimised here, because that removes the names used to bind resources; drivers optimise.
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
