// SPDX-License-Identifier: Apache-2.0
#include "fuzz/decoders.h"

#include <fmt/format.h>

namespace gnomon::fuzz {

std::string draco_document(std::size_t bytes, const std::string& file)
{
    return fmt::format(
        R"({{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_draco_mesh_compression"],)"
        R"("extensionsRequired":["KHR_draco_mesh_compression"],"buffers":[{{"uri":"{3}","byteLength":{0}}}],)"
        R"("bufferViews":[{{"buffer":0,"byteLength":{0}}}],"accessors":[)"
        R"({{"componentType":5126,"type":"VEC3","count":{1},"min":[0,0,0],"max":[5,2.5,5]}},)"
        R"({{"componentType":5126,"type":"VEC3","count":{1}}},{{"componentType":5126,"type":"VEC2","count":{1}}},)"
        R"({{"componentType":5123,"type":"SCALAR","count":{2}}}],"meshes":[{{"primitives":[{{"attributes":)"
        R"({{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},"indices":3,"extensions":{{"KHR_draco_mesh_compression":)"
        R"({{"bufferView":0,"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}}}}}}}}]}}],"nodes":[{{"mesh":0}}]}})",
        bytes, k_decoded_points, k_decoded_corners, file);
}

std::string meshopt_document(MeshoptKind kind, std::size_t bytes, const std::string& file)
{
    const bool indices = kind >= MeshoptKind::triangles;
    const char* const mode = kind == MeshoptKind::triangles  ? "TRIANGLES"
                             : kind == MeshoptKind::sequence ? "INDICES"
                                                             : "ATTRIBUTES";
    const char* const filter = kind == MeshoptKind::exponential  ? "EXPONENTIAL"
                               : kind == MeshoptKind::octahedral ? "OCTAHEDRAL"
                               : kind == MeshoptKind::quaternion ? "QUATERNION"
                                                                 : "NONE";
    const bool short_vectors = kind == MeshoptKind::octahedral || kind == MeshoptKind::quaternion;
    const std::uint32_t stride = indices ? 4 : short_vectors ? 8 : 12;
    const std::uint32_t count = indices ? k_decoded_corners : k_decoded_points;
    // A view of indices belongs to a mesh whose positions are zeros; other vectors are texture coordinates beside them.
    const std::string positions =
        fmt::format(R"({{{}"componentType":5126,"type":"VEC3","count":{},"min":[0,0,0],"max":[5,5,5]}})",
                    indices || short_vectors ? "" : "\"bufferView\":0,", k_decoded_points);
    const std::string other =
        indices ? fmt::format(R"(,{{"bufferView":0,"componentType":5125,"type":"SCALAR","count":{}}})", count)
        : short_vectors
            ? fmt::format(R"(,{{"bufferView":0,"componentType":5122,"normalized":true,"type":"VEC2","count":{}}})",
                          count)
            : "";
    const char* const uses = indices         ? R"("attributes":{"POSITION":0},"indices":1)"
                             : short_vectors ? R"("attributes":{"POSITION":0,"TEXCOORD_0":1})"
                                             : R"("attributes":{"POSITION":0})";
    return fmt::format(
        R"({{"asset":{{"version":"2.0"}},"extensionsUsed":["EXT_meshopt_compression","KHR_mesh_quantization"],)"
        R"("extensionsRequired":["EXT_meshopt_compression","KHR_mesh_quantization"],)"
        R"("buffers":[{{"uri":"{0}","byteLength":{1}}},{{"byteLength":{2},"extensions":)"
        R"({{"EXT_meshopt_compression":{{}}}}}}],"bufferViews":[{{"buffer":1,"byteLength":{2}{3},"extensions":)"
        R"({{"EXT_meshopt_compression":{{"buffer":0,"byteLength":{1},"byteStride":{4},"count":{5},"mode":"{6}",)"
        R"("filter":"{7}"}}}}}}],"accessors":[{8}{9}],"meshes":[{{"primitives":[{{{10}}}]}}],"nodes":[{{"mesh":0}}]}})",
        file, bytes, stride * count, indices ? "" : fmt::format(",\"byteStride\":{}", stride), stride, count, mode,
        filter, positions, other, uses);
}

}   // namespace gnomon::fuzz
