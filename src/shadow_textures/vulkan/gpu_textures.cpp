// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/vulkan/gpu_textures.h"

#include <algorithm>
#include <bit>
#include <iterator>

namespace gnomon::shadow_textures {

using light_views::CasterGeometry;
using light_views::GpuLightViews;
using light_views::LightView;
using light_views::LightViews;
using light_views::Rect;
using light_views::ViewPlan;

namespace {

constexpr std::uint32_t k_vert[] =
#include "light_views/vulkan/caster.vert.inc"
    ;
constexpr std::uint32_t k_receiver[] =
#include "shadow_textures/vulkan/receiver.frag.inc"
    ;
constexpr std::uint32_t k_receiver_masked[] =
#include "shadow_textures/vulkan/receiver_masked.frag.inc"
    ;
constexpr std::uint32_t k_between[] =
#include "shadow_textures/vulkan/caster_between.frag.inc"
    ;

vk::Rect in_page(const LightView& view, const Rect& rect)
{
    return {view.tile.x + rect.x0, view.tile.y + rect.y0, static_cast<std::uint32_t>(rect.width()),
            static_cast<std::uint32_t>(rect.height())};
}

// Converts to coordinates of the page, in which rectangles of different views are disjoint.
Rect page_rect(const LightView& view, const Rect& rect)
{
    return {view.tile.x + rect.x0, view.tile.y + rect.y0, view.tile.x + rect.x1, view.tile.y + rect.y1};
}

}   // namespace

GpuTextures::GpuTextures(const std::shared_ptr<vk::Device>& device, const LightViews& views)
    : device_(device), objects_(views.object_count())
{
    host_places_.assign(views.views().size() * objects_, {});
    waiting_.resize(views.views().size());
    place_words_.assign(host_places_.size(), 0);
    places_ = vk::Buffer(device, "shadow texture places",
                         std::max<std::size_t>(host_places_.size(), 1) * sizeof(shared::TexturePlace));
    for (const bool perspective : {true, false})
        for (const bool masked : {true, false}) {
            vk::GraphicsDesc desc;
            desc.name = "shadow receivers";
            desc.vertex = {"light_views/vulkan/caster.vert", k_vert};
            if (masked)
                desc.fragment = {"shadow_textures/vulkan/receiver_masked.frag", k_receiver_masked};
            else
                desc.fragment = {"shadow_textures/vulkan/receiver.frag", k_receiver};
            const vk::BlockExpectation push = vk::shared_push<light_views::shared::CasterConstants>();
            const vk::BlockExpectation alpha = vk::shared_block<light_views::shared::AlphaMaterial>("AlphaMaterials");
            desc.blocks = {push, vk::shared_block<shared::TexturePlace>("Places")};
            if (masked) desc.blocks.push_back(alpha);
            desc.depth = VK_FORMAT_D32_SFLOAT;
            desc.depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
            desc.depth_write = false;
            desc.depth_clamp = !perspective;
            receiver_[perspective ? 0 : 1][masked ? 1 : 0] = vk::Pipeline(device, desc);
            desc.name = "casters between";
            desc.fragment = {};
            desc.blocks = {push};
            if (masked) {
                desc.fragment = {"shadow_textures/vulkan/caster_between.frag", k_between};
                desc.blocks.push_back(alpha);
            }
            desc.depth_write = true;
            caster_[perspective ? 0 : 1][masked ? 1 : 0] = vk::Pipeline(device, desc);
        }
}

void GpuTextures::place_texture(const LightView& view, const Receiver& receiver)
{
    const std::size_t at = receiver.view * objects_ + receiver.object;
    const Rect rect = page_rect(view, receiver.rect);
    const auto row_words = static_cast<std::uint32_t>(rect.width() + 31) / 32;
    const std::uint32_t words = row_words * static_cast<std::uint32_t>(rect.height());
    shared::TexturePlace& place = host_places_[at];
    if (place_words_[at] == 0 || TextureArena::size_class(place_words_[at]) != TextureArena::size_class(words)) {
        drop_texture(receiver.view, receiver.object);
        place.first_word = arena_.take(words);
    }
    place_words_[at] = words;
    place.row_words = row_words;
    place.corner = {rect.x0, rect.y0};
    place.columns = rect.width(), place.rows = rect.height();
    changed_places_.push_back(static_cast<std::uint32_t>(at));
}

void GpuTextures::drop_texture(std::size_t view, scene::ObjectId object)
{
    const std::size_t at = view * objects_ + object;
    if (place_words_[at] == 0) return;
    arena_.give_back(host_places_[at].first_word, place_words_[at]);
    place_words_[at] = 0;
    host_places_[at] = {};
    changed_places_.push_back(static_cast<std::uint32_t>(at));
}

// Enlarges the buffer of words if it is too small, and copies its contents.
void GpuTextures::make_room(vk::Commands& commands, bool keep)
{
    const VkDeviceSize bytes = std::max<VkDeviceSize>(arena_.words(), 1) * 4;
    if (words_ && words_.bytes() >= bytes) return;
    device_->check_storage_range("shadow textures", bytes);
    vk::Buffer larger(device_, "shadow textures",
                      std::min<VkDeviceSize>(std::bit_ceil(bytes), device_->limits().maxStorageBufferRange));
    if (words_ && keep) {
        const VkBufferCopy whole{0, 0, words_.bytes()};
        commands.pass("shadow textures: move")
            .reads(words_, vk::Use::copy_source)
            .writes(larger, vk::Use::copy_target)
            .copy([&](vk::Recorder& r) { r.copy(words_, larger, std::span(&whole, 1)); });
        outgrown_.push_back(std::move(words_));   // kept until the commands have completed
    }
    words_ = std::move(larger);
}

void GpuTextures::upload_places(vk::Commands& commands)
{
    std::vector<vk::Upload> uploads;
    if (!places_filled_) {
        if (!host_places_.empty())
            uploads.push_back(vk::upload_of(places_, std::span<const shared::TexturePlace>(host_places_)));
        places_filled_ = true;
    } else {
        for (const std::uint32_t at : changed_places_)
            uploads.push_back(vk::upload_of(places_, std::span<const shared::TexturePlace>(&host_places_[at], 1),
                                            at * sizeof(shared::TexturePlace)));
    }
    changed_places_.clear();
    if (!uploads.empty()) commands.upload("shadow texture places", uploads);
}

void GpuTextures::clear_textures(vk::Commands& commands, const std::vector<Receiver>& receivers)
{
    if (receivers.empty()) return;
    commands.pass("shadow textures: empty").writes(words_, vk::Use::copy_target).copy([&](vk::Recorder& recorder) {
        for (const Receiver& receiver : receivers) {
            const std::size_t at = receiver.view * objects_ + receiver.object;
            recorder.fill(words_, 0, std::size_t{4} * host_places_[at].first_word, std::size_t{4} * place_words_[at]);
        }
    });
}

// Draws each receiver once, against the unchanged depth buffer of everything.
void GpuTextures::draw_receivers(vk::Commands& commands, const LightViews& views, const vk::Image& depth, int page,
                                 std::span<const Receiver> receivers, const CasterGeometry& casters)
{
    if (receivers.empty()) return;
    vk::Pass pass = commands.pass("shadow textures: receivers");
    casters.declare(pass).reads(places_, vk::Use::storage_read).writes(words_);
    pass.depth({.image = &depth, .layer = static_cast<std::uint32_t>(page), .write = false})
        .render([&](vk::Recorder& recorder) {
            const vk::Pipeline* bound = nullptr;
            for (const Receiver& receiver : receivers) {
                const LightView& view = views.views()[receiver.view];
                recorder.viewport(in_page(view, view.projection.whole()));
                recorder.scissor(in_page(view, receiver.rect));
                const auto draw = [&](const CasterGeometry::Part& part, bool masked) {
                    const vk::Pipeline& wanted = receiver_[view.projection.perspective ? 0 : 1][masked ? 1 : 0];
                    if (bound != &wanted) {
                        bound = &wanted;
                        recorder.bind(wanted);
                        casters.bind(recorder, masked);
                        recorder.set("Places", places_);
                        recorder.set("Textures", words_);
                    }
                    recorder.push(
                        light_views::shared::CasterConstants{view.projection.clip_from_world, 0, 0, part.material,
                                                             receiver.view * static_cast<std::uint32_t>(objects_)});
                    const VkDrawIndexedIndirectCommand c = casters.draw(receiver.object, part);
                    recorder.draw_indexed(c.indexCount, 1, c.firstIndex, c.vertexOffset, c.firstInstance);
                    ++counts_.draws;
                };
                if (casters.opaque(receiver.object).index_count > 0) draw(casters.opaque(receiver.object), false);
                for (const CasterGeometry::Part& part : casters.masked(receiver.object)) draw(part, true);
            }
        });
}

void GpuTextures::record(vk::Commands& commands, const LightViews& views, const GpuLightViews& buffers,
                         const CasterGeometry& casters, const scene::SceneState& state, const InSight& in_sight)
{
    counts_ = {};
    outgrown_.clear();
    std::vector<Receiver> receivers;
    std::vector<scene::ObjectId> changed;
    for (std::uint32_t v = 0; v < views.views().size(); ++v) {
        const LightView& view = views.views()[v];
        const ViewPlan& plan = view.plan;
        std::vector<scene::ObjectId>& waiting = waiting_[v];
        if (plan.kind == ViewPlan::Kind::whole || plan.kind == ViewPlan::Kind::restless) {
            for (scene::ObjectId o = 0; o < objects_; ++o) drop_texture(v, o);
            waiting.clear();
        }
        if (!view.shown) continue;
        for (const scene::ObjectId object : plan.departed) drop_texture(v, object);

        // Make the textures that changed now, and those that wait, where their receivers are in sight.
        changed.clear();
        std::set_union(plan.receivers.begin(), plan.receivers.end(), waiting.begin(), waiting.end(),
                       std::back_inserter(changed));
        waiting.clear();
        for (const scene::ObjectId object : changed) {
            const Receiver receiver{v, object, views.casters().footprint(view.projection, state, object)};
            if (receiver.rect.empty()) continue;   // it waited, and departed
            if (in_sight && !in_sight(object)) {
                drop_texture(v, object);
                waiting.push_back(object);
                continue;
            }
            place_texture(view, receiver);
            receivers.push_back(receiver);
        }
        counts_.waiting += waiting.size();
    }
    counts_.updated = receivers.size();
    make_room(commands, true);
    upload_places(commands);
    clear_textures(commands, receivers);
    const auto page_of = [&](const Receiver& r) { return views.views()[r.view].tile.page; };
    std::stable_sort(receivers.begin(), receivers.end(),
                     [&](const auto& a, const auto& b) { return page_of(a) < page_of(b); });
    for (std::size_t i = 0; i < receivers.size();) {
        const int page = page_of(receivers[i]);
        std::size_t end = i;
        while (end < receivers.size() && page_of(receivers[end]) == page) ++end;
        draw_receivers(commands, views, buffers.depth(), page, std::span(receivers).subspan(i, end - i), casters);
        i = end;
    }
}

// For each receiver, draws into its own rectangle the depth of all casters that reach nearer to the light, and its own.
void GpuTextures::draw_casters_between(vk::Commands& commands, const LightViews& views, int page,
                                       std::span<const Receiver> receivers, const CasterGeometry& casters,
                                       PreviousMethod which)
{
    vk::Pass pass = commands.pass("shadow textures: casters between");
    casters.declare(pass);
    pass.depth({.image = &scratch_, .layer = static_cast<std::uint32_t>(page), .clear = 0.0f})
        .render([&](vk::Recorder& recorder) {
            const vk::Pipeline* bound = nullptr;
            for (const Receiver& receiver : receivers) {
                const LightView& view = views.views()[receiver.view];
                recorder.viewport(in_page(view, view.projection.whole()));
                recorder.scissor(in_page(view, receiver.rect));
                const Extents& extents = extents_[receiver.view];
                const float farthest = extents.range[receiver.object].farthest;
                for (const scene::ObjectId o : extents.casters) {
                    if (o != receiver.object && extents.range[o].nearest > farthest) continue;
                    counts_.draws_of_all_between +=
                        (casters.opaque(o).index_count > 0 ? 1u : 0u) + casters.masked(o).size();
                    if (which == PreviousMethod::by_extents && !extents.rect[o].overlaps(receiver.rect)) continue;
                    const auto draw = [&](const CasterGeometry::Part& part, bool masked) {
                        const vk::Pipeline& wanted = caster_[view.projection.perspective ? 0 : 1][masked ? 1 : 0];
                        if (bound != &wanted) {
                            bound = &wanted;
                            recorder.bind(wanted);
                            casters.bind(recorder, masked);
                        }
                        recorder.push(light_views::shared::CasterConstants{view.projection.clip_from_world, 0, 0,
                                                                           part.material, 0});
                        const VkDrawIndexedIndirectCommand c = casters.draw(o, part);
                        recorder.draw_indexed(c.indexCount, 1, c.firstIndex, c.vertexOffset, c.firstInstance);
                        ++counts_.draws;
                    };
                    if (casters.opaque(o).index_count > 0) draw(casters.opaque(o), false);
                    for (const CasterGeometry::Part& part : casters.masked(o)) draw(part, true);
                }
            }
        });
}

void GpuTextures::record_per_caster(vk::Commands& commands, const LightViews& views, const CasterGeometry& casters,
                                    const scene::SceneState& state, PreviousMethod which, const InSight& in_sight)
{
    counts_ = {};
    outgrown_.clear();
    if (!scratch_) {
        const auto side = static_cast<std::uint32_t>(std::max(views.atlas().page_size, 1));
        scratch_ = vk::Image(device_, {.name = "depths between",
                                       .width = side,
                                       .height = side,
                                       .layers = static_cast<std::uint32_t>(std::max(views.atlas().pages, 1)),
                                       .format = VK_FORMAT_D32_SFLOAT,
                                       .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
                                       .array = true});
    }
    // Group receivers whose rectangles are disjoint, to draw each group in one pass.
    struct Group {
        int page;
        std::vector<Receiver> receivers;
    };
    std::vector<Group> groups;
    std::vector<Receiver> all;
    extents_.resize(views.views().size());
    for (std::uint32_t v = 0; v < views.views().size(); ++v) {
        const LightView& view = views.views()[v];
        for (scene::ObjectId o = 0; o < objects_; ++o) drop_texture(v, o);
        if (!view.shown) continue;
        Extents& extents = extents_[v];
        extents.casters.clear(), extents.range.clear(), extents.rect.clear();
        for (scene::ObjectId o = 0; o < objects_; ++o) {
            if (views.casters().casts(o) && state.object_there(o)) extents.casters.push_back(o);
            extents.range.push_back(views.casters().distance(view.projection, state, o));
            extents.rect.push_back(views.casters().footprint(view.projection, state, o));
        }
        for (scene::ObjectId o = 0; o < objects_; ++o) {
            const Receiver receiver{v, o, extents.rect[o]};
            if (receiver.rect.empty()) continue;
            if (in_sight && !in_sight(o)) {
                ++counts_.waiting;
                continue;
            }
            place_texture(view, receiver);
            all.push_back(receiver);
            const auto free = [&](const Group& group) {
                return group.page == view.tile.page &&
                       std::none_of(group.receivers.begin(), group.receivers.end(), [&](const Receiver& r) {
                           return page_rect(views.views()[r.view], r.rect).overlaps(page_rect(view, receiver.rect));
                       });
            };
            const auto group = std::find_if(groups.begin(), groups.end(), free);
            if (group != groups.end())
                group->receivers.push_back(receiver);
            else
                groups.push_back({view.tile.page, {receiver}});
        }
    }
    // Allocate and clear all textures.
    counts_.updated = all.size();
    make_room(commands, false);
    upload_places(commands);
    clear_textures(commands, all);
    // Draw casters and receivers, group by group.
    for (const Group& group : groups) {
        draw_casters_between(commands, views, group.page, group.receivers, casters, which);
        draw_receivers(commands, views, scratch_, group.page, group.receivers, casters);
    }
}

}   // namespace gnomon::shadow_textures
