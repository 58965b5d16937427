// SPDX-License-Identifier: Apache-2.0
// AFF files that are wrong by accident or on purpose: an error with file, line and column; never a crash, a hang, or
// more memory than the file justifies.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <chrono>
#include <ctime>
#include <vector>

#include "aff_files.h"
#include "base/random.h"
#include "sanitized.h"

namespace gnomon::io {
namespace {

using test::AffFolder;
using test::k_material;
using test::k_mesh;

// "file name:line:column: problem" of the error, or "accepted".
std::string error_of(const AffFolder& folder, const std::string& text)
{
    try {
        folder.load(text);
        return "accepted";
    } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        return std::filesystem::path(error.file()).filename().string() + ":" + error.place() + ": " + error.problem();
    }
}

void expect_error(const AffFolder& folder, const std::string& text, const std::string& start)
{
    EXPECT_TRUE(error_of(folder, text).starts_with(start))
        << text.substr(0, 200) << "\n  gives " << error_of(folder, text) << "\n  expected " << start;
}

double peak_megabytes()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

struct Bad {
    std::string text, place;   // place: "line:column"
};

// LONG: a table of texts and the places of their errors.
TEST(HostileAff, ErrorsNameLineAndColumn)
{
    const AffFolder folder;
    folder.texture("t.ppm");
    folder.write(folder.textures() / "bad.ppm", "P6\n9999 9999\n255\n12345");
    const std::string fm = k_material;   // one line
    const std::string track4 = " 0 0 0 0 0 0 0  1 0 0 0 0 0 0  2 0 0 0 0 0 0  3 0 0 0 0 0 0 ";
    const std::string turn4 = " 0 0 0 1 9 0 0 0  1 0 0 1 9 0 0 0  2 0 0 1 9 0 0 0  3 0 0 1 9 0 0 0 ";
    for (const auto& [text, place] : std::vector<Bad>{
             // Words and numbers.
             {"b 1 1 1\nfoo", "2:1"},
             {"b 1 1 1\r\rB 1 1 1", "3:1"},
             {"b 1 1 1\r\n\r\n  M", "3:3"},
             {"triangles 1", "1:1"},
             {"{ }", "1:1"},
             {"b 1 x 1", "1:5"},
             {"b 1 1e 1", "1:5"},
             {"b 1 1.5.5 1", "1:5"},
             {"b 1 nan 1", "1:5"},
             {"b 1 -inf 1", "1:5"},
             {"b 1 1e999 1", "1:5"},
             {"b 1 1e300 1", "1:5"},
             {"b 1 0x10 1", "1:5"},
             {"b 1 +-1 1", "1:5"},
             {"b 1 1", "1:6"},
             {"b 1 { 1", "1:5"},
             {"b", "1:2"},
             // Camera, lights, time.
             {"v from 0 0 0 up 0 1 0", "1:14"},
             {"v from 0 0 0 at 0 0 0 up 0 1 0 angle 40 hither 1 resolution 8 8", "1:14"},
             {"v from 0 0 0 at 0 0 1 up 0 1 0 angle 180 hither 1 resolution 8 8", "1:38"},
             {"v from 0 0 0 at 0 0 1 up 0 1 0 angle 0 hither 1 resolution 8 8", "1:38"},
             {"v from 0 0 0 at 0 0 1 up 0 1 0 angle 40 hither 1 resolution 0 8", "1:61"},
             {"v from 0 0 0 at 0 0 1 up 0 1 0 angle 40 hither 1 resolution 8 1000000", "1:63"},
             {"v from 0 0 0 at 0 0 1 up 0 1 0 angle 40 hither 1 resolution 16000 15000", "1:61"},
             {"v from 0 0 0 at 0 0 1 up 0 1 0 angle 40 hither 1 resolution 8.5 8", "1:61"},
             {"l 1 2", "1:6"},
             {"l 1 2 3 4 b 0 0 0", "1:11"},
             {"la { 1 2 3", "1:4"},
             {"a 0 1 0", "1:7"},
             {"a 0 1 -5", "1:7"},
             {"a 0 5e-324 2", "1:5"},
             {"a 0 1 99999999999", "1:7"},
             {"a 0 1 99999999999999999999999", "1:7"},
             {"a 1 0 5", "1:5"},
             {"a 1 1 5", "1:5"},
             // Materials.
             {"fm 1 1 1 1 1 1 1 1 1 1 0", "1:25"},
             {"fm 1 1 1 1 1 1 1 1 1 1 -1 1", "1:24"},
             {"f 1 1 1 1 1 1 0 x", "1:17"},
             // Shapes.
             {fm + "s 0 0 0", "2:8"},
             {fm + "s 0 0 0 0", "2:9"},
             {fm + "c 0 0 0 1 0 0 0 1", "2:3"},
             {fm + "c 0 0 0 0 0 0 1 0", "2:3"},
             {fm + "c 0 0 0 -1 0 0 1 1", "2:3"},
             {fm + "p 2 0 0 0 1 0 0", "2:3"},
             {fm + "p 3 0 0 0 1 0 0 0 1", "2:3"},
             {fm + "p 4000000000 0 0 0", "2:3"},
             {fm + "p -3 0 0 0", "2:3"},
             {fm + "pp 3 0 0 0 1 0 0 0 0 1", "2:4"},
             {fm + "tt t.ppm 0 0 0 0 0 1 1 1", "2:25"},
             {fm + "tt no.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1", "2:4"},
             {fm + "tt ../t.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1", "2:4"},
             {fm + "tt T.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1", "2:4"},
             {fm + "ttp t.ppm { }", "2:11"},
             {fm + "tpa 0", "2:5"},
             {fm + "tpa 9 0", "2:5"},
             {fm + "tpa 2 1 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1 0 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1", "2:45"},
             // Meshes.
             {fm + "m normals 1 0 0 0", "2:3"},
             {fm + "m vertices 3 0 0 0 1 0 0 0 1 0 normals 1 0 0 1 triangles 1 0 1 2 0 0 1", "2:70"},
             {fm + "m vertices 3 0 0 0 1 0 0 0 1 0 triangles 1 0 1 3", "2:48"},
             {fm + "m vertices 3 0 0 0 1 0 0 0 1 0 triangles 1 0 1 -1", "2:48"},
             {fm + "m vertices 3 0 0 0 1 0 0 0 1 0 triangles 1 0 1 1.0", "2:48"},
             {fm + "m vertices 3 0 0 0 1 0 0 0 1 0 triangles 1 0 1", "2:42"},
             {fm + "m vertices 3 0 0 0 1 0 0 0 1 0 triangles 2 0 1 2", "2:42"},
             {fm + "m vertices 3 0 0 0 1 0 0 triangles 1 0 1 2", "2:26"},
             {fm + "m vertices 2 0 0 0 1 0 0 0 1 0 triangles 1 0 1 2", "2:26"},
             {fm + "m vertices 3 0 0 0 1 0 0 0 1 0 texturecoords 1 no.ppm 0 0 triangles 1 0 1 2 0 0 0", "2:48"},
             {fm + "m vertices 3 0 0 0 1 0 0 0 1 0 texturecoords 1 t.ppm 0 0 normals 1 0 0 1 triangles 0", "2:58"},
             {fm + "m vertices 1000000000000 0 0 0", "2:12"},
             {fm + "m vertices 18446744073709551617 0 0 0", "2:12"},
             // Transforms.
             {"xs 1 1 1 0 0 0 90 0 0 0 { }", "1:10"},
             {"xs 1 1 1 0 1 0 90 0 0 { }", "1:23"},
             {"xs 1 1 1 0 1 0 90 0 0 0 b 1 1 1", "1:25"},
             {"x { }", "1:3"},
             {"x a b 1 1 1", "1:5"},
             {"x a {\n x b {\n }\n", "1:5"},
             {"x a {}}", "1:7"},
             {"}", "1:1"},
             // Tracks.
             {"k a transl", "1:5"},
             {"k a {", "1:5"},
             {"k a { move 4 }", "1:7"},
             {"k a { transl 3 0 0 0 0 0 0 0 1 0 0 0 0 0 0 2 0 0 0 0 0 0 }", "1:14"},
             {"k a { transl 4000000 0 }", "1:14"},
             {fmt::format("k a {{ transl 4{0}transl 4{0}}}", track4), "1:75"},
             {"k a { rot 4 0 0 0 0 90 0 0 0 1 0 0 1 9 0 0 0 2 0 0 1 9 0 0 0 3 0 0 1 9 0 0 0}", "1:15"},
             {"k a { visibility 1 0 2 }", "1:22"},
             {"k a { visibility 2 5 1 4 1 }", "1:24"},
             {"k a { visibility 0 }", "1:18"},
             {"k a { visibility 1 0 1 visibility 1 0 1 }", "1:24"},
             // Includes.
             {"i 0 no.aff", "1:5"},
             {"i x no.aff", "1:3"},
             {"i 0 main.aff", "1:5"},
             {"i 0 /etc/passwd", "1:5"},
             {"i 0 ../TextureFiles/t.ppm", "1:5"},
             {"i 0 ..", "1:5"},
             {"i 0 .", "1:5"},
             {"i 0 a\\b", "1:5"},
             {"i 0", "1:4"},
             {"i 0 {", "1:5"},
             {"d x", "1:3"},
         })
        expect_error(folder, text, std::string("main.aff:") + place + ": ");
    // The tokens before these are valid.
    EXPECT_EQ(error_of(folder, std::string("k a { transl 4") + track4 + "rot 4" + turn4 + "scale 4" + track4 +
                                   "visibility 1 0 1 }"),
              "accepted");
    // A broken image is an error in its own file.
    expect_error(folder, fm + "tt bad.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1", "bad.ppm:");
}

TEST(HostileAff, ErrorsInsideIncludesNameTheIncludedFile)
{
    const AffFolder folder;
    folder.include("part.aff", "# fine\n\n  b 1 1 oops");
    expect_error(folder, "i 0 part.aff", "part.aff:3:9: ");
    // Braces must balance in each file.
    folder.include("open.aff", "x a {");
    expect_error(folder, "i 0 open.aff }", "open.aff:1:5: ");
    folder.include("close.aff", "\n }");
    expect_error(folder, "x a { i 0 close.aff", "close.aff:2:2: ");
}

TEST(HostileAff, MessagesShowNoControlCharacters)
{
    const AffFolder folder;
    for (const std::string& junk : {std::string("\x01\x02\x1b[31m"), std::string("\0\0\0", 3),
                                    std::string("\xff\xfe\x80"), std::string(1 << 20, 'z')}) {
        const std::string error = error_of(folder, "b 1 1 1\n" + junk);
        EXPECT_TRUE(error.starts_with("main.aff:2:1: ")) << error;
        EXPECT_LT(error.size(), 200u);
        for (const char c : error) EXPECT_TRUE(c >= 0x20 && c < 0x7f) << int(c);
    }
}

TEST(HostileAff, WarningsShortenNamesAndRemoveControlCharacters)
{
    const AffFolder folder;
    // Latin-1 has control characters above 127 as well.
    const scene::Scene named = folder.load(
        "x a\x9b"
        "31m { }\nx " +
        std::string(1 << 20, 'z') + " { }");
    ASSERT_FALSE(named.warnings.empty());
    for (const std::string& warning : named.warnings) {
        EXPECT_EQ(warning.find("\xc2\x9b"), std::string::npos) << warning;
        EXPECT_LT(warning.size(), 1000u);
    }
    // Each name is looked up among the earlier ones.
    std::string many;
    for (int i = 0; i < 200'000; ++i) many += "x " + std::to_string(i) + " { }\n";
    const std::clock_t start = std::clock();
    EXPECT_EQ(folder.load(many).warnings.size(), 1u);
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 8.0 * test::k_patience);
}

TEST(HostileAff, RefusesCyclesAndDeepNesting)
{
    const AffFolder folder;
    folder.include("a.aff", "\ni 0 b.aff");
    folder.include("b.aff", "\n\ni 0 a.aff");
    expect_error(folder, "i 0 a.aff", "b.aff:3:5: ");

    for (int i = 0; i < 200; ++i)
        folder.include(std::string("n") + std::to_string(i) + ".aff",
                       std::string("i 0 n") + std::to_string(i + 1) + ".aff");
    folder.include("n200.aff", "");
    EXPECT_NE(error_of(folder, "i 0 n0.aff").find("deep"), std::string::npos);

    std::string deep;
    for (int i = 0; i < 100'000; ++i) deep += "x a{";
    EXPECT_TRUE(error_of(folder, deep).starts_with("main.aff:1:")) << error_of(folder, deep);
    EXPECT_TRUE(error_of(folder, deep + std::string(100'000, '}')).starts_with("main.aff:1:"));
    // Depths that real scenes need are accepted.
    std::string good = k_material;
    for (int i = 0; i < 200; ++i) good += "x a{";
    EXPECT_EQ(error_of(folder, good + k_mesh + std::string(200, '}')), "accepted");
    // Scales whose product overflows.
    std::string large = k_material;
    for (int i = 0; i < 50; ++i) large += "xs 1e9 1e9 1e9 0 0 0 0 0 0 0 {";
    EXPECT_TRUE(error_of(folder, large + k_mesh + std::string(50, '}')).starts_with("main.aff:2:"));
}

TEST(HostileAff, LimitsNestedIncludes)
{
    // Ten levels of ten includes: 10^10 without a cycle.
    const AffFolder folder;
    for (int level = 0; level < 10; ++level) {
        std::string text;
        for (int i = 0; i < 10; ++i) text += std::string("i 0 level") + std::to_string(level + 1) + ".aff\n";
        folder.include(std::string("level") + std::to_string(level) + ".aff", text);
    }
    folder.include("level10.aff", k_mesh);
    const auto start = std::chrono::steady_clock::now();
    EXPECT_NE(error_of(folder, k_material + "i 0 level0.aff"), "accepted");
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    EXPECT_LT(seconds.count(), 30 * test::k_patience);
}

TEST(HostileAff, LimitsTrianglesOfShapes)
{
    // A few bytes make many triangles: cones are counted, spheres share a mesh.
    const AffFolder folder;
    const double before = peak_megabytes();
    std::string cones = k_material, spheres = k_material;
    for (int i = 0; i < 200'000; ++i) cones += "c 0 0 0 1 0 0 1 1\n", spheres += "s 0 0 0 1\n";
    EXPECT_TRUE(error_of(folder, cones).starts_with("main.aff:")) << error_of(folder, cones);
    error_of(folder, spheres);
    EXPECT_LT(peak_megabytes() - before, 1500);
}

TEST(HostileAff, CountsAreCheckedAgainstTheFile)
{
    const AffFolder folder;
    const double before = peak_megabytes();
    for (const std::string count :
         {"100000000", "4294967295", "4294967296", "4294967297", "9223372036854775807", "18446744073709551615"}) {
        for (const std::string& text :
             {std::string("m vertices ") + count + " 0 0 0", std::string("m vertices 1 0 0 0 normals ") + count,
              std::string("m vertices 1 0 0 0 triangles ") + count + " 0",
              std::string("m vertices 1 0 0 0 texturecoords ") + count + " t.ppm 0",
              std::string("p ") + count + " 0 0 0", std::string("pp ") + count + " 0", std::string("tpa ") + count,
              std::string("k a { transl ") + count, std::string("k a { rot ") + count,
              std::string("k a { scale ") + count, std::string("k a { visibility ") + count})
            EXPECT_TRUE(error_of(folder, k_material + text).starts_with("main.aff:2:")) << text;
    }
    EXPECT_LT(peak_megabytes() - before, 100);
}

TEST(HostileAff, OpensOnlyRegularFilesInsideItsFolder)
{
    const AffFolder folder;
    const test::ScratchFolder outside;
    folder.write(outside / "secret.aff", "b 1 1 1");
    folder.write(outside / "secret.ppm", "P6 1 1 255 abc");
    ASSERT_EQ(mkfifo((folder.aff() / "fifo.aff").c_str(), 0600), 0);
    ASSERT_EQ(mkfifo((folder.textures() / "fifo.ppm").c_str(), 0600), 0);
    std::filesystem::create_directory(folder.aff() / "folder.aff");
    std::filesystem::create_symlink(outside / "secret.aff", folder.aff() / "out.aff");
    std::filesystem::create_symlink(outside / "secret.ppm", folder.textures() / "out.ppm");
    std::filesystem::create_symlink("/dev/zero", folder.aff() / "zero.aff");
    std::filesystem::create_symlink("loop.aff", folder.aff() / "loop.aff");
    for (const std::string name : {"fifo.aff", "folder.aff", "out.aff", "zero.aff", "loop.aff"})
        expect_error(folder, std::string("i 0 ") + name, "main.aff:1:5: ");
    for (const std::string name : {"fifo.ppm", "out.ppm"})
        expect_error(folder, fmt::format("{}tt {} 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1", k_material, name), "main.aff:2:4: ");
    // A link that stays inside is accepted.
    folder.include("real.aff", "b 1 1 1");
    std::filesystem::create_symlink("real.aff", folder.aff() / "link.aff");
    EXPECT_EQ(error_of(folder, "i 0 link.aff"), "accepted");

    // The texture folder itself may not lead outside.
    std::filesystem::remove_all(folder.textures());
    std::filesystem::create_symlink(outside.path(), folder.textures());
    expect_error(folder, k_material + "tt secret.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1", "main.aff:2:4: ");

    // And the main file.
    EXPECT_THROW(load_aff(folder.aff() / "fifo.aff"), InputError);
    EXPECT_THROW(load_aff(folder.aff() / "folder.aff"), InputError);
    EXPECT_THROW(load_aff(folder.aff() / "absent.aff"), InputError);
    EXPECT_THROW(load_aff(folder.aff() / "absent" / "absent.aff"), InputError);
    EXPECT_THROW(load_aff(""), InputError);
}

// All features of the format in few bytes.
std::string small_scene()
{
    return "b 1 1 1 am 2 2 2 # x\nv from 0 0 5 at 0 0 0 up 0 1 0 angle 40 hither 0.1 resolution 8 6\n"
           "l 1 2 3 .5 .5 .5 la lite 0 1 0 a 0 2 3\n" +
           k_material +
           "s 0 0 0 1 c 0 0 0 1 0 1 0 .5\np 3 0 0 0 1 0 0 0 1 0 pp 3 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1\n"
           "tt t.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1\nttp t.ppm 0 0 0 0 0 1 0 0 1 0 0 0 0 1 1 0 0 1 0 0 0 1 0 1\n"
           "tpa 2 0 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1 1 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1\n"
           "xs 1 2 3 0 1 0 45 1 0 0 { m vertices 3 0 0 0 1 0 0 0 1 0 normals 1 0 0 1\n"
           "texturecoords 3 t.ppm 0 0 1 0 0 1 triangles 1 0 1 2 0 0 0 0 1 2 } f 1 0 0 .5 .5 3 0 1\n"
           "x a { i 0 part.aff } d 1 i 1 part.aff\n"
           "k a { transl 4 0 0 0 0 0 0 0 1 1 0 0 0 0 0 2 2 0 0 0 0 0 3 3 0 0 0 0 0\n"
           "rot 4 0 0 1 0 0 0 0 0 1 0 1 0 90 0 .5 0 2 0 1 0 180 0 0 0 3 0 1 0 270 0 0 0\n"
           "scale 4 0 1 1 1 0 0 0 1 1 2 1 0 0 0 2 1 1 1 0 0 0 3 1 1 1 0 0 0 visibility 2 0 1 1 0 }";
}

// Loads and uses the scene; true if accepted. Anything but InputError fails the test.
bool survives(const AffFolder& folder, const std::string& text)
{
    try {
        const scene::Scene scene = folder.load(text);
        for (const double time : {-1.0, 0.0, 1.0, 1.5, 9.0})
            for (const scene::Node& node : scene.nodes)
                if (node.transform) node.transform->evaluate(time);
        scene.bounds(1);
        return true;
    } catch (const InputError&) {
        return false;
    }
}

TEST(HostileAff, TruncatedAnywhereLoadsOrIsRefused)
{
    const AffFolder folder;
    folder.texture("t.ppm");
    folder.include("part.aff", k_mesh);
    const std::string text = small_scene();
    ASSERT_TRUE(survives(folder, text)) << error_of(folder, text);
    std::size_t accepted = 0;
    for (std::size_t size = 0; size < text.size(); ++size) accepted += survives(folder, text.substr(0, size));
    // Most truncations leave an incomplete statement.
    EXPECT_LT(accepted, text.size() / 3);
}

TEST(HostileAff, RandomMutationsLoadOrAreRefused)
{
    const AffFolder folder;
    folder.texture("t.ppm");
    folder.include("part.aff", k_mesh);
    const std::string text = small_scene();
    const std::string alphabet = "0123456789.-+e {}#%\n\r\txmkpsctlvabdfi\xff\x01";
    Random random(20);
    std::size_t refused = 0;
    for (int round = 0; round < 1500; ++round) {
        std::string mutated = text;
        for (std::uint32_t i = 0, n = 1 + random.below(4); i < n; ++i) {
            const std::size_t at = random.below(static_cast<std::uint32_t>(mutated.size()));
            const char c = alphabet[random.below(static_cast<std::uint32_t>(alphabet.size()))];
            switch (random.below(4)) {
                case 0:
                    mutated[at] = c;
                    break;
                case 1:
                    mutated.insert(at, 1, c);
                    break;
                case 2:
                    mutated.erase(at, 1 + random.below(8));
                    break;
                default:
                    mutated.insert(
                        at, mutated.substr(random.below(static_cast<std::uint32_t>(mutated.size())), random.below(60)));
            }
        }
        refused += !survives(folder, mutated);
    }
    EXPECT_GT(refused, 300u);
}

}   // namespace
}   // namespace gnomon::io
