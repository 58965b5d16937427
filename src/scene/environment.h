// SPDX-License-Identifier: Apache-2.0
#pragma once
// Image-based light: an environment map as a background and as a few directional lights.
//
// The image is longitude by latitude: its upper edge is straight up (+Y), its centre looks along -Z, its right quarter
// along +X, and its sides meet at +Z. Texels are radiance, linear RGB.
//
// Rays that leave the scene see the image itself, and traced frames light by it (environment_light/). Bounced light and
// rasterised frames use directional lights with shadows, one for each part of the image that a median cut makes
// [Debevec 2005, "A Median Cut Algorithm for Light Probe Sampling"]; they carry all of its light. Rasterised frames
// blur rough specular reflection by order-2 spherical harmonics without shadows [Ramamoorthi and Hanrahan 2001, "An
// Efficient Representation for Irradiance Environment Maps"].
//
// Cost: one pass over the image when it is made; a look-up reads four texels.

#include <array>
#include <vector>

#include "base/image.h"
#include "base/math.h"

namespace gnomon::scene {

/// One part of the image, integrated into a directional light.
struct EnvironmentLight {
    glm::vec3 to_light{0};     // unit: the part's centroid, weighted by luminance
    glm::vec3 irradiance{0};   // on a surface that faces it
    glm::vec3 flux{0};         // the integral of radiance over the part's solid angle
};

class Environment {
 public:
    /// @param radiance  three channels, not empty; negative values and NaN count as 0
    explicit Environment(ImageF radiance);

    /// Radiance from a unit direction; bilinear, seamless at +Z.
    glm::vec3 radiance(const glm::vec3& direction) const;
    /// Irradiance / pi on an unoccluded surface with this unit normal, within a few percent; never negative.
    glm::vec3 ambient(const glm::vec3& normal) const;
    /// Irradiance on an unoccluded surface with this unit normal. Cost: a sum over some 10,000 parts of the image.
    glm::vec3 irradiance(const glm::vec3& normal) const;
    /// The integral of radiance over all directions.
    glm::vec3 flux() const { return flux_; }

    /// Cuts the image into `count` parts of similar flux. Black parts and parts of a single direction cannot be cut, so
    /// there may be fewer. Deterministic.
    /// @param count  a power of two, 1 to 1024
    std::vector<EnvironmentLight> lights(int count) const;

    const ImageF& image() const { return image_; }
    /// Coefficients of ambient(), in the order of Ramamoorthi and Hanrahan.
    const std::array<glm::vec3, 9>& harmonics() const { return harmonics_; }
    /// Unit direction of an image point; u from the left, v from the top, 0 to 1.
    static glm::vec3 direction_at(double u, double v);

 private:
    // Sums over one cell of the coarser grid that is cut.
    struct Cell {
        glm::dvec3 flux{0};
        glm::dvec3 weighted{0};   // directions, by luminance times solid angle
        double light = 0;         // luminance times solid angle
    };
    struct Part;
    void gather();
    void project();
    Cell sum_of(const Part& part) const;
    void cut(const Part& part, int count, std::vector<EnvironmentLight>& lights) const;

    ImageF image_;
    int columns_ = 0, rows_ = 0;
    std::vector<Cell> cells_;
    glm::vec3 flux_{0};
    std::array<glm::vec3, 9> harmonics_{};   // of irradiance / pi, in the order of Ramamoorthi and Hanrahan
};

}   // namespace gnomon::scene
