// SPDX-License-Identifier: Apache-2.0
#pragma once
// Memory that traced frames use one after the other, so that each of them need not be given new pages by the system: at
// 1920 x 1080, 200 MB; and what tiles keep while the camera stands still.

#include "image/pixel_filter.h"
#include "shading/centre_samples.h"
#include "trace/bounced_places.h"
#include "trace/kept_tiles.h"

namespace gnomon::trace {

struct FrameScratch {
    shading::CentreSamples centres;
    BouncedPlaces places;
    image::SampleSums sums;
    KeptTiles kept;   // those of a frame with adaptive samples belong to `centres`

    void forget_samples() { centres = {}, places = {}, sums = {}; }
    void forget() { forget_samples(), kept.forget(); }
    std::size_t bytes() const { return centres.bytes() + places.bytes() + sums.bytes() + kept.bytes(); }
};

}   // namespace gnomon::trace
