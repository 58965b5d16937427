// SPDX-License-Identifier: Apache-2.0
#pragma once
// Cancellation of long work, and its progress.
//
// The caller of long work makes an Interruption and, with an InterruptionScope, makes it the current one of its thread.
// Tasks::for_each() passes it on to the threads that run its bodies. Loops call interruption_point(), which throws
// InterruptedError once the work is to stop: because request() was called, from any thread, or because the progress
// callback returned false or threw. So no function in between needs an argument for it. Without a current Interruption,
// interruption_point() does nothing.
//
// An Interruption also stops when the one that was current when it was made stops.
//
// Cost: interruption_point() reads a flag and a clock: about 30 ns, once per loop of some tens of microseconds.

#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <optional>
#include <string_view>

#include "gnomon/types.h"

namespace gnomon {

class Interruption {
 public:
    /// @param progress  called every k_interval and whenever a stage reports, from any of the threads that work, never
    ///                  from two at once; may be empty
    explicit Interruption(Progress progress = {});
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    /// Asks the work to stop. Thread-safe.
    void request() noexcept { requested_.store(true, std::memory_order_relaxed); }
    /// Whether the work is to stop. Calls the progress callback if it is due. Thread-safe.
    bool requested() noexcept;
    /// Calls the progress callback. Thread-safe.
    /// @param stage  a string literal
    /// @param done   0 to 1; within a stage, the largest value so far is passed on
    void report(std::string_view stage, double done) noexcept;
    /// Throws what the progress callback threw, else InterruptedError.
    [[noreturn]] void raise();

    /// The interruption of this thread's work; null if there is none.
    static Interruption* current() noexcept;

    /// Longest time between two calls of the progress callback, as long as interruption points are passed.
    static constexpr std::chrono::milliseconds k_interval{2};

 private:
    using Clock = std::chrono::steady_clock;
    bool is_due() const noexcept;
    void call() noexcept;

    const Progress progress_;
    Interruption* const outer_;
    std::atomic<bool> requested_ = false;
    std::atomic<Clock::rep> called_;   // when the callback was called last
    std::mutex mutex_;                 // of all that follows
    ProgressStep step_{"preparing", 0};
    std::exception_ptr failure_;
};

/// Makes an interruption the current one of this thread, as long as the scope lasts.
class InterruptionScope {
 public:
    /// @param interruption  null: the work of this scope cannot be stopped
    explicit InterruptionScope(Interruption* interruption) noexcept;
    ~InterruptionScope();
    InterruptionScope(const InterruptionScope&) = delete;
    InterruptionScope& operator=(const InterruptionScope&) = delete;

 private:
    Interruption* const before_;
};

/// Lets the current work of this thread go on for a while after it is asked to stop, as long as the scope lasts: for
/// work that is short, and that costs more to undo than to finish. What it reports is not passed on.
class InterruptionGrace {
 public:
    /// @param most  from the request on; then the work stops
    explicit InterruptionGrace(std::chrono::milliseconds most);

 private:
    std::optional<Interruption> own_;   // none: nothing can stop the work
    std::optional<InterruptionScope> scope_;
};

/// @throws InterruptedError, or what the progress callback threw: the current work is to stop
inline void interruption_point()
{
    if (Interruption* const current = Interruption::current(); current && current->requested()) current->raise();
}

/// Reports progress to the current interruption, and stops where it asks to.
/// @throws as interruption_point()
void report_progress(std::string_view stage, double done);

}   // namespace gnomon
