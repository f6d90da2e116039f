#include "search/code/shadow_edge.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "numerics/normal.h"

namespace seater_perception {
namespace {

// Chosen by hand: a weaker shadow is fitted as a slope of the light, a stronger one leaves too few grey levels. What is
// found in between is measured by perception_shadows (docs/results/perception.md) and guarded by shadow_edge_test.
constexpr double kStrongest = 0.1, kWeakest = 0.9;  // light in the shadow
// Chosen by hand: two levels explain 2 / pi = 0.64 of normally distributed samples, 0.75 of evenly distributed ones (a
// slope of the light), and all of two levels.
constexpr double kDivided = 0.85;               // part of the quiet zone's variance that two levels have to explain
constexpr std::size_t kFewest = 4;              // samples of a level; chosen by hand
constexpr double kWidths[] = {0.15, 0.3, 0.6};  // [cells] that are tried; chosen by hand

struct RingSample {
  Eigen::Vector2d at;  // square -1 .. 1
  double grey;
};

/// The quiet zone's samples, once round.
std::vector<RingSample> ringOf(const PatternGrid& grid, const ImageLevels::Samples& samples) {
  std::vector<RingSample> ring;
  const int last = grid.along() - 1;
  const auto add = [&](int row, int column) {
    const int i = row * grid.along() + column;
    if (samples.weights[i] > 0.0F) ring.push_back({{grid.x(column), grid.y(row)}, samples.grey[i]});
  };
  for (int k = 0; k < last; ++k) add(0, k);
  for (int k = 0; k < last; ++k) add(k, last);
  for (int k = last; k > 0; --k) add(last, k);
  for (int k = last; k > 0; --k) add(k, 0);
  return ring;
}

struct Levels {
  double dark = 0.0, light = 0.0, explained = 0.0;
};

/// Two levels that explain most (N. Otsu, "A threshold selection method from gray-level histograms", 1979).
Levels divide(const std::vector<RingSample>& ring) {
  std::vector<double> sorted;
  for (const RingSample& s : ring) sorted.push_back(s.grey);
  std::sort(sorted.begin(), sorted.end());
  double sum = 0.0, squares = 0.0, below = 0.0;
  for (const double g : sorted) sum += g, squares += g * g;
  const auto n = static_cast<double>(sorted.size());
  const double variance = squares - sum * sum / n;
  Levels best;
  for (std::size_t k = 0; k + 1 < sorted.size(); ++k) {
    below += sorted[k];
    const double m = static_cast<double>(k + 1), dark = below / m, light = (sum - below) / (n - m);
    const double between = m * (n - m) / n * (light - dark) * (light - dark);
    if (k + 1 >= kFewest && k + 1 + kFewest <= sorted.size() && between > best.explained * variance) {
      best = {dark, light, between / variance};
    }
  }
  return best;
}

/// Places where the ring passes from one level into the other.
std::vector<Eigen::Vector2d> crossings(const std::vector<RingSample>& ring, double threshold) {
  std::vector<Eigen::Vector2d> places;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const RingSample &a = ring[i], &b = ring[(i + 1) % ring.size()];
    if ((a.grey < threshold) == (b.grey < threshold)) continue;
    places.push_back(a.at + (threshold - a.grey) / (b.grey - a.grey) * (b.at - a.at));
  }
  return places;
}

/// How far out a pixel lies in a region: 0 in the middle, 1 at its border.
double eccentricity(const cv::Rect& region, const cv::Point& p) {
  const double x = (2.0 * (p.x - region.x) + 1.0) / region.width - 1.0;
  const double y = (2.0 * (p.y - region.y) + 1.0) / region.height - 1.0;
  return std::max(std::abs(x), std::abs(y));
}

/// Of the shadows in whose regions the pixel lies (one at least), that of the nearest print.
const ShadowEdge& nearest(const std::vector<ShadowEdge>& shadows, const cv::Point& p) {
  const ShadowEdge* best = nullptr;
  double least = 0.0;
  for (const ShadowEdge& shadow : shadows) {
    if (!shadow.region.contains(p)) continue;
    const double out = eccentricity(shadow.region, p);
    if (!best || out < least) best = &shadow, least = out;
  }
  return *best;
}

/// The transition's width that explains the ring best.
double widthOf(const std::vector<RingSample>& ring, const Levels& levels, const SquareToQuad& map, double cell,
               ShadowEdge shadow) {
  double best = 0.0, smallest = 0.0;
  for (const double cells : kWidths) {
    shadow.width = cells * cell;
    double squares = 0.0;
    for (const RingSample& s : ring) squares += std::pow(s.grey - levels.light * shadow.light(map(s.at)), 2);
    if (best == 0.0 || squares < smallest) best = shadow.width, smallest = squares;
  }
  return best;
}

}  // namespace

double ShadowEdge::light(const Eigen::Vector2d& p) const {
  return factor + (1.0 - factor) * normalDistribution((normal.dot(p) - offset) / width);
}

ShadowEdge ShadowEdge::seenFrom(const Eigen::Vector2d& origin) const {
  ShadowEdge there = *this;
  there.offset -= normal.dot(origin);
  there.region -= cv::Point(static_cast<int>(origin.x()), static_cast<int>(origin.y()));
  return there;
}

std::optional<ShadowEdge> findShadowEdge(const PatternGrid& grid, const ImageLevels::Samples& samples,
                                         const Quad& quad) {
  const std::vector<RingSample> ring = ringOf(grid, samples);
  if (ring.size() < 4 * kFewest) return std::nullopt;
  // No two groups of them differ by more than the lightest and the darkest.
  const auto darker = [](const RingSample& a, const RingSample& b) { return a.grey < b.grey; };
  const auto [darkest, lightest] = std::minmax_element(ring.begin(), ring.end(), darker);
  if (!(darkest->grey < kWeakest * lightest->grey)) return std::nullopt;
  const Levels levels = divide(ring);
  if (!(levels.light > 0.0) || levels.explained < kDivided) return std::nullopt;
  ShadowEdge shadow;
  shadow.factor = levels.dark / levels.light;
  if (!(shadow.factor > kStrongest && shadow.factor < kWeakest)) return std::nullopt;
  const auto places = crossings(ring, 0.5 * (levels.dark + levels.light));
  if (places.size() != 2) return std::nullopt;
  const SquareToQuad map(quad);
  const Eigen::Vector2d a = map(places[0]), along = map(places[1]) - a;
  if (!(along.norm() > 1.0)) return std::nullopt;
  shadow.normal = Eigen::Vector2d(-along.y(), along.x()).normalized();
  shadow.offset = shadow.normal.dot(a);
  // On which side it is light.
  double side = 0.0;
  for (const RingSample& s : ring) {
    side += (s.grey - 0.5 * (levels.dark + levels.light)) * (shadow.normal.dot(map(s.at)) - shadow.offset);
  }
  if (side < 0.0) shadow.normal = -shadow.normal, shadow.offset = -shadow.offset;
  shadow.width = widthOf(ring, levels, map, meanSide(quad) / grid.cells(), shadow);
  shadow.region = regionRound(quad);
  return shadow;
}

cv::Mat withoutShadows(const cv::Mat& grey, const std::vector<ShadowEdge>& shadows) {
  if (shadows.empty()) return grey;
  cv::Mat lit = grey.clone();
  for (const ShadowEdge& shadow : shadows) {
    const cv::Rect region = shadow.region & cv::Rect(0, 0, grey.cols, grey.rows);
    for (int v = region.y; v < region.y + region.height; ++v) {
      const uchar* from = grey.ptr<uchar>(v);
      uchar* to = lit.ptr<uchar>(v);
      for (int u = region.x; u < region.x + region.width; ++u) {
        if (&nearest(shadows, {u, v}) == &shadow) to[u] = cv::saturate_cast<uchar>(from[u] / shadow.light({u, v}));
      }
    }
  }
  return lit;
}

}  // namespace seater_perception
