// SPDX-License-Identifier: Apache-2.0
#pragma once
// Memory that traced frames use one after the other, so that each of them need not be given new pages by the system: at
// 1920 x 1080, 200 MB.

#include "image/pixel_filter.h"
#include "shading/centre_samples.h"

namespace gnomon::trace {

struct FrameScratch {
    shading::CentreSamples centres;
    image::SampleSums sums;

    std::size_t bytes() const { return centres.bytes() + sums.bytes(); }
};

}   // namespace gnomon::trace
