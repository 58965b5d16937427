// SPDX-License-Identifier: Apache-2.0
#pragma once
// The scripts and the style sheet of every report page, which CMake embeds in the program (cmake/EmbedText.cmake).

#include <string_view>

namespace gnomon::bench {

extern const std::string_view k_chart_js;   // Chart.js 3.9, minified
extern const std::string_view k_page_css;   // report/page.css
extern const std::string_view k_page_js;    // report/page.js

}   // namespace gnomon::bench
