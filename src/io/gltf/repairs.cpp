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
    {"number is out of range", "numbers are out of range", "clamped, or taken as absent"},
    {"interpolation is a number", "interpolations are numbers", "taken as LINEAR"},
    {"vertex whose weights do not sum to 1", "vertices whose weights do not sum to 1",
     "renormalised; the first joint is used where all are zero"},
    {"normal is not of unit length", "normals are not of unit length",
     "normalised; replaced by the faces' normal where there is no direction"},
    {"tangent is not of unit length", "tangents are not of unit length",
     "normalised; any direction across the normal where there is none"},
    {"texture without its texture coordinates", "textures without their texture coordinates", "left out"},
    {"image file does not exist", "image files do not exist", "replaced by a neutral texel"},
    {"file has another name than written", "files have other names than written", "the most similar one is read"},
    {"accessor whose min and max are missing or wrong", "accessors whose min and max are missing or wrong", "computed"},
    {"use of a buffer view for another kind of data than declared or used before",
     "uses of buffer views for another kind of data than declared or used before", "read as used"},
    {"inverse bind matrix whose last row is not 0 0 0 1", "inverse bind matrices whose last row is not 0 0 0 1",
     "the row is replaced"},
    {"joint is not below the root of its skeleton", "joints are not below the root of their skeleton",
     "the skeleton is ignored"},
    {"node of a scene is not a root", "nodes of scenes are not roots", "placed where the scene lists them"},
    {"stride where there should be none, or none where there should be one",
     "strides where there should be none, or none where there should be one", "read as declared"},
    {"offset or stride is not aligned", "offsets or strides are not aligned", "read as declared"},
    {"rotation is not of unit length", "rotations are not of unit length", "normalised; none where it has no length"},
    {"matrix of a node is not made of translation, rotation and scale",
     "matrices of nodes are not made of translation, rotation and scale", "used as they are"},
    {"vertex that uses a joint twice", "vertices that use a joint twice", "its weights are added"},
    {"skin whose joints have no common root", "skins whose joints have no common root", "used as they are"},
    {"skin on a node whose mesh has no joints", "skins on nodes whose meshes have no joints", "left out"},
    {"list of weights is not as long as there are morph targets",
     "lists of weights are not as long as there are morph targets", "cut, or filled with zeros"},
    {"attribute of a morph target that the primitive lacks", "attributes of morph targets that the primitives lack",
     "left out"},
    {"set of attributes without the set before it", "sets of attributes without the set before them",
     "used as they are numbered"},
    {"attribute that glTF does not have", "attributes that glTF does not have", "left out"},
    {"channel of an animation that has nothing to animate, or what another one animates",
     "channels of animations that have nothing to animate, or what others animate", "left out"},
    {"extension is not listed where it should be", "extensions are not listed where they should be", "taken as listed"},
    {"extension where it has no meaning", "extensions where they have no meaning", "left out"},
    {"image without its type, or with two sources or none", "images without their type, or with two sources or none",
     "its data decides; a neutral texel where there is none"},
    {"buffer in a data URI of another type", "buffers in data URIs of another type", "read as bytes"},
    {"spot light whose outer angle is not beyond its inner one",
     "spot lights whose outer angle is not beyond their inner one", "the inner angle is reduced"},
    {"camera whose far plane is not behind its near one", "cameras whose far plane is not behind their near one",
     "its depth is unlimited"},
    {"byte order mark before the JSON", "byte order marks before the JSON", "skipped"},
    {"node repeats a mesh in a place where 64 others have it",
     "nodes repeat meshes in places where 64 others have them", "left out"},
    {"vertex whose colour is zero, opacity included", "vertices whose colours are zero, opacity included",
     "taken as white"},
    {"property is null", "properties are null", "taken as absent"},
    {"accessor has no elements", "accessors have no elements", "what uses them is left out"},
    {"node has a matrix beside translation, rotation or scale",
     "nodes have matrices beside translation, rotation or scale", "the matrix is used"},
    {"matrix of a node that is animated", "matrices of nodes that are animated",
     "taken apart into translation, rotation and scale"},
    {"channel of an animation whose values are not as many as its keys",
     "channels of animations whose values are not as many as their keys", "left out"},
    {"key of an animation is not later than the one before it",
     "keys of animations are not later than those before them", "left out"},
    {"key of an animation has a negative time", "keys of animations have negative times", "used as they are"},
    {"spot light has no cone", "spot lights have no cone", "that of 45 degrees is used"},
    {"vector of a vertex is not finite", "vectors of vertices are not finite", "taken as zero"},
    {"name has a percent sign without an escape", "names have percent signs without an escape", "taken literally"},
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
