// SPDX-License-Identifier: Apache-2.0
#include "gnomon/video.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "api/frame_layers.h"
#include "api/scene_access.h"
#include "base/hash.h"
#include "gnomon/version.h"
#include "io/file/output_name.h"
#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "scene/scene.h"
#include "video/clip_exposure.h"
#include "video/encoder.h"
#include "video/finished_video.h"
#include "video/frame_file.h"
#include "video/frame_list.h"
#include "video/frames_folder.h"

namespace gnomon {

namespace fs = std::filesystem;
using io::OutputKind;
using video::FramesFolder;

namespace {
// Even smooth images take at least this much as PNG, so a disk with less space is too small.
constexpr double k_least_bytes_per_pixel = 0.1;
// At a slower rate, MP4 cannot represent the duration of a frame and would lose some. ffmpeg rejects faster rates.
constexpr double k_slowest_video = 0.001, k_fastest_video = 1000;   // frames a second
constexpr int k_least_video_side = 2;                               // an odd side loses one row or column
constexpr int k_largest_video_side = 16385;                         // the encoder's limit, and one that is lost
constexpr int k_sheet_images = 12;
constexpr int k_sheet_columns = 4;
constexpr std::size_t k_channels_beside_shadows =
    25;                                // of all other layers but ids and motion, including those of a reference
constexpr int k_overlay_warm_up = 8;   // frames before a single image of the cached state

// Whether other runs render the other frames.
bool is_part(const VideoJob& job)
{
    return job.chunks > 1 || job.part;
}

void check_job(const Scene& scene, const RenderOptions& options, const VideoJob& job, FrameRange frames,
               io::OutputKind kind)
{
    const std::string out = job.out.string();
    if (frames.count() == 0 || frames.first < 1 || frames.last > scene.frame_count())
        throw UsageError(
            fmt::format("frames {}-{}: the clip has frames 1 to {}", frames.first, frames.last, scene.frame_count()));
    if (kind == io::OutputKind::image && frames.count() > 1)
        throw UsageError(fmt::format("{}: {} frames need a name such as name-{{frame:04}}.png, or a video such as .mp4",
                                     out, frames.count()));
    if (kind == io::OutputKind::video && !(job.fps >= k_slowest_video && job.fps <= k_fastest_video))
        throw UsageError(fmt::format("{}: a video of {:g} frames a second: expected {} to {}; --fps sets another rate",
                                     out, job.fps, k_slowest_video, k_fastest_video));
    if (job.part && (job.part->count() == 0 || job.part->first < frames.first || job.part->last > frames.last))
        throw UsageError(fmt::format("chunk {}-{}: the range has frames {} to {}", job.part->first, job.part->last,
                                     frames.first, frames.last));
    if (io::is_jpeg_name(job.out) && options.background == BackgroundKind::transparent)
        throw UsageError(
            fmt::format("{}: a .jpg has no alpha, and the background is transparent: write .png or .exr, or "
                        "choose a background of one colour",
                        out));
    if (job.warm_up.value_or(0) < 0) throw UsageError("the number of warm-up frames must not be negative");
    if (job.contact_sheet.empty()) return;
    if (io::is_exr_name(job.out))
        throw UsageError("a contact sheet needs the output of .png images or of a video, not .exr");
    if (io::is_jpeg_name(job.out))
        throw UsageError("a contact sheet needs the output of .png images or of a video, not .jpg");
    if (io::output_kind(job.contact_sheet) != io::OutputKind::image || io::is_exr_name(job.contact_sheet) ||
        io::is_jpeg_name(job.contact_sheet))
        throw UsageError(fmt::format("{}: a contact sheet must be a .png file", job.contact_sheet.string()));
    // The sheet is written last and must not overwrite an image.
    const auto plain = [](const fs::path& file) { return fs::absolute(file).lexically_normal(); };
    const fs::path sheet = plain(job.contact_sheet);
    for (int frame = frames.first; kind != io::OutputKind::video && frame <= frames.last; ++frame)
        if (plain(io::numbered_name(job.out, frame)) == sheet)
            throw UsageError(
                fmt::format("{}: the contact sheet would overwrite an image; choose another name", sheet.string()));
    if (is_part(job)) throw UsageError("a contact sheet needs the whole range; it cannot be combined with --chunk");
}

// A shadow channel per light may be too many. Check before rendering that the file can be read again.
void check_layers(const Scene& scene, const RenderOptions& options, Size size, const VideoJob& job)
{
    const fs::path& out = job.out;
    const bool layers = options.layers && (options.overlay == Overlay::none || options.overlay == Overlay::redrawn);
    const std::size_t lights = api::scene_of(scene)->lights.size();
    const std::size_t room = io::room_in_exr(size, job.images.exr_compression);
    const std::size_t beside = k_channels_beside_shadows + (options.ids ? 2 : 0) + (options.motion ? 2 : 0);
    if (layers && io::is_exr_name(out) && lights + beside > room)
        throw UsageError(fmt::format(
            "{}: {} lights; an .exr of {} x {} pixels has room for the shadows of {}: keep fewer with --lights N, "
            "or write a .png",
            out.string(), lights, size.width, size.height, room - std::min(room, beside)));
}

// Checks the size before rendering, because the encoder would reject it only at the end.
void check_video_size(Size size, const fs::path& out)
{
    const auto fits = [](int side) { return side >= k_least_video_side && side <= k_largest_video_side; };
    if (!fits(size.width) || !fits(size.height))
        throw UsageError(fmt::format("{}: a video of {} x {} pixels: expected {} to {} a side", out.string(),
                                     size.width, size.height, k_least_video_side, k_largest_video_side));
}

void check_room(const fs::path& file, Size size, int frames)
{
    std::error_code error;
    const fs::space_info space = fs::space(file.has_parent_path() ? file.parent_path() : fs::path("."), error);
    if (error) return;   // unknown; an error will appear when writing
    const double needed = k_least_bytes_per_pixel * size.width * size.height * frames;
    if (static_cast<double>(space.available) < needed)
        throw MissingError(
            fmt::format("cannot write {}: {} frames need {:.3g} MB at least, the disk has {:.3g} MB left",
                        file.string(), frames, needed / 1e6, static_cast<double>(space.available) / 1e6));
}

bool is_whole(const fs::path& frame, Size size)
{
    if (io::is_exr_name(frame)) return io::is_whole_exr(frame, size);
    if (io::is_jpeg_name(frame)) return io::is_whole_jpeg(frame, size.width, size.height);
    return io::is_whole_png(frame, size.width, size.height);
}

// Chooses frames evenly spaced over the range, including the first and the last.
std::vector<std::size_t> sheet_choice(std::size_t frames)
{
    const std::size_t count = std::min<std::size_t>(frames, k_sheet_images);
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < count; ++i) chosen.push_back(count == 1 ? 0 : i * (frames - 1) / (count - 1));
    return chosen;
}

void warm_up(const Scene& scene, Renderer& renderer, int first, int frames, const Progress& progress)
{
    for (int i = 0; i < frames; ++i) {
        const auto step = [&](const ProgressStep& s) {
            return !progress || progress({"warming up", (i + s.done) / frames});
        };
        renderer.render(scene, std::max(1, first - frames + i), step);
    }
}

void write_sheet(const std::vector<FrameRecord>& frames, const fs::path& out)
{
    std::vector<fs::path> pngs;
    std::vector<std::string> labels;
    for (const std::size_t i : sheet_choice(frames.size())) {
        pngs.push_back(frames[i].file);
        labels.push_back(fmt::format("frame {}  {:.2f} s", frames[i].frame, frames[i].time));
    }
    write_contact_sheet(pngs, labels, std::min<int>(k_sheet_columns, static_cast<int>(pngs.size())), out);
}

// Whether one exposure is computed for all frames.
bool exposes_clip(const VideoJob& job, const RenderOptions& options)
{
    return !options.exposure && !job.exposure_of_each_frame && io::output_kind(job.out) != OutputKind::image;
}

video::VideoIdentity identity_of(const Scene& scene, const RenderOptions& options, const VideoJob& job,
                                 FrameRange whole)
{
    video::VideoIdentity identity;
    identity.scene = scene.info().name;
    identity.size = image_size(scene, options);
    identity.version = version();
    // Portable arithmetic gives the same bytes under every instruction set.
    identity.instruction_set = api::instruction_set_of(options);
    identity.scene_fingerprint = video::fingerprint_of(*api::scene_of(scene));
    identity.fingerprint = video::fingerprint_of(identity.scene_fingerprint, scene, options);
    identity.frames = whole;
    identity.fps = job.fps;
    identity.delivery = video::choose_delivery(
        job.out, job.encoding, options.background == BackgroundKind::transparent && options.overlay == Overlay::none,
        job.fps, whole.first);
    if (!identity.delivery.audio.empty()) {
        std::error_code none;
        identity.delivery.audio = fs::absolute(identity.delivery.audio, none);
        identity.delivery.audio_hash = video::hash_of_file(identity.delivery.audio);
    }
    // Frames also depend on what they are kept for.
    const std::uint32_t kinds[] = {exposes_clip(job, options), identity.delivery.alpha, identity.delivery.deep};
    identity.fingerprint = hash_bytes(kinds, sizeof kinds, identity.fingerprint);
    return identity;
}

// Whether the finished video is this one. Says why a video that is there is another one.
bool is_complete(const VideoJob& job, const video::VideoIdentity& identity)
{
    // The contact sheet is written before the video, from frames that are removed with it.
    std::error_code none;
    if (!fs::exists(job.out, none) || (!job.contact_sheet.empty() && !fs::exists(job.contact_sheet, none)))
        return false;
    const video::Container container = identity.delivery.container;
    const std::string comment = video::comment_of_video(job.out, container);
    const bool whole = video::is_whole_video(job.out, container);
    if (comment == video::comment_of(identity) && whole) return true;
    if (is_part(job) || !job.on_notice) return false;
    const std::string stamp = video::stamp_in(comment);
    const video::Difference difference = video::difference_of(stamp, identity);
    const std::string reason = !whole ? "incomplete"
                               : difference == video::Difference::none
                                   ? "of other frames, at another rate, or encoded otherwise"
                                   : describe(difference, stamp, identity);
    job.on_notice(fmt::format("{} is {}: it is rendered again", job.out.string(), reason));
    return false;
}

// The result for a video that is complete. A run that was killed after it had encoded the video has left its frames.
VideoResult nothing_to_do(const Scene& scene, const VideoJob& job, FrameRange range,
                          const video::VideoIdentity& identity, video::FramesFolder& folder)
{
    VideoResult result;
    result.size = identity.size;
    result.complete_before = true;
    for (int frame = range.first; frame <= range.last; ++frame) {
        FrameRecord record;
        record.frame = frame;
        record.time = scene.time_of(frame);
        record.file = job.out;
        record.kept = true;
        result.frames.push_back(std::move(record));
    }
    result.files.push_back(job.out);
    if (is_part(job)) return result;
    const auto left = folder.open_existing();
    if (left ? video::comment_of(*left) == video::comment_of(identity) : !folder.has_frames()) folder.remove();
    return result;
}

// Which frames of the range an earlier run has completed. Says which others it has left, and why they are not kept.
std::vector<bool> find_kept(const VideoJob& job, FrameRange range, const video::VideoIdentity& identity,
                            const video::FramesFolder& folder, io::OutputKind kind, Size size, const Progress& progress)
{
    std::vector<bool> kept(static_cast<std::size_t>(range.count()));
    if (!job.resume) return kept;
    std::map<std::string, std::vector<int>> outdated;   // by reason
    for (int frame = range.first; frame <= range.last; ++frame) {
        if (progress && !progress({"rendering", 0})) throw InterruptedError("interrupted");
        const auto index = static_cast<std::size_t>(frame - range.first);
        if (kind != io::OutputKind::video) {
            kept[index] = is_whole(io::numbered_name(job.out, frame), size);
        } else if (const auto found = folder.find(frame, identity)) {
            kept[index] = found->difference == video::Difference::none;
            if (!kept[index]) outdated[describe(found->difference, found->stamp, identity)].push_back(frame);
        }
    }
    for (const auto& [reason, frames] : outdated)
        if (job.on_notice)
            job.on_notice(fmt::format("{} of {} {} {}: {} rendered again", video::list_frames(frames),
                                      folder.path().string(), frames.size() == 1 ? "is" : "are", reason,
                                      frames.size() == 1 ? "it is" : "they are"));
    return kept;
}

// Writes a frame to the record's file and notes what it took.
// @param identity  of a video; null for images
void write_frame(const Frame& frame, const video::VideoIdentity* identity, const VideoJob& job, FrameRecord& record)
{
    if (identity)
        video::write_video_frame(frame, identity->delivery, record.file, video::stamp_of(*identity));
    else
        frame.write(record.file, job.images);
    record.exposure = frame.exposure;
    record.milliseconds = frame.milliseconds;
    record.times = frame.times;
    record.counters = frame.counters;
    record.noise = frame.noise;
}

// Sets a renderer's exposure, and restores what it was.
class ExposureScope {
 public:
    explicit ExposureScope(Renderer& renderer) : renderer_(renderer), before_(renderer.options().exposure) {}
    ~ExposureScope()
    {
        if (changed_) change(before_);
    }
    ExposureScope(const ExposureScope&) = delete;
    ExposureScope& operator=(const ExposureScope&) = delete;
    void set(double stops)
    {
        changed_ = true;
        change(stops);
    }

 private:
    void change(std::optional<double> exposure)
    {
        RenderOptions options = renderer_.options();
        options.exposure = exposure;
        renderer_.set_options(std::move(options));
    }

    Renderer& renderer_;
    std::optional<double> before_;
    bool changed_ = false;
};
}   // namespace

VideoResult render_video(const Scene& scene, Renderer& renderer, const VideoJob& job, const Progress& progress,
                         const std::function<void(const FrameRecord&)>& on_frame)
{
    // Reject invalid jobs before any frame is rendered.
    const io::OutputKind kind = io::output_kind(job.out);
    if (!job.frames && kind != io::OutputKind::image && scene.frame_count() > k_most_frames_unasked)
        throw UsageError(
            fmt::format("the clip has {} frames, which is more than {}: name those to render, --frames 1-{}",
                        scene.frame_count(), k_most_frames_unasked, k_most_frames_unasked));
    const FrameRange whole =
        job.frames.value_or(FrameRange{1, kind == io::OutputKind::image ? 1 : scene.frame_count()});
    check_job(scene, renderer.options(), job, whole, kind);
    const FrameRange range = job.part.value_or(chunk_of(whole, job.chunk, job.chunks));
    const bool encodes = kind == io::OutputKind::video && !is_part(job);
    video::FramesFolder folder(job.out);
    video::VideoIdentity identity;
    if (kind == io::OutputKind::video) {
        identity = identity_of(scene, renderer.options(), job, whole);
        if (job.resume && is_complete(job, identity)) return nothing_to_do(scene, job, range, identity, folder);
    }
    if (encodes) video::check_encoder(identity.delivery, progress);
    if (kind == io::OutputKind::numbered) io::make_folder(job.out);
    if (kind != io::OutputKind::video || encodes) io::check_writable(io::numbered_name(job.out, range.first));
    if (!job.contact_sheet.empty()) io::check_writable(job.contact_sheet);

    VideoResult result;
    result.size = image_size(scene, renderer.options());
    if (kind == io::OutputKind::video) check_video_size(result.size, job.out);
    check_layers(scene, renderer.options(), result.size, job);
    check_room(job.out, result.size, range.count());

    if (kind == io::OutputKind::video) folder.open(identity, job.resume, is_part(job));
    const std::vector<bool> kept = find_kept(job, range, identity, folder, kind, result.size, progress);

    // Remove the folder only if it is empty, because other chunks may be about to write their first frame. Ignore
    // errors here, so that the original error is reported.
    const auto let_go_if_empty = [&]() noexcept {
        try {
            if (!is_part(job) && !folder.has_frames()) folder.remove();
        } catch (...) {
        }
    };

    // Render the missing frames.
    try {
        ExposureScope exposure(renderer);
        if (exposes_clip(job, renderer.options()) && std::find(kept.begin(), kept.end(), false) != kept.end()) {
            const bool is_video = kind == io::OutputKind::video;
            const std::optional<double> known = is_video ? folder.exposure() : std::nullopt;
            const double stops = known ? *known : video::clip_exposure(scene, renderer, progress);
            if (is_video && !known) folder.note_exposure(identity, stops);
            exposure.set(stops);
        }
        const bool one_overlay = renderer.options().overlay == Overlay::shadow_states && whole.count() == 1;
        const int warm_up_frames = job.warm_up.value_or(one_overlay ? k_overlay_warm_up : 0);
        bool warm = false;
        for (int frame = range.first; frame <= range.last; ++frame) {
            const int index = frame - range.first;
            const auto step = [&](double part) {
                return !progress || progress({"rendering", (index + part) / range.count()});
            };
            FrameRecord record;
            record.frame = frame;
            record.time = scene.time_of(frame);
            record.file = kind == io::OutputKind::video ? folder.file(frame) : io::numbered_name(job.out, frame);
            record.kept = kept[static_cast<std::size_t>(index)];
            if (!step(0)) throw InterruptedError("interrupted");
            if (!record.kept) {
                if (!warm) warm_up(scene, renderer, frame, warm_up_frames, progress);
                warm = true;
                const Frame image = renderer.render(scene, frame, [&](const ProgressStep& s) { return step(s.done); });
                write_frame(image, kind == io::OutputKind::video ? &identity : nullptr, job, record);
            }
            if (on_frame) on_frame(record);
            result.frames.push_back(std::move(record));
        }
    } catch (const InterruptedError& error) {
        if (kind != io::OutputKind::video) throw;
        let_go_if_empty();
        if (!folder.has_frames()) throw;
        throw InterruptedError(
            fmt::format("{}; --resume continues with the frames in {}", error.what(), folder.path().string()));
    } catch (...) {
        if (kind == io::OutputKind::video) let_go_if_empty();
        throw;
    }

    if (!job.contact_sheet.empty()) write_sheet(result.frames, job.contact_sheet);
    if (!encodes) {
        for (const FrameRecord& record : result.frames) result.files.push_back(record.file);
        return result;
    }

    // Encode the video when all frames are complete, and remove the frames.
    std::vector<fs::path> frames;
    for (const FrameRecord& record : result.frames) frames.push_back(record.file);
    video::encode_video(frames, job.fps, job.out, progress, video::comment_of(identity), identity.delivery);
    folder.remove();
    for (FrameRecord& record : result.frames) record.file = job.out;
    result.files.push_back(job.out);
    return result;
}

}   // namespace gnomon
