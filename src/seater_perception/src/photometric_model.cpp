#include "seater_perception/photometric_model.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace seater_perception {
namespace {

constexpr double kReach = 4.2;  // [standard deviations] beyond it a cell border is not felt: 1e-5
constexpr int kMaxLines = 6;    // borders within reach along one axis; more only if the blur is wider than a cell
constexpr double kNoCorrelation = 1e-5;
constexpr double kMaxCorrelation = 0.95;
constexpr int kTableSteps = 64;  // per standard deviation
constexpr int kTableReach = 5;

/// Normal distribution and density, by cubic Hermite interpolation: 1e-9.
class NormalTable {
 public:
  NormalTable() {
    for (int i = 0; i < kSize; ++i) {
      const double h = static_cast<double>(i) / kTableSteps - kTableReach;
      distribution_[static_cast<std::size_t>(i)] = 0.5 * std::erfc(-h * M_SQRT1_2);
      density_[static_cast<std::size_t>(i)] = std::exp(-0.5 * h * h) / std::sqrt(2.0 * M_PI);
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

MarkerPlane::MarkerPlane(const Eigen::Isometry3d& pose)
    : r1_(pose.linear().col(0)), r2_(pose.linear().col(1)), r3_(pose.linear().col(2)) {
  t1_ = r1_.dot(pose.translation());
  t2_ = r2_.dot(pose.translation());
  t3_ = r3_.dot(pose.translation());
  inverse_t3_ = 1.0 / t3_;
}

bool MarkerPlane::hit(const PixelRay& ray, const SpreadCovariance& spread, MarkerHit& hit) const {
  const double along = r3_.x() * ray.x + r3_.y() * ray.y + r3_.z();
  const double inverse = 1.0 / along, depth = t3_ * inverse;
  if (!(depth > 1e-6 && depth < 1e6)) return false;
  hit.alpha = (r1_.x() * ray.x + r1_.y() * ray.y + r1_.z()) * inverse;
  hit.beta = (r2_.x() * ray.x + r2_.y() * ray.y + r2_.z()) * inverse;
  hit.x = t3_ * hit.alpha - t1_;
  hit.y = t3_ * hit.beta - t2_;
  const double x0 = depth * (r1_.x() - hit.alpha * r3_.x()), x1 = depth * (r1_.y() - hit.alpha * r3_.y());
  const double y0 = depth * (r2_.x() - hit.beta * r3_.x()), y1 = depth * (r2_.y() - hit.beta * r3_.y());
  hit.gxu = x0 * ray.x_by_u + x1 * ray.y_by_u;
  hit.gxv = x0 * ray.x_by_v + x1 * ray.y_by_v;
  hit.gyu = y0 * ray.x_by_u + y1 * ray.y_by_u;
  hit.gyv = y0 * ray.x_by_v + y1 * ray.y_by_v;
  const double xx = spread.uu * hit.gxu * hit.gxu + 2.0 * spread.uv * hit.gxu * hit.gxv + spread.vv * hit.gxv * hit.gxv;
  const double yy = spread.uu * hit.gyu * hit.gyu + 2.0 * spread.uv * hit.gyu * hit.gyv + spread.vv * hit.gyv * hit.gyv;
  const double xy = spread.uu * hit.gxu * hit.gyu + spread.uv * (hit.gxu * hit.gyv + hit.gxv * hit.gyu) +
                    spread.vv * hit.gxv * hit.gyv;
  if (!(xx > 0.0 && yy > 0.0)) return false;
  const double product = std::sqrt(xx * yy), inverse_product = 1.0 / product;
  hit.sx = std::sqrt(xx);
  hit.ratio = yy * inverse_product;
  hit.inverse_ratio = xx * inverse_product;
  hit.sy = hit.sx * hit.ratio;
  hit.rho = std::clamp(xy * inverse_product, -kMaxCorrelation, kMaxCorrelation);
  return true;
}

// With e1 = r1 - alpha r3 and e2 = r2 - beta r3, the ray's hit moves by dx = -e1 . d + w . (e1 x X), the gradients of x
// and y by the pixel change by (dlambda / lambda - alpha w2) grad x + (w3 + alpha w1) grad y and alike, which gives the
// changes of sx, sy and rho.
void MarkerPlane::derivativeByMotion(const MarkerHit& hit, const PatternResponse& response, double per_metre,
                                     double by_motion[6]) const {
  const double gx = response.by_x * per_metre, gy = response.by_y * per_metre;
  const double bx = response.by_log_sx, by = response.by_log_sy;
  const double twist = response.by_rho * (1.0 - hit.rho * hit.rho);
  const double p = (bx * hit.rho + twist) * hit.ratio;
  const double q = -(by * hit.rho + twist) * hit.inverse_ratio;
  const double away = hit.alpha * gx + hit.beta * gy + (bx + by) * inverse_t3_;
  by_motion[0] = -gx;
  by_motion[1] = -gy;
  by_motion[2] = away;
  by_motion[3] = hit.y * away + hit.alpha * p + hit.beta * by;
  by_motion[4] = -hit.x * away - hit.alpha * bx + hit.beta * q;
  by_motion[5] = hit.y * gx - hit.x * gy + p + q;
}

void derivativeBySpread(const MarkerHit& hit, const PatternResponse& response, double by_spread[3]) {
  const double ixx = 1.0 / (hit.sx * hit.sx), iyy = 1.0 / (hit.sy * hit.sy), ixy = response.by_rho / (hit.sx * hit.sy);
  const double cx = 0.5 * (response.by_log_sx - hit.rho * response.by_rho) * ixx;
  const double cy = 0.5 * (response.by_log_sy - hit.rho * response.by_rho) * iyy;
  by_spread[0] = cx * hit.gxu * hit.gxu + cy * hit.gyu * hit.gyu + ixy * hit.gxu * hit.gyu;
  by_spread[1] =
      2.0 * (cx * hit.gxu * hit.gxv + cy * hit.gyu * hit.gyv) + ixy * (hit.gxu * hit.gyv + hit.gxv * hit.gyu);
  by_spread[2] = cx * hit.gxv * hit.gxv + cy * hit.gyv * hit.gyv + ixy * hit.gxv * hit.gyv;
}

}  // namespace seater_perception
