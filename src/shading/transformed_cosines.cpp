// SPDX-License-Identifier: Apache-2.0
#include "shading/transformed_cosines.h"

#include <algorithm>
#include <cmath>

#include "shading/cosine_fit.h"

namespace gnomon::shading {

namespace {

static_assert(static_cast<float>(k_first_cosine_roughness) == GNOMON_COSINE_FIRST_ROUGHNESS &&
              static_cast<float>(k_least_view_cosine) == GNOMON_COSINE_LEAST_VIEW);

// The fit of a view and a roughness, between those of the table; its tilt in radians.
CosineFit fit_at(double n_v, double roughness)
{
    const auto split = [](double t, int count, int& low) {
        const double place = std::clamp(t, 0.0, 1.0) * (count - 1);
        low = std::min(static_cast<int>(place), count - 2);
        return place - low;
    };
    int row, column;
    const double down =
        split((roughness - k_first_cosine_roughness) / (1 - k_first_cosine_roughness), k_cosine_rows, row);
    const double across = split(1 - std::sqrt(std::max(0.0, 1 - n_v)), k_cosine_columns, column);
    const auto mixed = [&](double CosineFit::*member) {
        const auto cell = [&](int r, int c) {
            return k_cosine_fits[static_cast<std::size_t>((row + r) * k_cosine_columns + column + c)].*member;
        };
        return (1 - down) * ((1 - across) * cell(0, 0) + across * cell(0, 1)) +
               down * ((1 - across) * cell(1, 0) + across * cell(1, 1));
    };
    const double alpha = roughness * roughness;
    return {mixed(&CosineFit::a), mixed(&CosineFit::b), mixed(&CosineFit::c), mixed(&CosineFit::tilt) * alpha,
            mixed(&CosineFit::scale)};
}

}   // namespace

std::vector<TransformedCosineFit> transformed_cosine_fits()
{
    std::vector<TransformedCosineFit> fits;
    for (const CosineFit& f : k_cosine_fits)
        fits.push_back({static_cast<float>(f.a), static_cast<float>(f.b), static_cast<float>(f.c),
                        static_cast<float>(f.tilt), static_cast<float>(f.scale)});
    return fits;
}

TransformedCosine transformed_cosine(float n_v, float roughness)
{
    const double cosine = std::clamp(static_cast<double>(n_v), k_least_view_cosine, 1.0);
    const double rough = std::clamp(static_cast<double>(roughness), k_first_cosine_roughness, 1.0);
    const CosineFit fit = fit_at(cosine, rough);
    return {glm::inverse(cosine_matrix(rough * rough, std::acos(cosine), fit)), fit.scale};
}

}   // namespace gnomon::shading
