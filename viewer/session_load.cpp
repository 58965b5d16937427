// SPDX-License-Identifier: Apache-2.0
// The session's thread that loads scenes.
#include <utility>

#include "gnomon/error.h"
#include "viewer/session.h"

namespace gnomon::viewer {

namespace {

std::filesystem::file_time_type time_of_file(const std::string& what)
{
    std::error_code error;
    const auto time = std::filesystem::last_write_time(what, error);
    return error ? std::filesystem::file_time_type{} : time;
}

}   // namespace

void ViewSession::load(const SceneRecipe& recipe)
{
    const std::lock_guard lock(mutex_);
    wanted_ = recipe;
    state_.loading = true;
    state_.file = recipe.what;
    state_.stage = "loading";
    state_.done = 0;
    state_.error.clear();
    state_.trouble = nullptr;
    to_load_.notify_one();
}

void ViewSession::load_loop(const std::stop_token& stop)
{
    for (;;) {
        SceneRecipe recipe;
        {
            std::unique_lock lock(mutex_);
            if (!to_load_.wait(lock, stop, [&] { return wanted_.has_value(); })) return;
            recipe = *wanted_;
            wanted_.reset();
        }
        const auto overtaken = [&] {
            const std::lock_guard lock(mutex_);
            return stop.stop_requested() || wanted_;
        };
        const Progress progress = [&](const ProgressStep& step) {
            const std::lock_guard lock(mutex_);
            state_.stage = step.stage;
            state_.done = step.done;
            tell();
            return !stop.stop_requested() && !wanted_;
        };
        std::string error;
        std::exception_ptr trouble;
        try {
            const auto time = time_of_file(recipe.what);
            const LoadOptions options{.progress = progress,
                                      .threads = threads_,
                                      .strict = recipe.strict,
                                      .animation = recipe.animation,
                                      .ground = recipe.ground,
                                      .variant = recipe.variant,
                                      .memory = recipe.memory};
            const bool same = loaded_options_.strict == options.strict && loaded_options_.memory == options.memory &&
                              loaded_options_.animation == options.animation &&
                              loaded_options_.ground == options.ground && loaded_options_.variant == options.variant;
            if (!loaded_ || loaded_file_ != recipe.what || loaded_time_ != time || !same) {
                loaded_ = gnomon::load(recipe.what, options);
                loaded_file_ = recipe.what;
                loaded_options_ = options;
                loaded_options_.progress = {};
                loaded_time_ = time;
            }
            Scene made = *loaded_;
            if (recipe.fps > 0) made = made.at_rate(recipe.fps);
            if (!recipe.light_specs.empty()) made = made.with_light_specs(recipe.light_specs);
            if (recipe.lights) made = made.with_lights(*recipe.lights);
            if (!recipe.environment.empty()) made = made.with_environment(recipe.environment);
            const std::lock_guard lock(mutex_);
            scene_ = std::make_shared<const Scene>(std::move(made));
            ++state_.loads;
        } catch (const InterruptedError&) {
            if (overtaken()) continue;
        } catch (const std::exception& e) {
            error = e.what();
            trouble = std::current_exception();
        }
        const std::lock_guard lock(mutex_);
        if (wanted_) continue;
        state_.loading = false;
        state_.error = error;
        state_.trouble = trouble;
        tell();
    }
}

}   // namespace gnomon::viewer
