// SPDX-License-Identifier: Apache-2.0
#include "bench/report/image_figures.h"

#include <fmt/format.h>

#include "image/flip.h"
#include "image/image_metrics.h"

namespace gnomon::bench {

namespace {

ImageF linear_of(const Image8& image)
{
    ImageF linear(image.width, image.height, image.channels);
    const float* values = linear_from_srgb8();
    for (std::size_t i = 0; i < image.data.size(); ++i) linear.data[i] = values[image.data[i]];
    return linear;
}

}   // namespace

Image8 image_of(const Frame& frame)
{
    Image8 image(frame.size.width, frame.size.height, 3);
    image.data = frame.to_srgb8();
    return image;
}

ImageComparison compare_images(const std::string& caption, const std::string& left_name, const Image8& left,
                               const std::string& right_name, const Image8& right, Tasks& tasks)
{
    const ImageF a = linear_of(left), b = linear_of(right);
    const ImageF error = image::flip_ldr(a, b, tasks);
    const double different = image::pixels_different(a, b);
    const std::string apart = different == 0 ? "The images are identical."
                                             : fmt::format("{:.2f} % of the pixels differ; mean FLIP {:.4f}.",
                                                           100 * different, image::mean_of(error));
    return {caption + " " + apart, left_name, right_name, left, right, image::heat_map(error)};
}

}   // namespace gnomon::bench
