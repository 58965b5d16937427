// SPDX-License-Identifier: Apache-2.0
// Buffer views compressed with EXT_meshopt_compression: decoded as they were, with every mode and filter, refused where
// their numbers break the rules, and harmless where their bytes are not what an encoder writes.
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <fstream>

#include "base/random.h"
#include "gltf_child.h"
#include "io/load.h"
#include "support.h"

namespace gnomon {
namespace {

using test::Outcome;
using Kind = test::Outcome::Kind;

constexpr std::uint32_t k_side = 5, k_points = (k_side + 1) * (k_side + 1), k_corners = 6 * k_side * k_side;

struct Compressed {
    std::vector<std::uint8_t> positions, normals, indices;
    std::vector<float> points;   // as encoded
    std::vector<std::uint32_t> corners;
    std::string bytes;
    std::size_t begin[3] = {};
};

template <class Encode>
std::vector<std::uint8_t> bounded(std::size_t bound, const Encode& encode)
{
    std::vector<std::uint8_t> bytes(bound);
    bytes.resize(encode(bytes.data(), bytes.size()));
    return bytes;
}

/// @param exponential  positions go through that filter; @param sequence  indices as a sequence, not as triangles
Compressed compressed(bool exponential, bool sequence)
{
    Compressed c;
    std::vector<float> directions;
    for (std::uint32_t i = 0; i < k_points; ++i) {
        const auto x = static_cast<float>(i % (k_side + 1)), z = static_cast<float>(i / (k_side + 1));
        c.points.insert(c.points.end(), {x, 0.25f * x, z});
        directions.insert(directions.end(), {0, 1, 0, 0});
    }
    for (std::uint32_t z = 0; z < k_side; ++z)
        for (std::uint32_t x = 0; x < k_side; ++x) {
            const std::uint32_t a = z * (k_side + 1) + x, b = a + 1, d = a + k_side + 1;
            c.corners.insert(c.corners.end(), {a, d, b, b, d, d + 1});
        }
    std::vector<std::uint8_t> points(12 * k_points), octahedral(4 * k_points);
    if (exponential)
        meshopt_encodeFilterExp(points.data(), k_points, 12, 20, c.points.data());
    else
        std::memcpy(points.data(), c.points.data(), points.size());
    meshopt_encodeFilterOct(octahedral.data(), k_points, 4, 8, directions.data());
    c.positions = bounded(meshopt_encodeVertexBufferBound(k_points, 12), [&](auto* to, std::size_t size) {
        return meshopt_encodeVertexBuffer(to, size, points.data(), k_points, 12);
    });
    c.normals = bounded(meshopt_encodeVertexBufferBound(k_points, 4), [&](auto* to, std::size_t size) {
        return meshopt_encodeVertexBuffer(to, size, octahedral.data(), k_points, 4);
    });
    c.indices = sequence
                    ? bounded(meshopt_encodeIndexSequenceBound(k_corners, k_points),
                              [&](auto* to, std::size_t size) {
                                  return meshopt_encodeIndexSequence(to, size, c.corners.data(), k_corners);
                              })
                    : bounded(meshopt_encodeIndexBufferBound(k_corners, k_points), [&](auto* to, std::size_t size) {
                          return meshopt_encodeIndexBuffer(to, size, c.corners.data(), k_corners);
                      });
    const std::vector<std::uint8_t>* const parts[] = {&c.positions, &c.normals, &c.indices};
    for (int i = 0; i < 3; ++i) {
        c.begin[i] = c.bytes.size();
        c.bytes.append(parts[i]->begin(), parts[i]->end());
    }
    return c;
}

std::string document(const Compressed& c, const std::string& filter, const std::string& mode)
{
    const auto view = [&](std::size_t length, int stride, std::size_t begin, std::size_t from, std::uint32_t count,
                          const std::string& rest) {
        return fmt::format(
            R"({{"buffer":1,"byteOffset":{5},"byteLength":{0}{1},"extensions":{{"EXT_meshopt_compression":)"
            R"({{"buffer":0,"byteOffset":{2},"byteLength":{3},"byteStride":{4},"count":{6},{7}}}}}}})",
            count * static_cast<std::uint32_t>(stride),
            stride > 4 || rest.find("OCT") != std::string::npos ? fmt::format(",\"byteStride\":{}", stride) : "", from,
            length, stride, begin, count, rest);
    };
    const std::size_t end = 12 * k_points + 4 * k_points;
    return fmt::format(
        R"({{"asset":{{"version":"2.0"}},"extensionsUsed":["EXT_meshopt_compression","KHR_mesh_quantization"],)"
        R"("extensionsRequired":["EXT_meshopt_compression","KHR_mesh_quantization"],)"
        R"("buffers":[{{"uri":"m.bin","byteLength":{0}}},{{"byteLength":{1},"extensions":)"
        R"({{"EXT_meshopt_compression":{{}}}}}}],"bufferViews":[{2},{3},{4}],"accessors":[)"
        R"({{"bufferView":0,"componentType":5126,"type":"VEC3","count":{5},"min":[0,0,0],"max":[5,1.25,5]}},)"
        R"({{"bufferView":1,"componentType":5120,"normalized":true,"type":"VEC3","count":{5}}},)"
        R"({{"bufferView":2,"componentType":5125,"type":"SCALAR","count":{6}}}],"meshes":[{{"primitives":[)"
        R"({{"attributes":{{"POSITION":0,"NORMAL":1}},"indices":2}}]}}],"nodes":[{{"mesh":0}}]}})",
        c.bytes.size(), end + 4 * k_corners,
        view(c.positions.size(), 12, 0, c.begin[0], k_points, "\"mode\":\"ATTRIBUTES\"" + filter),
        view(c.normals.size(), 4, 12 * k_points, c.begin[1], k_points, R"("mode":"ATTRIBUTES","filter":"OCTAHEDRAL")"),
        view(c.indices.size(), 4, end, c.begin[2], k_corners, "\"mode\":\"" + mode + "\""), k_points, k_corners);
}

class Meshopt : public testing::Test {
 protected:
    std::filesystem::path write(const std::string& json, const std::string& bytes)
    {
        std::ofstream(folder_ / "m.bin", std::ios::binary) << bytes;
        std::ofstream(folder_ / "scene.gltf", std::ios::binary) << json;
        return folder_ / "scene.gltf";
    }
    test::ScratchFolder folder_;
};

TEST_F(Meshopt, EveryModeAndFilterDecodesToTheSameMesh)
{
    for (const bool exponential : {false, true})
        for (const bool sequence : {false, true}) {
            const Compressed c = compressed(exponential, sequence);
            const scene::Scene scene =
                io::load_gltf(write(document(c, exponential ? R"(,"filter":"EXPONENTIAL")" : R"(,"filter":"NONE")",
                                             sequence ? "INDICES" : "TRIANGLES"),
                                    c.bytes));
            EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
            ASSERT_EQ(scene.meshes.size(), 1u);
            const scene::Mesh& mesh = scene.meshes[0];
            ASSERT_EQ(mesh.positions.size(), k_points);
            ASSERT_EQ(3 * mesh.triangles.size(), k_corners);
            for (std::uint32_t i = 0; i < k_points; ++i)
                for (int k = 0; k < 3; ++k)
                    EXPECT_EQ(mesh.positions[i][k], c.points[3 * i + static_cast<std::uint32_t>(k)]);
            // Triangles keep their order, but may begin at another corner.
            for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
                const glm::uvec3 got = mesh.triangles[t];
                const std::uint32_t* const e = &c.corners[3 * t];
                const bool same = got == glm::uvec3(e[0], e[1], e[2]) || got == glm::uvec3(e[1], e[2], e[0]) ||
                                  got == glm::uvec3(e[2], e[0], e[1]);
                EXPECT_TRUE(same) << t;
            }
            for (const glm::vec3& n : mesh.normals) EXPECT_GT(n.y, 0.999f);
        }
}

TEST_F(Meshopt, NumbersThatBreakTheRulesAreRefused)
{
    const Compressed c = compressed(false, false);
    const std::string good = document(c, "", "TRIANGLES");
    const auto place_of = [&](const std::string& from, const std::string& to) {
        std::string json = good;
        json.replace(json.find(from), from.size(), to);
        const Outcome outcome = test::load_in_child(write(json, c.bytes));
        EXPECT_EQ(outcome.kind, Kind::refused) << to << outcome.what;
        return outcome.place;
    };
    const std::string first = "/bufferViews/0/extensions/EXT_meshopt_compression";
    EXPECT_EQ(place_of(R"("mode":"ATTRIBUTES")", R"("mode":"VERTICES")"), first);
    EXPECT_EQ(place_of(R"("mode":"ATTRIBUTES")", R"("mode":"ATTRIBUTES","filter":"QUATERNION")"), first);
    EXPECT_EQ(place_of(R"("mode":"ATTRIBUTES")", R"("mode":"ATTRIBUTES","filter":"ROT13")"), first);
    EXPECT_EQ(place_of(fmt::format(R"("count":{},"mode":"ATTR)", k_points), R"("count":4000000000000,"mode":"ATTR)"),
              first);
    EXPECT_EQ(place_of(fmt::format(R"("count":{},"mode":"ATTR)", k_points),
                       fmt::format(R"("count":{},"mode":"ATTR)", k_points + 1)),
              first);
    EXPECT_EQ(place_of(R"({"buffer":0,"byteOffset":0)", R"({"buffer":0,"byteOffset":100000)"), first);
}

TEST_F(Meshopt, DamagedBytesAreRefusedOrLoadedAndNothingElse)
{
    for (const bool sequence : {false, true}) {
        const Compressed c = compressed(true, sequence);
        const std::string json = document(c, R"(,"filter":"EXPONENTIAL")", sequence ? "INDICES" : "TRIANGLES");
        Random random(2, sequence ? 1 : 0);
        int refused = 0;
        constexpr int k_tries = 60;
        for (int i = 0; i < k_tries; ++i) {
            std::string damaged = c.bytes;
            for (std::uint32_t n = 1 + random.below(6); n > 0; --n)
                damaged[random.below(static_cast<std::uint32_t>(damaged.size()))] =
                    static_cast<char>(random.below(256));
            const Outcome outcome = test::load_in_child(write(json, damaged), i % 2 == 1);
            EXPECT_TRUE(outcome.kind == Kind::refused || outcome.kind == Kind::loaded)
                << i << ": signal " << outcome.signal << ' ' << outcome.what;
            refused += outcome.kind == Kind::refused;
        }
        EXPECT_GT(refused, k_tries / 4);
    }
}

}   // namespace
}   // namespace gnomon
