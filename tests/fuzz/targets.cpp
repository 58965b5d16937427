// SPDX-License-Identifier: Apache-2.0
#include "fuzz/targets.h"

#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>

#include "cli/command_line.h"
#include "cli/serve/upload.h"
#include "fuzz/decoders.h"
#include "fuzz/repair.h"
#include "fuzz/seeds.h"
#include "gnomon/error.h"
#include "io/aff/aff.h"
#include "io/image/exr.h"
#include "io/image/float_image.h"
#include "io/image/hdr.h"
#include "io/image/image_file.h"
#include "io/load.h"
#include "scene/state.h"

namespace gnomon::fuzz {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view k_folder_name = "gnomon-fuzz-";   // then the process, a dash, and six letters

// Larger images and scenes are refused here, so that the time is spent on many small inputs.
constexpr io::ImageLimits k_image{.max_side = 2048, .max_pixels = 1u << 20};
constexpr io::FloatImageLimits k_float_image{
    .max_side = 2048, .max_pixels = 1u << 20, .max_values = 1u << 22, .max_channels = 64};

}   // namespace

void remove_left_folders()
{
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(fs::temp_directory_path(), ignored)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(k_folder_name)) continue;
        pid_t process = 0;
        const char* const end = name.data() + name.size();
        const auto [after, error] = std::from_chars(name.data() + k_folder_name.size(), end, process);
        if (error != std::errc() || after == end || *after != '-' || process <= 0) continue;
        if (kill(process, 0) != 0 && errno == ESRCH) fs::remove_all(entry.path(), ignored);
    }
}

namespace {

// --- A scene folder with the files that inputs refer to.

class Folder {
 public:
    Folder() : owner_(getpid())
    {
        remove_left_folders();
        std::string pattern =
            (fs::temp_directory_path() / (std::string(k_folder_name) + std::to_string(getpid()) + "-XXXXXX")).string();
        if (!mkdtemp(pattern.data())) throw std::runtime_error("mkdtemp failed");
        root_ = pattern;
        fs::create_directory(root_ / "scene");
        fs::create_directory(root_ / "TextureFiles");
        const std::string image("P6\n2 1\n255\n\xff\x00\x00\x00\x00\xff", 17);
        write(root_ / "TextureFiles" / "t.ppm", image);
        for (const Bytes& png : png_seeds()) write(scene() / "t.png", png);
        write(scene() / "part.aff", std::string("s 0 0 0 1\n"));
        constexpr float k_floats[] = {.75f, .75f, .75f, .75f, .75f, .75f, .75f, .75f,
                                      .75f, .75f, .75f, .75f, .75f, .75f, .75f, .75f};
        write(scene() / "data.bin", std::string(reinterpret_cast<const char*>(k_floats), sizeof k_floats));
    }
    ~Folder()
    {
        std::error_code ignored;
        if (owner_ == getpid()) fs::remove_all(root_, ignored);
    }
    bool is_own() const { return owner_ == getpid(); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    fs::path scene() const { return root_ / "scene"; }
    template <class Text>
    fs::path put(const std::string& name, const Text& bytes) const
    {
        write(scene() / name, bytes);
        return scene() / name;
    }

 private:
    template <class Text>
    static void write(const fs::path& file, const Text& bytes)
    {
        std::ofstream out(file, std::ios::binary);
        out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        if (!out) throw std::runtime_error("cannot write " + file.string());
    }
    pid_t owner_;   // a forked process has a copy, and makes a folder of its own
    fs::path root_;
};

const Folder& folder()
{
    static std::unique_ptr<const Folder> folder;
    if (!folder || !folder->is_own()) folder = std::make_unique<const Folder>();
    return *folder;
}

// --- Checks of every outcome.

void check_message(const std::string& message)
{
    for (const char c : message)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            throw std::logic_error("control character in message: " + message);
}

template <class Read>
std::string reads(const Read& read)
{
    try {
        read();
        return {};
    } catch (const InputError& error) {
        check_message(error.what());
        return error.what();
    }
}

bool finite(const glm::dmat4& m)
{
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!std::isfinite(m[column][row])) return false;
    return true;
}

// An accepted scene can be evaluated at any time, and stays finite.
void check_scene(scene::Scene loaded)
{
    for (const std::string& warning : loaded.warnings) check_message(warning);
    const auto scene = std::make_shared<const scene::Scene>(std::move(loaded));
    const double start = scene->timeline.start, end = scene->timeline.end;
    scene::SceneState state(scene, start);
    for (const double time : {start + 0.3 * (end - start), end, start}) {
        state.advance(time);
        for (scene::NodeId node = 0; node < scene->nodes.size(); ++node)
            if (!finite(state.world(node))) throw std::logic_error("a node's place is not finite");
    }
}

template <class Pixels>
void check_image(const Pixels& image)
{
    const auto values = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                        static_cast<std::size_t>(image.channels);
    if (values == 0 || image.data.size() != values) throw std::logic_error("an image of the wrong size");
}

// --- The targets

using Input = std::span<const std::uint8_t>;

std::string run_image(Input bytes)
{
    return reads([&] { check_image(io::decode_image(bytes, "input", k_image)); });
}

std::string run_exr(Input bytes)
{
    return reads([&] {
        if (io::image_format(bytes) != io::ImageFormat::exr) throw InputError("input", "", "no OpenEXR image");
        const io::ExrImage image = io::decode_exr(bytes, "input", {}, k_float_image);
        for (const io::ExrLayer& layer : image.layers)
            if (layer.data.size() != static_cast<std::size_t>(image.size.width) *
                                         static_cast<std::size_t>(image.size.height) * layer.channels.size())
                throw std::logic_error("a layer of the wrong size");
        reads([&] { io::decode_float_image(bytes, "input", k_float_image); });
    });
}

std::string run_hdr(Input bytes)
{
    return reads([&] { check_image(io::decode_hdr(bytes, "input", k_float_image)); });
}

std::string run_aff(Input bytes)
{
    io::AffOptions options;
    options.scene.max_triangles = 1u << 18, options.scene.max_shape_triangles = 1u << 16;
    options.max_parsed_bytes = 1u << 20;
    const fs::path file = folder().put("main.aff", bytes);
    return reads([&] { check_scene(io::load_aff(file, {}, options)); });
}

std::string run_obj(Input bytes)
{
    const fs::path file = folder().put("main.obj", bytes);
    static const fs::path materials = folder().put("m.mtl", mtl_seeds()[0]);
    reads([&] { check_scene(io::load_obj(file, {}, {.strict = true})); });
    return reads([&] { check_scene(io::load_obj(file)); });
}

std::string run_mtl(Input bytes)
{
    folder().put("fuzzed.mtl", bytes);
    static const fs::path file =
        folder().put("with.obj", std::string("mtllib fuzzed.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
                                             "usemtl red\nf 1/1 2/2 3/3\nusemtl blue\nf 1/1 3/3 2/2\n"));
    // Whatever is in a file of materials, it is read, unless reading is strict.
    reads([&] { check_scene(io::load_obj(file)); });
    return reads([&] { check_scene(io::load_obj(file, {}, {.strict = true})); });
}

std::string run_gltf(Input bytes)
{
    const fs::path file = folder().put("main.gltf", bytes);
    reads([&] { check_scene(io::load_gltf(file, {}, {.strict = true})); });
    return reads([&] { check_scene(io::load_gltf(file)); });
}

std::string run_glb(Input bytes)
{
    const fs::path file = folder().put("main.glb", bytes);
    reads([&] { check_scene(io::load_gltf(file, {}, {.strict = true})); });
    return reads([&] { check_scene(io::load_gltf(file)); });
}

std::string run_draco(Input bytes)
{
    if (bytes.empty()) return "no bytes";
    folder().put("draco.bin", bytes);
    const fs::path file = folder().put("draco.gltf", draco_document(bytes.size(), "draco.bin"));
    return reads([&] { check_scene(io::load_gltf(file)); });
}

// The first byte selects mode and filter.
std::string run_meshopt(Input bytes)
{
    if (bytes.size() < 2) return "no bytes";
    const auto kind = static_cast<MeshoptKind>(bytes[0] % static_cast<int>(MeshoptKind::k_kinds));
    folder().put("meshopt.bin", bytes.subspan(1));
    const fs::path file = folder().put("meshopt.gltf", meshopt_document(kind, bytes.size() - 1, "meshopt.bin"));
    return reads([&] { check_scene(io::load_gltf(file)); });
}

std::string run_ply(Input bytes)
{
    const fs::path file = folder().put("main.ply", bytes);
    reads([&] { check_scene(io::load_ply(file, {}, {.strict = true})); });
    return reads([&] { check_scene(io::load_ply(file)); });
}

std::string run_stl(Input bytes)
{
    const fs::path file = folder().put("main.stl", bytes);
    reads([&] { check_scene(io::load_stl(file, {}, {.strict = true})); });
    return reads([&] { check_scene(io::load_stl(file)); });
}

// The first byte selects a subcommand.
std::string run_config(Input bytes)
{
    if (bytes.empty()) return "no subcommand";
    const fs::path file = folder().put("config.json", bytes.subspan(1));
    const options::SubcommandInfo& subcommand = options::subcommands()[bytes[0] % options::subcommands().size()];
    return reads([&] {
        options::OptionValues values(subcommand.subcommand);
        cli::read_config(file, subcommand, values);
    });
}

// Each line is a word. No other files than those here may be opened.
std::string run_options(Input bytes)
{
    std::vector<std::string> words(1);
    for (const std::uint8_t c : bytes)
        c == '\n' ? (void)words.emplace_back() : words.back().push_back(static_cast<char>(c));
    for (const std::string& word : words)
        if (word.find("config") != std::string::npos) return "not tested here";
    try {
        const cli::CommandLine line = cli::parse_command_line(words);
        if (line.help) cli::help_text(line.subcommand);
        return {};
    } catch (const UsageError& error) {   // repeats words as they were given; the program turns it into one line
        return error.what();
    }
}

// What a simulator uploads.
std::string run_upload(Input bytes)
{
    try {
        cli::read_upload({bytes.begin(), bytes.end()});
        return {};
    } catch (const UsageError& error) {
        check_message(error.what());
        return error.what();
    }
}

constexpr Target k_targets[] = {
    {"gltf", run_gltf, gltf_seeds, nullptr},
    {"glb", run_glb, glb_seeds, repair_glb},
    {"obj", run_obj, obj_seeds, nullptr},
    {"mtl", run_mtl, mtl_seeds, nullptr},
    {"aff", run_aff, aff_seeds, nullptr},
    {"png", run_image, png_seeds, repair_png},
    {"jpeg", run_image, jpeg_seeds, nullptr},
    {"ppm", run_image, ppm_seeds, nullptr},
    {"exr", run_exr, exr_seeds, nullptr},
    {"hdr", run_hdr, hdr_seeds, nullptr},
    {"draco", run_draco, draco_seeds, nullptr},
    {"meshopt", run_meshopt, meshopt_seeds, nullptr},
    {"webp", run_image, webp_seeds, nullptr},
    {"ply", run_ply, ply_seeds, nullptr},
    {"stl", run_stl, stl_seeds, nullptr},
    {"config", run_config, config_seeds, nullptr},
    {"options", run_options, option_seeds, nullptr},
    {"upload", run_upload, upload_seeds, nullptr},
};

}   // namespace

std::span<const Target> targets()
{
    return k_targets;
}

const Target* find_target(std::string_view name)
{
    for (const Target& target : k_targets)
        if (target.name == name) return &target;
    return nullptr;
}

}   // namespace gnomon::fuzz
