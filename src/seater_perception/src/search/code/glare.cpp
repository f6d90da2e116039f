#include "search/code/glare.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "search/code/spot_fit.h"

namespace seater_perception {
namespace {

// What is chosen here was chosen with drawn prints (docs/results/photographs.md, "Another maker's cameras"): the
// false codes that looser limits let through had spots of 0.85 cells, no power law and little more brightness.
constexpr double kBrighter = 0.2;  // of the contrast over the quiet zone's median: sharpened edges have 0.1 to 0.2
constexpr std::size_t kFewestBright = 3;  // samples
constexpr int kTogether = 6;              // samples (two a cell) between these, at most
// Cameras' grey levels follow the light by a curve like sRGB's (IEC 61966-2-1), about this power.
constexpr double kGamma = 2.2;
constexpr double kLeft = 0.4;   // of what the code alone leaves, the most that spot and code may leave
constexpr double kStep = 0.01;  // [half sides] of derivatives

}  // namespace

double Glare::light(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d d = p - centre;
  return height * std::exp(-0.5 * d.dot(precision * d));
}

Glare Glare::seenFrom(const Eigen::Vector2d& origin) const {
  Glare there = *this;
  there.centre -= origin;
  there.region -= cv::Point(static_cast<int>(origin.x()), static_cast<int>(origin.y()));
  return there;
}

bool mayHaveGlare(const PatternGrid& grid, const ImageLevels::Samples& samples) {
  std::vector<float> quiet, border;
  struct Bright {
    float grey = 0.0F;
    int row = 0, column = 0;
  };
  std::array<Bright, kFewestBright> brightest;  // ascending
  for (int row = 0, i = 0; row < grid.along(); ++row) {
    for (int column = 0; column < grid.along(); ++column, ++i) {
      if (!(samples.weights[i] > 0.0F)) continue;
      const int ring = grid.ring(row, column);
      if (ring == 0) quiet.push_back(samples.grey[i]);
      if (ring == 1) border.push_back(samples.grey[i]);
      if (!(samples.grey[i] > brightest[0].grey)) continue;
      brightest[0] = {samples.grey[i], row, column};
      std::sort(brightest.begin(), brightest.end(), [](const Bright& a, const Bright& b) { return a.grey < b.grey; });
    }
  }
  if (quiet.empty() || border.empty()) return false;
  const auto median = [](std::vector<float>& v) {
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
  };
  const float white = median(quiet), dark = median(border);
  if (!(white > dark && brightest[0].grey > white + static_cast<float>(kBrighter) * (white - dark))) return false;
  for (const Bright& a : brightest) {
    for (const Bright& b : brightest) {
      if (std::max(std::abs(a.row - b.row), std::abs(a.column - b.column)) > kTogether) return false;
    }
  }
  return true;
}

std::optional<Glare> findGlare(const PatternGrid& grid, const ImageLevels::Samples& samples,
                               const PatternTemplate& pattern, const Quad& quad) {
  const SpotFit fit(grid, samples, pattern, kGamma);
  SpotFit::Result result;
  const Spot best = fit.best(result);
  if (!(result.height > 0.0) || !(result.left < kLeft * fit.without().left)) return std::nullopt;
  Glare glare;
  glare.height = result.height;
  const SquareToQuad map(quad);
  const Eigen::Vector2d at(best.x, best.y);
  Eigen::Matrix2d to_pixel;
  to_pixel << (map(at + Eigen::Vector2d(kStep, 0.0)) - map(at - Eigen::Vector2d(kStep, 0.0))) / (2.0 * kStep),
      (map(at + Eigen::Vector2d(0.0, kStep)) - map(at - Eigen::Vector2d(0.0, kStep))) / (2.0 * kStep);
  const double det = to_pixel(0, 0) * to_pixel(1, 1) - to_pixel(0, 1) * to_pixel(1, 0);
  if (!(std::abs(det) > 1e-6)) return std::nullopt;
  Eigen::Matrix2d to_square;
  to_square << to_pixel(1, 1), -to_pixel(0, 1), -to_pixel(1, 0), to_pixel(0, 0);
  to_square /= det;
  glare.centre = map(at);
  glare.precision = to_square.transpose() * best.precision() * to_square;
  glare.region = regionRound(quad);
  return glare;
}

cv::Mat withoutGlare(const cv::Mat& grey, const std::vector<Glare>& glares) {
  if (glares.empty()) return grey;
  cv::Mat lit = grey.clone();
  double light[256];
  for (int i = 0; i < 256; ++i) light[i] = std::pow(i / 255.0, kGamma);
  for (const Glare& glare : glares) {
    const cv::Rect region = glare.region & cv::Rect(0, 0, grey.cols, grey.rows);
    for (int v = region.y; v < region.y + region.height; ++v) {
      uchar* to = lit.ptr<uchar>(v);
      for (int u = region.x; u < region.x + region.width; ++u) {
        const double left = std::max(0.0, light[to[u]] - glare.light({static_cast<double>(u), static_cast<double>(v)}));
        to[u] = cv::saturate_cast<uchar>(255.0 * std::pow(left, 1.0 / kGamma));
      }
    }
  }
  return lit;
}

}  // namespace seater_perception
