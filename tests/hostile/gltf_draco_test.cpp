// SPDX-License-Identifier: Apache-2.0
// Meshes compressed with KHR_draco_mesh_compression: decoded as they were, refused where they disagree with their
// accessors, and harmless where their bytes are not what an encoder writes.
#include <draco/compression/encode.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "base/random.h"
#include "gltf_child.h"
#include "gnomon/error.h"
#include "io/load.h"
#include "support.h"

namespace gnomon {
namespace {

using test::Outcome;
using Kind = test::Outcome::Kind;

// A grid of k_side x k_side quads with positions, normals and texture coordinates.
constexpr std::uint32_t k_side = 6, k_points = (k_side + 1) * (k_side + 1), k_faces = 2 * k_side * k_side;

std::array<float, 3> position(std::uint32_t i)
{
    const float x = static_cast<float>(i % (k_side + 1)), y = static_cast<float>(i / (k_side + 1));
    return {x, 0.1f * x * y, y};
}

std::string encoded(draco::MeshEncoderMethod method)
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
        const std::array<float, 3> p = position(i);
        const float normal[3] = {0, 2, 0}, uv[2] = {p[0] / k_side, p[2] / k_side};   // the importer makes it unit
        positions->SetAttributeValue(draco::AttributeValueIndex(i), p.data());
        normals->SetAttributeValue(draco::AttributeValueIndex(i), normal);
        coordinates->SetAttributeValue(draco::AttributeValueIndex(i), uv);
    }
    for (std::uint32_t y = 0; y < k_side; ++y)
        for (std::uint32_t x = 0; x < k_side; ++x) {
            const std::uint32_t a = y * (k_side + 1) + x, b = a + 1, c = a + k_side + 1, d = c + 1;
            using Point = draco::PointIndex;
            mesh.AddFace({Point(a), Point(c), Point(b)});
            mesh.AddFace({Point(b), Point(c), Point(d)});
        }
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
    return {buffer.data(), buffer.size()};
}

std::string document(std::size_t bytes, std::uint32_t points = k_points, std::uint32_t corners = 3 * k_faces)
{
    return fmt::format(
        R"({{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_draco_mesh_compression"],)"
        R"("extensionsRequired":["KHR_draco_mesh_compression"],"buffers":[{{"uri":"d.bin","byteLength":{0}}}],)"
        R"("bufferViews":[{{"buffer":0,"byteLength":{0}}}],"accessors":[)"
        R"({{"componentType":5126,"type":"VEC3","count":{1},"min":[0,0,0],"max":[6,4,6]}},)"
        R"({{"componentType":5126,"type":"VEC3","count":{1}}},{{"componentType":5126,"type":"VEC2","count":{1}}},)"
        R"({{"componentType":5123,"type":"SCALAR","count":{2}}}],"meshes":[{{"primitives":[{{"attributes":)"
        R"({{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},"indices":3,"extensions":{{"KHR_draco_mesh_compression":)"
        R"({{"bufferView":0,"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}}}}}}}}]}}],"nodes":[{{"mesh":0}}]}})",
        bytes, points, corners);
}

class Draco : public testing::Test {
 protected:
    std::filesystem::path write(const std::string& json, const std::string& bytes)
    {
        std::ofstream(folder_ / "d.bin", std::ios::binary) << bytes;
        std::ofstream(folder_ / "scene.gltf", std::ios::binary) << json;
        return folder_ / "scene.gltf";
    }
    test::ScratchFolder folder_;
};

TEST_F(Draco, BothMethodsDecodeToTheSameMesh)
{
    for (const auto method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
        const std::string bytes = encoded(method);
        const scene::Scene scene = io::load_gltf(write(document(bytes.size()), bytes));
        ASSERT_EQ(scene.meshes.size(), 1u);
        const scene::Mesh& mesh = scene.meshes[0];
        ASSERT_EQ(mesh.triangles.size(), k_faces);
        ASSERT_EQ(mesh.positions.size(), k_points);
        EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
        // The encoder may order vertices and triangles as it likes.
        const auto sorted = [](auto list) {
            std::sort(list.begin(), list.end());
            return list;
        };
        std::vector<std::array<float, 3>> got, expected;
        for (const glm::vec3& p : mesh.positions) got.push_back({p.x, p.y, p.z});
        for (std::uint32_t i = 0; i < k_points; ++i) expected.push_back(position(i));
        EXPECT_EQ(sorted(got), sorted(expected));
        float area = 0;
        for (const glm::uvec3& t : mesh.triangles) {
            const glm::vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
            const glm::vec3 cross = glm::cross(b - a, c - a);
            EXPECT_GT(cross.y, 0);
            area += 0.5f * cross.y;
        }
        EXPECT_NEAR(area, k_side * k_side, 1e-3);   // seen from above
        for (const glm::vec3& n : mesh.normals) EXPECT_EQ(n, glm::vec3(0, 1, 0));
        for (std::size_t v = 0; v < k_points; ++v)
            EXPECT_EQ(mesh.texcoords[0][v], glm::vec2(mesh.positions[v].x, mesh.positions[v].z) / float{k_side});
    }
}

TEST_F(Draco, DisagreementWithTheAccessorsIsRefused)
{
    const std::string bytes = encoded(draco::MESH_EDGEBREAKER_ENCODING);
    const std::string place = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    const auto refused_at = [&](const std::string& json) {
        const Outcome outcome = test::load_in_child(write(json, bytes));
        EXPECT_EQ(outcome.kind, Kind::refused) << outcome.what;
        return outcome.place;
    };
    EXPECT_EQ(refused_at(document(bytes.size(), k_points, 3 * k_faces + 3)), place);
    EXPECT_EQ(refused_at(document(bytes.size(), k_points - 1)), place);
    EXPECT_EQ(refused_at(document(bytes.size(), k_points + 1)).rfind(place + "/attributes", 0), 0u);
    std::string other = document(bytes.size());
    const std::string id = R"("bufferView":0,"attributes":{"POSITION":0)";
    other.replace(other.find(id), id.size(), R"("bufferView":0,"attributes":{"POSITION":77)");
    EXPECT_EQ(refused_at(other), place + "/attributes/POSITION");
    // Sizes that no file of this length has.
    EXPECT_EQ(refused_at(document(bytes.size(), 4'000'000'000u)).rfind("/", 0), 0u);
}

TEST_F(Draco, DamagedBytesAreRefusedOrLoadedAndNothingElse)
{
    for (const auto method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
        const std::string bytes = encoded(method);
        Random random(1, static_cast<std::uint64_t>(method));
        int refused = 0;
        constexpr int k_tries = 60;
        for (int i = 0; i < k_tries; ++i) {
            std::string damaged = bytes;
            if (i % 3 == 0) damaged.resize(1 + random.below(static_cast<std::uint32_t>(bytes.size() - 1)));
            for (std::uint32_t n = random.below(4); n > 0; --n)
                damaged[random.below(static_cast<std::uint32_t>(damaged.size()))] =
                    static_cast<char>(random.below(256));
            const Outcome outcome = test::load_in_child(write(document(damaged.size()), damaged), i % 2 == 1);
            EXPECT_TRUE(outcome.kind == Kind::refused || outcome.kind == Kind::loaded)
                << i << ": signal " << outcome.signal << ' ' << outcome.what;
            refused += outcome.kind == Kind::refused;
        }
        EXPECT_GT(refused, k_tries / 4);
    }
}

}   // namespace
}   // namespace gnomon
