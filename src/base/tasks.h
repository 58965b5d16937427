// SPDX-License-Identifier: Apache-2.0
#pragma once
// Parallel loops on oneTBB, in an arena of a chosen number of threads.
//
// Results must not depend on the number of threads: a task writes only data that its index owns, and sums are formed
// afterwards in index order.

#include <cstddef>
#include <functional>
#include <memory>

namespace gnomon {

/// A bounded set of worker threads.
class Tasks {
 public:
    /// @param threads  number of threads, the caller's included; 0: all of the machine
    explicit Tasks(int threads = 0);
    ~Tasks();
    Tasks(const Tasks&) = delete;
    Tasks& operator=(const Tasks&) = delete;
    Tasks& operator=(Tasks&&) noexcept;   // while no loop runs

    int threads() const { return threads_; }

    /// Runs body(i, worker) once for every i below count, in any order. worker is in 0 ... threads()-1, and no two
    /// bodies run with the same worker at the same time. With one thread, bodies run on the caller's thread, in order.
    /// The caller's Interruption is also that of the bodies; once it asks to stop, no further body begins.
    /// @throws one of the exceptions that bodies threw, or that of an interruption_point() before a body
    void for_each(std::size_t count, const std::function<void(std::size_t index, int worker)>& body);

 private:
    struct Arena;
    std::unique_ptr<Arena> arena_;
    int threads_;
};

}   // namespace gnomon
