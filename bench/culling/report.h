// SPDX-License-Identifier: Apache-2.0
#pragma once
// bench culling as a section of a report: the paper's Table 4 and Figures 7 and 8 with its printed values beside ours
// [Nah 2009, 3], and what certified culling does on the same rays.

#include "bench/culling/window.h"
#include "bench/report/page.h"

namespace gnomon::bench {

/// Figures: without Table 4. Brief: what is saved and what is wrong.
enum class CullingCharts { all, figures, brief };

void add_culling_section(ReportPage& page, const CullingWindow& window, CullingCharts charts = CullingCharts::all);

}   // namespace gnomon::bench
