// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/vulkan/lookup_records.h"

#include "base/bits.h"

namespace gnomon::shadow_textures {

namespace {

shared::ViewRecord record_of(const light_views::LightView& view)
{
    const light_views::ViewProjection& p = view.projection;
    shared::ViewRecord record{};
    record.clip_from_world = p.clip_from_world;
    record.origin = p.origin, record.forward = p.forward, record.across = p.across, record.down = p.down;
    record.reach = p.reach;
    record.perspective = p.perspective ? 1 : 0;
    record.size = static_cast<std::uint32_t>(view.tile.size);
    record.page = static_cast<std::uint32_t>(view.tile.page);
    record.corner = {view.tile.x, view.tile.y};
    return record;
}

}   // namespace

LookupRecords::LookupRecords(const std::shared_ptr<vk::Device>& device, const light_views::LightViews& views)
    : view_records_(device, "light view records",
                    std::max<std::size_t>(views.views().size(), 1) * sizeof(shared::ViewRecord)),
      light_records_(device, "light records",
                     std::max<std::size_t>(views.atlas().first_tile.size(), 1) * sizeof(shared::LightRecord)),
      casts_(device, "casters", std::max<std::size_t>(views.object_count(), 1) * sizeof(std::uint32_t)),
      nothing_(device, "no shadow textures", sizeof(shared::TexturePlace))
{
}

void LookupRecords::update(vk::Commands& commands, const light_views::LightViews& views)
{
    std::vector<shared::ViewRecord> view_records;
    std::vector<shared::LightRecord> light_records;
    for (const light_views::LightView& view : views.views()) view_records.push_back(record_of(view));
    for (std::size_t l = 0; l + 1 < views.atlas().first_tile.size(); ++l) {
        const std::uint32_t first = views.atlas().first_tile[l], end = views.atlas().first_tile[l + 1];
        light_records.push_back({first, first < end && views.views()[first].shown ? end - first : 0});
    }
    std::vector<vk::Upload> uploads;
    if (!same_bits(view_records, sent_views_))
        uploads.push_back(vk::upload_of(view_records_, std::span<const shared::ViewRecord>(view_records)));
    if (!same_bits(light_records, sent_lights_))
        uploads.push_back(vk::upload_of(light_records_, std::span<const shared::LightRecord>(light_records)));
    std::vector<std::uint32_t> casts;
    if (!sent_casts_ && views.object_count() > 0) {
        for (scene::ObjectId o = 0; o < views.object_count(); ++o) casts.push_back(views.casters().casts(o) ? 1 : 0);
        uploads.push_back(vk::upload_of(casts_, std::span<const std::uint32_t>(casts)));
    }
    sent_casts_ = true;
    if (!uploads.empty()) commands.upload("light view records", uploads);
    sent_views_ = std::move(view_records);
    sent_lights_ = std::move(light_records);
}

vk::Pass& LookupRecords::declare(vk::Pass& pass, const light_views::GpuLightViews& buffers,
                                 const GpuTextures* textures) const
{
    pass.reads(buffers.depth(), vk::Use::sampled).reads(buffers.item(), vk::Use::sampled);
    declare_views(pass);
    pass.reads(places(textures), vk::Use::storage_read).reads(casts_, vk::Use::storage_read);
    if (textures) pass.reads(words(textures), vk::Use::storage_read);
    return pass;
}

void LookupRecords::bind(vk::Recorder& recorder, const light_views::GpuLightViews& buffers,
                         const GpuTextures* textures) const
{
    recorder.set("light_depth", buffers.depth(), buffers.sampler());
    recorder.set("light_item", buffers.item(), buffers.sampler());
    bind_views(recorder);
    recorder.set("Places", places(textures));
    recorder.set("Textures", words(textures));
    recorder.set("Casts", casts_);
}

vk::Pass& LookupRecords::declare_views(vk::Pass& pass) const
{
    return pass.reads(view_records_, vk::Use::storage_read).reads(light_records_, vk::Use::storage_read);
}

void LookupRecords::bind_views(vk::Recorder& recorder) const
{
    recorder.set("ViewRecords", view_records_);
    recorder.set("LightRecords", light_records_);
}

shared::LookupConstants LookupRecords::constants(glm::uvec2 size, const light_views::LightViews& views,
                                                 const GpuTextures* textures, const LookupOptions& options)
{
    return {size,
            options.filter,
            options.self_margin,
            options.other_margin,
            static_cast<float>(views.options().projection.border),
            static_cast<std::uint32_t>(views.object_count()),
            textures ? 1u : 0u,
            0,
            options.as_printed ? 1u : 0u};
}

}   // namespace gnomon::shadow_textures
