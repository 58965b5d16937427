// SPDX-License-Identifier: Apache-2.0
// OBJ and MTL files that are malicious or broken: every import runs in a child process with limited time and memory,
// and ends in a scene or in an InputError. No file outside the scene's folder is opened.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <sstream>

#include "base/random.h"
#include "gnomon/error.h"
#include "image_bytes.h"
#include "io/load.h"
#include "sanitized.h"
#include "support.h"

namespace gnomon::io {
namespace {

constexpr rlim_t k_memory = 512ull << 20;
constexpr unsigned k_seconds = 10 * test::k_patience;

enum class Outcome { loaded, refused, died };

Outcome import_in_child(const std::filesystem::path& file)
{
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child == 0) {
        const rlimit memory{k_memory, k_memory}, time{k_seconds, k_seconds};
        if (!test::k_sanitized) setrlimit(RLIMIT_AS, &memory);
        setrlimit(RLIMIT_CPU, &time);
        alarm(12 * k_seconds);   // by the clock, if it sleeps: a busy machine takes longer
        try {
            const scene::Scene scene = load_obj(file);
            _exit(0);
        } catch (const InputError& error) {
            _exit(error.file().empty() || error.problem().find('\n') != std::string::npos ? 9 : 3);
        } catch (...) {
            _exit(9);
        }
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (!WIFEXITED(status)) return Outcome::died;
    return WEXITSTATUS(status) == 0 ? Outcome::loaded : WEXITSTATUS(status) == 3 ? Outcome::refused : Outcome::died;
}

// Small, with all features.
const char* const k_complete_obj =
    "# all of it\r\nmtllib m.mtl\no first one\nv 0 0 0\nv 1 0 0 1\nv 1 1 0 .5 .5 .5\nv 0 1e0 0\nv .5 .25 -1\n"
    "vt 0 0\nvt 1 0 0\nvt 1 1\nvn 0 0 1\nvn 0 0 -1\ng group\ns 1\nusemtl red\nf 1/1/1 2/2/1 3/3/1\n"
    "f -1//-1 -2//-1 -3//-1\ns off\nusemtl blue \r\nf 1 2 \\\n 3 4 5\nf 1/1 2/2 3/3 4/1\nl 1 2\np 1\nvp 0.1\n";
const char* const k_complete_mtl =
    "newmtl red\nKa 1 1 1\nKd .5 0 0\nKs 1 1 1\nNs 10\nd 0.5\nTr 0.5\nNi 1.5\nillum 7\nTf 1 1 1\n"
    "map_Kd -s 1 2 3 -o 0 1 -clamp on no.png\nmap_d -imfchan r no.png\n\nnewmtl blue\nKe 1 1 1\nPr .5\nPm .5\n"
    "bump -bm 2 no.png\nnorm no.png\nmap_Pr no.png\nunknown 1\n";

void write(const std::filesystem::path& file, const std::string& bytes)
{
    std::ofstream(file, std::ios::binary) << bytes;
}

TEST(HostileObj, SurvivesKnownMaliciousFiles)
{
    GNOMON_NEED_SCENE(folder, "hostile/obj");
    int files = 0, refused = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (entry.path().extension() != ".obj") continue;
        ++files;
        const auto begin = std::chrono::steady_clock::now();
        const Outcome outcome = import_in_child(entry.path());
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
        EXPECT_NE(outcome, Outcome::died) << entry.path();
        EXPECT_LT(seconds.count(), k_seconds);
        refused += outcome == Outcome::refused;
        // Only this one violates the format: it has a face and no vertex.
        EXPECT_EQ(outcome == Outcome::refused, entry.path().filename() == "invalid-relative-texture-index.obj")
            << entry.path();
    }
    std::printf("%d files, %d refused\n", files, refused);
    EXPECT_EQ(files, 24);
}

TEST(HostileObj, TruncatedAnywhereLoadsOrIsRefused)
{
    test::ScratchFolder folder;
    const std::string whole = k_complete_obj, materials = k_complete_mtl;
    write(folder / "m.mtl", materials);
    write(folder / "a.obj", whole);
    ASSERT_EQ(import_in_child(folder / "a.obj"), Outcome::loaded);
    for (std::size_t size = 0; size < whole.size(); ++size) {
        write(folder / "a.obj", whole.substr(0, size));
        EXPECT_NE(import_in_child(folder / "a.obj"), Outcome::died) << "after " << size << " bytes";
    }
    write(folder / "a.obj", whole);
    for (std::size_t size = 0; size < materials.size(); ++size) {
        write(folder / "m.mtl", materials.substr(0, size));
        EXPECT_NE(import_in_child(folder / "a.obj"), Outcome::died) << "after " << size << " bytes of the materials";
    }
}

TEST(HostileObj, RandomMutationsLoadOrAreRefused)
{
    test::ScratchFolder folder;
    Random random(2026);
    const std::string alphabet = "0123456789 /-.e\\\n\r#vftnusx\t\xff";
    int loaded = 0, refused = 0;
    for (int trial = 0; trial < 600; ++trial) {
        std::string files[2] = {k_complete_obj, k_complete_mtl};
        std::string& bytes = files[random.below(4) == 0];
        for (std::uint32_t i = 1 + random.below(4); i > 0; --i) {
            const std::size_t at = random.below(static_cast<std::uint32_t>(bytes.size()));
            const char c = alphabet[random.below(static_cast<std::uint32_t>(alphabet.size()))];
            switch (random.below(4)) {
                case 0:
                    bytes[at] = c;
                    break;
                case 1:
                    bytes.insert(at, 1 + random.below(30), c);
                    break;
                case 2:
                    bytes.erase(at, 1 + random.below(8));
                    break;
                default:
                    bytes.insert(at, bytes.substr(at / 2, random.below(60)));
            }
        }
        write(folder / "a.obj", files[0]);
        write(folder / "m.mtl", files[1]);
        const Outcome outcome = import_in_child(folder / "a.obj");
        EXPECT_NE(outcome, Outcome::died) << "trial " << trial;
        loaded += outcome == Outcome::loaded, refused += outcome == Outcome::refused;
    }
    std::printf("%d loaded, %d refused\n", loaded, refused);
    // Both must occur, or the mutations test nothing.
    EXPECT_GT(loaded, 50);
    EXPECT_GT(refused, 50);
}

TEST(HostileObj, SurvivesFilesThatAreLargeInOneRespect)
{
    test::ScratchFolder folder;
    const auto repeated = [](const std::string& text, int times) {
        std::string result;
        for (int i = 0; i < times; ++i) result += text;
        return result;
    };
    const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    std::string objects = triangle;
    for (int i = 0; i < 50000; ++i) objects += "o " + std::to_string(i) + "\nf 1 2 3\n";
    const std::pair<const char*, std::string> files[] = {
        {"one long face", triangle + "f" + repeated(" 1 2 3", 300000)},
        {"one long line", repeated("x", 20'000'000)},
        {"one long name", triangle + "usemtl " + repeated("y", 20'000'000) + "\nf 1 2 3"},
        {"many keywords", repeated("a\nb\nc\nd\ne\nf\ng\nh\ni\nj\nk\nl\nm\n", 200000)},
        {"many continuations", triangle + "f 1 2 3" + repeated("\\\n", 2'000'000)},
        {"many libraries", triangle + "mtllib" + repeated(" x.mtl", 200000) + "\nf 1 2 3"},
        {"many objects", objects},
        {"one vertex, many faces", triangle + repeated("f 1 1 1\n", 500000)},
        {"a binary file", repeated(std::string("\x7f"
                                               "ELF\2\1\1\0",
                                               8),
                                   100000)},
        {"deep number", "v 1" + repeated("0", 1'000'000) + " 0 0\n"},
    };
    for (const auto& [what, bytes] : files) {
        write(folder / "a.obj", bytes);
        EXPECT_NE(import_in_child(folder / "a.obj"), Outcome::died) << what;
    }
}

// Each name is looked up among the reported ones: four times as many take four times as long, not sixteen times.
TEST(HostileObj, ReportsManyMissingTexturesQuickly)
{
    const auto seconds_for = [](int count) {
        test::ScratchFolder folder;
        std::string materials, faces = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
        for (int i = 0; i < count; ++i) {
            materials += fmt::format("newmtl m{0}\nmap_Kd {0}.png\n", i);
            faces += fmt::format("usemtl m{}\nf 1 2 3\n", i);
        }
        write(folder / "a.mtl", materials);
        write(folder / "a.obj", faces);
        const std::clock_t start = std::clock();
        // One more says that the triangles lie in one place.
        EXPECT_EQ(load_obj(folder / "a.obj").warnings.size(), static_cast<std::size_t>(count) + 1);
        return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    };
    const double few = seconds_for(20'000);
    EXPECT_LT(seconds_for(80'000), 8 * few);
}

TEST(HostileObj, ReadsAFileWithManyNamesOnce)
{
    test::ScratchFolder folder;
    const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    std::string materials, dots, libraries;
    for (int i = 0; i < 20'000; ++i) materials += "newmtl material " + std::to_string(i) + "\nKd 1 0 0\n";
    for (int i = 0; i < 200; ++i, dots += "./") libraries += "mtllib " + dots + "a.mtl\n";
    write(folder / "a.mtl", materials);
    write(folder / "a.obj", libraries + triangle + "f 1 2 3\n");
    EXPECT_EQ(import_in_child(folder / "a.obj"), Outcome::loaded);

    // One image, each time with another bump scale.
    const auto png = test::png_bytes({2048, 2048, 1, PNG_COLOR_TYPE_GRAY}, {std::vector<std::uint8_t>(256)});
    write(folder / "p.png", {png.begin(), png.end()});
    std::string faces;
    materials.clear();
    for (int i = 0; i < 100; ++i) {
        materials += fmt::format("newmtl m{0}\nmap_Bump -bm 0.{0:03} p.png\n", i);
        faces += fmt::format("usemtl m{}\nf 1 2 3\n", i);
    }
    write(folder / "a.mtl", materials);
    write(folder / "a.obj", "mtllib a.mtl\n" + triangle + faces);
    try {
        load_obj(folder / "a.obj");
        FAIL() << "accepted";
    } catch (const InputError& error) {
        EXPECT_EQ(error.file(), "p.png");
    }
}

// The warning of an import about the only file that it names.
std::string warning_about(const std::filesystem::path& file)
{
    std::string all;
    for (const std::string& warning : load_obj(file).warnings) all += warning + "\n";
    return all;
}

TEST(HostileObj, OpensNoFileOutsideItsFolder)
{
    test::ScratchFolder outer;
    std::filesystem::create_directory(outer / "scene");
    const std::filesystem::path folder = outer / "scene";
    // A material file with an error, which would show that it was read.
    write(outer / "secret.mtl", "newmtl red\nKd not a colour\n");
    std::filesystem::create_symlink("../secret.mtl", folder / "link.mtl");
    std::filesystem::create_directory_symlink("..", folder / "up");
    std::filesystem::create_directory(folder / "directory.mtl");
    ASSERT_EQ(mkfifo((folder / "fifo.mtl").c_str(), 0600), 0);

    const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
    const std::string absolute = (outer / "secret.mtl").string();
    const std::pair<std::string, const char*> names[] = {{"../secret.mtl", "outside"},
                                                         {"..\\secret.mtl", "outside"},
                                                         {"link.mtl", "outside"},
                                                         {"up/secret.mtl", "outside"},
                                                         {absolute, "absolute"},
                                                         {"C:\\secret.mtl", "absolute"},
                                                         {"fifo.mtl", "not a regular"},
                                                         {"directory.mtl", "not a regular"},
                                                         {"/dev/zero", "absolute"},
                                                         {"/etc/passwd", "absolute"},
                                                         {"../../../../etc/none", "does not exist"},
                                                         {".", "not a regular"},
                                                         {"none.mtl", "does not exist"}};
    for (const auto& [name, reason] : names) {
        write(folder / "a.obj", fmt::format("mtllib {}\n{}", name, triangle));
        ASSERT_EQ(import_in_child(folder / "a.obj"), Outcome::loaded) << name;
        EXPECT_NE(warning_about(folder / "a.obj").find(reason), std::string::npos) << name;
        // The same for a texture.
        write(folder / "b.obj", "mtllib good.mtl\nvt 0 0\n" + triangle);
        write(folder / "good.mtl", "newmtl red\nmap_Kd " + name + "\n");
        ASSERT_EQ(import_in_child(folder / "b.obj"), Outcome::loaded) << name;
        EXPECT_NE(warning_about(folder / "b.obj").find(reason), std::string::npos) << name;
    }
    EXPECT_EQ(import_in_child(folder / "fifo.mtl"), Outcome::refused);
    EXPECT_EQ(import_in_child(folder), Outcome::refused);
    EXPECT_EQ(import_in_child("/dev/zero"), Outcome::refused);
    EXPECT_EQ(import_in_child(folder / "none.obj"), Outcome::refused);

    // A link or a detour inside the folder is allowed.
    write(folder / "real.mtl", "newmtl red\nKd 1 0 0\n");
    std::filesystem::create_symlink("real.mtl", folder / "inside.mtl");
    for (const char* name : {"inside.mtl", "directory.mtl/../real.mtl", "./real.mtl"}) {
        write(folder / "a.obj", "mtllib " + std::string(name) + "\n" + triangle);
        EXPECT_EQ(warning_about(folder / "a.obj"), "") << name;
    }
}

}   // namespace
}   // namespace gnomon::io
