// SPDX-License-Identifier: Apache-2.0
#include "cli/serve/service.h"

#include <stdlib.h>

#include <cmath>
#include <limits>
#include <mutex>

#include "cli/serve/encode.h"
#include "cli/serve/upload.h"
#include "gnomon/gnomon.h"
#include "io/file/atomic_file.h"

namespace gnomon::cli {

namespace {

// A folder of this process's own, which is removed with everything in it.
class OwnFolder {
 public:
    OwnFolder()
    {
        std::string name = (std::filesystem::temp_directory_path() / "gnomon-serve-XXXXXX").string();
        if (!::mkdtemp(name.data())) throw MissingError("cannot make a folder for temporary files: " + name);
        path_ = name;
    }
    ~OwnFolder()
    {
        std::error_code none;
        std::filesystem::remove_all(path_, none);
    }
    OwnFolder(const OwnFolder&) = delete;
    OwnFolder& operator=(const OwnFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

 private:
    std::filesystem::path path_;
};

// Declares that every node may move, and takes the light away if it is not needed.
Scene prepared(const Scene& scene, bool with_light)
{
    SceneBuilder builder(scene);
    if (!with_light) {
        for (const LightId& light : scene.lights()) builder.remove(light);
        builder.background({0, 0, 0});   // instead of an environment
    }
    for (const NodeId& node : scene.nodes())
        if (!scene.parent(node)) builder.set_mobility(node, Mobility::may_move);
    return builder.finish();
}

std::string color_png(const Frame& frame)
{
    return encode_png(frame.size, frame.to_srgb8());
}

// Drake's values for what is nearer or farther than the sensor's range are 0 and infinity.
std::string depth_tiff(const Frame& frame, const RenderForm& form)
{
    std::vector<float> depth = frame.layer("depth")->copy();
    for (float& value : depth)
        if (value == 0 || value > static_cast<float>(form.max_depth))
            value = std::numeric_limits<float>::infinity();
        else if (value < static_cast<float>(form.min_depth))
            value = 0;
    return encode_tiff(frame.size, depth);
}

// Labels are the colours of the materials, as the file has them; white where nothing is.
std::string label_png(const Frame& frame, const Scene& scene)
{
    const Layer& ids = *frame.layer("id");
    std::vector<std::uint8_t> pixels;
    pixels.reserve(3 * static_cast<std::size_t>(frame.size.width) * static_cast<std::size_t>(frame.size.height));
    std::map<std::uint32_t, std::array<std::uint8_t, 3>> colors{{0, {255, 255, 255}}};
    for (int y = 0; y < frame.size.height; ++y)
        for (int x = 0; x < frame.size.width; ++x) {
            const std::uint32_t id = ids.id(x, y, 1);
            auto found = colors.find(id);
            if (found == colors.end()) {
                const Vec3 color = scene.material(scene.material_of(id)).base_color;
                const auto byte = [](float c) { return static_cast<std::uint8_t>(std::lround(255 * c)); };
                found = colors.emplace(id, std::array{byte(color.x), byte(color.y), byte(color.z)}).first;
            }
            pixels.insert(pixels.end(), found->second.begin(), found->second.end());
        }
    return encode_png(frame.size, pixels);
}

}   // namespace

struct RenderService::Impl {
    // What is kept for one kind of images: clients send other materials for each. Depths and labels are rendered
    // without lights.
    struct Kept {
        std::optional<Upload> upload;
        std::optional<Scene> scene;
        std::vector<NodeId> nodes;
        std::optional<Renderer> renderer;
    };

    RenderOptions options;
    std::string environment;
    OwnFolder folder;
    std::mutex mutex;
    Kept colors, depths, labels;

    Scene load_upload(const std::string& file, const Upload& upload, bool with_light, const Progress& progress);
    bool take(Kept& kept, Upload upload, const std::string& file, bool with_light, const Progress& progress,
              FrameInput& input);
};

Scene RenderService::Impl::load_upload(const std::string& file, const Upload& upload, bool with_light,
                                       const Progress& progress)
{
    const std::filesystem::path path = folder.path() / (upload.is_binary ? "scene.glb" : "scene.gltf");
    io::AtomicFile written(path);
    written.write(file);
    written.commit();
    LoadOptions load_options;
    load_options.progress = progress;
    load_options.threads = options.threads;
    load_options.ground = false;
    Scene scene = load(path.string(), load_options);
    std::error_code none;
    std::filesystem::remove(path, none);
    if (with_light && !upload.has_lights) scene = scene.with_environment(environment);
    return prepared(scene, with_light);
}

// Makes `kept` hold the upload, by what it holds already if that shows the same. Returns whether it did.
bool RenderService::Impl::take(Kept& kept, Upload upload, const std::string& file, bool with_light,
                               const Progress& progress, FrameInput& input)
{
    const bool same = kept.upload && kept.scene && kept.upload->shows_the_same_as(upload);
    if (!same) {
        kept.upload.reset(), kept.scene.reset();
        kept.scene = load_upload(file, upload, with_light, progress);
        kept.nodes = kept.scene->nodes();
        if (kept.renderer) kept.renderer->forget();
    }
    // All matrices: those that are in force already cost a comparison.
    for (std::size_t i = 0; i < upload.matrices.size() && i < kept.nodes.size(); ++i)
        if (upload.rest["nodes"][i].contains("matrix")) input.transforms.push_back({kept.nodes[i], upload.matrices[i]});
    kept.upload = std::move(upload);
    return same;
}

RenderService::RenderService(RenderOptions options, std::string environment) : impl_(std::make_unique<Impl>())
{
    impl_->options = std::move(options);
    impl_->environment = std::move(environment);
}

RenderService::~RenderService() = default;

Answer RenderService::answer(const RenderForm& form, const std::string& scene, const Progress& progress)
{
    Upload upload = read_upload(scene);
    const std::lock_guard lock(impl_->mutex);
    const bool with_light = form.image == ServedImage::color;
    Impl::Kept& kept = with_light ? impl_->colors : form.image == ServedImage::depth ? impl_->depths : impl_->labels;

    RenderOptions options = impl_->options;
    options.size = form.size;
    if (!with_light) {
        options.indirect = Indirect::off;
        options.samples = 1;
        options.layers = form.image == ServedImage::depth;
        options.ids = form.image == ServedImage::label;
    }
    FrameInput input;
    input.camera.emplace();
    input.camera->transform = upload.camera_to_world;
    input.camera->intrinsics = form.lens;
    input.camera->near = form.near, input.camera->far = form.far;

    Answer answer;
    answer.reused = impl_->take(kept, std::move(upload), scene, with_light, progress, input);
    if (kept.renderer)
        kept.renderer->set_options(options);
    else
        kept.renderer.emplace(options);
    const Frame frame = kept.renderer->render(*kept.scene, input, progress);
    answer.milliseconds = frame.milliseconds;
    answer.type = form.image == ServedImage::depth ? "image/tiff" : "image/png";
    answer.body = form.image == ServedImage::color   ? color_png(frame)
                  : form.image == ServedImage::depth ? depth_tiff(frame, form)
                                                     : label_png(frame, *kept.scene);
    return answer;
}

}   // namespace gnomon::cli
