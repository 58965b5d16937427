// SPDX-License-Identifier: Apache-2.0
#include "bench/indirect/bench.h"

#include <algorithm>
#include <cmath>

#include "base/clocks.h"
#include "bench/indirect/reference_cache.h"
#include "gnomon/error.h"

namespace gnomon::bench {

namespace {

constexpr std::uint64_t k_seed = 1, k_other_seed = 2;

struct Times {
    double wall = 0, cpu = 0;
    Times& operator+=(const Times& o)
    {
        wall += o.wall, cpu += o.cpu;
        return *this;
    }
};

template <class Work>
Times time_of(const Work& work)
{
    const double wall = wall_ms(), cpu = cpu_ms();
    work();
    return {wall_ms() - wall, cpu_ms() - cpu};
}

// The time of one call of a method, or the time that the method measured itself.
template <class Work>
Times time_of(const IndirectMethod& method, IndirectTimes::Took IndirectTimes::*which, const Work& work)
{
    const Times taken = time_of(work);
    if (const IndirectTimes* own = method.own_times()) return {(own->*which).wall, (own->*which).cpu};
    return taken;
}

double sum_of(const glm::vec3& v)
{
    return static_cast<double>(v.x) + static_cast<double>(v.y) + static_cast<double>(v.z);
}

double square_of(const glm::vec3& v)
{
    return static_cast<double>(glm::dot(v, v));
}

double change_of(const glm::vec3& v)
{
    return sum_of(glm::abs(v)) / 3;
}

// One-bounce light, and light from the sky.

using Estimates = std::vector<reference::IrradianceEstimate>;

// The reference values of a frame.
struct Judged {
    int frame = 0;
    PointGrid grid;
    Estimates reference;
    std::vector<glm::vec3> brute;   // the sum over all texels, without visibility
    // Flicker: points of this frame that the next frame shows, too; empty in the last frame of the range.
    std::vector<FixedPoint> fixed;
    std::vector<std::size_t> fixed_pixels;
    std::vector<glm::vec3> change, other_change;   // to the next frame, in two independent references
};

// The scene at one frame, with its BVHs.
struct World {
    World(const std::shared_ptr<const scene::Scene>& s, const IndirectBenchOptions& options, int frame)
        : scene(s), camera(options.camera), size(options.size), state(s, s->timeline.time_of(frame)), rays(state)
    {
    }
    void go(int frame)
    {
        state.advance(scene->timeline.time_of(frame));
        rays.update(state);
    }
    scene::View view() const { return scene::make_view(state, camera, size); }
    std::shared_ptr<const scene::Scene> scene;
    scene::CameraId camera;
    Size size;
    scene::SceneState state;
    ray::RayScene rays;
};

class Bench {
 public:
    Bench(const std::shared_ptr<const scene::Scene>& scene, const IndirectBenchOptions& options,
          const Progress& progress)
        : scene_(scene),
          options_(options),
          progress_(progress),
          tasks_(options.threads),
          cache_(options.reference_cache, *scene)
    {
    }

    IndirectBenchResult run(const std::function<void(const IndirectRow&)>& on_row)
    {
        choose_frames();
        make_references();
        for (const IndirectMethodInfo& method : options_.methods) {
            result_.rows.push_back(measure(method));
            if (on_row) on_row(result_.rows.back());
        }
        result_.references_computed = cache_.computed(), result_.references_found = cache_.found();
        return std::move(result_);
    }

 private:
    // Whether an environment image lights the scene: its light without a bounce is direct light, which is left out.
    bool has_image() const { return scene_->background.kind == scene::Background::Kind::image; }
    glm::vec3 light_of(const reference::IrradianceEstimate& e) const
    {
        return has_image() ? e.indirect : e.indirect + e.surroundings;
    }

    const glm::vec3& error_of(const reference::IrradianceEstimate& e) const
    {
        return has_image() ? e.indirect_error : e.error;
    }

    // Chooses frames spread over the range, each followed by another frame of it unless the range is a single frame.
    void choose_frames()
    {
        const FrameRange range = options_.frames;
        const int most = std::max(1, range.count() - 1);
        const int count = std::min(options_.judged, most);
        for (int i = 0; i < count; ++i) {
            const int frame = range.first + (count > 1 ? i * (most - 1) / (count - 1) : 0);
            judged_.emplace_back().frame = frame;
            result_.judged.push_back(frame);
        }
    }

    // The reference at points, computed or read from the cache.
    Estimates reference(const World& world, std::span<const FixedPoint> points, std::uint64_t seed, int spp)
    {
        reference::ReferenceOptions options;
        options.samples = spp, options.bounces = options_.bounces, options.seed = seed;
        // Direct light is left out: that of emissive surfaces and of an environment image, too, from which cached
        // visibility starts bounces. The sky's is part of what is measured.
        options.surroundings = has_image() || scene_->background.kind == scene::Background::Kind::sky;
        options.shining = true, options.shining_unbounced = false;
        const double step = 1.0 / static_cast<double>(4 * judged_.size() + (options_.images ? 1 : 0));
        const double from = step * references_++;
        return cache_.irradiance(world.state, world.rays, points, options, tasks_, [&](const ProgressStep& at) {
            return !progress_ || progress_({"references", from + step * at.done});
        });
    }

    // Computes the references of all judged frames, and their noise.
    void make_references()
    {
        double sum = 0, error = 0;
        for (Judged& j : judged_) {
            World world(scene_, options_, j.frame);
            SeenImage image;
            see_image(world.state, world.rays, world.view(), 0, tasks_, image);
            j.grid = grid_of(image, world.rays, options_.grid);
            j.reference = reference(world, j.grid.points, k_seed, options_.spp);
            for (const reference::IrradianceEstimate& e : j.reference)
                sum += sum_of(light_of(e)), error += square_of(error_of(e));
            result_.points += j.reference.size();
            if (const bool all_visible = std::all_of(options_.methods.begin(), options_.methods.end(),
                                                     [](const IndirectMethodInfo& m) { return m.visible; });
                !all_visible) {
                std::vector<SeenPoint> points;
                for (const std::size_t pixel : j.grid.pixels) points.push_back(image.points[pixel]);
                j.brute = brute_irradiance(world.state, world.rays, points, tasks_);
            }
            if (options_.images && &j == &judged_[judged_.size() / 2]) make_image(world, image, j.frame);
            if (j.frame < options_.frames.last) make_changes(j, world);
        }
        const double values = 3 * static_cast<double>(std::max<std::size_t>(1, result_.points));
        result_.mean_irradiance = sum / values;
        if (sum > 0) result_.reference_noise = std::sqrt(error / values) / result_.mean_irradiance;
    }

    // Computes the reference at every pixel of a frame.
    void make_image(const World& world, const SeenImage& image, int frame)
    {
        IndirectImage& out = result_.image;
        out.frame = frame;
        for (const SeenPoint& seen : image.points) out.diffuse.push_back(seen.diffuse);
        out.reference.assign(image.points.size(), glm::vec3(0));
        const PointGrid all = grid_of(image, world.rays, 1);
        const Estimates light = reference(world, all.points, k_seed, options_.image_spp);
        for (std::size_t i = 0; i < light.size(); ++i) out.reference[all.pixels[i]] = light_of(light[i]);
    }

    // Computes how the irradiance of fixed points changes from this frame to the next, in two references.
    void make_changes(Judged& j, World& world)
    {
        // Choose the points of the coarser grid.
        const auto step = static_cast<std::size_t>(options_.flicker_grid);
        const auto width = static_cast<std::size_t>(options_.size.width);
        const std::size_t first = static_cast<std::size_t>(options_.grid / 2);
        std::vector<FixedPoint> points;
        std::vector<std::size_t> pixels, at;
        Estimates own;
        for (std::size_t i = 0; i < j.grid.points.size(); ++i) {
            const std::size_t x = j.grid.pixels[i] % width - first, y = j.grid.pixels[i] / width - first;
            if (x % step || y % step) continue;
            points.push_back(j.grid.points[i]), pixels.push_back(j.grid.pixels[i]);
            own.push_back(j.reference[i]);
        }

        // Evaluate both references in both frames, at the points visible in both.
        const Estimates other = reference(world, points, k_other_seed, options_.spp);
        world.go(j.frame + 1);
        find_again(*scene_, world.rays, world.view(), points, at);
        const Estimates next = reference(world, points, k_seed, options_.spp),
                        other_next = reference(world, points, k_other_seed, options_.spp);
        for (const std::size_t i : at) {
            j.fixed.push_back(points[i]), j.fixed_pixels.push_back(pixels[i]);
            j.change.push_back(light_of(next[i]) - light_of(own[i]));
            j.other_change.push_back(light_of(other_next[i]) - light_of(other[i]));
        }
    }

    // Runs one method over the range.
    // LONG: one sequence of measurements, each of which depends on the state that those before it left.
    IndirectRow measure(const IndirectMethodInfo& info)
    {
        // Construct the method at the first frame.
        IndirectRow row;
        row.method = info.name;
        row.title = info.title;
        row.settings = info.settings;
        row.vulkan = info.vulkan;
        const FrameRange range = options_.frames;
        World world(scene_, options_, range.first);
        std::unique_ptr<IndirectMethod> method;
        Times made = time_of([&] { method = info.make_for(world.state, world.rays, tasks_); });
        if (const IndirectTimes* own = method->own_times()) made = {own->made.wall, own->made.cpu};
        SeenImage image;
        std::vector<glm::vec3> light, before;
        Times still, moving, repair, fresh;
        std::vector<double> walls;
        double square = 0, sum = 0, reference_sum = 0, flicker = 0, floor = 0, brute_square = 0, brute_sum = 0;
        std::size_t values = 0, flickering = 0;
        const Judged* last = nullptr;   // reference values of the previous frame, if it has any

        for (int frame = range.first; frame <= range.last; ++frame) {
            if (progress_ && !progress_({info.name, static_cast<double>(frame - range.first) / range.count()}))
                throw InterruptedError("interrupted");
            const bool cold = frame == range.first;
            if (!cold) world.go(frame);
            see_image(world.state, world.rays, world.view(), method->grid_step(options_.size), tasks_, image);
            light.assign(image.points.size(), glm::vec3(0));

            // Light the frame.
            const Times begun =
                time_of(*method, &IndirectTimes::begun, [&] { method->begin_frame(world.state, world.rays, tasks_); });
            Times whole = begun;
            whole += time_of(*method, &IndirectTimes::lit, [&] { method->light(image, tasks_, light.data()); });

            // Measure flicker from the previous frame to this one.
            if (last && !last->fixed.empty()) {
                std::vector<std::size_t> seen;
                const auto again = find_again(*scene_, world.rays, world.view(), last->fixed, seen);
                std::vector<glm::vec3> now(again.size());
                method->sample(again, now.data());
                for (std::size_t k = 0; k < seen.size(); ++k) {
                    const std::size_t i = seen[k];
                    const glm::vec3 change = now[k] - before[last->fixed_pixels[i]];
                    flicker += change_of(change - last->change[i]);
                    floor += change_of(last->other_change[i] - last->change[i]);
                }
                flickering += seen.size();
            }

            // Record times and work. A static scene has only its first frame to measure.
            IndirectWork work;
            const Times ended = time_of([&] { work = method->end_frame(); });
            if (!method->own_times()) whole += ended;
            row.work.bytes = std::max(row.work.bytes, work.bytes);
            if (cold) {
                whole += made;
                row.ms_cold = whole.wall, row.cpu_ms_cold = whole.cpu, row.rays_cold = work.rays;
            }
            const bool counts = !cold || range.count() == 1;
            if (counts) {
                moving += whole, repair += begun, walls.push_back(whole.wall);
                row.work.clusters += work.clusters, row.work.rays += work.rays;
                row.work.rays_left_out += work.rays_left_out;
                row.work.dirty_pixels += work.dirty_pixels, row.work.dirty_nodes += work.dirty_nodes;
            }

            // Measure errors against the reference.
            last = nullptr;
            for (const Judged& j : judged_) {
                if (j.frame != frame) continue;
                last = &j;
                double own_square = 0, own_sum = 0;
                std::vector<ComparedPoint> compared;
                for (std::size_t i = 0; i < j.grid.pixels.size(); ++i) {
                    const glm::vec3& e = light[j.grid.pixels[i]];
                    compared.push_back({j.grid.pixels[i], e, light_of(j.reference[i]), error_of(j.reference[i])});
                    own_square += square_of(e - light_of(j.reference[i]));
                    sum += sum_of(e), own_sum += sum_of(light_of(j.reference[i]));
                    if (info.visible) continue;
                    brute_square += square_of(e - j.brute[i]), brute_sum += sum_of(j.brute[i]);
                }
                const double count = 3 * static_cast<double>(j.grid.pixels.size());
                if (own_sum > 0) row.nrmse_by_frame.push_back(std::sqrt(own_square / count) / (own_sum / count));
                row.local_means += compare_blocks(compared, options_.size.width);
                square += own_square, reference_sum += own_sum, values += j.grid.pixels.size();
            }
            if (options_.images && frame == result_.image.frame) row.image = light;
            before = light;

            // Time the same frame once more, without motion.
            if (!counts) continue;
            world.go(frame);
            still +=
                time_of(*method, &IndirectTimes::begun, [&] { method->begin_frame(world.state, world.rays, tasks_); });
            still += time_of(*method, &IndirectTimes::lit, [&] { method->light(image, tasks_, light.data()); });
            const Times still_ended = time_of([&] { method->end_frame(); });
            if (!method->own_times()) still += still_ended;

            // Time it with nothing kept, as the paper means it: G-buffer, light map, tree and sparse receivers.
            if (!method->forget()) continue;
            world.go(frame);
            if (!method->own_times())
                fresh += time_of([&] {
                    see_image(world.state, world.rays, world.view(), method->grid_step(options_.size), tasks_, image);
                });
            fresh +=
                time_of(*method, &IndirectTimes::begun, [&] { method->begin_frame(world.state, world.rays, tasks_); });
            fresh += time_of(*method, &IndirectTimes::lit, [&] { method->light(image, tasks_, light.data()); });
            method->end_frame();
        }

        // Compute means over the frames, and errors over all points.
        const auto later = static_cast<double>(std::max(1, range.count() - 1));
        row.ms_static = still.wall / later, row.cpu_ms_static = still.cpu / later;
        row.ms_moving = moving.wall / later, row.cpu_ms_moving = moving.cpu / later;
        row.ms_not_kept = fresh.wall / later, row.cpu_ms_not_kept = fresh.cpu / later;
        row.ms_repair = repair.wall / later, row.cpu_ms_repair = repair.cpu / later;
        const auto a_frame = [&](std::uint64_t n) {
            return static_cast<std::uint64_t>(static_cast<double>(n) / later);
        };
        row.work = {a_frame(row.work.clusters),    a_frame(row.work.rays), a_frame(row.work.dirty_pixels),
                    a_frame(row.work.dirty_nodes), row.work.bytes,         a_frame(row.work.rays_left_out)};
        std::sort(walls.begin(), walls.end());
        row.ms_moving_median = walls[walls.size() / 2], row.ms_moving_worst = walls.back();
        if (reference_sum > 0) {
            const double count = 3 * static_cast<double>(values), mean = reference_sum / count;
            row.nrmse = std::sqrt(square / count) / mean;
            row.energy_ratio = sum / reference_sum;
            if (brute_sum > 0) row.nrmse_brute = std::sqrt(brute_square / count) / (brute_sum / count);
            if (flickering > 0) {
                const double all = static_cast<double>(flickering) * mean;
                row.flicker = flicker / all, row.flicker_floor = floor / all;
            }
            if (options_.view_steps > 0 && info.walks) row.view_change = walk(*method, world, image, mean);
        }

        // Time the construction in the last frame.
        std::unique_ptr<IndirectMethod> again;
        Times rebuilt = time_of([&] { again = info.make_for(world.state, world.rays, tasks_); });
        if (const IndirectTimes* own = again->own_times()) rebuilt = {own->made.wall, own->made.cpu};
        row.ms_rebuild = rebuilt.wall, row.cpu_ms_rebuild = rebuilt.cpu;
        return row;
    }

    // Measures how much irradiance changes while only the view moves, around the scene's centre and forward.
    Change walk(IndirectMethod& method, World& world, SeenImage& image, double mean)
    {
        // Choose the points and find the largest distance seen.
        const scene::View start = world.view();
        see_image(world.state, world.rays, start, 0, tasks_, image);
        const PointGrid grid = grid_of(image, world.rays, options_.grid);
        float distance = 0;
        for (const SeenPoint& seen : image.points)
            if (seen.point.object != scene::none)
                distance = std::max(distance, glm::length(seen.point.position - start.eye));

        // Step along the camera path, and compare points that two successive views show.
        Change change;
        std::size_t count = 0;
        std::vector<glm::vec3> before(grid.points.size()), light(image.points.size());
        std::vector<std::uint8_t> known(grid.points.size(), 0);
        for (int step = 0; step <= options_.view_steps; ++step) {
            scene::View view = scene::turned(start, world.rays.bounds().centre(), step * options_.view_turn);
            view.eye += static_cast<float>(step * options_.view_zoom) * distance * view.forward;
            world.state.advance(world.state.time());
            world.rays.update(world.state);
            see_image(world.state, world.rays, view, method.grid_step(options_.size), tasks_, image);
            method.begin_frame(world.state, world.rays, tasks_);
            method.light(image, tasks_, light.data());
            std::vector<std::size_t> seen;
            const auto again = find_again(*scene_, world.rays, view, grid.points, seen);
            std::vector<glm::vec3> now(again.size());
            method.sample(again, now.data());
            method.end_frame();
            std::vector<std::uint8_t> known_now(known.size(), 0);
            for (std::size_t k = 0; k < seen.size(); ++k) {
                const std::size_t i = seen[k];
                if (known[i]) {
                    const double by = change_of(now[k] - before[i]) / mean;
                    change.mean += by, change.largest = std::max(change.largest, by);
                    ++count;
                }
                before[i] = now[k], known_now[i] = 1;
            }
            known = known_now;
        }
        if (count > 0) change.mean /= static_cast<double>(count);
        return change;
    }

    std::shared_ptr<const scene::Scene> scene_;
    const IndirectBenchOptions& options_;
    Progress progress_;
    Tasks tasks_;
    ReferenceCache cache_;
    std::vector<Judged> judged_;
    int references_ = 0;
    IndirectBenchResult result_;
};

}   // namespace

IndirectBenchResult bench_indirect(const std::shared_ptr<const scene::Scene>& scene,
                                   const IndirectBenchOptions& options, const Progress& progress,
                                   const std::function<void(const IndirectRow&)>& on_row)
{
    return Bench(scene, options, progress).run(on_row);
}

}   // namespace gnomon::bench
