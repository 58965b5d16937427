// SPDX-License-Identifier: Apache-2.0
#include "viewer/panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "viewer/orbit_camera.h"
#include "viewer/projection.h"

namespace gnomon::viewer {

namespace {

// The colours of the reports' charts.
constexpr ImU32 k_stage_colors[ViewTimes::k_stages] = {IM_COL32(229, 159, 53, 255), IM_COL32(94, 167, 107, 255),
                                                       IM_COL32(66, 133, 201, 255), IM_COL32(171, 120, 184, 255)};

constexpr float k_font_size = 13;        // the smallest
constexpr float k_least_width = 180;     // of the panel, with that font
constexpr float k_least_views = 1.75f;   // widths of the panel that a window has where the view lies beside it

constexpr float k_least_percent = 1, k_most_percent = 10000;   // of a held object's size

// Whether the option changes the scene, which then has to be loaded again, and not just a frame of it.
bool of_scene(std::string_view name)
{
    return name == "fps" || name == "lights" || name == "light" || name == "environment" || name == "strict" ||
           name == "animation" || name == "variant" || name == "ground";
}

std::vector<std::string> split(std::string_view choices)
{
    std::vector<std::string> parts;
    while (!choices.empty()) {
        const std::size_t end = std::min(choices.find('|'), choices.size());
        parts.emplace_back(choices.substr(0, end));
        choices.remove_prefix(std::min(end + 1, choices.size()));
    }
    return parts;
}

void tooltip(std::string_view text)
{
    if (!ImGui::IsItemHovered()) return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 28);
    ImGui::TextUnformatted(text.data(), text.data() + text.size());
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

void line(const std::string& text)
{
    ImGui::TextUnformatted(text.c_str());
}

}   // namespace

void TimeGraph::add(const ViewTimes& times)
{
    times_[next_] = times;
    next_ = (next_ + 1) % k_length;
    count_ = std::min(count_ + 1, k_length);
}

void TimeGraph::draw() const
{
    if (count_ == 0) return;

    // State the time of the latest frame.
    const ViewTimes& last = times_[(next_ + k_length - 1) % k_length];
    double most = 1;
    for (std::size_t i = 0; i < count_; ++i) most = std::max(most, times_[i].total());
    line(fmt::format("{:.1f} ms per frame ({:.1f} per second)", last.total(), 1000 / std::max(last.total(), 1e-3)));

    // Draw one stacked bar per frame, scaled to the slowest.
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x, height = 4 * ImGui::GetFontSize();
    ImDrawList* const draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled(corner, {corner.x + width, corner.y + height}, IM_COL32(20, 20, 22, 255));
    const float bar = width / static_cast<float>(k_length);
    for (std::size_t i = 0; i < count_; ++i) {
        const ViewTimes& times = times_[(next_ + k_length - count_ + i) % k_length];
        const float x = corner.x + bar * static_cast<float>(k_length - count_ + i);
        float y = corner.y + height;
        for (int stage = 0; stage < ViewTimes::k_stages; ++stage) {
            const float tall = height * static_cast<float>(times.ms[stage] / most);
            draw->AddRectFilled({x, y - tall}, {x + std::max(bar - 0.5f, 1.0f), y}, k_stage_colors[stage]);
            y -= tall;
        }
    }
    draw->AddText({corner.x + 3, corner.y + 1}, IM_COL32(200, 200, 200, 255), fmt::format("{:.0f} ms", most).c_str());
    ImGui::Dummy({width, height});

    // List the stages of the latest frame, in milliseconds: so many digits that two stages fit beside each other.
    for (int stage = 0; stage < ViewTimes::k_stages; ++stage) {
        if (stage % 2 == 1) ImGui::SameLine(ImGui::GetFontSize() * 11.5f);
        ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(k_stage_colors[stage]), "%s %.*f", ViewTimes::name(stage),
                           last.ms[stage] < 100 ? 1 : 0, last.ms[stage]);
    }
}

void Playback::advance(double seconds)
{
    if (!playing || frames <= 1) return;
    frame += seconds * fps * static_cast<double>(speed);
    const double length = frames;   // the last frame is shown as long as any other
    frame = 1 + std::fmod(std::fmod(frame - 1, length) + length, length);
}

void Playback::step(int by)
{
    playing = false;
    const double whole = std::floor(frame) + by;
    frame = whole < 1 ? frames : whole > frames ? 1 : whole;
}

void Playback::go(int to)
{
    playing = false;
    frame = to;
}

double Playback::time(const Scene& scene) const
{
    const int whole = std::clamp(static_cast<int>(frame), 1, frames);
    const double here = scene.time_of(whole);
    if (whole == frames) return here;
    return here + (frame - whole) * (scene.time_of(whole + 1) - here);
}

UserOverride* OverrideList::find(const NodeId& node)
{
    const auto found = std::find_if(list.begin(), list.end(), [&](const UserOverride& o) { return o.node == node; });
    return found == list.end() ? nullptr : &*found;
}

void Panel::option(ViewSettings& settings, const options::Option& option, PanelEvents& events)
{
    const std::string name(option.name);
    const options::OptionValues& values = settings.values();
    const auto set = [&](const std::string& text) {
        message = settings.set(option, text);
        if (!message.empty()) return;
        options_set.insert(name);
        (of_scene(option.name) ? events.scene_changed : events.options_changed) = true;
    };
    ImGui::PushItemWidth(ImGui::GetFontSize() * 9);
    const std::string current = values.text(name);
    if (option.kind == options::Kind::flag) {
        bool on = values.given(name);
        if (ImGui::Checkbox(name.c_str(), &on)) set(on ? "1" : "");
    } else if (option.kind == options::Kind::choice) {
        const bool may_be_none = option.fallback.empty();
        if (ImGui::BeginCombo(name.c_str(), current.empty() ? "none" : current.c_str())) {
            if (may_be_none && ImGui::Selectable("none", current.empty())) set("");
            for (const std::string& choice :
                 split(option.built_choices.empty() ? option.choices : option.built_choices))
                if (ImGui::Selectable(choice.c_str(), choice == current)) set(choice);
            ImGui::EndCombo();
        }
    } else {
        // Keep text while it is typed; it takes effect with Enter.
        auto edited = std::find_if(typed_.begin(), typed_.end(), [&](const auto& t) { return t.first == name; });
        if (edited == typed_.end()) edited = typed_.insert(typed_.end(), {name, current});
        std::array<char, 256> text{};
        std::strncpy(text.data(), edited->second.c_str(), text.size() - 1);
        const std::string hint(option.argument);
        if (ImGui::InputTextWithHint(name.c_str(), hint.c_str(), text.data(), text.size(),
                                     ImGuiInputTextFlags_EnterReturnsTrue))
            set(text.data());
        if (ImGui::IsItemActive())
            edited->second = text.data();
        else
            edited->second = settings.values().text(name);
    }
    tooltip(option.help);
    ImGui::PopItemWidth();
}

void Panel::options(ViewSettings& settings, PanelEvents& events)
{
    std::vector<std::string_view> groups;
    for (const options::Option& o : options::options())
        if ((o.subcommands & bit(options::Subcommand::view)) && o.built && o.group != "Everywhere" &&
            std::find(groups.begin(), groups.end(), o.group) == groups.end())
            groups.push_back(o.group);
    for (const std::string_view group : groups) {
        if (!ImGui::CollapsingHeader(std::string(group).c_str())) continue;
        for (const options::Option& o : options::options())
            if ((o.subcommands & bit(options::Subcommand::view)) && o.built && o.group == group && o.name != "size")
                option(settings, o, events);
    }
}

// A list of the values that an option may have in this scene, and "default".
// @param entries  labels and values
// @return whether the user chose one
bool Panel::list(ViewSettings& settings, const char* name, const char* label, std::string_view explained,
                 const std::vector<std::pair<std::string, std::string>>& entries)
{
    const std::string current = settings.values().text(name);
    std::string shown_now = current.empty() ? "default" : current;
    for (const auto& [text, value] : entries)
        if (value == current) shown_now = text;
    std::optional<std::string> chosen;
    ImGui::PushItemWidth(-ImGui::GetFontSize() * 5);
    if (ImGui::BeginCombo(label, shown_now.c_str())) {
        if (ImGui::Selectable("default", current.empty())) chosen = "";
        for (std::size_t i = 0; i < entries.size(); ++i)
            if (ImGui::Selectable(fmt::format("{}##{}", entries[i].first, i).c_str(), entries[i].second == current))
                chosen = entries[i].second;
        ImGui::EndCombo();
    }
    tooltip(explained);
    ImGui::PopItemWidth();
    if (!chosen) return false;
    message = settings.set(*options::find_option(options::Subcommand::view, name), *chosen);
    if (!message.empty()) return false;
    options_set.insert(name);
    return true;
}

void Panel::lists(ViewSettings& settings, const Scene& scene, std::uint64_t loads, PanelEvents& events)
{
    if (listed_ != &scene || listed_loads_ != loads) {
        const SceneInfo info = scene.info();
        listed_ = &scene, listed_loads_ = loads;
        clips_.clear(), cameras_.clear(), variants_.clear();
        const auto named = [](const std::string& text, std::size_t i) {
            return text.empty() ? std::to_string(i) : text;
        };
        for (std::size_t i = 0; i < info.animations.size(); ++i)
            clips_.emplace_back(named(info.animations[i].name, i) + (info.animations[i].plays ? " (plays)" : ""),
                                std::to_string(i));
        clips_.emplace_back("all", "all");
        for (std::size_t i = 0; i < info.cameras.size(); ++i)
            cameras_.emplace_back(named(info.cameras[i], i), std::to_string(i));
        for (const std::string& variant : info.variants) variants_.emplace_back(variant, variant);
    }
    if (clips_.size() > 2 &&
        list(settings, "animation", "clip",
             "which animation of the file plays, as --animation chooses it; default: all that move "
             "different things, or the first",
             clips_))
        events.scene_changed = true;
    if (cameras_.size() > 1 && list(settings, "camera", "camera", "which of the file's cameras is shown", cameras_))
        events.options_changed = events.scene_camera = true;
    if (!variants_.empty() &&
        list(settings, "variant", "variant", "which of the file's sets of materials is shown", variants_))
        events.scene_changed = true;
}

void Panel::player(Playback& playback, const Scene& scene) const
{
    if (playback.frames <= 1) {
        line("static scene: one frame");
        return;
    }
    if (ImGui::Button(playback.playing ? "Pause" : "Play")) playback.playing = !playback.playing;
    ImGui::SameLine();
    if (ImGui::Button("<")) playback.step(-1);
    ImGui::SameLine();
    if (ImGui::Button(">")) playback.step(1);
    ImGui::SameLine();
    ImGui::PushItemWidth(ImGui::GetFontSize() * 6);
    ImGui::SliderFloat("speed", &playback.speed, -2, 4, "%.2f");
    ImGui::PopItemWidth();
    auto frame = static_cast<float>(playback.frame);
    ImGui::PushItemWidth(-1);
    const std::string label = fmt::format("frame {} of {}, {:.2f} s", static_cast<int>(playback.frame), playback.frames,
                                          playback.time(scene));
    if (ImGui::SliderFloat("##frame", &frame, 1, static_cast<float>(playback.frames), label.c_str())) {
        playback.frame = static_cast<double>(frame);
        playback.playing = false;
    }
    ImGui::PopItemWidth();
}

void Panel::counters(const ViewImage& image) const
{
    const FrameCounters& counters = image.frame.counters;
    const FrameCounters::Shadow& shadow = counters.shadow;
    const auto percent = [](std::uint64_t part, std::uint64_t of) {
        return of ? 100 * static_cast<double>(part) / static_cast<double>(of) : 0.0;
    };
    line(fmt::format("{} shadow rays", shadow.rays));
    line(fmt::format("  {:.1f} % culled", percent(shadow.rays_skipped, shadow.rays)));
    line(fmt::format("  {:.1f} % traced against dynamic objects only", percent(shadow.rays_dynamic_only, shadow.rays)));
    line(fmt::format("{} rays for indirect light", counters.indirect.rays));
    line(fmt::format("{:.1f} MB of caches", static_cast<double>(image.remembered_bytes) / 1e6));
    line(fmt::format("{} x {} pixels", image.frame.view_size.width, image.frame.view_size.height));
}

void Panel::object(OverrideList& overrides, const ViewImage& image)
{
    if (!picked || !picked->instance) {
        line("click on an object to pick it");
        return;
    }
    line(fmt::format("{}: {}", picked->name.empty() ? "an object without a name" : picked->name, picked->mobility));
    UserOverride* applied = overrides.find(picked->node);
    bool held = applied != nullptr;
    if (ImGui::Checkbox("freeze", &held)) {
        if (held) {
            freeze(overrides);
        } else
            std::erase_if(overrides.list, [&](const UserOverride& o) { return o.node == picked->node; });
    }
    tooltip("keeps the object where it is now and ignores its animation, so that it can be moved, turned and scaled");
    applied = overrides.find(picked->node);
    if (!applied) return;
    const float step = 0.002f * glm::length(eye_of(image.camera) - picked->position);
    bool changed = ImGui::DragFloat3("move", &applied->offset.x, step, 0, 0, "%.3f");
    glm::vec3 degrees = glm::degrees(glm::eulerAngles(applied->turn));
    if (ImGui::DragFloat3("turn", &degrees.x, 1, 0, 0, "%.0f")) {
        applied->turn = glm::quat(glm::radians(degrees));
        changed = true;
    }
    float percent = 100 * applied->factor;
    if (ImGui::DragFloat("size", &percent, 1, k_least_percent, k_most_percent, "%.0f %%",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp)) {
        applied->factor = percent / 100;
        changed = true;
    }
    if (changed) moved.insert(picked->name);
}

UserOverride& Panel::freeze(OverrideList& overrides)
{
    if (UserOverride* const known = overrides.find(picked->node)) return *known;
    UserOverride made{picked->node, picked->transform};
    made.pivot = glm::vec3(matrix_of(picked->transform) * glm::dvec4(glm::dvec3(picked->pivot), 1));
    overrides.list.push_back(made);
    frozen.insert(picked->name);
    return overrides.list.back();
}

float Panel::middle_of_view() const
{
    const float left = docked_width();
    return left + (ImGui::GetIO().DisplaySize.x - left) / 2;
}

void Panel::keys()
{
    if (!help) return;
    ImGui::SetNextWindowPos({middle_of_view(), ImGui::GetIO().DisplaySize.y / 2}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::Begin("Keys", &help, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse);
    static constexpr const char* k_keys[][2] = {
        {"left drag", "orbit around the pivot"},
        {"right drag", "look around"},
        {"middle or shift drag", "pan"},
        {"wheel", "zoom"},
        {"W A S D, E Q", "fly, up and down; with shift, four times as fast"},
        {"click", "pick an object"},
        {"arrows, rings, square", "drag to move, turn and scale the picked object"},
        {"G", "show or hide these handles"},
        {"F", "aim at the picked object"},
        {"C, Enter", "use the scene's camera"},
        {"1, 3, 7, 9", "see all from the front, the right, above, a corner"},
        {"space", "play or pause"},
        {"left, right", "step one frame back or forward"},
        {"Home, End", "go to the first or last frame"},
        {"O", "show or hide the overlay: shadow states, or redrawn areas"},
        {"Tab", "show or hide the panel"},
        {"P, F12", "save a screenshot"},
        {"up", "read the file again"},
        {"R", "start or stop recording"},
        {"H", "show or hide this help"},
        {"Escape", "quit"},
    };
    for (const auto& [key, action] : k_keys) {
        ImGui::TextUnformatted(key);
        ImGui::SameLine(ImGui::GetFontSize() * 13);
        ImGui::TextUnformatted(action);
    }
    line("Drop a scene file on the window to open it. A file is loaded again when it changes.");
    ImGui::End();
}

// Explains the colours of an overlay. The overlay of shadow states has a legend in the image.
void Panel::legend(const std::string& overlay)
{
    struct Entry {
        ImU32 color;
        const char* text;
    };
    std::vector<Entry> entries;
    if (overlay == "redrawn")
        entries = {{IM_COL32(255, 89, 63, 255), "dynamic: drawn in every frame over the static objects"},
                   {IM_COL32(108, 231, 124, 255), "came to rest: drawn once and then kept"},
                   {IM_COL32(255, 210, 63, 255), "repaired: redrawn where an object moved away or the light changed"},
                   {IM_COL32(150, 150, 150, 255), "kept: depths unchanged"}};
    else if (overlay == "clusters")
        entries = {{IM_COL32(235, 110, 80, 255), "lit surfaces: one colour per cluster, a node of the light tree"},
                   {IM_COL32(140, 65, 48, 255), "darker colours: smaller clusters"},
                   {IM_COL32(64, 64, 64, 255), "in no cluster: not visible from the light"}};
    if (entries.empty()) return;
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({display.x - 8, display.y - 8}, ImGuiCond_Always, {1, 1});
    ImGui::Begin("##legend", nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoDecoration);
    for (const Entry& entry : entries) {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        const float side = ImGui::GetFontSize();
        ImGui::GetWindowDrawList()->AddRectFilled(at, {at.x + side, at.y + side}, entry.color);
        ImGui::Dummy({side, side});
        ImGui::SameLine();
        ImGui::TextUnformatted(entry.text);
    }
    ImGui::End();
}

float Panel::docked_width() const
{
    return shown && ImGui::GetIO().DisplaySize.x >= k_least_views * width_ ? width_ : 0;
}

// Begins the panel's window: at the window's left edge, as tall as the window, and as wide as the user makes it.
void Panel::begin_docked()
{
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const float unit = ImGui::GetFontSize() / k_font_size;
    if (width_ == 0) width_ = k_width * unit;
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({k_width * unit, display.y}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSizeConstraints({k_least_width * unit, display.y},
                                        {std::max(k_width * unit, display.x / k_least_views), display.y});
    ImGui::SetNextWindowBgAlpha(docked_width() > 0 ? 1 : 0.85f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
    ImGui::Begin("Gnomon", &shown, ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse);
    ImGui::PopStyleVar();
    width_ = ImGui::GetWindowWidth();
}

PanelEvents Panel::draw(ViewSettings& settings, Playback& playback, OverrideList& overrides, const Scene* scene,
                        const ViewImage* image, const LoadState& load, bool own_camera, bool recording)
{
    PanelEvents events;
    keys();
    legend(settings.values().text("overlay"));

    // Show the progress of loading, or of bounced light, at the bottom, and the latest error or message at the top.
    if (load.loading) {
        ImGui::SetNextWindowPos({middle_of_view(), ImGui::GetIO().DisplaySize.y - 20}, ImGuiCond_Always, {0.5f, 1});
        ImGui::Begin("##loading", nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoDecoration);
        line(fmt::format("{}: {} {:.0f} %", load.file, load.stage, 100 * load.done));
        ImGui::ProgressBar(static_cast<float>(load.done), {ImGui::GetFontSize() * 24, 0}, "");
        ImGui::End();
    }
    if (!load.loading && !load.preparing.empty()) {
        ImGui::SetNextWindowPos({middle_of_view(), ImGui::GetIO().DisplaySize.y - 20}, ImGuiCond_Always, {0.5f, 1});
        ImGui::Begin("##preparing", nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoDecoration);
        line(load.preparing);
        ImGui::End();
    }
    const std::string& error = load.error.empty() ? load.frame_error : load.error;
    const std::string& notice = error.empty() ? message : error;
    if (!notice.empty()) {
        ImGui::SetNextWindowPos({middle_of_view(), 10}, ImGuiCond_Always, {0.5f, 0});
        ImGui::Begin("##message", nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoDecoration);
        ImGui::PushTextWrapPos(ImGui::GetFontSize() * 40);
        line(notice);
        ImGui::PopTextWrapPos();
        ImGui::End();
    }
    if (!shown) return events;

    // Draw the panel itself.
    begin_docked();
    if (scene) player(playback, *scene);
    if (scene) lists(settings, *scene, load.loads, events);
    if (ImGui::Button("Screenshot")) events.screenshot = true;
    ImGui::SameLine();
    if (ImGui::Button(recording ? "Stop recording" : "Record")) events.record = true;
    ImGui::SameLine();
    if (own_camera && ImGui::Button("Scene's camera")) events.scene_camera = true;
    if (!own_camera && ImGui::Button("Help (H)")) help = !help;
    ImGui::Separator();
    graph_.draw();
    if (image) {
        ImGui::Separator();
        counters(*image);
        ImGui::Separator();
        object(overrides, *image);
    }
    ImGui::Separator();
    options(settings, events);
    ImGui::End();
    return events;
}

}   // namespace gnomon::viewer
