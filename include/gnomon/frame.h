// SPDX-License-Identifier: Apache-2.0
#pragma once
// A rendered frame: linear light and layers.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gnomon/frame_times.h"
#include "gnomon/image_options.h"
#include "gnomon/math.h"
#include "gnomon/output.h"
#include "gnomon/types.h"

namespace gnomon {

/// One layer of an image: a view of memory that is shared with the renderer, without a copy. The values stay valid and
/// unchanged as long as this layer, a copy of it or its Frame exists. Rows are from the top, channels interleaved.
///
/// | name | channels | values |
/// |---|---|---|
/// | "" | R G B | the image: linear light, Rec. 709 primaries, averaged over samples |
/// | depth | Z | distance in metres (units of the scene) along the camera's axis; 0: nothing |
/// | normal | X Y Z | shading normal in world space; 0: nothing |
/// | albedo, direct, indirect | R G B | reflectance, and direct and indirect light, averaged over samples |
/// | shadow | L0 L1 ... | by light: 1 lit, 0 in shadow, averaged over samples |
/// | id | object material | ids (u32), as pick() gives them; 0: nothing |
/// | motion | X Y | from where the surface point was a frame before to where it is: pixels, right and down |
///
/// Depth, normal, id and motion are those at the pixel's centre, whatever the number of samples.
struct Layer {
    std::string name;
    std::vector<std::string> channels;
    PixelFormat format = PixelFormat::f32;   // f32, or u32 for ids
    Size size;
    const void* data = nullptr;           // the first channel of the upper left pixel
    std::ptrdiff_t pixel_stride = 0;      // bytes from one pixel to the next; the channels of a pixel are adjacent
    std::ptrdiff_t row_stride = 0;        // bytes from one row to the next
    std::shared_ptr<const void> memory;   // keeps the values

    /// The value of one pixel.
    /// @param x, y  from the top left, from 0
    /// @throws UsageError  outside the layer, or its values are ids
    float value(int x, int y, int channel = 0) const;
    /// The id of one pixel.
    /// @throws UsageError  outside the layer, or its values are not ids
    std::uint32_t id(int x, int y, int channel = 0) const;
    /// All values in the order of rows, pixels and channels; width * height * channels of them.
    /// @throws UsageError  its values are ids, or are not adjacent in memory; the renderer's own layers are
    std::span<const float> values() const;
    /// All ids in the same order.
    /// @throws UsageError  its values are not ids, or are not adjacent in memory
    std::span<const std::uint32_t> ids() const;
    /// A copy of values().
    std::vector<float> copy() const;
};

/// What an image shows where nothing of the scene is.
enum class BackgroundKind {
    environment,   // what lights the scene: its sky, environment image or colour
    transparent,   // nothing: the frame has a layer of alpha, and a ground shows its shadows alone
    color,         // one colour
};

/// A rendered frame. It shares its memory with the renderer, which renders the next frame into the same memory if
/// nothing holds a layer of it any more, and otherwise into new memory. A caller that drops a frame before it renders
/// the next one therefore saves an allocation.
struct Frame {
    Size size;
    std::vector<Layer> layers;   // the first is the image
    double exposure = 0;         // stops, applied by write() and to_srgb8() before tone mapping
    ToneMap tonemap = ToneMap::neutral;
    /// With another background than the environment there is a layer "alpha", and the image lacks what lies behind: its
    /// colours are associated (multiplied by alpha).
    BackgroundKind background = BackgroundKind::environment;
    float background_color[3]{};   // of BackgroundKind::color, sRGB
    FrameCounters counters;
    double noise = 0;   // of a reference: the root mean square of its standard error, divided by the image's mean
    double milliseconds = 0;   // of the frame, without loading and writing
    FrameTimes times;          // the same time by stage
    double time = 0;           // scene time in seconds
    int frame = 1;             // of the clip; 0 if a time was given
    /// No light is missing because of FrameInput::indirect_ray_limit, of which the next frame of the same input has
    /// more, and none is rough because of FrameInput::preview.
    bool complete = true;
    double fps = 0;   // of the scene's clip
    /// From the world to the camera's space, which looks along -Z with +Y up.
    Transform world_to_camera{};
    /// From the world to the image. After the division by w, x goes from 0 at the left edge to 1 at the right, y from 0
    /// at the upper edge to 1 at the lower. Of the rendered view, as view_size is.
    Transform world_to_image{};
    std::string instruction_set{};     // that results depend on: "auto" (none), or "native-NAME"
    Size view_size{};                  // of the rendered view, which overlays surround with titles
    int view_left = 0, view_top = 0;   // and its place in the image

    /// The layer of that name; null if the frame has none.
    const Layer* layer(const std::string& name) const;
    /// Applies exposure, tone mapping and sRGB encoding, and puts a background of one colour behind; a transparent one
    /// is black. Returns width * height * 3 bytes.
    std::vector<std::uint8_t> to_srgb8() const;
    /// The same as width * height * 4 bytes, with alpha that is not associated; 255 without a layer of alpha.
    std::vector<std::uint8_t> to_srgb8_alpha() const;
    /// The same as to_srgb8() and to_srgb8_alpha(), with 16 bits a channel.
    std::vector<std::uint16_t> to_srgb16() const;
    std::vector<std::uint16_t> to_srgb16_alpha() const;   // see above
    /// Writes .png (tone-mapped; with alpha if the background is transparent), .jpg (tone-mapped) or .exr (all layers,
    /// linear, without exposure; with the frame's number, time and camera). The file is replaced atomically.
    /// @throws UsageError    another extension; a .jpg with a transparent background; more channels than fit an .exr:
    ///         16,384, or fewer if the image is wider than 2,047 pixels; an option is out of range
    /// @throws MissingError  the file cannot be written
    void write(const std::filesystem::path& file, const ImageOptions& options = {}) const;
};

}   // namespace gnomon
