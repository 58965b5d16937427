// SPDX-License-Identifier: Apache-2.0
#pragma once
// Derives states from evidence, one record (one side of one static triangle) at a time.
//
// Parts are visited top down. A part without evidence, or with a decided state, is skipped. A part with both occluded
// and free rays is PARTIAL without a proof. For any other part, the certificate that the evidence allows is tried; if
// it fails, the part is PARTIAL, and its quarters get states of their own and are judged.

#include "base/interruption.h"
#include "shadow_culling/certified/certified_culling.h"

namespace gnomon::shadow_culling {

class Judge {
 public:
    Judge(const scene::SceneState& state, const StaticTriangles& triangles, ShadowMemory& memory,
          const std::vector<char>& light_on, const CertifiedOptions& options);

    /// Judges all parts of a record that have evidence, and removes the evidence. Once no certificates are left, the
    /// other parts stay as they are; later rays bring their evidence again.
    void judge(RecordId record);
    /// Sets the number of certificates that may still be tried; unlimited unless set.
    void allow(std::uint64_t certificates) { allowed_ = certificates; }
    bool allowed() const { return allowed_ > 0; }
    /// Allows no more certificates once this asks to stop; null: never.
    void stop_with(Interruption* interruption) { interruption_ = interruption; }
    const CullingCounters& counters() const { return counters_; }

 private:
    void gather_evidence(const std::uint8_t* finest);
    void judge_part(const MicroTriangle& part, std::uint32_t at_level, int light);
    ShadowState certify(const MicroTriangle& part, std::uint32_t at_level, int light, bool saw_occluded);
    void fill_down(const MicroTriangle& part, std::uint32_t at_level, int light, ShadowState state);

    const scene::SceneState& state_;
    const StaticTriangles& triangles_;
    ShadowMemory& memory_;
    const std::vector<char>& light_on_;
    const CertifiedOptions& options_;
    CullingCounters counters_;
    std::uint64_t allowed_ = ~std::uint64_t{0};
    Interruption* interruption_ = nullptr;

    // The present record.
    TriangleId triangle_ = 0;
    RecordId record_ = 0;
    std::uint32_t level_ = 0;
    glm::dvec3 corner_[3], normal_;
    double lift_ = 0;
    Rim rim_{RimCodes{}};              // the parts lie inside it
    std::vector<std::uint8_t> seen_;   // evidence of all levels, like the pyramid
    std::vector<TriangleId> occluders_;
};

}   // namespace gnomon::shadow_culling
