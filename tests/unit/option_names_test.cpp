// SPDX-License-Identifier: Apache-2.0
// Names of the public interface's choices, and the agreement of options, their defaults and ranges with the library.
#include <gtest/gtest.h>

#include <set>

#include "api/check_options.h"
#include "options/render_options.h"

namespace gnomon::options {
namespace {

// The compiler writes an enumerator by its name, and any other value as a cast: "(gnomon::ToneMap)7".
template <auto Value>
constexpr bool is_enumerator()
{
    const std::string_view text = __PRETTY_FUNCTION__;
    const std::size_t at = text.find("Value = ");
    return at != std::string_view::npos && text[at + 8] != '(';
}

template <class E, int... Values>
std::set<int> enumerators(std::integer_sequence<int, Values...>)
{
    std::set<int> found;
    ((is_enumerator<static_cast<E>(Values)>() ? void(found.insert(Values)) : void()), ...);
    return found;
}

template <class E>
class EnumNames : public testing::Test {
};
using Enums = testing::Types<RenderMethod, Accelerator, ToneMap, Overlay, ShadowCulling, ShadowTextures, Indirect,
                             IndirectOn, VideoCodec, ExrType, ExrCompression>;
TYPED_TEST_SUITE(EnumNames, Enums);

TYPED_TEST(EnumNames, EveryValueHasOneNameAndReadsBack)
{
    std::set<int> named;
    std::set<std::string_view> names;
    for (const auto& entry : k_enum_names<TypeParam>) {
        EXPECT_TRUE(named.insert(static_cast<int>(entry.value)).second) << entry.name;
        EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
        EXPECT_EQ(name_of(entry.value), entry.name);
        if (!entry.offered) continue;
        EXPECT_EQ(parse_enum<TypeParam>("option", entry.name), entry.value);
    }
    const std::set<int> all = enumerators<TypeParam>(std::make_integer_sequence<int, 32>());
    EXPECT_GE(all.size(), 2u);
    EXPECT_EQ(named, all);
}

TYPED_TEST(EnumNames, RejectsUnknownNamesAndValues)
{
    for (const char* word : {"", "nonsense", "Off", "|"})
        EXPECT_THROW(parse_enum<TypeParam>("option", word), UsageError) << word;
    EXPECT_THROW(name_of(static_cast<TypeParam>(31)), InternalError);
}

TEST(OptionNames, MessagesNameTheChoices)
{
    try {
        parse_enum<ShadowCulling>("shadow-culling", "best");
        FAIL();
    } catch (const UsageError& error) {
        EXPECT_STREQ(error.what(), "--shadow-culling best: expected off, paper or certified");
    }
    EXPECT_EQ(k_choices<ShadowTextures>, "per-caster|depth|coherent|items");
    EXPECT_THROW(parse_enum<ShadowTextures>("shadow-textures", "off"), UsageError);   // of the library alone
}

TEST(OptionNames, ChoicesOfAnotherTypeAreAnInternalError)
{
    const OptionValues values(Subcommand::render);
    EXPECT_EQ(values.choice<ToneMap>("tonemap"), ToneMap::neutral);
    EXPECT_THROW(values.choice<Indirect>("tonemap"), InternalError);
    EXPECT_THROW(values.choice<ToneMap>("samples"), InternalError);
    EXPECT_THROW(values.choice<ToneMap>("no-such-option"), InternalError);
}

// What the command line renders without any option is what the library renders by default.
TEST(OptionDefaults, AreTheLibrarys)
{
    for (const Subcommand subcommand : {Subcommand::render, Subcommand::view}) {
        const RenderOptions read = read_render_options(OptionValues(subcommand)), own;
        EXPECT_EQ(read.size, own.size);
        EXPECT_EQ(read.camera, own.camera);
        EXPECT_EQ(read.turntable_seconds, own.turntable_seconds);
        EXPECT_EQ(read.renderer, own.renderer);
        EXPECT_EQ(read.max_depth, own.max_depth);
        // Hosts, which render for windows and measurements, begin with one sample a pixel.
        EXPECT_EQ(read.samples, subcommand == Subcommand::render ? k_adaptive_samples : own.samples);
        EXPECT_EQ(read.filter, own.filter);
        EXPECT_EQ(read.exposure, own.exposure);
        EXPECT_EQ(read.tonemap, own.tonemap);
        EXPECT_EQ(read.shadow_culling, own.shadow_culling);
        EXPECT_EQ(read.indirect, own.indirect);
        EXPECT_EQ(read.shadow_textures, own.shadow_textures);
        EXPECT_EQ(read.shadow_filter, own.shadow_filter);
        EXPECT_EQ(read.rsm_samples, own.rsm_samples);
        EXPECT_EQ(read.indirect_level, own.indirect_level);
        EXPECT_EQ(read.depth_threshold, own.depth_threshold);
        EXPECT_EQ(read.normal_threshold, own.normal_threshold);
        EXPECT_EQ(read.validity_margin, own.validity_margin);
        EXPECT_EQ(read.separate_trees, own.separate_trees);
        EXPECT_EQ(read.cluster_shadows, own.cluster_shadows);
        EXPECT_EQ(read.as_printed, own.as_printed);
        EXPECT_EQ(read.indirect_at_every_pixel, own.indirect_at_every_pixel);
        EXPECT_EQ(read.indirect_memory, own.indirect_memory);
        EXPECT_EQ(read.indirect_on, own.indirect_on);
        EXPECT_EQ(read.bounces, own.bounces);
        EXPECT_EQ(read.accelerator, own.accelerator);
        EXPECT_EQ(read.memory, own.memory);
        EXPECT_EQ(read.threads, own.threads);
        EXPECT_EQ(read.overlay, own.overlay);
        EXPECT_EQ(read.overlay_light, own.overlay_light);
    }
}

std::string refusal(const RenderOptions& options)
{
    try {
        check_options(options);
        return {};
    } catch (const UsageError& error) {
        return error.what();
    }
}

TEST(OptionRanges, LibraryAndCommandLineAgree)
{
    EXPECT_EQ(refusal({}), "");
    EXPECT_EQ(refusal({.samples = 4096}), "");
    EXPECT_EQ(refusal({.samples = 4097}), "samples are out of range: 1 to 4096");
    EXPECT_EQ(refusal({.exposure = std::nan("")}), "exposure is out of range: -100 to 100 stops");
    EXPECT_EQ(refusal({.reference = ReferenceLightOptions{.spp = 0}}), "spp is out of range: 1 to 16777216");
    EXPECT_EQ(refusal({.size = {0, 5}}), "size 0x5 is out of range: 1 to 32768 a side");
    const Option* samples = find_option(Subcommand::render, "samples");
    ASSERT_TRUE(samples);
    EXPECT_EQ(samples->range.high, 4096);
    EXPECT_NO_THROW(check_value(*samples, "4096"));
    EXPECT_THROW(check_value(*samples, "4097"), UsageError);
}

}   // namespace
}   // namespace gnomon::options
