// SPDX-License-Identifier: Apache-2.0
#include "base/tasks.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace gnomon {

struct Tasks::Arena {
    explicit Arena(int threads)
        : control(tbb::global_control::max_allowed_parallelism,
                  static_cast<std::size_t>(std::max(threads, tbb::info::default_concurrency()))),
          arena(threads)
    {
    }
    // More threads than processors may be asked for: tests of thread-independence do.
    tbb::global_control control;
    tbb::task_arena arena;
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
    arena_->arena.execute([&] {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, count, 1),
            [&](const tbb::blocked_range<std::size_t>& range) {
                for (std::size_t i = range.begin(); i != range.end(); ++i)
                    body(i, tbb::this_task_arena::current_thread_index());
            },
            tbb::simple_partitioner());
    });
}

}   // namespace gnomon
