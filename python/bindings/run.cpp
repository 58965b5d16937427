// SPDX-License-Identifier: Apache-2.0
#include "python/bindings/run.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "gnomon/error.h"

namespace gnomon::python {

namespace {

constexpr std::chrono::milliseconds k_signal_interval{10};   // between two looks for signals
constexpr std::chrono::seconds k_longest_end{10};            // that the end of the interpreter waits for work to stop

// The thread that works for the main thread.
class Worker {
 public:
    Worker()
    {
        std::thread([this] { serve(); }).detach();
    }

    /// Starts a job, which must not throw.
    void start(std::function<void()> job)
    {
        const std::lock_guard lock(mutex_);
        job_ = std::move(job);
        changed_.notify_all();
    }
    /// Waits until the job has ended, or the time is over. Returns whether it has ended.
    bool wait(std::chrono::milliseconds longest)
    {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, longest, [this] { return !job_; });
    }

 private:
    [[noreturn]] void serve()
    {
        std::unique_lock lock(mutex_);
        for (;;) {
            changed_.wait(lock, [this] { return static_cast<bool>(job_); });
            lock.unlock();
            job_();
            lock.lock();
            job_ = nullptr;
            changed_.notify_all();
        }
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    std::function<void()> job_;
};

// Of the process; the global lock guards what is not atomic. The worker is never destroyed, because its thread may wait
// in it until the process ends.
struct Runs {
    unsigned long main_thread = 0;
    pid_t process = 0;   // in which work ran first; 0: none did
    Worker* worker = nullptr;
    bool worker_is_busy = false;
    std::atomic<int> active{0};
    std::atomic<bool> closing{false};
};
Runs& runs()
{
    static Runs& all = *new Runs;
    return all;
}

// One piece of work.
struct Run {
    const py::object& callback;
    std::atomic<bool> stop{false};
    std::optional<py::error_already_set> raised{};   // under the global lock
    std::exception_ptr thrown{};

    bool report(const ProgressStep& step)
    {
        if (stop || runs().closing) return false;
        if (callback.is_none()) return true;
        const py::gil_scoped_acquire locked;
        try {
            const py::object answer = callback(py::str(step.stage.data(), step.stage.size()), step.done);
            if (!answer.is(py::bool_(false))) return true;
        } catch (py::error_already_set& error) {
            if (!raised) raised.emplace(std::move(error));
        }
        stop = true;
        return false;
    }
    void work(const std::function<void(const Progress&)>& job)
    {
        try {
            job([this](const ProgressStep& step) { return report(step); });
        } catch (...) {
            thrown = std::current_exception();
        }
    }
};

// The main thread's part while the worker runs.
void watch_signals(Run& run, Worker& worker, const std::function<void()>& cancel)
{
    while (!worker.wait(k_signal_interval)) {
        const py::gil_scoped_acquire locked;
        if (run.stop || PyErr_CheckSignals() == 0) continue;
        run.raised.emplace();
        run.stop = true;
        if (cancel) cancel();
    }
}

// Stops what daemon threads still run, and waits for it: a thread must not find the interpreter gone when it returns.
void close()
{
    runs().closing = true;
    const py::gil_scoped_release unlocked;
    const auto last = std::chrono::steady_clock::now() + k_longest_end;
    while (runs().active > 0 && std::chrono::steady_clock::now() < last)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

struct Counted {
    Counted() { ++runs().active; }
    ~Counted() { --runs().active; }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
};

}   // namespace

void prepare_runs()
{
    runs().main_thread = py::module_::import("threading").attr("main_thread")().attr("ident").cast<unsigned long>();
    py::module_::import("atexit").attr("register")(py::cpp_function(close));
}

void run(const py::object& callback, const std::function<void()>& cancel,
         const std::function<void(const Progress&)>& work)
{
    Runs& all = runs();
    if (!callback.is_none() && !PyCallable_Check(callback.ptr()))
        throw py::type_error("progress must be callable: progress(stage, done)");
    if (all.closing) throw UsageError("the interpreter is ending");
    if (all.process != 0 && all.process != getpid())
        throw UsageError(
            "this process was forked from one in which Gnomon had worked, and lacks its threads: start it by "
            "multiprocessing's method 'spawn' or 'forkserver'");
    all.process = getpid();

    const Counted counted;
    Run run{callback};
    if (PyThread_get_thread_ident() == all.main_thread && !all.worker_is_busy) {
        if (!all.worker) all.worker = new Worker;
        all.worker_is_busy = true;
        {
            const py::gil_scoped_release unlocked;
            all.worker->start([&] { run.work(work); });
            watch_signals(run, *all.worker, cancel);
        }
        all.worker_is_busy = false;
    } else {
        const py::gil_scoped_release unlocked;
        run.work(work);
    }
    if (run.raised) throw py::error_already_set(std::move(*run.raised));
    if (run.thrown) std::rethrow_exception(run.thrown);
}

}   // namespace gnomon::python
