#include "seater_perception/edge_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

namespace seater_perception {
namespace {

constexpr double kSkippedEnd = 2.5;        // [px] of each end of a side: the blurred corner; and at most
constexpr double kSkippedPart = 0.2;       // of the half side
constexpr double kShortestFit = 8.0;       // [px] a shorter side has too few pixels
constexpr double kBentFrom = 60.0;         // [px] from this length on, a side may be a parabola
constexpr double kSmallestContrast = 8.0;  // [grey levels] between light and dark
constexpr double kLargestResidual = 0.15;  // rms, of the contrast: more is not one edge
constexpr int kSteps = 12;
constexpr double kDone = 1e-3;          // [px]
constexpr std::size_t kSamples = 1200;  // of a side are enough; a longer side gives every second, third ... pixel

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

struct Sample {
  double t, s, grey;  // t from -1 to 1 along the side, s [px] outwards
};

/// A side: where it was supposed to be, and the fitted offset outwards, a + b t + c t^2 [px].
struct Side {
  Eigen::Vector2d middle, along, outward;  // unit vectors
  double half = 0.0;                       // half length [px]
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();

  double at(double t) const { return offset[0] + t * (offset[1] + t * offset[2]); }
  Eigen::Vector2d point(double t) const { return middle + t * half * along + at(t) * outward; }
  Eigen::Vector2d tangent(double t) const { return half * along + (offset[1] + 2.0 * t * offset[2]) * outward; }
};

Side between(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Eigen::Vector2d& inside) {
  Side side;
  side.middle = 0.5 * (from + to);
  side.half = 0.5 * (to - from).norm();
  side.along = (to - from) / (2.0 * side.half);
  side.outward = Eigen::Vector2d(side.along.y(), -side.along.x());
  if (side.outward.dot(inside - side.middle) > 0.0) side.outward = -side.outward;
  return side;
}

/// All pixels of the band round the side as it is known now; false when the band leaves the picture.
bool collect(const cv::Mat& grey, const Side& side, double band, std::vector<Sample>& samples) {
  samples.clear();
  const double reach = 1.0 - std::min(kSkippedPart, kSkippedEnd / side.half);
  const Eigen::Vector2d a = side.point(-1.0), b = side.point(1.0);
  const double margin = band + std::abs(side.offset[2]) + 1.0;
  const int x0 = static_cast<int>(std::floor(std::min(a.x(), b.x()) - margin));
  const int x1 = static_cast<int>(std::ceil(std::max(a.x(), b.x()) + margin));
  const int y0 = static_cast<int>(std::floor(std::min(a.y(), b.y()) - margin));
  const int y1 = static_cast<int>(std::ceil(std::max(a.y(), b.y()) + margin));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector2d d = Eigen::Vector2d(x, y) - side.middle;
      const double t = d.dot(side.along) / side.half, s = d.dot(side.outward);
      if (std::abs(t) > reach || std::abs(s - side.at(t)) > band) continue;
      if (x < 0 || y < 0 || x >= grey.cols || y >= grey.rows) return false;
      samples.push_back({t, s, static_cast<double>(grey.at<uchar>(y, x))});
    }
  }
  if (samples.size() < 16) return false;
  const std::size_t stride = samples.size() / kSamples + 1;
  if (stride > 1) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < samples.size(); i += stride) samples[kept++] = samples[i];
    samples.resize(kept);
  }
  return true;
}

/// Parameters of the step: offset a, b, c; middle grey, half contrast, width.
struct Step {
  Vector6d p;

  /// Grey level of a sample and its derivative by the parameters.
  double value(const Sample& q, Vector6d& by_p) const {
    const double z = (q.s - (p[0] + q.t * (p[1] + q.t * p[2]))) / (std::sqrt(2.0) * p[5]);
    const double step = std::erf(z);
    const double slope = p[4] * 2.0 / std::sqrt(M_PI) * std::exp(-z * z);
    const double by_offset = -slope / (std::sqrt(2.0) * p[5]);
    by_p << by_offset, by_offset * q.t, by_offset * q.t * q.t, 1.0, step, -slope * z / p[5];
    return p[3] + p[4] * step;
  }
};

Vector6d start(const Side& side, const std::vector<Sample>& samples) {
  double inner = 0.0, outer = 0.0;
  int inner_count = 0, outer_count = 0;
  for (const Sample& q : samples) {
    const bool is_outer = q.s > side.at(q.t);
    (is_outer ? outer : inner) += q.grey;
    ++(is_outer ? outer_count : inner_count);
  }
  inner /= std::max(1, inner_count);
  outer /= std::max(1, outer_count);
  Vector6d p;
  p << side.offset, 0.5 * (inner + outer), 0.5 * (outer - inner), 0.8;
  return p;
}

/// One Gauss-Newton fit of the step to the samples; false when it does not look like an edge.
bool fitStep(const std::vector<Sample>& samples, bool bent, double band, Step& step) {
  double residual = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    Matrix6d A = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero(), by_p;
    residual = 0.0;
    for (const Sample& q : samples) {
      const double r = q.grey - step.value(q, by_p);
      A += by_p * by_p.transpose();
      g += by_p * r;
      residual += r * r;
    }
    if (!bent) {
      A.row(2).setZero();
      A.col(2).setZero();
      A(2, 2) = 1.0;
      g[2] = 0.0;
    }
    A.diagonal() += 1e-6 * A.diagonal() + Vector6d::Constant(1e-9);
    Vector6d change = A.ldlt().solve(g);
    if (!change.allFinite()) return false;
    const double largest = change.head<3>().cwiseAbs().maxCoeff();
    if (largest > 0.5 * band) change *= 0.5 * band / largest;
    step.p += change;
    step.p[5] = std::clamp(step.p[5], 0.2, band);
    if (largest < kDone) break;
  }
  const double contrast = 2.0 * step.p[4];
  return contrast > kSmallestContrast &&
         std::sqrt(residual / static_cast<double>(samples.size())) < kLargestResidual * contrast;
}

bool fitSide(const cv::Mat& grey, double band, Side& side) {
  if (2.0 * side.half < kShortestFit) return false;
  const bool bent = 2.0 * side.half > kBentFrom;
  std::vector<Sample> samples;
  Step step;
  // The band follows the edge: one that is centred on it leaves out as much on the dark as on the light side.
  for (int round = 0; round < 3; ++round) {
    if (!collect(grey, side, band, samples)) return false;
    if (round == 0) step.p = start(side, samples);
    if (!fitStep(samples, bent, band, step)) return false;
    const Eigen::Vector3d moved = step.p.head<3>() - side.offset;
    side.offset = step.p.head<3>();
    if (side.offset.cwiseAbs().maxCoeff() > 3.0 * band + 1.0) return false;
    if (moved.cwiseAbs().maxCoeff() < 0.02) break;
  }
  return true;
}

/// Where a side's end meets the next side's beginning.
std::optional<Eigen::Vector2d> meet(const Side& side, const Side& next) {
  Eigen::Vector2d t(1.0, -1.0);
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector2d gap = next.point(t[1]) - side.point(t[0]);
    Eigen::Matrix2d J;
    J << side.tangent(t[0]), -next.tangent(t[1]);
    if (std::abs(J.determinant()) < 0.05 * side.half * next.half) return std::nullopt;
    const Eigen::Vector2d change = J.inverse() * gap;
    t += change;
    if (!t.allFinite() || t.cwiseAbs().maxCoeff() > 2.0) return std::nullopt;
    if (change.norm() * side.half < kDone) break;
  }
  return side.point(t[0]);
}

}  // namespace

std::optional<std::array<Eigen::Vector2d, 4>> fitEdges(const cv::Mat& grey,
                                                       const std::array<Eigen::Vector2d, 4>& corners,
                                                       double half_band) {
  const Eigen::Vector2d inside = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  std::array<Side, 4> sides;  // side i: from corner i to corner i + 1
  for (std::size_t i = 0; i < 4; ++i) {
    sides[i] = between(corners[i], corners[(i + 1) % 4], inside);
    if (!fitSide(grey, half_band, sides[i])) return std::nullopt;
  }
  std::array<Eigen::Vector2d, 4> result;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto corner = meet(sides[(i + 3) % 4], sides[i]);
    if (!corner || (*corner - corners[i]).norm() > half_band) return std::nullopt;
    result[i] = *corner;
  }
  return result;
}

}  // namespace seater_perception
