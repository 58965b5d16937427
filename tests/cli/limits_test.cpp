// SPDX-License-Identifier: Apache-2.0
// Files that ask for much: loading and building take about n log n steps, and clips of any length are asked about.
#include <fmt/format.h>
#include <sys/resource.h>

#include <array>

#include "image_bytes.h"
#include "run_program.h"

namespace gnomon::test {
namespace {

namespace fs = std::filesystem;

// A glTF file of triangles; `nodes` is the JSON of its nodes, all of which may show mesh 0. The first one moves.
fs::path gltf_of(const ScratchFolder& folder, const std::string& nodes, const std::string& roots, float seconds = 1)
{
    const std::array<float, 26> numbers{-1, -1, 0,  1, -1, 0, 1,       1, 0, -1, -1, 0, 1,
                                        1,  0,  -1, 1, 0,  0, seconds, 0, 0, 0,  1,  0, 0};
    std::ofstream(folder / "numbers.bin", std::ios::binary)
        .write(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
    std::ofstream(folder / "scene.gltf") << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[)" << roots
                                         << R"(]}],"nodes":[)" << nodes << R"(],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "buffers":[{"uri":"numbers.bin","byteLength":104}],
        "bufferViews":[{"buffer":0,"byteLength":72},{"buffer":0,"byteOffset":72,"byteLength":8},
                       {"buffer":0,"byteOffset":80,"byteLength":24}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":6,"type":"VEC3","min":[-1,-1,0],"max":[1,1,0]},
                     {"bufferView":1,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[)"
                                         << seconds << R"(]},
                     {"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"}],
        "animations":[{"channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],
                       "samplers":[{"input":1,"output":2}]}]})";
    return folder / "scene.gltf";
}

// Processor time of all programs that have ended.
double children_seconds()
{
    struct rusage usage {};
    ::getrusage(RUSAGE_CHILDREN, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// The limit of processor time is far above what is measured, and far below what a quadratic number of steps takes.
Outcome run_in(int seconds, const std::vector<std::string>& arguments)
{
    const double before = children_seconds();
    const Outcome outcome = run(arguments);
    const double took = children_seconds() - before;
    std::printf("%s: %.2f s\n", arguments.front().c_str(), took);
    EXPECT_LT(took, seconds * k_patience);
    return outcome;
}

TEST(Limits, AChainOfNodesTakesItsLength)
{
    constexpr int k_nodes = 100'000;
    const ScratchFolder folder;
    std::string nodes;
    for (int i = 0; i < k_nodes; ++i)
        nodes += i + 1 < k_nodes ? fmt::format(R"({{"mesh":0,"translation":[0,0,0.0001],"children":[{}]}},)", i + 1)
                                 : R"({"mesh":0})";
    const fs::path scene = gltf_of(folder, nodes, "0");
    const Outcome outcome = run_in(6, {"render", scene, "-o", folder / "a.png", "--size", "8x8", "--frame", "2"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST(Limits, CoincidentSurfacesAreJudgedOnce)
{
    constexpr int k_nodes = 16'000;
    const ScratchFolder folder;
    std::string nodes, roots;
    for (int i = 0; i < k_nodes; ++i) {
        nodes += i + 1 < k_nodes ? R"({"mesh":0},)" : R"({"mesh":0})";
        roots += fmt::format("{}{}", i, i + 1 < k_nodes ? "," : "");
    }
    const fs::path scene = gltf_of(folder, nodes, roots);
    const Outcome outcome = run_in(2, {"info", scene});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST(Limits, AskWhichFramesOfALongClip)
{
    const ScratchFolder folder;
    const fs::path scene = gltf_of(folder, R"({"mesh":0})", "0", 10'000);
    const std::vector<std::string> clip{"render", scene, "--size", "8x8", "--quiet", "-o", folder / "{frame}.png"};
    expect_failure(run(clip), 2, "--frames");
    EXPECT_EQ(names_in(folder.path()).size(), 2u);
    std::vector<std::string> part = clip;
    part.insert(part.end(), {"--frames", "150000-150001"});
    const Outcome outcome = run(part);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(names_in(folder.path()).size(), 4u);
}

// Triangles with a grey PNG each, as a glTF file or as an OBJ file. Rows repeat, so that large images take little time
// to write.
fs::path textured_scene(const ScratchFolder& folder, int images, int side, bool obj = false)
{
    test::PngKind kind{.width = side, .height = side, .depth = 8, .type = PNG_COLOR_TYPE_GRAY};
    std::vector<std::uint8_t> row(static_cast<std::size_t>(side));
    std::string uris, textures, materials, meshes, nodes, roots, mtl,
        faces =
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n"
            "vt 1 0\nvt 0 1\n";
    for (int i = 0; i < images; ++i) {
        for (std::size_t k = 0; k < row.size(); ++k)
            row[k] = static_cast<std::uint8_t>(k * 7 + static_cast<std::size_t>(i));
        const std::vector<std::uint8_t> png = test::png_bytes(kind, {row});
        std::ofstream(folder / fmt::format("{}.png", i), std::ios::binary)
            .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
        const char* const comma = i > 0 ? "," : "";
        uris += fmt::format(R"({}{{"uri":"{}.png"}})", comma, i);
        textures += fmt::format(R"({}{{"source":{}}})", comma, i);
        materials += fmt::format(R"({}{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":{}}}}}}})", comma, i);
        meshes += fmt::format(R"({}{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":{}}}]}})",
                              comma, i);
        nodes += fmt::format(R"({}{{"mesh":{}}})", comma, i);
        roots += fmt::format("{}{}", comma, i);
        mtl += fmt::format("newmtl m{0}\nmap_Kd {0}.png\n", i);
        faces += fmt::format("usemtl m{}\nf 1/1 2/2 3/3\n", i);
    }
    std::ofstream(folder / "scene.mtl") << mtl;
    std::ofstream(folder / "scene.obj") << "mtllib scene.mtl\n" << faces;
    constexpr std::array<float, 15> k_numbers{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1};
    std::ofstream(folder / "numbers.bin", std::ios::binary)
        .write(reinterpret_cast<const char*>(k_numbers.data()), sizeof k_numbers);
    std::ofstream(folder / "scene.gltf") << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[)" << roots
                                         << R"(]}],"nodes":[)" << nodes << R"(],"meshes":[)" << meshes
                                         << R"(],"materials":[)" << materials << R"(],"textures":[)" << textures
                                         << R"(],"images":[)" << uris
                                         << R"(],"buffers":[{"uri":"numbers.bin","byteLength":60}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
                     {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}]})";
    return folder / (obj ? "scene.obj" : "scene.gltf");
}

// Runs the program in a process of its own, and measures the most memory that it takes, in megabytes.
std::pair<Outcome, double> run_and_measure(const std::vector<std::string>& arguments)
{
    RunningProgram program(arguments);
    struct rusage usage {};
    Outcome outcome = program.wait(&usage);
    return {std::move(outcome), static_cast<double>(usage.ru_maxrss) / 1024};
}

TEST(Limits, TexturesBeyondTheMemoryAreHalved)
{
    const ScratchFolder folder;
    const fs::path scene = textured_scene(folder, 6, 400);   // .85 MB each, with their coarser levels
    const Outcome whole = run({"info", scene}), halved = run({"info", scene, "--memory", "2"});
    EXPECT_EQ(whole.code, 0) << whole.err;
    EXPECT_EQ(whole.err.find("halved"), std::string::npos) << whole.err;
    EXPECT_EQ(halved.code, 0) << halved.err;
    EXPECT_NE(halved.err.find("textures were halved"), std::string::npos) << halved.err;
}

TEST(Limits, LoadingNeverTakesMoreThanTheMemory)
{
    if (k_sanitized) GTEST_SKIP() << "the sanitizer needs memory itself";
    constexpr int k_images = 8, k_side = 2000;   // 21 MB each as a texture
    for (const bool obj : {false, true}) {
        const ScratchFolder folder;
        const fs::path scene = textured_scene(folder, k_images, k_side, obj);
        const double none = run_and_measure({"info", "builtin:cornell"}).second;
        const auto [whole, whole_took] = run_and_measure({"info", scene});
        EXPECT_EQ(whole.code, 0) << whole.err;
        EXPECT_EQ(whole.err.find("halved"), std::string::npos) << whole.err;
        EXPECT_GT(whole_took, none + 8 * 20) << "the measurement misses memory";
        constexpr int k_limit = 80;
        const auto [halved, took] = run_and_measure({"info", scene, "--memory", fmt::format("{}", k_limit)});
        std::printf("%s: %.1f MB, with a limit of %d MB %.1f MB, beside %.1f MB of the program\n",
                    scene.extension().c_str(), whole_took - none, k_limit, took - none, none);
        EXPECT_EQ(halved.code, 0) << halved.err;
        EXPECT_NE(halved.err.find("halved"), std::string::npos) << halved.err;
        constexpr double k_allocator = 4;   // what malloc holds back
        EXPECT_LT(took, none + k_limit + k_allocator);
        // An image that cannot be decoded within the limit is refused, before it takes memory.
        const auto [refused, refused_took] = run_and_measure({"info", scene, "--memory", "3"});
        expect_failure(refused, 3, "--memory");
        EXPECT_LT(refused_took, none + 3);
    }
}

TEST(LimitsFull, EightImagesOf8000x8000StayWithinTheMemory)
{
    const ScratchFolder folder;
    const fs::path scene = textured_scene(folder, 8, 8000);   // 341 MB each as a texture
    for (const auto& arguments :
         {std::vector<std::string>{"info", scene}, {"render", scene, "-o", folder / "a.png", "--size", "64x64"}}) {
        const auto [outcome, took] = run_and_measure(arguments);
        std::printf("%s: %.0f MB\n", arguments.front().c_str(), took);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_NE(outcome.err.find("3 textures were halved"), std::string::npos) << outcome.err;
        EXPECT_LT(took, 2048);
    }
}

// Nodes that share 100,000 keys, which take 3.2 MB for each of them as they are kept.
fs::path scene_of_keys(const ScratchFolder& folder, int count)
{
    constexpr int k_keys = 100'000;
    std::string roots, nodes, channels;
    for (int i = 0; i < count; ++i) {
        const char* const comma = i > 0 ? "," : "";
        roots += fmt::format("{}{}", comma, i);
        nodes += fmt::format(R"({}{{"mesh":0}})", comma);
        channels += fmt::format(R"({}{{"sampler":0,"target":{{"node":{},"path":"translation"}}}})", comma, i);
    }
    std::vector<float> numbers;
    for (int k = 0; k < k_keys; ++k) numbers.push_back(static_cast<float>(k));
    numbers.resize(4 * k_keys);
    for (const float corner : {0, 0, 0, 1, 0, 0, 0, 1, 0}) numbers.push_back(corner);
    std::ofstream(folder / "numbers.bin", std::ios::binary)
        .write(reinterpret_cast<const char*>(numbers.data()), static_cast<std::streamsize>(4 * numbers.size()));
    std::ofstream(folder / "scene.gltf") << fmt::format(
        R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{6}]}}],"nodes":[{7}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "buffers":[{{"uri":"numbers.bin","byteLength":{0}}}],
        "bufferViews":[{{"buffer":0,"byteOffset":{1},"byteLength":36}},{{"buffer":0,"byteLength":{2}}},
                       {{"buffer":0,"byteOffset":{2},"byteLength":{3}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
                     {{"bufferView":1,"componentType":5126,"count":{4},"type":"SCALAR","min":[0],"max":[{5}]}},
                     {{"bufferView":2,"componentType":5126,"count":{4},"type":"VEC3"}}],
        "animations":[{{"channels":[{8}],"samplers":[{{"input":1,"output":2}}]}}]}})",
        4 * numbers.size(), 16 * k_keys, 4 * k_keys, 12 * k_keys, k_keys, k_keys - 1, roots, nodes, channels);
    return folder / "scene.gltf";
}

TEST(Limits, KeysBeyondTheMemoryAreRefused)
{
    const ScratchFolder folder;
    const fs::path scene = scene_of_keys(folder, 1);
    EXPECT_EQ(run({"info", scene}).code, 0);
    expect_failure(run({"info", scene, "--memory", "2"}), 3, "--memory");
}

TEST(Limits, ManyNodesWithTheSameKeysAreRefusedBeforeTheyTakeMemory)
{
    if (k_sanitized) GTEST_SKIP() << "the sanitizer needs memory itself";
    const ScratchFolder folder;
    const double none = run_and_measure({"info", "builtin:cornell"}).second;
    const auto [outcome, took] = run_and_measure({"info", scene_of_keys(folder, 2000)});   // 6.4 GB of them
    expect_failure(outcome, 3, "far more keys than the size of the file allows");
    EXPECT_LT(took, none + 64);
}

TEST(Limits, GroupsAndMaterialsBeyondTheMemoryAreRefused)
{
    constexpr int k_names = 2000;   // 4.8 MB of groups, 3.6 MB of materials as they are kept
    for (const std::string kind : {"g", "usemtl"}) {
        const ScratchFolder folder;
        std::ofstream obj(folder / "scene.obj"), mtl(folder / "scene.mtl");
        obj << "mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
        for (int i = 0; i < k_names; ++i) {
            obj << kind << " n" << i << "\nf 1 2 3\n";
            mtl << "newmtl n" << i << "\nKd 1 0 0\n";
        }
        obj.close(), mtl.close();
        EXPECT_EQ(run({"info", folder / "scene.obj"}).code, 0) << kind;
        expect_failure(run({"info", folder / "scene.obj", "--memory", "3"}), 3,
                       kind == "g" ? "its groups would take more memory" : "its materials would take more memory");
    }
}

TEST(Limits, TimePasses)
{
    const ScratchFolder folder;
    const auto start = std::chrono::steady_clock::now();
    expect_failure(
        run({"render", "builtin:kinetic", "--quiet", "-o", folder / "a.png", "--samples", "64", "--time-limit", "0.5"}),
        130, "the time limit has passed");
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    EXPECT_LT(took, 10 * k_patience);
    EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(Limits, APathOnADriveIsAbsoluteAndNotRemote)
{
    const ScratchFolder folder;
    for (const auto& [uri, problem] : {std::pair("C:/t.png", "does not exist"), {"https://a/t.png", "is a remote"}}) {
        std::ofstream(folder / "scene.gltf") << fmt::format(
            R"({{"asset":{{"version":"2.0"}},"images":[{{"uri":"{}"}}],"textures":[{{"source":0}}],"materials":[
            {{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}]}})",
            uri);
        const Outcome outcome = run({"info", folder / "scene.gltf"});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_NE(outcome.err.find(problem), std::string::npos) << outcome.err;
    }
}

TEST(Limits, NamesInMessagesAreOneLine)
{
    const ScratchFolder folder;
    expect_failure(run({"render", "builtin:cornell", "--quiet", "-o", folder / "\x1b[2J\n\x9b/a.png"}), 4,
                   "?[2J?"
                   "?/a.png");
    expect_failure(run({"render", "builtin:cornell", "--quiet", "-o", "\x1b[2J\n\x9b.\n"}), 2, "?[2J??.?");
    const Outcome written = run({"render", "builtin:cornell", "--size", "8x8", "-o", folder / "\x1b[2J\n.png"});
    EXPECT_EQ(written.code, 0) << written.err;
    EXPECT_NE(written.out.find("?[2J?.png (1 frame"), std::string::npos) << written.out;
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"\x1b[2J\n.png"});
}

}   // namespace
}   // namespace gnomon::test
