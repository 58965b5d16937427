// SPDX-License-Identifier: Apache-2.0
#pragma once
// The options of `view`, live: values of the option table that the panel may change at any time, and what they mean for
// the next frame.

#include "app/option_values.h"
#include "app/view/session.h"

namespace gnomon::app {

class ViewSettings {
 public:
    explicit ViewSettings(OptionValues values) : values_(std::move(values)) {}

    const OptionValues& values() const { return values_; }
    /// As on the command line; an empty text takes the option back to its default.
    /// @return what is wrong with it, and then nothing changed; else empty
    std::string set(const Option& option, const std::string& text);

    /// @throws UsageError  for options that exclude each other
    RenderOptions render_options() const;
    SceneRecipe recipe(const std::string& what) const;

 private:
    OptionValues values_;
};

}   // namespace gnomon::app
