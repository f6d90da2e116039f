#pragma once

#include <Eigen/Geometry>
#include <array>

namespace seater_perception {

/// Corners of a quadrilateral in the image, in order round it [px].
using Quad = std::array<Eigen::Vector2d, 4>;

double meanSide(const Quad& quad);                  ///< [px]
double shortestSide(const Quad& quad);              ///< [px]
double longestSide(const Quad& quad);               ///< [px]
Eigen::Vector2d centre(const Quad& quad);           ///< mean of the corners
Eigen::AlignedBox2d boundingBox(const Quad& quad);  ///< the smallest one with all corners

}  // namespace seater_perception
