// SPDX-License-Identifier: Apache-2.0
#pragma once
// A small room as a glTF document, with lights, materials and a camera whose values KHR_animation_pointer animates.
#include <map>

#include "gltf_document.h"

namespace gnomon::test {

inline constexpr const char* k_light_pointer = "/extensions/KHR_lights_punctual/lights/";

/// A floor (material 0), a wall (1) and a panel above (2), a point light (0), a spot light (1) and a directional one
/// (2), a camera with a perspective (0) and an orthographic one (1).
class PointerDocument {
 public:
    /// Lets a pointer animate a property.
    /// @param values  as many as `type` has for each key, three times that for a spline
    void animate(const std::string& pointer, const std::vector<float>& times, const std::vector<float>& values,
                 const char* type, const char* interpolation = "LINEAR")
    {
        static const std::map<std::string, int> sizes{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
        const int input = document_.times(times), output = document_.floats(values, type, sizes.at(type));
        animate(pointer, input, output, interpolation);
    }
    void animate(const std::string& pointer, int input, int output, const char* interpolation = "LINEAR")
    {
        const char* const comma = channels_.empty() ? "" : ",";
        channels_ +=
            fmt::format(R"({}{{"sampler":{},"target":{{"path":"pointer","extensions":{{"KHR_animation_pointer":)"
                        R"({{"pointer":"{}"}}}}}}}})",
                        comma, count_++, pointer);
        samplers_ +=
            fmt::format(R"({}{{"input":{},"output":{},"interpolation":"{}"}})", comma, input, output, interpolation);
    }
    Document& document() { return document_; }

    /// @param materials  the three materials
    scene::Scene load(const std::string& materials = R"({},{"emissiveFactor":[0.5,0.25,1]},{})")
    {
        if (positions_ < 0) {
            positions_ = document_.positions({-2, 0, 2, 2, 0, 2, 2, 0, -2, -2, 0, -2});
            indices_ = document_.accessor<std::uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 5123, 1);
        }
        std::string meshes, animations;
        for (int m = 0; m < 3; ++m)
            meshes +=
                fmt::format(R"({}{{"primitives":[{{"attributes":{{"POSITION":{}}},"indices":{},"material":{}}}]}})",
                            m ? "," : "", positions_, indices_, m);
        if (!channels_.empty())
            animations = fmt::format(R"(,"animations":[{{"channels":[{}],"samplers":[{}]}}])", channels_, samplers_);
        const auto light = [](int index) {
            return fmt::format(R"("extensions":{{"KHR_lights_punctual":{{"light":{}}}}})", index);
        };
        return document_.load(
            fmt::format(R"("meshes":[{}],"materials":[{}],"cameras":[{{"type":"perspective","perspective":)"
                        R"({{"yfov":0.9,"znear":0.1}}}},{{"type":"orthographic","orthographic":)"
                        R"({{"xmag":2,"ymag":2,"znear":0.1,"zfar":50}}}}],"nodes":[{{"mesh":0}},)"
                        R"({{"mesh":1,"translation":[0,1,-2],"rotation":[0.7071068,0,0,0.7071068]}},)"
                        R"({{"mesh":2,"translation":[0.4,1.8,0],"scale":[0.2,1,0.2],"rotation":[1,0,0,0]}},)"
                        R"({{"translation":[-0.8,1.2,0.3],{}}},)"
                        R"({{"translation":[0.9,1.6,0.4],"rotation":[-0.7071068,0,0,0.7071068],{}}},)"
                        R"({{"rotation":[-0.5,0,0,0.8660254],{}}},)"
                        R"({{"camera":0,"translation":[0,1,4]}},{{"camera":1,"translation":[0,1,4]}}]{})",
                        meshes, materials, light(0), light(1), light(2), animations),
            R"("extensionsUsed":["KHR_animation_pointer","KHR_lights_punctual","KHR_materials_emissive_strength"],)"
            R"("extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":4,"color":[1,0.5,0.25]},)"
            R"({"type":"spot","intensity":6,"spot":{"innerConeAngle":0.2,"outerConeAngle":0.6}},)"
            R"({"type":"directional","intensity":0.3}]}},)");
    }

 private:
    Document document_;
    std::string channels_, samplers_;
    int count_ = 0, positions_ = -1, indices_ = -1;
};

}   // namespace gnomon::test
