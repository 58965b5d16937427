// SPDX-License-Identifier: Apache-2.0
#pragma once
// Parallel loops on oneTBB, in an arena of a chosen number of threads.
//
// Results never depend on the number of threads: a task writes only what its index owns, and sums are made afterwards
// in index order.

#include <cstddef>
#include <functional>
#include <memory>

namespace gnomon {

/// A bounded set of worker threads.
class Tasks {
 public:
    /// @param threads  how many, the caller's included; 0: all the machine has
    explicit Tasks(int threads = 0);
    ~Tasks();
    Tasks(const Tasks&) = delete;
    Tasks& operator=(const Tasks&) = delete;

    int threads() const { return threads_; }

    /// Runs body(i, worker) once for every i below count, in any order; worker is in 0 ... threads()-1 and no two
    /// bodies run with the same worker at once. With one thread: on the caller's thread, in order.
    /// @throws what a body throws (one of them)
    void for_each(std::size_t count, const std::function<void(std::size_t index, int worker)>& body);

 private:
    struct Arena;
    std::unique_ptr<Arena> arena_;
    int threads_;
};

}   // namespace gnomon
