// SPDX-License-Identifier: Apache-2.0
#include "bench/indirect/reference_cache.h"

#include <fmt/format.h>

#include <fstream>

#include "base/hash.h"
#include "gnomon/error.h"
#include "io/file/atomic_file.h"
#include "video/frames_folder.h"

namespace gnomon::bench {

namespace {

// Increase it when the reference computes other values for the same points.
constexpr std::uint64_t k_version = 2;
constexpr std::uint64_t k_magic = 0x31666572676e6f6dull;   // "mongref1"

class Hash {
 public:
    template <class T>
    void add(const T& value)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        value_ = hash_bytes(&value, sizeof value, value_);
    }
    template <class T>
    void add_all(const std::vector<T>& values)
    {
        add(values.size());
        value_ = hash_span(std::span<const T>(values), value_);
    }
    std::uint64_t value() const { return value_; }

 private:
    std::uint64_t value_ = hash_bytes(nullptr, 0);
};

bool read_whole(const std::filesystem::path& file, std::vector<reference::IrradianceEstimate>& out)
{
    std::ifstream in(file, std::ios::binary);
    std::uint64_t head[2] = {};
    if (!in.read(reinterpret_cast<char*>(head), sizeof head) || head[0] != k_magic || head[1] != out.size())
        return false;
    const auto bytes = static_cast<std::streamsize>(out.size() * sizeof out[0]);
    return in.read(reinterpret_cast<char*>(out.data()), bytes) && in.peek() == std::ifstream::traits_type::eof();
}

}   // namespace

ReferenceCache::ReferenceCache(const std::filesystem::path& folder, const scene::Scene& scene)
    : folder_(folder), scene_hash_(video::fingerprint_of(scene))
{
    if (folder_.empty()) return;
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error) throw MissingError(fmt::format("cannot create the folder {}: {}", folder_.string(), error.message()));
}

std::vector<reference::IrradianceEstimate> ReferenceCache::irradiance(const scene::SceneState& state,
                                                                      const ray::RayScene& rays,
                                                                      std::span<const FixedPoint> points,
                                                                      const reference::ReferenceOptions& options,
                                                                      Tasks& tasks, const Progress& progress)
{
    const scene::Scene& scene = state.scene();
    std::vector<reference::IrradiancePoint> places;
    for (const FixedPoint& point : points) places.push_back(place_of(scene, rays, point));

    // Hash everything that the values depend on.
    Hash hash;
    hash.add(k_version), hash.add(scene_hash_);
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o)
        hash.add(state.object_matrix(o)), hash.add(state.object_visible(o));
    hash.add(state.time());
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const scene::LightState& at = state.light(static_cast<scene::LightId>(l));
        hash.add(at.position), hash.add(at.direction), hash.add(at.visible);
    }
    hash.add(scene.background.kind), hash.add(options.surroundings);
    hash.add(options.samples), hash.add(options.bounces), hash.add(options.seed);
    hash.add(options.shining), hash.add(options.shining_unbounced);
    for (const reference::IrradiancePoint& p : places)
        hash.add(p.position), hash.add(p.normal), hash.add(p.geometric_normal), hash.add(p.offset), hash.add(p.key),
            hash.add(p.smooth_normal), hash.add(p.smooth_origin);

    // Read the file of that name, or compute the values and write it.
    const std::filesystem::path file = folder_ / fmt::format("{:016x}.reference", hash.value());
    std::vector<reference::IrradianceEstimate> result(points.size());
    if (!folder_.empty() && read_whole(file, result)) {
        ++found_;
        return result;
    }
    result = reference::reference_irradiance(state, rays, places, options, tasks, nullptr, progress);
    ++computed_;
    if (!folder_.empty()) {
        io::AtomicFile out(file);
        const std::uint64_t head[2] = {k_magic, result.size()};
        out.write(head, sizeof head);
        out.write(result.data(), result.size() * sizeof result[0]);
        out.commit();
    }
    return result;
}

}   // namespace gnomon::bench
