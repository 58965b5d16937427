// SPDX-License-Identifier: Apache-2.0
// The options of a renderer, to and from Python's dataclass RenderOptions.
#include "python/bindings/parts.h"

namespace gnomon::python {

namespace {

constexpr const char* k_all = "all";
constexpr const char* k_auto = "auto";

// Fields that are numbers, or a word for one of them.
struct NumberOrWord {
    int number;
    const char* word;
};
constexpr NumberOrWord k_bounces{k_all_bounces, k_all};
constexpr NumberOrWord k_samples{k_adaptive_samples, k_auto};

// A camera's name or its number.
struct NameOrNumber {};

struct OptionReader : FieldReader {
    using FieldReader::operator();
    void operator()(const char* name, std::string& member, NameOrNumber) const
    {
        const py::object value = from.attr(name);
        if (py::isinstance<py::int_>(value))
            member = py::str(value).cast<std::string>();
        else
            (*this)(name, member);
    }
    void operator()(const char* name, int& member, const NumberOrWord& word) const
    {
        const py::object value = from.attr(name);
        if (py::isinstance<py::str>(value) && value.cast<std::string>() == word.word)
            member = word.number;
        else
            (*this)(name, member);
    }
};

struct OptionWriter : FieldWriter {
    using FieldWriter::operator();
    void operator()(const char* name, const std::string& member, NameOrNumber) const { into[name] = write(member); }
    void operator()(const char* name, int member, const NumberOrWord& word) const
    {
        into[name] = member == word.number ? py::object(py::str(word.word)) : write(member);
    }
};

template <class M, class Visit>
void visit_options(M& m, const Visit& visit)
{
    visit("size", m.size);
    visit("camera", m.camera, NameOrNumber{});
    visit("turntable_seconds", m.turntable_seconds);
    visit("renderer", m.renderer);
    visit("max_depth", m.max_depth);
    visit("samples", m.samples, k_samples);
    visit("filter", m.filter);
    visit("shutter", m.shutter);
    visit("f_number", m.f_number);
    visit("aperture", m.aperture);
    visit("focus", m.focus);
    visit("exposure", m.exposure);
    visit("tonemap", m.tonemap);
    visit("background", m.background);
    visit("background_color", m.background_color);
    visit("shadow_culling", m.shadow_culling);
    visit("indirect", m.indirect);
    visit("shadow_textures", m.shadow_textures);
    visit("sun_size", m.sun_size);
    visit("shadow_filter", m.shadow_filter);
    visit("as_printed", m.as_printed);
    visit("bounces", m.bounces, k_bounces);
    visit("reference", m.reference);
    visit("rsm_samples", m.rsm_samples);
    visit("indirect_level", m.indirect_level);
    visit("depth_threshold", m.depth_threshold);
    visit("normal_threshold", m.normal_threshold);
    visit("validity_margin", m.validity_margin);
    visit("separate_trees", m.separate_trees);
    visit("cluster_shadows", m.cluster_shadows);
    visit("indirect_at_every_pixel", m.indirect_at_every_pixel);
    visit("indirect_memory", m.indirect_memory);
    visit("indirect_on", m.indirect_on);
    visit("accelerator", m.accelerator);
    visit("arithmetic", m.arithmetic);
    visit("threads", m.threads);
    visit("memory", m.memory);
    visit("layers", m.layers);
    visit("ids", m.ids);
    visit("motion", m.motion);
    visit("report_changes", m.report_changes);
    visit("overlay", m.overlay);
    visit("overlay_light", m.overlay_light);
    visit("interactive", m.interactive);
    visit("keep_image", m.keep_image);
}

template <class M, class Visit>
void visit_reference(M& m, const Visit& visit)
{
    visit("spp", m.spp);
    visit("bounces", m.bounces, k_bounces);
    visit("seed", m.seed);
}

}   // namespace

void read(py::handle from, const std::string&, ReferenceLightOptions& to)
{
    visit_reference(to, OptionReader{{from, "ReferenceLightOptions"}});
}

void read(py::handle from, const std::string&, RenderOptions& to)
{
    visit_options(to, OptionReader{{from, "RenderOptions"}});
}

py::object write(const ReferenceLightOptions& value)
{
    OptionWriter writer;
    visit_reference(value, writer);
    return make("ReferenceLightOptions", writer.into);
}

py::object write(const RenderOptions& value)
{
    OptionWriter writer;
    visit_options(value, writer);
    return make("RenderOptions", writer.into);
}

}   // namespace gnomon::python
