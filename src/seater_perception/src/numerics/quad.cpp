#include "numerics/quad.h"

#include <algorithm>

namespace seater_perception {
namespace {

/// Side i leads from corner i to the next one.
double side(const Quad& quad, std::size_t i) {
  return (quad[(i + 1) % 4] - quad[i]).norm();
}

}  // namespace

double meanSide(const Quad& quad) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum += side(quad, i);
  return 0.25 * sum;
}

double shortestSide(const Quad& quad) {
  return std::min({side(quad, 0), side(quad, 1), side(quad, 2), side(quad, 3)});
}

double longestSide(const Quad& quad) {
  return std::max({side(quad, 0), side(quad, 1), side(quad, 2), side(quad, 3)});
}

Eigen::Vector2d centre(const Quad& quad) {
  return 0.25 * (quad[0] + quad[1] + quad[2] + quad[3]);
}

Eigen::AlignedBox2d boundingBox(const Quad& quad) {
  Eigen::AlignedBox2d box;
  for (const auto& corner : quad) box.extend(corner);
  return box;
}

}  // namespace seater_perception
