#include "search/code/spot_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "numerics/solve.h"

namespace seater_perception {
namespace {

// Narrower than these a spot could pass for a bit, wider than these it is a slope of the light.
constexpr double kNarrowest = 0.6, kNarrowestMean = 0.9, kWidest = 4.0;  // [cells] standard deviation
constexpr double kFarthest = 1.2;                                        // of half a side, from the print's middle
constexpr double kFirstWidths[] = {1.1, 2.2};                            // [cells] tried first
constexpr int kPlaces = 4;                                               // along a side, tried first
// Of the search for the best spot: the last steps are then below a hundredth of a side. Chosen by hand.
constexpr int kRounds = 9;
constexpr double kFirstSteps[] = {0.2, 0.2, 0.4, 0.4, 0.5};  // as of Spot
constexpr double kHopeless = 0.7;   // of what the code alone leaves: more is no spot to begin with
constexpr double kSmallest = 0.04;  // [full light] of a spot

}  // namespace

double& Spot::operator[](int i) {
  double* all[] = {&x, &y, &log_first, &log_second, &turn};
  return *all[i];
}

Eigen::Matrix2d Spot::precision() const {
  const Eigen::Vector2d along(std::cos(turn), std::sin(turn)), across(-along.y(), along.x());
  return std::exp(-2.0 * log_first) * along * along.transpose() +
         std::exp(-2.0 * log_second) * across * across.transpose();
}

SpotFit::SpotFit(const PatternGrid& grid, const ImageLevels::Samples& samples, const PatternTemplate& pattern,
                 double gamma)
    : cell_(2.0F / static_cast<float>(grid.cells())), rows_(grid.size(), kUnknowns - 1), light_(grid.size()) {
  PatternTemplate::Fit value, quiet;
  value.gain = quiet.quiet = 1.0;
  for (int row = 0, i = 0; row < grid.along(); ++row) {
    for (int column = 0; column < grid.along(); ++column, ++i) {
      rows_.row(i).head<3>() << 1.0F, grid.x(column), grid.y(row);
      light_[i] = std::pow(samples.grey[i] / 255.0F, static_cast<float>(gamma));
    }
  }
  rows_.col(3) = pattern.grey(value);
  rows_.col(4) = pattern.grey(quiet);
  x_ = rows_.col(1);
  y_ = rows_.col(2);
  for (Eigen::Index k = 0; k < rows_.cols(); ++k) rows_.col(k).array() *= samples.weights.array();
  light_.array() *= samples.weights.array();
  normal_.topLeftCorner<kUnknowns - 1, kUnknowns - 1>() = (rows_.transpose().lazyProduct(rows_)).cast<double>();
  right_.head<kUnknowns - 1>() = (rows_.transpose() * light_).cast<double>();
  squares_ = static_cast<double>(light_.squaredNorm());
}

SpotFit::Result SpotFit::without() const {
  Normal N = normal_;
  N(5, 5) = 1.0;
  return {squares_ - right_.dot(solved(N, right_)), 0.0};
}

SpotFit::Result SpotFit::with(const Spot& spot) const {
  const Result none{2.0 * squares_, 0.0};
  const double first = std::exp(spot.log_first) / cell_, second = std::exp(spot.log_second) / cell_;
  const bool possible = std::min(first, second) > kNarrowest && std::sqrt(first * second) > kNarrowestMean &&
                        std::max(first, second) < kWidest && std::max(std::abs(spot.x), std::abs(spot.y)) < kFarthest;
  if (!possible) return none;
  const Eigen::Matrix2f S = (-0.5 * spot.precision()).cast<float>();
  const auto dx = x_ - static_cast<float>(spot.x), dy = y_ - static_cast<float>(spot.y);
  // Where nothing was seen, the other columns and the light are 0, and the spot's own squares hardly more.
  const Eigen::VectorXf g = (S(0, 0) * dx * dx + 2.0F * S(0, 1) * dx * dy + S(1, 1) * dy * dy).exp();
  Normal N = normal_;
  Column b = right_;
  N.col(5).head<kUnknowns - 1>() = (rows_.transpose() * g).cast<double>();
  N.row(5) = N.col(5).transpose();
  N(5, 5) = static_cast<double>(g.squaredNorm()) + 1e-9;
  b[5] = static_cast<double>(light_.dot(g));
  const Column c = solved(N, b);
  return c[5] > kSmallest && c[3] > 0.0 ? Result{squares_ - b.dot(c), c[5]} : none;
}

Spot SpotFit::coarse(Result& result) const {
  Spot best;
  for (const double width : kFirstWidths) {
    for (int k = 0; k < kPlaces * kPlaces; ++k) {
      const auto at = [](int i) { return 2.0 * (i + 0.5) / kPlaces - 1.0; };
      const double log_width = std::log(width * static_cast<double>(cell_));
      const Spot spot{at(k % kPlaces), at(k / kPlaces), log_width, log_width, 0.0};
      const Result there = with(spot);
      if (there.left < result.left) result = there, best = spot;
    }
  }
  return best;
}

/// Coordinate by coordinate (R. Hooke and T. Jeeves, "Direct search", 1961).
void SpotFit::refine(Spot& spot, Result& result) const {
  std::array<double, Spot::kUnknowns> steps;
  std::copy(std::begin(kFirstSteps), std::end(kFirstSteps), steps.begin());
  for (int round = 0; round < kRounds; ++round) {
    for (int i = 0; i < Spot::kUnknowns; ++i) {
      double& step = steps[static_cast<std::size_t>(i)];
      bool better = false;
      for (const double sign : {1.0, -1.0}) {
        Spot other = spot;
        other[i] += sign * step;
        const Result there = with(other);
        if (!(there.left < result.left)) continue;
        result = there, spot = other, better = true;
        break;
      }
      if (!better) step *= 0.5;
    }
  }
}

Spot SpotFit::best(Result& result) const {
  const Result before = result = without();
  Spot spot = coarse(result);
  if (result.left < kHopeless * before.left)
    refine(spot, result);
  else
    result = before;
  return spot;
}

}  // namespace seater_perception
