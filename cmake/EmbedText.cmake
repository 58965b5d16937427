# SPDX-License-Identifier: Apache-2.0
# Converts a text file to C++: cmake -DINPUT=page.css -DOUTPUT=page_css.cpp -DNAME=k_page_css -P EmbedText.cmake
#
# The output defines `extern const std::string_view gnomon::bench::NAME` by raw string literals of a length that every
# compiler accepts. The text must not contain the delimiter that ends the literal.
file(READ "${INPUT}" text)
string(FIND "${text}" ")embedded\"" found)
if(NOT found EQUAL -1)
    message(FATAL_ERROR "${INPUT} contains )embedded\", which ends the raw string literal")
endif()
string(LENGTH "${text}" length)
set(piece 15000)
set(source "// Generated from a text file by EmbedText.cmake.\n#include <string_view>\n\nnamespace gnomon::bench {\n\n")
string(APPEND source "namespace {\nconstexpr char k_text[] =\n")
set(at 0)
while(at LESS length)
    string(SUBSTRING "${text}" ${at} ${piece} part)
    string(APPEND source "R\"embedded(${part})embedded\"\n")
    math(EXPR at "${at} + ${piece}")
endwhile()
string(APPEND source ";\n}\n\nextern const std::string_view ${NAME};\n")
string(APPEND source "const std::string_view ${NAME}(k_text, sizeof k_text - 1);\n\n}   // namespace gnomon::bench\n")
file(WRITE "${OUTPUT}" "${source}")
