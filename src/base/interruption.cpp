// SPDX-License-Identifier: Apache-2.0
#include "base/interruption.h"

#include <algorithm>
#include <utility>

#include "gnomon/error.h"

namespace gnomon {

namespace {

thread_local Interruption* t_current = nullptr;

}   // namespace

Interruption::Interruption(Progress progress)
    : progress_(std::move(progress)), outer_(t_current), called_(Clock::now().time_since_epoch().count())
{
}

Interruption* Interruption::current() noexcept
{
    return t_current;
}

bool Interruption::is_due() const noexcept
{
    return Clock::now().time_since_epoch() - Clock::duration(called_.load(std::memory_order_relaxed)) >= k_interval;
}

bool Interruption::requested() noexcept
{
    if (progress_ && !requested_.load(std::memory_order_relaxed) && is_due()) {
        // If another thread is calling, go on.
        if (const std::unique_lock lock(mutex_, std::try_to_lock); lock && is_due()) call();
    }
    if (!requested_.load(std::memory_order_relaxed) && outer_ && outer_->requested()) request();
    return requested_.load(std::memory_order_relaxed);
}

void Interruption::report(std::string_view stage, double done) noexcept
{
    if (outer_) outer_->report(stage, done);
    if (!progress_) return;
    const std::lock_guard lock(mutex_);
    step_ = {stage, stage == step_.stage ? std::max(done, step_.done) : done};
    if (!requested_.load(std::memory_order_relaxed)) call();
}

// Calls the callback, under the lock. What it does itself is not part of this work.
void Interruption::call() noexcept
{
    const InterruptionScope apart(nullptr);
    try {
        if (!progress_(step_)) request();
    } catch (...) {
        failure_ = std::current_exception();
        request();
    }
    called_.store(Clock::now().time_since_epoch().count(), std::memory_order_relaxed);
}

void Interruption::raise()
{
    std::exception_ptr failure;
    {
        const std::lock_guard lock(mutex_);
        failure = failure_;
    }
    if (failure) std::rethrow_exception(failure);
    if (outer_ && outer_->requested()) outer_->raise();
    throw InterruptedError("interrupted");
}

InterruptionScope::InterruptionScope(Interruption* interruption) noexcept
    : before_(std::exchange(t_current, interruption))
{
}

InterruptionScope::~InterruptionScope()
{
    t_current = before_;
}

InterruptionGrace::InterruptionGrace(std::chrono::milliseconds most)
{
    Interruption* const outer = Interruption::current();
    if (!outer) return;
    using Clock = std::chrono::steady_clock;
    {
        const InterruptionScope apart(nullptr);   // or a request to the outer one would stop this one at once
        own_.emplace([outer, most, since = std::optional<Clock::time_point>()](const ProgressStep&) mutable {
            if (!outer->requested()) return true;
            if (!since) since = Clock::now();
            if (Clock::now() - *since < most) return true;
            outer->raise();
        });
    }
    scope_.emplace(&*own_);
}

void report_progress(std::string_view stage, double done)
{
    Interruption* const current = Interruption::current();
    if (!current) return;
    current->report(stage, done);
    if (current->requested()) current->raise();
}

}   // namespace gnomon
