#include "marker/photometric_model.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "numerics/normal.h"

namespace seater_perception {
namespace {

constexpr double kReach = 4.2;  // [standard deviations] beyond it a cell border is not felt: 1e-5
constexpr int kMaxLines = 6;    // borders within reach along one axis; more only if the PSF is wider than a cell
constexpr double kNoCorrelation = 1e-5;  // adds at most rho / (2 pi), less than what kReach leaves out
// Cubic interpolation with this step is exact to 1e-9: h^4 / 384 times the largest fourth derivative.
constexpr int kTableSteps = 64;  // per standard deviation
constexpr int kTableReach = 5;   // [standard deviations] beyond kReach

/// Normal distribution and density, by cubic Hermite interpolation: 1e-9.
class NormalTable {
 public:
  NormalTable() {
    for (int i = 0; i < kSize; ++i) {
      const double h = static_cast<double>(i) / kTableSteps - kTableReach;
      distribution_[static_cast<std::size_t>(i)] = normalDistribution(h);
      density_[static_cast<std::size_t>(i)] = normalDensity(h);
    }
  }

  /// |h| has to be less than kTableReach.
  void at(double h, double& distribution, double& density) const {
    const double position = (h + kTableReach) * kTableSteps;
    const auto i = static_cast<std::size_t>(position);
    const double t = position - static_cast<double>(i), step = 1.0 / kTableSteps;
    const double h0 = h - t * step, h1 = h0 + step;
    const double d0 = density_[i], d1 = density_[i + 1];
    const double t2 = t * t, u = t2 * (3.0 - 2.0 * t), a = step * (t - 2.0 * t2 + t2 * t), b = step * (t2 * t - t2);
    distribution = distribution_[i] + u * (distribution_[i + 1] - distribution_[i]) + a * d0 + b * d1;
    density = d0 + u * (d1 - d0) - a * h0 * d0 - b * h1 * d1;
  }

 private:
  static constexpr int kSize = 2 * kTableReach * kTableSteps + 2;
  std::array<double, kSize> distribution_, density_;
};

const NormalTable kNormal;

/// The borders between cells that are felt along one axis.
struct Lines {
  int before = 0;  // column (row) on the near side of the first border
  int count = 0;
  double scale;                                                // 1 / sigma
  double h[kMaxLines], weight[kMaxLines], density[kMaxLines];  // standardised distance, share beyond the border

  Lines(double at, double sigma, int cells) : scale(1.0 / sigma) {
    // Casting truncates towards zero; all is at least 0 there.
    const double low = std::clamp(at - kReach * sigma + 1.0, 0.0, cells + 2.0), high = at + kReach * sigma;
    int first = static_cast<int>(low);
    int last = high < 0.0 ? -1 : static_cast<int>(std::min(high, static_cast<double>(cells)));
    while (last - first >= kMaxLines) {  // the farther end gives way
      if (at - first > last - at)
        ++first;
      else
        --last;
    }
    before = std::min(first - 1, cells);
    count = std::max(0, last - first + 1);
    for (int i = 0; i < count; ++i) {
      h[i] = (at - (first + i)) * scale;
      h[i] = std::clamp(h[i], -kReach, kReach);
      kNormal.at(h[i], weight[i], density[i]);
    }
  }
};

/// What the correlation adds where border i of x crosses border j of y; c is the crossing's second difference.
void addCrossing(double h, double k, double density, double rho, PatternResponse& out, double& by_h, double& by_k) {
  const double h2 = h * h - 1.0, k2 = k * k - 1.0, h3 = h * (h * h - 3.0), k3 = k * (k * k - 3.0);
  const double h4 = h * h * (h * h - 6.0) + 3.0, k4 = k * k * (k * k - 6.0) + 3.0;
  const double a2 = rho * rho / 2.0, a3 = a2 * rho / 3.0, a4 = a3 * rho / 4.0;
  out.value += density * (rho + a2 * h * k + a3 * h2 * k2 + a4 * h3 * k3);
  by_h -= density * (rho * h + a2 * h2 * k + a3 * h3 * k2 + a4 * h4 * k3);
  by_k -= density * (rho * k + a2 * k2 * h + a3 * k3 * h2 + a4 * k4 * h3);
  out.by_rho += density * (1.0 + rho * h * k + a2 * h2 * k2 + a3 * h3 * k3);
}

}  // namespace

PatternResponse smoothedPattern(const MarkerPattern& pattern, double x, double y, double sx, double sy, double rho) {
  const Lines columns(x, sx, pattern.cells()), rows(y, sy, pattern.cells());
  PatternResponse out;
  const int c0 = columns.before, r0 = rows.before;
  if (columns.count == 0 && rows.count == 0) {
    out.value = pattern.at(c0, r0);
    return out;
  }
  // step[i]: jump at border i within the current row, summed up over the rows below by their weights.
  double step[kMaxLines], below_step[kMaxLines], below = 0.0;
  double by_hx[kMaxLines] = {};
  for (int j = 0; j <= rows.count; ++j) {
    double left = pattern.at(c0, r0 + j), row_value = left;
    for (int i = 0; i < columns.count; ++i) {
      const double right = pattern.at(c0 + 1 + i, r0 + j);
      step[i] = right - left;
      row_value += step[i] * columns.weight[i];
      left = right;
    }
    if (j == 0) {
      out.value = row_value;
      for (int i = 0; i < columns.count; ++i) by_hx[i] = step[i];
    } else {
      const double share = rows.weight[j - 1], k = rows.h[j - 1];
      out.value += share * (row_value - below);
      double by_k = rows.density[j - 1] * (row_value - below);
      for (int i = 0; i < columns.count; ++i) {
        const double crossing = step[i] - below_step[i];
        by_hx[i] += share * crossing;
        if (crossing == 0.0 || std::abs(rho) < kNoCorrelation) continue;
        double by_h = 0.0;
        addCrossing(columns.h[i], k, crossing * columns.density[i] * rows.density[j - 1], rho, out, by_h, by_k);
        out.by_x += by_h;
        out.by_log_sx -= by_h * columns.h[i];
      }
      out.by_y += by_k;
      out.by_log_sy -= by_k * k;
    }
    below = row_value;
    for (int i = 0; i < columns.count; ++i) below_step[i] = step[i];
  }
  for (int i = 0; i < columns.count; ++i) {
    const double by_h = by_hx[i] * columns.density[i];
    out.by_x += by_h;
    out.by_log_sx -= by_h * columns.h[i];
  }
  out.by_x *= columns.scale;
  out.by_y *= rows.scale;
  out.flat = false;
  return out;
}

}  // namespace seater_perception
