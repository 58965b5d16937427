// SPDX-License-Identifier: Apache-2.0
// glTF files made to hurt: loops, long chains, deep and wide JSON, sizes that overflow, names that lead elsewhere.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <fstream>

#include "gltf_child.h"
#include "support.h"

namespace gnomon {
namespace {

using test::Outcome;
using Kind = test::Outcome::Kind;

class GltfHostileMade : public testing::Test {
 protected:
    Outcome load(const std::string& text, const std::string& name = "scene.gltf")
    {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return test::load_in_child(folder_ / name);
    }
    void expect_refused(const std::string& text, const std::string& place, const std::string& name = "scene.gltf")
    {
        const Outcome outcome = load(text, name);
        EXPECT_EQ(outcome.kind, Kind::refused) << text.substr(0, 200) << " signal " << outcome.signal << outcome.what;
        EXPECT_EQ(outcome.place, place) << outcome.what;
    }
    test::ScratchFolder folder_;
};

std::string document(const std::string& rest)
{
    return std::string(R"({"asset":{"version":"2.0"})") + (rest.empty() ? "" : ",") + rest + "}";
}

std::string u32(std::uint32_t v)
{
    std::string s;
    for (int i = 0; i < 4; ++i) s += static_cast<char>(v >> 8 * i & 0xff);
    return s;
}

std::string glb(std::string json, std::uint32_t claimed = 0)
{
    while (json.size() % 4) json += ' ';
    const auto size = static_cast<std::uint32_t>(json.size());
    return "glTF" + u32(2) + u32(claimed ? claimed : size + 20) + u32(size) + "JSON" + json;
}

TEST_F(GltfHostileMade, SmallestFileLoads)
{
    EXPECT_EQ(load(document("")).kind, Kind::loaded);
    EXPECT_EQ(load(glb(document("")), "a.glb").kind, Kind::loaded);
}

TEST_F(GltfHostileMade, NodeLoops)
{
    expect_refused(document(R"("nodes":[{"children":[0]}])"), "/nodes/0");
    expect_refused(
        document(R"("nodes":[{},{"children":[3]},{"children":[1]},{"children":[2]}],"scenes":[{"nodes":[0]}])"),
        "/nodes/1");
    expect_refused(document(R"("nodes":[{"children":[2]},{"children":[2]},{}])"), "/nodes/1/children/0");
    expect_refused(document(R"("nodes":[{"children":[1,1]},{}])"), "/nodes/0/children/1");
}

TEST_F(GltfHostileMade, LongChainOfNodesLoads)
{
    std::string nodes;
    constexpr int count = 200'000;
    for (int i = 0; i + 1 < count; ++i) nodes += fmt::format("{{\"children\":[{}]}},", i + 1);
    const Outcome outcome = load(document("\"nodes\":[" + nodes + "{}]"));
    EXPECT_EQ(outcome.kind, Kind::loaded) << outcome.what << outcome.signal;
}

TEST_F(GltfHostileMade, DeepAndWideJson)
{
    expect_refused(std::string(100'000, '['), "1:129");
    std::string deep;
    for (int i = 0; i < 100'000; ++i) deep += "{\"a\":";
    EXPECT_EQ(load(document("\"extras\":" + deep)).kind, Kind::refused);
    // Brackets within strings nest nothing; an escaped quote ends no string.
    EXPECT_EQ(load(document("\"extras\":\"" + std::string(1000, '[') + "\\\"" + std::string(1000, '{') + "\"")).kind,
              Kind::loaded);
    std::string wide = "[";
    for (int i = 0; i < 6'000'000; ++i) wide += "{},";
    EXPECT_EQ(load(document("\"extras\":" + wide + "{}]")).kind, Kind::refused);
    std::string nodes = "{}";
    for (int i = 0; i < 500'000; ++i) nodes += ",{}";
    EXPECT_EQ(load(document("\"nodes\":[" + nodes + "]")).place, "/nodes");
    EXPECT_EQ(load(document("\"extras\":1e999")).kind, Kind::refused);
    EXPECT_EQ(load("\xef\xbb\xbf" + document("")).place, "1:1");
}

TEST_F(GltfHostileMade, CountsThatOverflow)
{
    const std::string count =
        R"("bufferViews":[{"buffer":0,"byteLength":12}],"buffers":[{"byteLength":12,)"
        R"("uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAA"}],"accessors":[{"bufferView":0,)"
        R"("componentType":5126,"type":"VEC3","count":)";
    expect_refused(document(count + "4611686018427387904}]"), "/accessors/0/count");
    expect_refused(document(count + "9007199254740992}]"), "/accessors/0");
    expect_refused(document(count + "1537228672809129302}]"), "/accessors/0/count");   // 12 times it wraps to 8
    expect_refused(document(count + R"(1,"byteOffset":9007199254740988}])"), "/accessors/0/byteOffset");
    expect_refused(document(count + "-1}]"), "/accessors/0/count");
    expect_refused(document(count + "1.5}]"), "/accessors/0/count");
    EXPECT_EQ(load(document(count + "1}]")).kind, Kind::loaded);
    expect_refused(
        document(R"("buffers":[{"byteLength":4294967296,"uri":"data:application/octet-stream;base64,AAAA"}])"),
        "/buffers/0/byteLength");
    // Zeros need no bytes, but memory all the same.
    const std::string zeros = R"("accessors":[{"componentType":5126,"type":"VEC3","count":1000000000,"min":[0,0,0],)"
                              R"("max":[0,0,0]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
                              R"("nodes":[{"mesh":0}])";
    expect_refused(document(zeros), "/meshes/0/primitives/0/attributes/POSITION");
}

TEST_F(GltfHostileMade, OneAccessorUsedOften)
{
    std::string primitives;
    for (int i = 0; i < 20'000; ++i) primitives += R"({"attributes":{"POSITION":0}},)";
    primitives.pop_back();
    const Outcome outcome = load(
        document(R"("accessors":[{"componentType":5126,"type":"VEC3","count":100000,"min":[0,0,0],"max":[0,0,0]}],)"
                 R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[)" +
                 primitives + "]}]"));
    EXPECT_EQ(outcome.kind, Kind::refused) << outcome.signal;
}

TEST_F(GltfHostileMade, FramesOfGlb)
{
    expect_refused(glb(document("")).substr(0, 11), "byte 11", "a.glb");
    expect_refused(glb(document("")).substr(0, 30), "byte 8", "a.glb");
    expect_refused(glb(document("") + std::string(40, ' '), 0xfffffffc), "byte 8", "a.glb");
    expect_refused("glTF" + u32(1) + u32(20) + u32(0) + "JSON", "byte 4", "a.glb");
    expect_refused("glTF" + u32(2) + u32(24) + u32(0xfffffffc) + "JSON    ", "byte 12", "a.glb");
    expect_refused("", "byte 0", "a.glb");
    expect_refused("", "1:1", "a.gltf");
    const std::string whole =
        glb(document(R"("buffers":[{"byteLength":8}])")) + u32(8) + std::string("BIN\0", 4) + "12345678";
    std::string framed = whole;
    framed.replace(8, 4, u32(static_cast<std::uint32_t>(framed.size())));
    EXPECT_EQ(load(framed, "a.glb").kind, Kind::loaded);
    for (std::size_t length = 0; length < framed.size(); ++length)
        EXPECT_EQ(load(framed.substr(0, length), "a.glb").kind, Kind::refused) << length;
}

TEST_F(GltfHostileMade, NamesThatLeadElsewhere)
{
    const test::ScratchFolder outside;
    std::ofstream(outside / "secret.bin") << "12345678";
    std::filesystem::create_directory(folder_ / "sub");
    std::ofstream(folder_ / "sub" / "in side.bin") << "12345678";
    std::filesystem::create_symlink(outside / "secret.bin", folder_ / "link.bin");
    std::filesystem::create_symlink("sub/in side.bin", folder_ / "inner.bin");
    ASSERT_EQ(mkfifo((folder_ / "fifo").c_str(), 0600), 0);
    const auto with = [&](const std::string& uri) {
        return document(R"("buffers":[{"byteLength":8,"uri":")" + uri + "\"}]");
    };
    const std::string place = "/buffers/0/uri";
    for (const char* uri : {"fifo", "sub", ".", "..", "link.bin", "/etc/passwd", "/dev/zero",
                            "../../../../../../etc/passwd", "%2e%2e/%2e%2e/etc", "file:///etc/passwd", "sub/../../x",
                            "missing.bin", "bad%zz", "a%00b", ":", "", "sub/in%20side.bin/"})
        expect_refused(with(uri), place);
    expect_refused(with(std::string("../") + outside.path().filename().string() + "/secret.bin"), place);
    for (const char* uri : {"sub/in side.bin", "sub/in%20side.bin", "sub/../sub/in%20side.bin", "inner.bin",
                            "data:application/octet-stream;base64,MTIzNDU2Nzg="})
        EXPECT_EQ(load(with(uri)).kind, Kind::loaded) << uri;
    EXPECT_EQ(load(with("http://localhost:1/a.bin")).warnings, 1u);   // unused: only said
    expect_refused(with("data:application/octet-stream;base64,MTIz"), "/buffers/0/byteLength");
    expect_refused(with("data:application/octet-stream;base64,M!IzNDU2Nzg="), place);
    // Needed from the network: refused, not fetched.
    const Outcome remote =
        load(document(R"("buffers":[{"byteLength":36,"uri":"http://localhost:1/a.bin"}],)"
                      R"("bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,)"
                      R"("componentType":5126,"type":"VEC3","count":3,"min":[0,0,0],"max":[0,0,0]}],)"
                      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}])"));
    EXPECT_EQ(remote.kind, Kind::refused);
    EXPECT_NE(remote.what.find("network"), std::string::npos) << remote.what;
}

TEST_F(GltfHostileMade, TheFileItselfIsNoFile)
{
    ASSERT_EQ(mkfifo((folder_ / "fifo.gltf").c_str(), 0600), 0);
    std::filesystem::create_directory(folder_ / "folder.gltf");
    EXPECT_EQ(test::load_in_child(folder_ / "fifo.gltf").kind, Kind::refused);
    EXPECT_EQ(test::load_in_child(folder_ / "folder.gltf").kind, Kind::refused);
    EXPECT_EQ(test::load_in_child(folder_ / "missing.gltf").kind, Kind::refused);
}

TEST_F(GltfHostileMade, HugePictureInAFewBytes)
{
    // A PNG of 60000 x 60000 whose pixels are a kilobyte of nothing.
    std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
    png += std::string("\0\0\xea\x60\0\0\xea\x60\x08\x06\0\0\0\0\0\0\0", 17) + std::string("\0\0\x04\0IDAT", 8) +
           std::string(1024, '\0');
    std::ofstream(folder_ / "huge.png", std::ios::binary) << png;
    const std::string used =
        R"("images":[{"uri":"huge.png"}],"textures":[{"source":0}],"materials":[{"emissiveTexture":)"
        R"({"index":0}}],"accessors":[{"componentType":5126,"type":"VEC3","count":3,"min":[0,0,0],)"
        R"("max":[0,0,0]},{"componentType":5126,"type":"VEC2","count":3}],"meshes":[{"primitives":[)"
        R"({"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],"nodes":[{"mesh":0}])";
    expect_refused(document(used), "/images/0");
}

TEST_F(GltfHostileMade, RequiredExtensions)
{
    for (const char* name :
         {"KHR_draco_mesh_compression", "KHR_texture_basisu", "EXT_meshopt_compression", "KHR_materials_clearcoat",
          "KHR_animation_pointer", "EXT_mesh_gpu_instancing", "VENDOR_something"}) {
        const Outcome outcome =
            load(document(fmt::format("\"extensionsUsed\":[\"{0}\"],\"extensionsRequired\":[\"{0}\"]", name)));
        EXPECT_EQ(outcome.kind, Kind::refused);
        EXPECT_EQ(outcome.place, "/extensionsRequired/0");
        EXPECT_NE(outcome.what.find(name), std::string::npos) << outcome.what;
        EXPECT_EQ(load(document(fmt::format("\"extensionsUsed\":[\"{}\"]", name))).warnings, 1u) << name;
    }
}

// Every byte of a small scene replaced by something else: an answer, whatever it is, and never a crash.
TEST_F(GltfHostileMade, BrokenBytes)
{
    GNOMON_NEED_SCENE(file, "gltf/BoxAnimated.glb");
    std::ifstream stream(file, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(stream)), {});
    std::uint32_t seed = 12345;
    for (int round = 0; round < 300; ++round) {
        std::string broken = bytes;
        for (int k = 0; k < 1 + round % 4; ++k) {
            seed = seed * 1664525u + 1013904223u;
            broken[seed % broken.size()] = static_cast<char>(seed >> 24);
        }
        const Outcome outcome = load(broken, "a.glb");
        ASSERT_NE(outcome.kind, Kind::died) << "round " << round << " signal " << outcome.signal;
        ASSERT_NE(outcome.kind, Kind::other_error) << outcome.what;
    }
}

}   // namespace
}   // namespace gnomon
