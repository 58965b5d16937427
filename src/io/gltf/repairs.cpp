// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/repairs.h"

#include <fmt/format.h>

namespace gnomon::io::gltf {

namespace {

struct Wording {
    const char* one;    // of the fault, after the number 1
    const char* many;   // after other numbers
    const char* repair;
};

constexpr Wording k_wordings[] = {
    {"array is empty", "arrays are empty", "taken as absent"},
    {"number is slightly out of range", "numbers are slightly out of range", "clamped"},
    {"interpolation is a number", "interpolations are numbers", "taken as LINEAR"},
    {"vertex whose weights do not sum to 1", "vertices whose weights do not sum to 1",
     "renormalised; the first joint is used where all are zero"},
    {"normal is not of unit length", "normals are not of unit length",
     "normalised; replaced by the faces' normal where there is no direction"},
    {"tangent is not of unit length", "tangents are not of unit length",
     "normalised; any direction across the normal where there is none"},
    {"texture without its texture coordinates", "textures without their texture coordinates", "left out"},
    {"image file does not exist", "image files do not exist", "replaced by a neutral texel"},
    {"POSITION without min and max", "POSITION accessors without min and max", "computed"},
    {"use of a buffer view for another kind of data than declared or used before",
     "uses of buffer views for another kind of data than declared or used before", "read as used"},
    {"inverse bind matrix whose last row is not 0 0 0 1", "inverse bind matrices whose last row is not 0 0 0 1",
     "the row is replaced"},
    {"joint is not below the root of its skeleton", "joints are not below the root of their skeleton",
     "the skeleton is ignored"},
    {"node of a scene is not a root", "nodes of scenes are not roots", "placed where the scene lists them"},
    {"accessor of animation data has a stride", "accessors of animation data have a stride", "read with the stride"},
};
static_assert(std::size(k_wordings) == static_cast<std::size_t>(Fault::count));

}   // namespace

void Repairs::count(Fault fault, const std::string& pointer)
{
    Counter& counter = counters_[static_cast<std::size_t>(fault)];
    if (counter.number++ == 0) counter.first = pointer;
}

std::vector<std::string> Repairs::warnings() const
{
    std::vector<std::string> result;
    for (std::size_t i = 0; i < counters_.size(); ++i) {
        const Counter& counter = counters_[i];
        if (counter.number == 0) continue;
        const Wording& wording = k_wordings[i];
        result.push_back(fmt::format("{}: {} {}: {}", counter.first.empty() ? "/" : counter.first, counter.number,
                                     counter.number == 1 ? wording.one : wording.many, wording.repair));
    }
    return result;
}

}   // namespace gnomon::io::gltf
