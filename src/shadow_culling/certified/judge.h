// SPDX-License-Identifier: Apache-2.0
#pragma once
// Turns evidence into states, one record (one side of one static triangle) at a time.
//
// Top down: a part without evidence is left alone; one decided already needs nothing; one in which rays were both
// occluded and free is PARTIAL without any proof; else the certificate that the evidence allows is tried. Where it
// fails the part is PARTIAL, and its quarters, which get states of their own now, are judged.

#include "shadow_culling/certified/certified_culling.h"

namespace gnomon::shadow_culling {

class Judge {
 public:
    Judge(const scene::SceneState& state, const StaticTriangles& triangles, ShadowMemory& memory,
          const std::vector<char>& light_on, const CertifiedOptions& options);

    /// Judges all parts of a record with evidence, and takes the evidence. Where certificates run out, what is left
    /// stays as it is; rays will see it again.
    void judge(RecordId record);
    /// Certificates that may still be tried; without end unless set.
    void allow(std::uint64_t certificates) { allowed_ = certificates; }
    bool allowed() const { return allowed_ > 0; }
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

    // The record under judgement.
    TriangleId triangle_ = 0;
    RecordId record_ = 0;
    std::uint32_t level_ = 0;
    glm::dvec3 corner_[3], normal_;
    double lift_ = 0;
    Rim rim_{RimCodes{}};              // its parts lie inside
    std::vector<std::uint8_t> seen_;   // evidence of all levels, like the pyramid
    std::vector<TriangleId> occluders_;
};

}   // namespace gnomon::shadow_culling
