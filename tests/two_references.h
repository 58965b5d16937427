// SPDX-License-Identifier: Apache-2.0
#pragma once
// The error of an image against two independent references, whose noise is in no figure.

#include <algorithm>
#include <cmath>
#include <vector>

namespace gnomon::test {

struct ErrorOfImage {
    double nrmse = 0, energy = 0;   // energy: as a fraction of the references'
};

/// @param a, b  as large as the image
inline ErrorOfImage error_of(const std::vector<float>& image, const std::vector<float>& a, const std::vector<float>& b)
{
    double square = 0, sum = 0, all = 0;
    for (std::size_t i = 0; i < image.size(); ++i) {
        const double x = image[i], p = a[i], q = b[i];
        square += (x - p) * (x - q), sum += x, all += 0.5 * (p + q);
    }
    const auto n = static_cast<double>(image.size());
    return {std::sqrt(std::max(square / n, 0.0)) / (all / n), sum / all};
}

}   // namespace gnomon::test
