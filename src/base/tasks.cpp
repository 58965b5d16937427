// SPDX-License-Identifier: Apache-2.0
#include "base/tasks.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <vector>

#include "base/interruption.h"

#if defined(GNOMON_THREAD_SANITIZER)
#include <sanitizer/tsan_interface.h>
#endif

namespace gnomon {

namespace {

// Declares happens-before edges to ThreadSanitizer, which cannot see them because oneTBB is built without it. In its
// builds, the templates of oneTBB in this file are not instrumented either; this class declares only the order that
// for_each promises. In other builds it does nothing.
class Order {
 public:
#if defined(GNOMON_THREAD_SANITIZER)
    // All that a thread did before leave() happens before what another thread does after a later enter().
    void leave()
    {
        __tsan_release(this);
    }
    void enter()
    {
        __tsan_acquire(this);
    }
#else
    void leave() {}
    void enter() {}
#endif
};

// A loop: the caller's code happens before all bodies, and all bodies before what follows. Bodies of different
// workers are unordered.
struct Loop {
    Order begin, end;
    Loop() { begin.leave(); }
    ~Loop() { end.enter(); }
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;
};

// One run of a body, which may throw.
class Turn {
 public:
    Turn(Loop& loop, Order& worker) : loop_(loop), worker_(worker)
    {
        loop_.begin.enter();
        worker_.enter();
    }
    ~Turn()
    {
        worker_.leave();
        loop_.end.leave();
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

 private:
    Loop& loop_;
    Order& worker_;
};

}   // namespace

struct Tasks::Arena {
    explicit Arena(int threads)
        : control(tbb::global_control::max_allowed_parallelism,
                  static_cast<std::size_t>(std::max(threads, tbb::info::default_concurrency()))),
          arena(threads),
          turns(static_cast<std::size_t>(threads))
    {
    }
    // Allow more threads than processors; tests of thread-independence need that.
    tbb::global_control control;
    tbb::task_arena arena;
    std::vector<Order> turns;   // by worker; orders the bodies of a worker, which may run on different threads
};

Tasks::Tasks(int threads) : threads_(threads > 0 ? threads : tbb::info::default_concurrency())
{
    if (threads_ > 1) arena_ = std::make_unique<Arena>(threads_);
}

Tasks& Tasks::operator=(Tasks&&) noexcept = default;
Tasks::~Tasks() = default;

void Tasks::for_each(std::size_t count, const std::function<void(std::size_t, int)>& body)
{
    if (!arena_) {
        for (std::size_t i = 0; i < count; ++i) {
            interruption_point();
            body(i, 0);
        }
        return;
    }
    Interruption* const interruption = Interruption::current();
    Loop loop;
    const auto run = [&](std::size_t i, int worker) {
        const Turn turn(loop, arena_->turns[static_cast<std::size_t>(worker)]);
        const InterruptionScope scope(interruption);
        interruption_point();
        body(i, worker);
    };
    arena_->arena.execute([&] {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, count, 1),
            [&](const tbb::blocked_range<std::size_t>& range) {
                for (std::size_t i = range.begin(); i != range.end(); ++i)
                    run(i, tbb::this_task_arena::current_thread_index());
            },
            tbb::simple_partitioner());
    });
}

}   // namespace gnomon
