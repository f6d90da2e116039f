#include "numerics/robust_loss.h"

#include <algorithm>
#include <cmath>

#include "numerics/normal.h"
#include "numerics/vector_clones.h"

namespace seater_perception {
namespace {

constexpr int kPartial = 256;  // summed in single precision before the sum is carried over

/// Tukey's loss in units of the limit c: rho = c^2 / 6 (1 - (1 - u^2)^3), psi = r (1 - u^2)^2.
SEATER_VECTOR_CLONES void sumTukey(const float* residual, const float* valid, int count, float inverse_limit,
                                   float* sums) {
  float inliers = 0, rho = 0, weights = 0, slopes = 0, squares = 0, weighted = 0, psi2 = 0, all = 0;
  for (int i = 0; i < count; ++i) {
    const float v = valid[i], r = residual[i], u = r * inverse_limit, u2 = u * u;
    const float in = u2 < 1.0F ? v : 0.0F, a = 1.0F - (u2 < 1.0F ? u2 : 1.0F), w = a * a, r2 = r * r;
    all += v;
    inliers += in;
    rho += v * (1.0F - w * a);
    weights += in * w;
    slopes += in * a * (1.0F - 5.0F * u2);
    squares += v * r2;
    weighted += in * w * r2;
    psi2 += in * w * w * r2;
  }
  const float results[] = {all, inliers, rho, weights, slopes, squares, weighted, psi2};
  for (int k = 0; k < 8; ++k) sums[k] = results[k];
}

SEATER_VECTOR_CLONES void sumHuber(const float* residual, const float* valid, int count, float limit, float* sums) {
  float inliers = 0, rho = 0, weights = 0, slopes = 0, squares = 0, weighted = 0, psi2 = 0, all = 0;
  for (int i = 0; i < count; ++i) {
    const float v = valid[i], r = residual[i], a = r < 0.0F ? -r : r, m = a < limit ? a : limit;
    const float w = limit / (a > limit ? a : limit), in = a < limit ? v : 0.0F;
    all += v;
    inliers += in;
    rho += v * m * (a - 0.5F * m);
    weights += v * w;
    slopes += in;
    squares += v * r * r;
    weighted += v * w * r * r;
    psi2 += v * m * m;
  }
  const float results[] = {all, inliers, rho, weights, slopes, squares, weighted, psi2};
  for (int k = 0; k < 8; ++k) sums[k] = results[k];
}

}  // namespace

double clippedMean(double mean, double sd, const ClipRange& range, double& by_mean) {
  by_mean = 1.0;
  double result = mean;
  const auto overshoot = [sd](double z, double& beyond) {  // mean of max(0, n - z) for standard normal n
    beyond = normalDistribution(-z);
    return sd * (normalDensity(z) - z * beyond);
  };
  double beyond = 0.0;
  if (range.high - mean > kClipReach * sd && mean - range.low > kClipReach * sd) return mean;
  const double up = (range.high - mean) / sd, down = (mean - range.low) / sd;
  if (up < kClipReach) {
    result -= overshoot(up, beyond);
    by_mean -= beyond;
  }
  if (down < kClipReach) {
    result += overshoot(down, beyond);
    by_mean -= beyond;
  }
  by_mean = std::max(0.0, by_mean);
  return result;
}

LossSums sumLoss(const float* residual, const float* valid, int count, double scale, RobustLoss loss, double tukey) {
  const double limit = loss == RobustLoss::tukey ? tukey * scale : kHuber * scale;
  double total[8] = {};
  for (int first = 0; first < count; first += kPartial) {
    float sums[8];
    const int n = std::min(kPartial, count - first);
    if (loss == RobustLoss::tukey)
      sumTukey(residual + first, valid + first, n, static_cast<float>(1.0 / limit), sums);
    else
      sumHuber(residual + first, valid + first, n, static_cast<float>(limit), sums);
    for (int k = 0; k < 8; ++k) total[k] += sums[k];
  }
  const double unit = loss == RobustLoss::tukey ? limit * limit / 6.0 : 1.0;
  return {total[0], total[1], unit * total[2], total[3], total[4], total[5], total[6], total[7]};
}

}  // namespace seater_perception
