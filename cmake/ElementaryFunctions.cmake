# SPDX-License-Identifier: Apache-2.0
# Replaces the C library's elementary functions by those of src/base/elementary/functions.cpp, in everything that is
# linked with gnomon_base: the C library selects variants by the processor, whose results differ.

function(gnomon_wrap_elementary_functions target)
    foreach(name acos asin atan atan2 cbrt cos exp exp2 log log10 log2 pow sin sincos tan)
        target_link_options(${target} INTERFACE "LINKER:--wrap=${name},--wrap=${name}f")
    endforeach()
endfunction()
