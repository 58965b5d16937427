// SPDX-License-Identifier: Apache-2.0
#pragma once
// The options of `gnomon view`, which the panel may change at any time, converted to the options of the next frame.

#include "options/option_values.h"
#include "viewer/session.h"

namespace gnomon::viewer {

class ViewSettings {
 public:
    explicit ViewSettings(options::OptionValues values) : values_(std::move(values)) {}

    const options::OptionValues& values() const { return values_; }
    /// Sets an option to a value as on the command line; an empty text restores its default.
    /// @return empty, or an error message; then nothing is changed
    std::string set(const options::Option& option, const std::string& text);

    /// Of images in motion, which have no blur.
    /// @throws UsageError  if options exclude each other
    RenderOptions motion_options() const;
    /// Of images at rest and of saved ones. Where motion or lens blur them, their samples are adaptive unless their
    /// number is given, because one place of the lens for each pixel is noise.
    /// @throws UsageError  if options exclude each other
    RenderOptions render_options() const;
    /// `--exposure auto-frame`: also the frames of a recording have their own.
    bool exposure_of_each_frame() const { return values_.text("exposure") == "auto-frame"; }
    /// How to load `scene`, a file or a built-in scene, with the options of the scene.
    SceneRecipe recipe(const std::string& scene) const;

 private:
    options::OptionValues values_;
};

/// Whether images have motion blur or depth of field.
bool blurs(const RenderOptions& options);

}   // namespace gnomon::viewer
