// SPDX-License-Identifier: Apache-2.0
#include "base/tasks.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <vector>

#if defined(GNOMON_THREAD_SANITIZER)
#include <sanitizer/tsan_interface.h>
#endif

namespace gnomon {

namespace {

// ThreadSanitizer sees nothing of oneTBB, which is not built with it. In its builds this file is not either, with all
// templates of oneTBB, and says itself what is ordered: no more than what for_each promises. In others it says nothing.
class Order {
 public:
#if defined(GNOMON_THREAD_SANITIZER)
    // What a thread did before it leaves comes before what another does that enters after that.
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

// One loop: the caller comes before all bodies, and after them; nothing is ordered between bodies of different workers.
struct Loop {
    Order begin, end;
    Loop() { begin.leave(); }
    ~Loop() { end.enter(); }
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;
};

// One body, which may end by throwing.
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
    // More threads than processors may be asked for: tests of thread-independence do.
    tbb::global_control control;
    tbb::task_arena arena;
    std::vector<Order> turns;   // by worker: its bodies come one after the other, on whatever threads
};

Tasks::Tasks(int threads) : threads_(threads > 0 ? threads : tbb::info::default_concurrency())
{
    if (threads_ > 1) arena_ = std::make_unique<Arena>(threads_);
}

Tasks::~Tasks() = default;

void Tasks::for_each(std::size_t count, const std::function<void(std::size_t, int)>& body)
{
    if (!arena_) {
        for (std::size_t i = 0; i < count; ++i) body(i, 0);
        return;
    }
    Loop loop;
    const auto run = [&](std::size_t i, int worker) {
        const Turn turn(loop, arena_->turns[static_cast<std::size_t>(worker)]);
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
