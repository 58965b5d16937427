// SPDX-License-Identifier: Apache-2.0
#include "options/presets.h"

#include <string_view>

namespace gnomon::options {

namespace {
struct PresetValue {
    std::string_view preset, option, value;
};
// docs/guide/videos.md states time and error of each. "good" is what the table of options has.
constexpr PresetValue k_values[] = {
    {"draft", "samples", "1"},
    {"draft", "max-depth", "4"},
    {"best", "samples", "64"},
    {"best", "filter", "blackman-harris"},
};
}   // namespace

void apply_preset(OptionValues& values)
{
    const std::string preset = values.text("preset");
    for (const PresetValue& entry : k_values)
        if (entry.preset == preset) values.set_default(entry.option, std::string(entry.value));
}

}   // namespace gnomon::options
