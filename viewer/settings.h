// SPDX-License-Identifier: Apache-2.0
#pragma once
// The options of `view`, live: values of the option table that the panel may change at any time, and what they mean for
// the next frame.

#include "options/option_values.h"
#include "viewer/session.h"

namespace gnomon::viewer {

class ViewSettings {
 public:
    explicit ViewSettings(options::OptionValues values) : values_(std::move(values)) {}

    const options::OptionValues& values() const { return values_; }
    /// As on the command line; an empty text takes the option back to its default.
    /// @return what is wrong with it, and then nothing changed; else empty
    std::string set(const options::Option& option, const std::string& text);

    /// @throws UsageError  for options that exclude each other
    RenderOptions render_options() const;
    SceneRecipe recipe(const std::string& what) const;

 private:
    options::OptionValues values_;
};

}   // namespace gnomon::viewer
