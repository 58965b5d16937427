// SPDX-License-Identifier: Apache-2.0
#pragma once
// Path-traced indirect light in the traced frame: a random estimate with its error (reference/reference.h).

#include <optional>

#include "reference/reference.h"
#include "trace/indirect_light.h"

namespace gnomon::frame {

class ReferenceIndirect final : public trace::IndirectLight {
 public:
    /// @param options  options.samples paths for each pixel, divided among its samples
    ReferenceIndirect(const reference::ReferenceOptions& options, int samples_per_pixel)
        : options_(options), samples_per_pixel_(samples_per_pixel)
    {
    }
    void begin_frame(const trace::FrameContext& frame) override;
    bool is_estimate() const override { return true; }
    bool reflects_lobes() const override { return true; }
    bool has_further_bounces() const override { return options_.bounces > 1; }
    bool replaces(const scene::Light& light) const override { return !light_->uses(light); }
    std::unique_ptr<Worker> make_worker() override;
    FrameCounters::Indirect end_frame(std::span<const std::unique_ptr<Worker>> workers) override;

 private:
    class Work;
    reference::ReferenceOptions options_;
    int samples_per_pixel_;
    int image_width_ = 0;
    const ray::RayScene* rays_ = nullptr;              // of the frame
    std::optional<reference::ReferenceLight> light_;   // of the frame
};

}   // namespace gnomon::frame
