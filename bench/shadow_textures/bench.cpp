// SPDX-License-Identifier: Apache-2.0
#include "bench/shadow_textures/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "base/clocks.h"
#include "gnomon/error.h"
#include "options/enum_names.h"
#ifdef GNOMON_VULKAN
#include "scene/builtin/builtin.h"
#include "scene/view.h"
#include "shadow_textures/vulkan/method_textures.h"
#include "shadow_textures/vulkan/plain_frame.h"
#endif

namespace gnomon::bench {

std::vector<ShadowTextures> usual_methods()
{
    return {ShadowTextures::depth, ShadowTextures::coherent, ShadowTextures::items};
}

std::string name_of(const ShadowTexturesRow& row)
{
    return row.by_footprints ? "by-footprints" : std::string(options::name_of(row.method));
}

double growth_exponent(const std::vector<std::pair<double, double>>& points)
{
    GNOMON_CHECK_LE(2u, points.size());
    const auto n = static_cast<double>(points.size());
    double x = 0, y = 0, xx = 0, xy = 0;
    for (const auto& [px, py] : points) {
        const double lx = std::log(px), ly = std::log(py);
        x += lx, y += ly, xx += lx * lx, xy += lx * ly;
    }
    return (n * xy - x * y) / (n * xx - x * x);
}

#ifdef GNOMON_VULKAN

namespace {

using light_views::LightViews;
using light_views::LightViewsOptions;

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

LightViewsOptions view_options(const ShadowTexturesBenchOptions& options, ShadowTextures method, bool by_footprints)
{
    LightViewsOptions result;
    result.by_footprints = by_footprints;
    result.atlas.view_size = options.view_size;
    return shadow_textures::view_options(method, result);
}

glm::mat4 clip_from_world(const scene::View& view)
{
    constexpr float k_near = 0.1f;   // the camera is farther than this from all objects
    const glm::vec3 right = view.right / glm::dot(view.right, view.right), down = -view.up / glm::dot(view.up, view.up);
    const auto row = [&](const glm::vec3& axis) { return glm::vec4(axis, -glm::dot(axis, view.eye)); };
    return glm::transpose(glm::mat4(row(right), row(down), glm::vec4(0, 0, 0, k_near), row(view.forward)));
}

// Frames that are not measured: the first draws everything, and the second detects the dynamic objects.
constexpr int k_warm_up = 2;

// One method with its own buffers and textures; only the motion is common to all methods.
class Runner {
 public:
    Runner(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
           const ShadowTexturesBenchOptions& options, ShadowTextures method, bool by_footprints = false)
        : method_(method),
          by_footprints_(by_footprints),
          previous_(options.as_printed ? shadow_textures::PreviousMethod::all_between
                                       : shadow_textures::PreviousMethod::by_extents),
          by_timestamps_(device->info().kind != "software"),
          views_(state, view_options(options, method, by_footprints)),
          casters_(device, state),
          textures_(device, views_, method),
          image_(device, views_, static_cast<std::uint32_t>(options.size.width),
                 static_cast<std::uint32_t>(options.size.height)),
          commands_(device)
    {
        look_up_.as_printed = options.as_printed;
    }

    /// Draws the image. @return milliseconds
    double draw_image(const scene::SceneState& state, const scene::View& view)
    {
        return draw_image(state, view, look_up_);
    }
    double draw_image(const scene::SceneState& state, const scene::View& view,
                      const shadow_textures::LookupOptions& look_up)
    {
        double ignored = 0;
        return timed(ignored, [&] {
            image_.record(commands_, views_, textures_.buffers(), textures_.textures(), casters_, state,
                          clip_from_world(view), view.eye, look_up);
        });
    }
    Image8 image_of(const scene::SceneState& state, const scene::View& view, bool as_printed, float filter)
    {
        shadow_textures::LookupOptions look_up;
        look_up.as_printed = as_printed;
        look_up.filter = filter;
        draw_image(state, view, look_up);
        return image();
    }

    void frame(const scene::SceneState& state, const scene::View& view, bool measured, bool with_image)
    {
        double cpu = 0;
        // Update the light view's buffers.
        const double buffers = timed(cpu, [&] {
            views_.update(state);
            casters_.update(commands_, state);
            if (method_ != ShadowTextures::per_caster) textures_.record_views(commands_, views_, casters_);
        });
        // Update the receivers' textures.
        const double textures = method_ == ShadowTextures::items ? 0 : timed(cpu, [&] {
            textures_.record_textures(commands_, views_, casters_, state, {}, previous_);
        });
        // Draw the depths that the look-up of a receiver compares, too, outside the method's time.
        if (method_ == ShadowTextures::per_caster) {
            textures_.record_views(commands_, views_, casters_);
            commands_.submit();
        }

        // Draw the image, and record times and counters.
        const double image = with_image ? draw_image(state, view) : 0;
        if (!measured) return;
        buffers_ms_.push_back(buffers), textures_ms_.push_back(textures), shadow_ms_.push_back(buffers + textures);
        frame_ms_.push_back(buffers + textures + image), cpu_ms_.push_back(cpu);
        const light_views::LightViewsCounts& counts = views_.counts();
        const shadow_textures::TextureCounts made = textures_.counts();
        draws_ += static_cast<double>(made.draws);
        all_between_ += static_cast<double>(made.draws_of_all_between + made.updated);
        if (method_ != ShadowTextures::per_caster) {
            draws_ += static_cast<double>(counts.draws);
            copies_ += static_cast<double>(counts.copies);
        }
        updated_ += static_cast<double>(made.updated);
        touched_ += static_cast<double>(counts.touched);
    }

    bool remembers() const { return method_ != ShadowTextures::per_caster; }

    ShadowTexturesRow row() const
    {
        const auto n = static_cast<double>(frame_ms_.size());
        ShadowTexturesRow row;
        row.method = method_;
        row.by_footprints = by_footprints_;
        row.buffers_ms = median(buffers_ms_), row.textures_ms = median(textures_ms_);
        row.shadow_ms = median(shadow_ms_), row.frame_ms = median(frame_ms_), row.shadow_cpu_ms = median(cpu_ms_);
        row.draws = draws_ / n, row.copies = copies_ / n, row.textures_updated = updated_ / n;
        row.touched = touched_ / n;
        if (method_ == ShadowTextures::per_caster) row.draws_of_all_between = all_between_ / n;
        return row;
    }

    /// A copy of buffers and textures, to be compared.
    struct Contents {
        std::vector<vk::Buffer> layers;
        vk::Buffer words;
    };
    Contents contents()
    {
        Contents c;
        const light_views::GpuLightViews& buffers = textures_.buffers();
        for (std::uint32_t page = 0; page < buffers.depth().desc().layers; ++page) {
            c.layers.push_back(commands_.read_back(buffers.depth(), page));
            c.layers.push_back(commands_.read_back(buffers.item(), page));
        }
        if (textures_.textures()) c.words = commands_.read_back(textures_.textures()->textures());
        commands_.submit();
        return c;
    }
    bool same(const Contents& mine, const Runner& other, const Contents& others) const
    {
        for (std::size_t i = 0; i < mine.layers.size(); ++i) {
            const auto a = mine.layers[i].as<std::uint32_t>(), b = others.layers[i].as<std::uint32_t>();
            if (!std::equal(a.begin(), a.end(), b.begin(), b.end())) return false;
        }
        if (!textures_.textures()) return true;   // items: a test compares them with textures
        const auto a = mine.words.as<std::uint32_t>(), b = others.words.as<std::uint32_t>();
        for (std::size_t v = 0; v < views_.views().size(); ++v)
            for (scene::ObjectId o = 0; o < views_.object_count(); ++o) {
                const auto &p = textures_.textures()->place(v, o), &q = other.textures_.textures()->place(v, o);
                if (p.row_words != q.row_words || p.rows != q.rows || p.corner != q.corner) return false;
                const auto words = static_cast<std::ptrdiff_t>(p.row_words) * p.rows;
                if (!std::equal(a.begin() + p.first_word, a.begin() + p.first_word + words, b.begin() + q.first_word))
                    return false;
            }
        return true;
    }

    Image8 image()
    {
        const vk::Buffer pixels = commands_.read_back(image_.color());
        commands_.submit();
        const int width = static_cast<int>(image_.color().width()), height = static_cast<int>(image_.color().height());
        Image8 image(width, height, 3);
        const auto bytes = pixels.as<std::uint8_t>();
        const std::size_t count = image.data.size() / 3;
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t c = 0; c < 3; ++c) image.data[3 * i + c] = bytes[4 * i + c];
        return image;
    }

 private:
    // Runs `body` and submits its commands. Returns milliseconds by the result's clock.
    // @param cpu  increased by the thread's CPU time for `body`
    template <class Body>
    double timed(double& cpu, const Body& body)
    {
        const double begin = cpu_ms(), begin_thread = thread_cpu_ms();
        body();
        cpu += thread_cpu_ms() - begin_thread;
        commands_.submit();
        if (!by_timestamps_) return cpu_ms() - begin;
        double sum = 0;
        for (const vk::PassTiming& timing : commands_.timings()) sum += timing.ms;
        return sum;
    }

    ShadowTextures method_;
    bool by_footprints_;
    shadow_textures::PreviousMethod previous_;
    shadow_textures::LookupOptions look_up_;
    bool by_timestamps_;
    LightViews views_;
    light_views::CasterGeometry casters_;
    shadow_textures::MethodTextures textures_;
    shadow_textures::PlainFrame image_;
    vk::Commands commands_;
    std::vector<double> buffers_ms_, textures_ms_, shadow_ms_, frame_ms_, cpu_ms_;
    double draws_ = 0, all_between_ = 0, copies_ = 0, updated_ = 0, touched_ = 0;
};

// All methods in one scene, with the same motion.
class Setting {
 public:
    Setting(const std::shared_ptr<vk::Device>& device, const ShadowTexturesBenchOptions& options, int objects,
            double dynamic)
        : device_(device), options_(options), scene_(make_scene(options, objects, dynamic)), state_(scene_, 0)
    {
        for (const ShadowTextures method : options.methods)
            runners_.push_back(std::make_unique<Runner>(device, state_, options, method));
        if (options.by_footprints)
            runners_.push_back(std::make_unique<Runner>(device, state_, options, ShadowTextures::coherent, true));
    }

    void frame(int frame)
    {
        state_.advance(frame / scene_->timeline.fps);
        for (const auto& runner : runners_)
            if (frame > 0 || runner->remembers())
                runner->frame(state_, view(), frame >= k_warm_up, !options_.dynamic_objects.has_value());
    }

    /// Adds a row for each method, and compares its buffers and textures with those of a full redraw.
    void finish(ShadowTexturesBenchResult& result)
    {
        Runner full(device_, state_, options_, ShadowTextures::depth);
        full.frame(state_, view(), false, false);
        const Runner::Contents expected = full.contents();
        for (const auto& runner : runners_) {
            ShadowTexturesRow row = runner->row();
            row.objects = static_cast<int>(scene_->objects.size());
            row.dynamic_objects = static_cast<int>(scene_->statistics().objects_dynamic);
            row.dynamic_percent = 100.0 * row.dynamic_objects / row.objects;
            row.identical_to_full = runner->same(runner->contents(), full, expected);
            if (options_.dynamic_objects) row.frame_ms += runner->draw_image(state_, view());
            row.printed_wrong_percent = different_percent(runner->image_of(state_, view(), false, 0),
                                                          runner->image_of(state_, view(), true, 0));
            result.rows.push_back(row);
        }
        if (!options_.images) return;
        Runner& last = *runners_.back();
        result.images.push_back({result.rows.back().objects, result.rows.back().dynamic_objects,
                                 last.image_of(state_, view(), false, 1), last.image_of(state_, view(), true, 1)});
    }

 private:
    static double different_percent(const Image8& a, const Image8& b)
    {
        std::size_t different = 0;
        const std::size_t pixels = a.data.size() / 3;
        for (std::size_t i = 0; i < pixels; ++i)
            different += !std::equal(&a.data[3 * i], &a.data[3 * i] + 3, &b.data[3 * i]);
        return 100 * static_cast<double>(different) / static_cast<double>(std::max<std::size_t>(pixels, 1));
    }
    static std::shared_ptr<const scene::Scene> make_scene(const ShadowTexturesBenchOptions& options, int objects,
                                                          double dynamic)
    {
        scene::SpheresOptions spheres;
        spheres.objects = objects;
        spheres.dynamic = dynamic;
        spheres.vertices = options.vertices;
        if (options.dynamic_objects) spheres.dynamic_objects = *options.dynamic_objects, spheres.crowd = true;
        return std::make_shared<const scene::Scene>(scene::make_spheres(spheres));
    }
    scene::View view() const { return scene::make_view(state_, 0, options_.size); }

    const std::shared_ptr<vk::Device>& device_;
    const ShadowTexturesBenchOptions& options_;
    std::shared_ptr<const scene::Scene> scene_;
    scene::SceneState state_;
    std::vector<std::unique_ptr<Runner>> runners_;
};

}   // namespace

ShadowTexturesBenchResult bench_shadow_textures(const ShadowTexturesBenchOptions& options, const Progress& progress)
{
    const auto device = vk::Device::open();
    ShadowTexturesBenchResult result;
    result.device = device->info().name;
    result.clock = device->info().kind == "software" ? "process CPU" : "device";
    const std::vector<double> percents = options.dynamic_objects ? std::vector<double>{0} : options.dynamic;
    const auto total = static_cast<double>(options.objects.size() * percents.size() *
                                           static_cast<unsigned>(options.frames + k_warm_up));
    double done = 0;
    const auto before_frame = [&] {
        if (progress && !progress({"measuring", done++ / total})) throw InterruptedError("interrupted");
    };
    const int frames = k_warm_up + options.frames;

    // Measure every setting.
    for (const double dynamic : percents) {
        if (!options.dynamic_objects) {
            for (const int objects : options.objects) {
                Setting setting(device, options, objects, dynamic);
                for (int frame = 0; frame < frames; ++frame) before_frame(), setting.frame(frame);
                setting.finish(result);
            }
            continue;
        }
        // Run all crowds frame by frame in turn, so that other load on the machine affects all of them.
        std::vector<std::unique_ptr<Setting>> crowds;
        for (const int objects : options.objects)
            crowds.push_back(std::make_unique<Setting>(device, options, objects, dynamic));
        for (int frame = 0; frame < frames; ++frame)
            for (const auto& crowd : crowds) before_frame(), crowd->frame(frame);
        for (const auto& crowd : crowds) crowd->finish(result);
    }

    // Fit the growth with the number of objects.
    for (const ShadowTextures method : options.methods) {
        std::vector<std::pair<double, double>> points;
        for (const ShadowTexturesRow& row : result.rows)
            if (row.method == method && !row.by_footprints && points.size() < options.objects.size())
                points.emplace_back(row.objects, row.shadow_ms);
        const auto [least, most] = std::minmax_element(points.begin(), points.end());
        if (points.size() > 1 && least->first < most->first)
            result.exponents.emplace_back(method, growth_exponent(points));
    }
    return result;
}

#else

ShadowTexturesBenchResult bench_shadow_textures(const ShadowTexturesBenchOptions&, const Progress&)
{
    throw MissingError("this program was built without Vulkan, which bench shadow-textures needs");
}

#endif

}   // namespace gnomon::bench
