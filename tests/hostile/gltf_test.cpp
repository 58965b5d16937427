// SPDX-License-Identifier: Apache-2.0
// glTF files made to do harm: loops, long chains, deep and wide JSON, sizes that overflow, file names that lead
// outside.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <csignal>
#include <fstream>
#include <stdexcept>

#include "gltf_child.h"
#include "image_bytes.h"
#include "support.h"

namespace gnomon {
namespace {

using test::Outcome;
using Kind = test::Outcome::Kind;

class HostileGltf : public testing::Test {
 protected:
    Outcome load(const std::string& text, const std::string& name = "scene.gltf", bool strict = false)
    {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return test::load_in_child(folder_ / name, strict);
    }
    void expect_refused(const std::string& text, const std::string& place, const std::string& name = "scene.gltf")
    {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        for (const bool strict : {false, true}) {
            const Outcome outcome = test::load_in_child(folder_ / name, strict);
            EXPECT_EQ(outcome.kind, Kind::refused)
                << text.substr(0, 200) << " signal " << outcome.signal << outcome.what << " strict " << strict;
            EXPECT_EQ(outcome.place, place) << outcome.what;
        }
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

// What the tests below look for in the process that loads a file: crashes, endless work, memory, and exceptions that
// are not for the user.
TEST(ChildProcess, TellsHowLoadingEnded)
{
    const auto none = [] { return std::size_t{0}; };
    EXPECT_EQ(test::run_in_child(none).kind, Kind::loaded);
    const test::Outcome refused =
        test::run_in_child([]() -> std::size_t { throw InputError("a.gltf", "/nodes", "no"); });
    EXPECT_EQ(refused.kind, Kind::refused);
    EXPECT_EQ(refused.place, "/nodes");
    const test::Outcome wrong = test::run_in_child([]() -> std::size_t { throw std::logic_error("a bug"); });
    EXPECT_EQ(wrong.kind, Kind::other_error);
    EXPECT_EQ(wrong.what, "a bug");
    const test::Outcome crashed = test::run_in_child([&] { return ::raise(SIGSEGV) != 0 ? none() : none(); });
    EXPECT_EQ(crashed.kind, Kind::died);
    if (!test::k_sanitized) {
        EXPECT_EQ(crashed.signal, SIGSEGV);   // a sanitizer prints, and ends the process itself
    }
    const test::Outcome endless = test::run_in_child(
        [&] {
            for (volatile bool ends = false; !ends;) {
            }
            return none();
        },
        1);
    EXPECT_EQ(endless.kind, Kind::died);
    EXPECT_TRUE(endless.signal == SIGXCPU || endless.signal == SIGKILL) << endless.signal;
    // Twice what is allowed; and what is touched counts as its peak.
    const auto take = [](std::size_t megabytes) {
        return [megabytes] {
            const std::string memory(megabytes << 20, 'x');
            return static_cast<std::size_t>(memory.back() == 'y');
        };
    };
    if (!test::k_sanitized) {
        EXPECT_EQ(test::run_in_child(take(1024)).kind, Kind::other_error);
    }
    EXPECT_GT(test::run_in_child(take(100)).peak_kib, test::run_in_child(none).peak_kib + 90 * 1024);
}

TEST_F(HostileGltf, LoadsTheSmallestFile)
{
    EXPECT_EQ(load(document("")).kind, Kind::loaded);
    EXPECT_EQ(load(glb(document("")), "a.glb").kind, Kind::loaded);
}

TEST_F(HostileGltf, RefusesNodeLoops)
{
    expect_refused(document(R"("nodes":[{"children":[0]}])"), "/nodes/0");
    expect_refused(
        document(R"("nodes":[{},{"children":[3]},{"children":[1]},{"children":[2]}],"scenes":[{"nodes":[0]}])"),
        "/nodes/1");
    expect_refused(document(R"("nodes":[{"children":[2]},{"children":[2]},{}])"), "/nodes/1/children/0");
    expect_refused(document(R"("nodes":[{"children":[1,1]},{}])"), "/nodes/0/children/1");
}

TEST_F(HostileGltf, LoadsALongChainOfNodes)
{
    std::string nodes;
    constexpr int count = 200'000;
    for (int i = 0; i + 1 < count; ++i) nodes += fmt::format("{{\"children\":[{}]}},", i + 1);
    const Outcome outcome = load(document("\"nodes\":[" + nodes + "{}]"));
    EXPECT_EQ(outcome.kind, Kind::loaded) << outcome.what << outcome.signal;
}

TEST_F(HostileGltf, LimitsDepthAndWidthOfJson)
{
    expect_refused(std::string(100'000, '['), "1:129");
    std::string deep;
    for (int i = 0; i < 100'000; ++i) deep += "{\"a\":";
    EXPECT_EQ(load(document("\"extras\":" + deep)).kind, Kind::refused);
    // Brackets within strings do not nest; an escaped quote does not end a string.
    EXPECT_EQ(load(document("\"extras\":\"" + std::string(1000, '[') + "\\\"" + std::string(1000, '{') + "\"")).kind,
              Kind::loaded);
    std::string wide = "[";
    for (int i = 0; i < 6'000'000; ++i) wide += "{},";
    EXPECT_EQ(load(document("\"extras\":" + wide + "{}]")).kind, Kind::refused);
    std::string nodes = "{}";
    for (int i = 0; i < 500'000; ++i) nodes += ",{}";
    EXPECT_EQ(load(document("\"nodes\":[" + nodes + "]")).place, "/nodes");
    EXPECT_EQ(load(document("\"extras\":1e999")).kind, Kind::refused);
    EXPECT_EQ(load("\xef\xbb\xbf" + document(""), "a.gltf", true).place, "1:1");
    EXPECT_EQ(load("\xef\xbb\xbf" + document("")).warnings, 1u);
}

TEST_F(HostileGltf, RefusesCountsThatOverflow)
{
    const std::string count =
        R"("bufferViews":[{"buffer":0,"byteLength":12}],"buffers":[{"byteLength":12,)"
        R"("uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAA"}],"accessors":[{"bufferView":0,)"
        R"("componentType":5126,"type":"VEC3","count":)";
    expect_refused(document(count + "4611686018427387904}]"), "/accessors/0/count");
    expect_refused(document(count + "9007199254740992}]"), "/accessors/0");
    expect_refused(document(count + "1537228672809129302}]"), "/accessors/0/count");   // times 12 it wraps to 8
    expect_refused(document(count + R"(1,"byteOffset":9007199254740988}])"), "/accessors/0/byteOffset");
    expect_refused(document(count + "-1}]"), "/accessors/0/count");
    expect_refused(document(count + "1.5}]"), "/accessors/0/count");
    EXPECT_EQ(load(document(count + "1}]")).kind, Kind::loaded);
    expect_refused(
        document(R"("buffers":[{"byteLength":4294967296,"uri":"data:application/octet-stream;base64,AAAA"}])"),
        "/buffers/0/byteLength");
    // Zeros need no bytes in the file, but memory nevertheless.
    const std::string zeros = R"("accessors":[{"componentType":5126,"type":"VEC3","count":1000000000,"min":[0,0,0],)"
                              R"("max":[0,0,0]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
                              R"("nodes":[{"mesh":0}])";
    expect_refused(document(zeros), "/meshes/0/primitives/0/attributes/POSITION");
}

TEST_F(HostileGltf, LimitsMemoryOfASharedAccessor)
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

TEST_F(HostileGltf, RefusesBrokenGlbHeaders)
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

TEST_F(HostileGltf, RefusesFileNamesOutsideItsFolder)
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
    EXPECT_EQ(load(with("http://localhost:1/a.bin")).warnings, 1u);   // unused: only a warning
    expect_refused(with("data:application/octet-stream;base64,MTIz"), "/buffers/0/byteLength");
    expect_refused(with("data:application/octet-stream;base64,M!IzNDU2Nzg="), place);
    // Needed from the network: refused, not fetched.
    const Outcome remote =
        load(document(R"("buffers":[{"byteLength":36,"uri":"http://localhost:1/a.bin"}],)"
                      R"("bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,)"
                      R"("componentType":5126,"type":"VEC3","count":3,"min":[0,0,0],"max":[0,0,0]}],)"
                      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}])"));
    EXPECT_EQ(remote.kind, Kind::refused);
    EXPECT_NE(remote.what.find("remote"), std::string::npos) << remote.what;
}

TEST_F(HostileGltf, RefusesPipesAndFolders)
{
    ASSERT_EQ(mkfifo((folder_ / "fifo.gltf").c_str(), 0600), 0);
    std::filesystem::create_directory(folder_ / "folder.gltf");
    EXPECT_EQ(test::load_in_child(folder_ / "fifo.gltf").kind, Kind::refused);
    EXPECT_EQ(test::load_in_child(folder_ / "folder.gltf").kind, Kind::refused);
    EXPECT_EQ(test::load_in_child(folder_ / "missing.gltf").kind, Kind::refused);
}

TEST_F(HostileGltf, RefusesAHugeImageInAFewBytes)
{
    // A PNG of 60000 x 60000 whose pixels are a kilobyte of zeros.
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

TEST_F(HostileGltf, RefusesUnknownRequiredExtensions)
{
    for (const char* name : {"KHR_texture_basisu", "KHR_materials_diffuse_transmission", "VENDOR_something"}) {
        const Outcome outcome =
            load(document(fmt::format("\"extensionsUsed\":[\"{0}\"],\"extensionsRequired\":[\"{0}\"]", name)));
        EXPECT_EQ(outcome.kind, Kind::refused);
        EXPECT_EQ(outcome.place, "/extensionsRequired/0");
        EXPECT_NE(outcome.what.find(name), std::string::npos) << outcome.what;
        EXPECT_EQ(load(document(fmt::format("\"extensionsUsed\":[\"{}\"]", name))).warnings, 1u) << name;
    }
}

// A triangle with the attributes that many tests need: positions, texture coordinates, joints, weights.
std::string triangle_bytes()
{
    const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, weights[] = {1, 0, 0, 0};
    std::string bytes(reinterpret_cast<const char*>(corners), sizeof corners);
    bytes.append(24, '\0');
    for (int i = 0; i < 3; ++i) bytes.append(reinterpret_cast<const char*>(weights), sizeof weights);
    return bytes;
}

const char* const k_triangle =
    R"("buffers":[{"uri":"t.bin","byteLength":108}],"bufferViews":[{"buffer":0,"byteLength":36},)"
    R"({"buffer":0,"byteOffset":36,"byteLength":24},{"buffer":0,"byteOffset":60,"byteLength":48}],)"
    R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
    R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],)";

template <class Each>
std::string repeated(int count, Each each)
{
    std::string list;
    for (int i = 0; i < count; ++i) list += (i ? "," : "") + each(i);
    return list;
}

TEST_F(HostileGltf, ReadsAFileWithManyNamesOnce)
{
    constexpr int count = 60;
    std::ofstream(folder_ / "t.bin", std::ios::binary) << triangle_bytes();
    const auto png = test::png_bytes({4096, 4096, 8, PNG_COLOR_TYPE_GRAY}, {std::vector<std::uint8_t>(4096)});
    std::ofstream(folder_ / "p.png", std::ios::binary).write(reinterpret_cast<const char*>(png.data()), png.size());
    const auto name = [](int i) { return (i % 2 ? "./" : "") + std::string(i % 3 ? "p" : "%70") + ".png"; };
    const std::string images =
        "\"images\":[" + repeated(count, [&](int i) { return "{\"uri\":\"" + name(i) + "\"}"; }) + "],\"textures\":[" +
        repeated(count, [](int i) { return fmt::format("{{\"source\":{}}}", i); }) + "]";
    const auto material = [](int i) {
        return fmt::format(R"({{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":{}}}}}}})", i);
    };
    const auto primitive = [](int i) {
        return fmt::format(R"({{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":{}}})", i);
    };
    Outcome outcome =
        load(document(k_triangle + images + ",\"materials\":[" + repeated(count, material) +
                      "],\"meshes\":[{\"primitives\":[" + repeated(count, primitive) + "]}],\"nodes\":[{\"mesh\":0}]"));
    EXPECT_EQ(outcome.kind, Kind::loaded) << outcome.what << outcome.signal;

    // Buffers.
    std::ofstream(folder_ / "b.bin", std::ios::binary) << std::string(16 << 20, '\0');
    outcome = load(document(
        "\"buffers\":[" +
        repeated(count,
                 [](int i) { return fmt::format(R"({{"uri":"{}b.bin","byteLength":16777216}})", i % 2 ? "./" : ""); }) +
        "]"));
    EXPECT_EQ(outcome.kind, Kind::loaded) << outcome.what << outcome.signal;

    // Unused images, in a file that mostly contains other data.
    std::ofstream(folder_ / "p.png", std::ios::binary | std::ios::app) << std::string(16 << 20, '\0');
    outcome =
        load(document("\"images\":[" + repeated(20000, [](int) { return std::string(R"({"uri":"p.png"})"); }) + "]"));
    EXPECT_EQ(outcome.kind, Kind::loaded) << outcome.what << outcome.signal;
}

TEST_F(HostileGltf, LimitsTrianglesOfInstances)
{
    // Some 30 bytes of the file per instance, each with a hundred thousand triangles.
    constexpr int count = 20000, triangles = 100'000;
    std::ofstream(folder_ / "t.bin", std::ios::binary) << triangle_bytes() + std::string(12 * triangles, '\0');
    const auto nodes = repeated(count, [](int i) { return fmt::format(R"({{"mesh":0,"translation":[{},0,0]}})", i); });
    const Outcome outcome =
        load(document(R"("buffers":[{"uri":"t.bin","byteLength":1200108}],"bufferViews":[{"buffer":0,"byteLength":36},)"
                      R"({"buffer":0,"byteOffset":108,"byteLength":1200000}],"accessors":[)"
                      R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
                      R"({"bufferView":1,"componentType":5125,"count":300000,"type":"SCALAR"}],)"
                      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"nodes":[)" +
                      nodes + "]"));
    EXPECT_EQ(outcome.kind, Kind::refused) << outcome.signal;
    EXPECT_EQ(outcome.place, "/nodes/1343") << outcome.what;
}

TEST_F(HostileGltf, LimitsSetsOfJoints)
{
    // Each vertex depends on all of 32,000 joints; the sets overlap in few bytes.
    constexpr int vertices = 400, sets = 8000, joints = 4 * (vertices + sets);
    std::string bytes(12 * vertices, '\0');
    for (int j = 0; j < joints; ++j) bytes += {static_cast<char>(j & 0xff), static_cast<char>(j >> 8)};
    const float weights[4] = {1.0f / (4 * sets), 1.0f / (4 * sets), 1.0f / (4 * sets), 1.0f / (4 * sets)};
    for (int v = 0; v < vertices; ++v) bytes.append(reinterpret_cast<const char*>(weights), sizeof weights);
    std::ofstream(folder_ / "t.bin", std::ios::binary) << bytes;
    const auto accessor = [](int s) {
        return fmt::format(R"({{"bufferView":1,"byteOffset":{},"componentType":5123,"count":400,"type":"VEC4"}})",
                           8 * s);
    };
    const auto attribute = [](int s) { return fmt::format(R"("JOINTS_{0}":{1},"WEIGHTS_{0}":1)", s, s + 2); };
    const auto number = [](int i) { return std::to_string(i + 2); };
    const Outcome outcome = load(document(
        fmt::format(R"("buffers":[{{"uri":"t.bin","byteLength":{0}}}],"bufferViews":[{{"buffer":0,"byteLength":4800}},)"
                    R"({{"buffer":0,"byteOffset":4800,"byteLength":{1},"byteStride":8}},)"
                    R"({{"buffer":0,"byteOffset":{2},"byteLength":6400}}],)",
                    bytes.size(), 2 * joints, 4800 + 2 * joints) +
        R"("accessors":[{"bufferView":0,"componentType":5126,"count":400,"type":"VEC3","min":[0,0,0],"max":[0,0,0]},)"
        R"({"bufferView":2,"componentType":5126,"count":400,"type":"VEC4"},)" +
        repeated(sets, accessor) + R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0,)" +
        repeated(sets, attribute) + R"(}}]}],"nodes":[{"mesh":0,"skin":0},{"children":[)" + repeated(joints, number) +
        "]}," + repeated(joints, [](int) { return std::string("{}"); }) + R"(],"skins":[{"joints":[)" +
        repeated(joints, number) + "]}]"));
    EXPECT_EQ(outcome.kind, Kind::loaded) << outcome.what << outcome.signal;
}

TEST_F(HostileGltf, ShortensLongNamesInMessages)
{
    const std::string name(1 << 20, 'z');
    const std::string text = document("\"extensions\":{\"" + name + "\":{}}");
    const Outcome outcome = load(text, "scene.gltf", true);
    EXPECT_EQ(outcome.kind, Kind::refused);
    EXPECT_LT(outcome.what.size(), 500u);
    const scene::Scene scene = io::load_gltf(folder_ / "scene.gltf");
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_LT(scene.warnings[0].size(), 500u);
}

// Changes each byte of a small scene: the file loads or is refused, without a crash.
// Both modes take turns.
TEST_F(HostileGltf, SurvivesChangedBytes)
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
        const Outcome outcome = load(broken, "a.glb", round % 2 == 1);
        ASSERT_NE(outcome.kind, Kind::died) << "round " << round << " signal " << outcome.signal;
        ASSERT_NE(outcome.kind, Kind::other_error) << outcome.what;
    }
}

}   // namespace
}   // namespace gnomon
