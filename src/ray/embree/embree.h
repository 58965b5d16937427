// SPDX-License-Identifier: Apache-2.0
#pragma once
// Embree's handles with one owner each, and its errors as ours. Private to this folder: a move to another version of
// Embree should end here.

#include <embree3/rtcore.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>

namespace gnomon::ray {

/// The device all scenes share. Trees are built by one thread, so that they come out the same every time; only `commit`
/// may build them. (Embree's own option threads=1 would hold the whole process to one thread for the device's lifetime:
/// it is a limit of oneTBB's, not of the device.)
class EmbreeDevice {
 public:
    EmbreeDevice();
    ~EmbreeDevice();
    EmbreeDevice(const EmbreeDevice&) = delete;
    EmbreeDevice& operator=(const EmbreeDevice&) = delete;

    RTCDevice get() const { return device_; }
    std::size_t bytes() const { return bytes_; }
    /// Builds or rebuilds a scene on the caller's thread alone.
    void commit(RTCScene scene) const;
    /// Throws what the last calls left behind: MissingError for want of memory, else InternalError.
    void check() const;

 private:
    static bool count_memory(void* self, ssize_t bytes, bool post);
    struct Arena;
    std::unique_ptr<Arena> arena_;
    RTCDevice device_ = nullptr;
    std::atomic<std::size_t> bytes_ = 0;
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

/// Bits that rays and geometries share.
inline constexpr unsigned k_mask_seen = 1;     // met by closest-hit rays
inline constexpr unsigned k_mask_blocks = 2;   // met by shadow rays

/// What filters know of a ray, behind Embree's own context.
///
/// Closest-hit packets are traced as coherent ones, twice as fast. Any-hit packets are not: Embree's coherent traversal
/// answers about one ray in four million differently depending on which rays share its packet, and remembered shadows
/// must equal traced ones to the bit. Its other traversal gave the same answers in every packet and as single rays (13
/// million rays on random soups), at 0.86 of the speed.
struct TraceContext {
    enum class Kind { closest, any };
    RTCIntersectContext embree;   // first: filters get a pointer to it
    bool front_only = false;

    explicit TraceContext(Kind kind, bool front = false) : front_only(front)
    {
        rtcInitIntersectContext(&embree);
        embree.flags =
            kind == Kind::closest ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    }
};

}   // namespace gnomon::ray
