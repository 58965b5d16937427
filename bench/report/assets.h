// SPDX-License-Identifier: Apache-2.0
#pragma once
// What every report page holds, made part of the program by CMake (see cmake/EmbedText.cmake).

#include <string_view>

namespace gnomon::bench {

extern const std::string_view k_chart_js;   // Chart.js 3.9, minified
extern const std::string_view k_page_css;   // report/page.css
extern const std::string_view k_page_js;    // report/page.js

}   // namespace gnomon::bench
