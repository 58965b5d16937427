// SPDX-License-Identifier: Apache-2.0
// Meshes compressed with Draco, buffer views compressed with meshoptimizer, and WebP images, as encoders write them.
#include <draco/compression/encode.h>
#include <meshoptimizer.h>
#include <webp/encode.h>

#include <array>
#include <stdexcept>

#include "fuzz/decoders.h"
#include "fuzz/seeds.h"

namespace gnomon::fuzz {

namespace {

constexpr std::uint32_t k_side = k_decoded_side, k_points = k_decoded_points;

// Calls face(a, b, c) for the triangles of a grid of points.
template <class Face>
void each_face(Face face)
{
    for (std::uint32_t y = 0; y + 1 < k_side; ++y)
        for (std::uint32_t x = 0; x + 1 < k_side; ++x) {
            const std::uint32_t a = y * k_side + x, b = a + 1, c = a + k_side, d = c + 1;
            face(a, c, b), face(b, c, d);
        }
}

Bytes draco_mesh(draco::MeshEncoderMethod method)
{
    draco::Mesh mesh;
    mesh.set_num_points(k_points);
    const auto add = [&](draco::GeometryAttribute::Type type, std::int8_t components) {
        draco::GeometryAttribute attribute;
        attribute.Init(type, nullptr, components, draco::DT_FLOAT32, false, 4 * components, 0);
        return mesh.attribute(mesh.AddAttribute(attribute, true, k_points));
    };
    draco::PointAttribute* const positions = add(draco::GeometryAttribute::POSITION, 3);
    draco::PointAttribute* const normals = add(draco::GeometryAttribute::NORMAL, 3);
    draco::PointAttribute* const coordinates = add(draco::GeometryAttribute::TEX_COORD, 2);
    for (std::uint32_t i = 0; i < k_points; ++i) {
        const auto x = static_cast<float>(i % k_side), y = static_cast<float>(i / k_side);
        const float position[3] = {x, .1f * x * y, y}, normal[3] = {0, 1, 0}, uv[2] = {x / k_side, y / k_side};
        positions->SetAttributeValue(draco::AttributeValueIndex(i), position);
        normals->SetAttributeValue(draco::AttributeValueIndex(i), normal);
        coordinates->SetAttributeValue(draco::AttributeValueIndex(i), uv);
    }
    each_face([&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        mesh.AddFace({draco::PointIndex(a), draco::PointIndex(b), draco::PointIndex(c)});
    });
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    draco::EncoderBuffer buffer;
    if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) throw std::runtime_error("Draco does not encode");
    return {buffer.data(), buffer.data() + buffer.size()};
}

template <class Encode>
Bytes with_kind(MeshoptKind kind, std::size_t bound, const Encode& encode)
{
    Bytes bytes(bound + 1);
    bytes[0] = static_cast<std::uint8_t>(kind);
    bytes.resize(1 + encode(bytes.data() + 1, bound));
    return bytes;
}

Bytes webp_image(bool lossless, int channels)
{
    constexpr int width = 9, height = 7;
    Bytes pixels(static_cast<std::size_t>(width * height * channels));
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i % 29 * 8);
    std::uint8_t* encoded = nullptr;
    const int stride = width * channels;
    const std::size_t size = channels == 4
                                 ? (lossless ? WebPEncodeLosslessRGBA(pixels.data(), width, height, stride, &encoded)
                                             : WebPEncodeRGBA(pixels.data(), width, height, stride, 60, &encoded))
                                 : (lossless ? WebPEncodeLosslessRGB(pixels.data(), width, height, stride, &encoded)
                                             : WebPEncodeRGB(pixels.data(), width, height, stride, 60, &encoded));
    const Bytes result(encoded, encoded + size);
    WebPFree(encoded);
    return result;
}

}   // namespace

std::vector<Bytes> draco_seeds()
{
    return {draco_mesh(draco::MESH_SEQUENTIAL_ENCODING), draco_mesh(draco::MESH_EDGEBREAKER_ENCODING)};
}

std::vector<Bytes> meshopt_seeds()
{
    std::vector<std::array<float, 3>> points;
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = 0; i < k_points; ++i)
        points.push_back({static_cast<float>(i % k_side), .5f, static_cast<float>(i / k_side)});
    each_face([&](std::uint32_t a, std::uint32_t b, std::uint32_t c) { indices.insert(indices.end(), {a, b, c}); });
    std::vector<std::array<float, 3>> exponential(k_points);
    meshopt_encodeFilterExp(exponential.data(), k_points, 12, 15, &points[0][0]);
    const auto vertices = [&](MeshoptKind kind, const void* data) {
        return with_kind(kind, meshopt_encodeVertexBufferBound(k_points, 12), [&](auto* to, std::size_t size) {
            return meshopt_encodeVertexBuffer(to, size, data, k_points, 12);
        });
    };
    return {vertices(MeshoptKind::attributes, points.data()), vertices(MeshoptKind::exponential, exponential.data()),
            with_kind(MeshoptKind::triangles, meshopt_encodeIndexBufferBound(indices.size(), k_points),
                      [&](auto* to, std::size_t size) {
                          return meshopt_encodeIndexBuffer(to, size, indices.data(), indices.size());
                      }),
            with_kind(MeshoptKind::sequence, meshopt_encodeIndexSequenceBound(indices.size(), k_points),
                      [&](auto* to, std::size_t size) {
                          return meshopt_encodeIndexSequence(to, size, indices.data(), indices.size());
                      })};
}

std::vector<Bytes> webp_seeds()
{
    return {webp_image(true, 3), webp_image(true, 4), webp_image(false, 3), webp_image(false, 4)};
}

}   // namespace gnomon::fuzz
