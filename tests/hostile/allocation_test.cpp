// SPDX-License-Identifier: Apache-2.0
// Failing allocations while a file is read or a frame rendered: an operator new refuses each allocation in turn. The
// result is std::bad_alloc (the program reports "out of memory", exit code 4), nothing leaks (under AddressSanitizer),
// no thread waits for another that gave up, and the next file or frame is complete.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <new>

#include "cli/program.h"
#include "cli/signals.h"
#include "fuzz/targets.h"
#include "gnomon/error.h"
#include "gnomon/renderer.h"
#include "image_bytes.h"
#include "io/image/image_file.h"
#include "sanitized.h"

namespace {
// The number of allocations until one fails; 0 or less: none fails.
std::atomic<long> g_allocations_left{0};

void* allocate(std::size_t size, std::size_t alignment = 0) noexcept
{
    if (g_allocations_left.load(std::memory_order_relaxed) > 0 && g_allocations_left.fetch_sub(1) == 1) return nullptr;
    if (size == 0) size = 1;
    return alignment == 0 ? std::malloc(size)
                          : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

void* allocate_or_throw(std::size_t size, std::size_t alignment = 0)
{
    void* memory = allocate(size, alignment);
    if (!memory) throw std::bad_alloc();
    return memory;
}

// Never inlined: the compiler would warn about a free() that does not match the new above.
[[gnu::noinline]] void give_back(void* memory) noexcept
{
    std::free(memory);
}
}   // namespace

// clang-format off
void* operator new(std::size_t size) { return allocate_or_throw(size); }
void* operator new[](std::size_t size) { return allocate_or_throw(size); }
void* operator new(std::size_t size, std::align_val_t at) { return allocate_or_throw(size, static_cast<std::size_t>(at)); }
void* operator new[](std::size_t size, std::align_val_t at) { return allocate_or_throw(size, static_cast<std::size_t>(at)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return allocate(size); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return allocate(size); }
void operator delete(void* memory) noexcept { give_back(memory); }
void operator delete[](void* memory) noexcept { give_back(memory); }
void operator delete(void* memory, std::size_t) noexcept { give_back(memory); }
void operator delete[](void* memory, std::size_t) noexcept { give_back(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { give_back(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { give_back(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { give_back(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { give_back(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { give_back(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { give_back(memory); }
// clang-format on

namespace gnomon::fuzz {
namespace {

// The first hundreds one by one; after them, where the elements of large files are, in growing steps.
constexpr long k_each = 400;

long after(long n)
{
    return n + (n < k_each ? 1 : n / 40);
}

// Shared by a child and its parent.
struct Shared {
    long at = 0;   // the allocation that fails
    bool done = false;
    long out_of_memory = 0, spared = 0;
    char fault[200] = "";
};

// Makes one allocation after the other fail while a seed is read, until the reading needs no further allocation.
void fail_each(const Target& target, const Bytes& seed, Shared& shared)
{
    target.run(seed);   // first run: libraries allocate what they keep
    for (;; shared.at = after(shared.at)) {
        std::string outcome;
        bool thrown = false;
        g_allocations_left = shared.at;
        try {
            outcome = target.run(seed);
        } catch (const std::bad_alloc&) {
            thrown = true;
        } catch (const std::exception& error) {
            g_allocations_left = 0;
            std::snprintf(shared.fault, sizeof shared.fault, "%s", error.what());
        }
        shared.done = g_allocations_left.exchange(0) > 0;
        if (!outcome.empty()) std::snprintf(shared.fault, sizeof shared.fault, "%s", outcome.c_str());
        if (shared.done || shared.fault[0]) break;
        ++(thrown ? shared.out_of_memory : shared.spared);
    }
    const std::string again = target.run(seed);
    if (!again.empty()) std::snprintf(shared.fault, sizeof shared.fault, "afterwards: %s", again.c_str());
}

// Runs failing allocations in one child process after the other: a failure in a destructor ends its child.
class Children {
 public:
    Children() : memory_(::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))
    {
        if (memory_ == MAP_FAILED) throw std::bad_alloc();
        new (memory_) Shared;
    }
    ~Children() { ::munmap(memory_, sizeof(Shared)); }
    Children(const Children&) = delete;
    Children& operator=(const Children&) = delete;

    Shared& shared() const { return *static_cast<Shared*>(memory_); }
    /// @param work  runs in the child until it is done; starts at the current allocation
    /// @param next  the allocation at which the next child starts, after the one that ended a child
    void run(const std::function<void()>& work, const std::function<long(long)>& next)
    {
        Shared& shared = this->shared();
        shared.at = 1, shared.done = false;
        while (!shared.done) {
            std::fflush(nullptr);
            const pid_t child = ::fork();
            if (child == 0) {
                cli::install_terminate_handler();
                ::dup2(::open("/dev/null", O_WRONLY), STDERR_FILENO);
                work();
                ::_exit(0);
            }
            int status = 0;
            ::waitpid(child, &status, 0);
            ASSERT_STREQ(shared.fault, "") << "allocation " << shared.at;
            ASSERT_TRUE(WIFEXITED(status)) << "allocation " << shared.at << ": signal " << WTERMSIG(status);
            if (WEXITSTATUS(status) == 0) continue;
            ASSERT_EQ(WEXITSTATUS(status), cli::k_exit_missing) << "allocation " << shared.at;
            ++ended_;
            shared.at = next(shared.at);
        }
    }
    void tell() const
    {
        std::printf(
            "%ld allocations failed and were out of memory, %ld of them in a destructor; %ld could be done without\n",
            shared().out_of_memory + ended_, ended_, shared().spared);
    }

 private:
    void* memory_;
    long ended_ = 0;
};

class FailingAllocations : public testing::TestWithParam<Target> {};

// In a child, because some libraries allocate in destructors: then the program ends, with the same code and message.
TEST_P(FailingAllocations, ReadersReportOutOfMemory)
{
    Children children;
    for (const Bytes& seed : GetParam().seeds()) {
        children.run([&] { fail_each(GetParam(), seed, children.shared()); }, after);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(children.shared().out_of_memory, 3);
    children.tell();
}

INSTANTIATE_TEST_SUITE_P(Each, FailingAllocations, testing::ValuesIn(targets().begin(), targets().end()),
                         [](const auto& chosen) { return std::string(chosen.param.name); });

// A frame with dynamic objects, certified culling and indirect light, on several threads that wait for each other.
class Frames {
 public:
    Frames() : whole_(Renderer(k_options).render(scene_, k_frame).layers[0].copy()) {}

    /// @return the number of allocations until one failed, or until the frame was complete
    long render_with_allocations(long left, Shared& shared)
    {
        Renderer renderer(k_options);
        renderer.render(scene_, k_frame - 1);
        bool thrown = true;
        g_allocations_left = left;
        try {
            renderer.render(scene_, k_frame);
            thrown = false;
        } catch (const std::bad_alloc&) {
        } catch (const MissingError&) {   // Embree's
        } catch (const std::exception& error) {
            g_allocations_left = 0;
            std::snprintf(shared.fault, sizeof shared.fault, "%s", error.what());
        }
        const long unused = g_allocations_left.exchange(0);
        if (unused <= 0) ++(thrown ? shared.out_of_memory : shared.spared);
        if (renderer.render(scene_, k_frame).layers[0].copy() != whole_)
            std::snprintf(shared.fault, sizeof shared.fault, "the next frame is another");
        return left - std::max(unused, 0L);
    }

 private:
    static constexpr int k_frame = 12;
    inline static const RenderOptions k_options{.size = {64, 48}, .threads = 3};
    Scene scene_ = load("builtin:cornell");
    std::vector<float> whole_;
};

TEST(FailingRenderAllocations, EndTheFrameAndTheNextIsComplete)
{
    constexpr int k_tries = 30, k_seconds = 120 * test::k_patience;
    Children children;
    Shared& shared = children.shared();
    children.run(
        [&] {
            Frames frames;
            const long all = frames.render_with_allocations(std::numeric_limits<long>::max(), shared);
            const long step = std::max(all / k_tries, 1L);
            while (shared.at < all && !shared.fault[0]) {
                shared.at += step;
                ::alarm(k_seconds);   // ends a deadlock by a signal
                frames.render_with_allocations(shared.at, shared);
            }
            shared.done = true;
        },
        [](long at) { return at; });
    if (HasFatalFailure()) return;
    EXPECT_GT(shared.out_of_memory, k_tries / 4);
    children.tell();
}

// The C libraries do not allocate with operator new: if their memory is not freed, the process grows.
TEST(FailingImageAllocations, CLibrariesFreeTheirMemory)
{
    constexpr int side = 1024, k_tries = 20;
    const std::vector<std::uint8_t> row(side, 77);
    for (const auto& [what, bytes] : {std::pair("JPEG", test::jpeg_bytes({side, side, JCS_GRAYSCALE, 1, true}, row)),
                                      std::pair("PNG", test::png_bytes({side, side, 8, PNG_COLOR_TYPE_GRAY}, {row}))}) {
        const auto held = [] {
            const struct mallinfo2 info = ::mallinfo2();
            return info.uordblks + info.hblkhd;
        };
        const std::size_t before = held();
        int refused = 0;
        for (int i = 0; i < k_tries; ++i) {
            g_allocations_left = 1;
            try {
                io::decode_image(bytes, what);
            } catch (const std::bad_alloc&) {
                ++refused;
            }
            g_allocations_left = 0;
        }
        EXPECT_EQ(refused, k_tries) << what;
        EXPECT_LT(held(), before + (100 << 10)) << what;
    }
}

}   // namespace
}   // namespace gnomon::fuzz
