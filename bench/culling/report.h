// SPDX-License-Identifier: Apache-2.0
#pragma once
// Writes the results of bench culling as a section of a report: Table 4 and Figures 7 and 8 of the paper with its
// printed values next to ours [Nah 2009, 3], and certified culling on the same rays.

#include <span>

#include "bench/culling/window.h"
#include "bench/report/page.h"

namespace gnomon::bench {

/// `figures` omits Table 4; `brief` shows only savings and wrong results.
enum class CullingCharts { all, figures, brief };

/// The table and the chart of savings against the step.
void add_step_figures(ReportPage& page, std::span<const CullingWindow> windows);

void add_culling_section(ReportPage& page, const CullingWindow& window, CullingCharts charts = CullingCharts::all);

}   // namespace gnomon::bench
