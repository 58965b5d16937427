// SPDX-License-Identifier: Apache-2.0
// The system calls of loading a scene: no file outside the scene's folder, no socket.
#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <regex>

#include "sanitized.h"
#include "support.h"

namespace gnomon {
namespace {

// The paths that loading opened between two marks in the trace, and whether it created a socket.
struct Trace {
    std::vector<std::string> opened;
    bool socket = false;
};

Trace trace_command(const std::string& traced, const test::ScratchFolder& scratch)
{
    const std::filesystem::path log = scratch / "trace";
    const std::string command = fmt::format(
        "strace -f -e trace=open,openat,openat2,creat,socket,connect -o '{}' {} >/dev/null 2>&1", log.string(), traced);
    const int status = std::system(command.c_str());
    (void)status;   // refused files end with an error, as expected
    Trace trace;
    std::ifstream stream(log);
    const std::regex open_call("(?:open|openat|openat2|creat)\\((?:AT_FDCWD, )?\"([^\"]*)\"");
    for (std::string line; std::getline(stream, line);) {
        std::smatch match;
        if (std::regex_search(line, match, open_call)) trace.opened.push_back(match[1]);
        if (line.find("socket(") != std::string::npos || line.find("connect(") != std::string::npos)
            trace.socket = true;
    }
    return trace;
}

Trace trace_info(const std::filesystem::path& scene, const test::ScratchFolder& scratch)
{
    return trace_command(fmt::format("'{}' info '{}'", test::places::program, scene.string()), scratch);
}

// Kernel files, and the one that ThreadSanitizer creates as each program starts.
bool is_system(const std::string& path)
{
    return path.starts_with("/proc/") || path.starts_with("/sys/") ||
           (test::k_sanitized_thread && path.find("/tsan.rodata.") != std::string::npos);
}

bool have_strace()
{
    if (test::places::program.empty()) return false;
    test::ScratchFolder scratch;
    const std::string command = fmt::format("strace -o '{}' true >/dev/null 2>&1", (scratch / "t").string());
    return std::system(command.c_str()) == 0;
}

// What the tests below look for is in the trace of a program that does it, in a process below it. The shell that only
// reads is sh: where HOME is not set, bash asks for the user's entry through the socket of a name service.
TEST(SystemCalls, OpeningAFileAndASocketIsTraced)
{
    if (!have_strace()) GTEST_SKIP() << "no strace, or tracing is not permitted";
    test::ScratchFolder scratch;
    const std::string secret = (scratch / "secret").string();
    std::ofstream(secret) << "x";
    const Trace file = trace_command(fmt::format("sh -c '(cat {}; true)'", secret), scratch);
    EXPECT_NE(std::find(file.opened.begin(), file.opened.end(), secret), file.opened.end());
    EXPECT_FALSE(file.socket);
    EXPECT_TRUE(trace_command("bash -c '(: </dev/tcp/127.0.0.1/1; true)'", scratch).socket);
}

TEST(SystemCalls, GltfOpensNothingOutsideItsFolder)
{
    if (!have_strace()) GTEST_SKIP() << "no strace, or tracing is not permitted";
    test::ScratchFolder scratch, scenes;
    std::ofstream(scenes / "in.bin") << "12345678";
    const auto write = [&](const std::string& name, const std::string& uri) {
        std::ofstream(scenes / name) << R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":8,"uri":")" + uri +
                                            "\"}]}";
    };
    // A file that names nothing shows what the program opens at its start (libraries, machine).
    std::ofstream(scenes / "empty.gltf") << R"({"asset":{"version":"2.0"}})";
    const Trace usual = trace_info(scenes / "empty.gltf", scratch);
    ASSERT_FALSE(usual.opened.empty());
    EXPECT_FALSE(usual.socket);
    ASSERT_NE(std::find(usual.opened.begin(), usual.opened.end(), (scenes / "empty.gltf").string()),
              usual.opened.end());

    const std::string inside = std::filesystem::canonical(scenes.path()).string() + '/';
    int number = 0;
    for (const char* uri : {"in.bin", "/etc/passwd", "../../../../../../../../etc/passwd", "http://localhost:1/x.bin",
                            "file:///etc/passwd", "ftp://localhost/x", "/dev/zero", "%2fetc%2fpasswd"}) {
        const std::string name = fmt::format("scene{}.gltf", number++);
        write(name, uri);
        const Trace trace = trace_info(scenes / name, scratch);
        EXPECT_FALSE(trace.socket) << uri;
        for (const std::string& path : trace.opened) {
            const bool own = path.rfind(inside, 0) == 0 || path.rfind(scenes.path().string(), 0) == 0;
            const bool known = std::find(usual.opened.begin(), usual.opened.end(), path) != usual.opened.end();
            const bool system = is_system(path);
            EXPECT_TRUE(own || known || system) << uri << " opened " << path;
        }
    }
}

TEST(SystemCalls, ObjAndAffOpenNothingOutsideTheirFolder)
{
    if (!have_strace()) GTEST_SKIP() << "no strace, or tracing is not permitted";
    test::ScratchFolder scratch, root;
    const std::filesystem::path scenes =
        root / "aff";   // a TextureFiles folder beside an AFF's folder counts as inside
    std::filesystem::create_directory(scenes);
    // With a texture, because threads load system libraries.
    std::ofstream(scenes / "m.mtl") << "newmtl a\nmap_Kd none.ppm\n";
    std::ofstream(scenes / "empty.obj") << "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const Trace usual = trace_info(scenes / "empty.obj", scratch);
    const std::string inside = std::filesystem::canonical(root.path()).string() + '/';
    const char* const outside[] = {"/etc/passwd", "../../../../../../etc/passwd", "http://localhost:1/x", "/dev/zero",
                                   "..\\..\\etc\\passwd"};
    int number = 0;
    for (const char* name : outside) {
        std::ofstream(scenes / "m.mtl") << "newmtl a\nmap_Kd " << name << "\nmap_d " << name << "\n";
        const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        const auto obj = scenes / fmt::format("scene{}.obj", number), mtl = scenes / fmt::format("mtl{}.obj", number);
        const auto aff = scenes / fmt::format("scene{}.aff", number),
                   texture = scenes / fmt::format("tex{}.aff", number);
        ++number;
        std::ofstream(obj) << "mtllib " << name << "\n" << triangle;
        std::ofstream(mtl) << "mtllib m.mtl\nusemtl a\n" << triangle;
        std::ofstream(aff) << "i 0 " << name << "\n";
        std::ofstream(texture) << "fm 0 0 0 1 1 1 0 0 0 0 0 1\ntt " << name << " 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1\n";
        for (const auto& file : {obj, mtl, aff, texture}) {
            const Trace trace = trace_info(file, scratch);
            EXPECT_FALSE(trace.socket) << file;
            for (const std::string& path : trace.opened) {
                const bool own = path.rfind(inside, 0) == 0 || path.rfind(root.path().string(), 0) == 0;
                const bool known = std::find(usual.opened.begin(), usual.opened.end(), path) != usual.opened.end();
                const bool system = is_system(path);
                EXPECT_TRUE(own || known || system) << file << " opened " << path;
            }
        }
    }
}

TEST(SystemCalls, ValidatorFilesOpenNothingOutsideTheirFolder)
{
    GNOMON_NEED_SCENE(folder, "hostile/gltf-validator");
    if (!have_strace()) GTEST_SKIP() << "no strace, or tracing is not permitted";
    test::ScratchFolder scratch, scenes;
    std::ofstream(scenes / "empty.gltf") << R"({"asset":{"version":"2.0"}})";
    const Trace usual = trace_info(scenes / "empty.gltf", scratch);
    for (const char* name : {"base/data/buffer", "base/data/image"}) {
        for (const auto& entry : std::filesystem::directory_iterator(folder / name)) {
            if (entry.path().extension() != ".gltf" && entry.path().extension() != ".glb") continue;
            const Trace trace = trace_info(entry.path(), scratch);
            EXPECT_FALSE(trace.socket) << entry.path();
            const std::string own = std::filesystem::canonical(entry.path().parent_path()).string();
            for (const std::string& path : trace.opened) {
                const bool known = std::find(usual.opened.begin(), usual.opened.end(), path) != usual.opened.end();
                const bool system = is_system(path);
                EXPECT_TRUE(known || system || path == entry.path().string() || path.rfind(own, 0) == 0)
                    << entry.path() << " opened " << path;
            }
        }
    }
}

}   // namespace
}   // namespace gnomon
