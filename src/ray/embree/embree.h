// SPDX-License-Identifier: Apache-2.0
#pragma once
// Owning handles of Embree objects, and Embree's errors as exceptions of ours. Private to this folder, so that another
// version of Embree changes as little else as possible.

#include <embree3/rtcore.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "base/math.h"
#include "base/memory_limit.h"

namespace gnomon::ray {

/// The Embree device of a RayScene. Trees are built by one thread, so that they are reproducible; only `commit` may
/// build them. (Embree's option threads=1 would limit the whole process to one thread for the device's lifetime,
/// because it is a limit of oneTBB and not of the device.)
class EmbreeDevice {
 public:
    EmbreeDevice();
    ~EmbreeDevice();
    EmbreeDevice(const EmbreeDevice&) = delete;
    EmbreeDevice& operator=(const EmbreeDevice&) = delete;

    RTCDevice get() const { return device_; }
    std::size_t bytes() const { return bytes_; }
    /// Limits the memory of trees from now on: commit() and check() throw MissingError beyond it.
    void limit_memory(const MemoryLimit& limit) { limit_ = limit; }
    const MemoryLimit& limit() const { return limit_; }
    /// Builds or rebuilds a scene on the caller's thread alone.
    /// @throws InterruptedError  the current work was interrupted: the scene is unusable
    void commit(RTCScene scene) const;
    /// Throws the error of the last calls, if any: MissingError if memory ran out, else InternalError.
    void check() const;

 private:
    static bool count_memory(void* self, ssize_t bytes, bool post);
    static bool go_on(void* interruption, double done);
    struct Arena;
    std::unique_ptr<Arena> arena_;
    RTCDevice device_ = nullptr;
    std::atomic<std::size_t> bytes_ = 0;
    MemoryLimit limit_;
    mutable std::atomic<bool> refused_ = false;   // memory, because of the limit
};

template <class Handle, void (*release)(Handle)>
class EmbreeHandle {
 public:
    EmbreeHandle() = default;
    explicit EmbreeHandle(Handle handle) : handle_(handle) {}
    ~EmbreeHandle()
    {
        if (handle_) release(handle_);
    }
    EmbreeHandle(EmbreeHandle&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
    EmbreeHandle& operator=(EmbreeHandle&& other) noexcept
    {
        std::swap(handle_, other.handle_);
        return *this;
    }
    Handle get() const { return handle_; }

 private:
    Handle handle_ = nullptr;
};
using SceneHandle = EmbreeHandle<RTCScene, rtcReleaseScene>;
using GeometryHandle = EmbreeHandle<RTCGeometry, rtcReleaseGeometry>;

/// Mask bits of rays and geometries.
inline constexpr unsigned k_mask_seen = 1;     // for closest-hit rays
inline constexpr unsigned k_mask_blocks = 2;   // for shadow rays
inline constexpr unsigned k_mask_thins = 4;    // for rays that collect what light passes through
inline constexpr unsigned k_mask_all = k_mask_seen | k_mask_blocks | k_mask_thins;

/// A hit on a surface that thins light. Embree may report the same one several times, because its trees may hold a
/// triangle in several places.
struct ThinHit {
    unsigned ray, instance, geometry, triangle;   // Embree's ids
    glm::vec3 passes;

    auto place() const { return std::tuple(ray, instance, geometry, triangle); }
};

/// Context of a trace for filters; extends Embree's own.
///
/// Closest-hit packets are traced as coherent ones, which is twice as fast. Any-hit packets are not, because with
/// Embree's coherent traversal the result of about one ray in four million depends on the other rays of its packet, and
/// remembered shadows must equal traced ones to the bit. The incoherent traversal gave the same results in every packet
/// and for single rays (13 million rays on random soups), at 0.86 of the speed.
struct TraceContext {
    enum class Kind { closest, any };
    RTCIntersectContext embree;   // must be first: filters get a pointer to it
    bool front_only = false;
    std::vector<ThinHit>* thin = nullptr;   // takes the hits of rays with k_mask_thins

    explicit TraceContext(Kind kind, bool front = false) : front_only(front)
    {
        rtcInitIntersectContext(&embree);
        embree.flags =
            kind == Kind::closest ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    }
};

}   // namespace gnomon::ray
