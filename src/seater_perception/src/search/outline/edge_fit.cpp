#include "search/outline/edge_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "numerics/column_products.h"
#include "numerics/normal.h"
#include "numerics/vector_clones.h"

namespace seater_perception {
namespace {

// A corner is rounded off within about two standard deviations of the PSF, 1.2 px in config/cameras/degraded.yaml; but
// four fifths of a short side are used.
constexpr double kSkippedEnd = 2.5;   // [px] of each end of a side; and at most
constexpr double kSkippedPart = 0.2;  // of the half side
// Leaves four fifths of it, some 25 pixels of a band of 4 px, for six unknowns. Chosen by hand.
constexpr double kShortestFit = 8.0;  // [px] length of a side
// A lens bends a side by the square of its length. Chosen by hand: a shorter side would not bear the third unknown.
// detection_test (Distortion) and camera_effects_test draw bent sides.
constexpr double kBentFrom = 60.0;  // [px] from this length on, a side may be a parabola
// Chosen by hand between what prints show (config/cameras/degraded.yaml: contrast 175, noise 0.02 of it; the dimmest of
// tracker_cases_test: contrast 40, noise 0.08) and a covered edge, which detection_test draws.
constexpr double kSmallestContrast = 8.0;  // [grey levels] between light and dark
constexpr double kLargestResidual = 0.15;  // rms, of the contrast: more is not one edge
constexpr double kDark = 0.1;  // fraction of the samples that are darker than what is taken for dark, to begin with
// They end what does not converge.
constexpr int kSteps = 12, kPasses = 3;
constexpr double kDone = 1e-3;  // [px] a hundredth of the corners' accuracy
// Where the band is moved to the edge next. Steps shrink tenfold each: what is left then is near kDone.
constexpr double kNearlyDone = 0.01;  // [px]
// Farther than 1.5 half bands, the edge was not in the band to begin with; the rest is chosen by hand.
constexpr double kLargestMove = 1.5, kSmallMove = 0.6;  // of a corner in one pass, in half bands
// All pixels of a side up to 300 px with a half band of 4 px; beyond, time (perception_speed) is saved at no loss that
// perception_accuracy shows.
constexpr double kSamples = 2400.0;  // of a side; a longer side gives every third, fifth ... pixel
// Below, the pixel's own area (sd 0.29 px) hides what the lens does.
constexpr double kSmallestPsf = 0.1;  // [px]
constexpr double kFarthest = 1e6;     // [px] no image is so large

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr int kChunk = 128, kStep = 16;  // samples at a time; of the last ones, as addColumnProducts wants them

/// Pixels of the band round a side.
struct Samples {
  std::vector<float> t, s, grey;  // t from -1 to 1 along the side, s [px] outwards; longer than `count`
  std::size_t count = 0;

  void holdAtLeast(std::size_t most) {
    if (t.size() >= most) return;
    for (auto* values : {&t, &s, &grey}) values->resize(2 * most);
  }
};

/// A side: where it was supposed to be, and the fitted offset outwards, a + b t + c t^2 [px].
struct Side {
  Eigen::Vector2d middle, along, outward;  // unit vectors
  double half = 0.0;                       // half length [px]
  double width = 0.0;                      // edge width: standard deviation of the step [px]
  double residual = 0.0;                   // rms of its pixels about the step [grey levels]
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

/// Where low <= a + b x <= high, cut from [first, last].
void cut(double a, double b, double low, double high, double& first, double& last) {
  if (std::abs(b) < 1e-9) {
    if (a < low || a > high) last = first - 1.0;
    return;
  }
  const double p = (low - a) / b, q = (high - a) / b;
  first = std::max(first, std::min(p, q));
  last = std::min(last, std::max(p, q));
}

/// All pixels of the band round the side as it is known now; false when the band leaves the image.
bool collect(const cv::Mat& grey, const Side& side, double band, Samples& samples) {
  std::size_t count = 0;
  const double reach = 1.0 - std::min(kSkippedPart, kSkippedEnd / side.half);
  const Eigen::Vector2d a = side.point(-1.0), b = side.point(1.0);
  const double margin = band + std::abs(side.offset[2]) + 1.0, most = band + side.offset.cwiseAbs().sum();
  const int y0 = static_cast<int>(std::floor(std::min(a.y(), b.y()) - margin));
  const int y1 = static_cast<int>(std::ceil(std::max(a.y(), b.y()) + margin));
  // Odd: an even one would take the same columns of every row.
  const int stride = static_cast<int>(4.0 * side.half * band / kSamples) | 1;
  int number = 0;
  const Eigen::Vector2d along_t = side.along / side.half, outward = side.outward;  // copies: no look at memory
  const Eigen::Vector3d offset = side.offset;
  for (int y = y0; y <= y1; ++y) {
    double first = side.middle.x() - side.half - margin, last = side.middle.x() + side.half + margin;
    const double dy = y - side.middle.y();
    cut(dy * side.along.y() - side.middle.x() * side.along.x(), side.along.x(), -reach * side.half, reach * side.half,
        first, last);
    cut(dy * side.outward.y() - side.middle.x() * side.outward.x(), side.outward.x(), -most, most, first, last);
    if (!(first <= last)) continue;  // of a side that is all but upright, they may be too large for integers
    const int x0 = static_cast<int>(std::ceil(first)), x1 = static_cast<int>(std::floor(last));
    if (x1 < x0) continue;
    // All of the row are written, and what does not count is written over: cheaper than to ask first.
    samples.holdAtLeast(count + static_cast<std::size_t>(x1 - x0) + 1 + kChunk);
    float *to_t = samples.t.data(), *to_s = samples.s.data(), *to_grey = samples.grey.data();
    const bool row_in = y >= 0 && y < grey.rows;
    const uchar* row = grey.ptr<uchar>(std::clamp(y, 0, grey.rows - 1));
    const double t0 = dy * along_t.y() - side.middle.x() * along_t.x(),
                 s0 = dy * outward.y() - side.middle.x() * outward.x();
    for (int x = x0; x <= x1; ++x) {
      const double t = t0 + x * along_t.x(), s = s0 + x * outward.x();
      const bool counts = !(std::abs(s - (offset[0] + t * (offset[1] + t * offset[2]))) > band);
      const bool in = row_in && x >= 0 && x < grey.cols;
      if (counts && !in) return false;
      if (stride > 1 && counts && ++number % stride != 0) continue;
      to_t[count] = static_cast<float>(t);
      to_s[count] = static_cast<float>(s);
      to_grey[count] = in ? static_cast<float>(row[x]) : 0.0F;
      count += counts ? 1 : 0;
    }
  }
  samples.count = count;
  return count >= 16;
}

/// Parameters of the step: offset a, b, c; middle grey, half contrast, width.
using Step = Vector6d;

/// From the samples' mean, which tells how much of the band is light: the edge's place, here and along the side.
Step start(const Side& side, const Samples& samples, double band) {
  std::array<int, 256> counts{};
  for (std::size_t i = 0; i < samples.count; ++i) ++counts[static_cast<std::size_t>(samples.grey[i])];
  const auto at = [&](double fraction) {
    int before = static_cast<int>(fraction * static_cast<double>(samples.count - 1)), grey = 0;
    while ((before -= counts[static_cast<std::size_t>(grey)]) >= 0) ++grey;
    return static_cast<double>(grey);
  };
  const double dark = at(kDark), light = std::max(dark + 1.0, at(1.0 - kDark));
  double n = 0.0, t = 0.0, tt = 0.0, y = 0.0, ty = 0.0;
  for (std::size_t i = 0; i < samples.count; ++i) {
    const double light_part = std::clamp((samples.grey[i] - dark) / (light - dark), 0.0, 1.0);
    const double inwards = band * (1.0 - 2.0 * light_part), along = samples.t[i];
    n += 1.0, t += along, tt += along * along, y += inwards, ty += along * inwards;
  }
  const double slope = (n * ty - t * y) / std::max(1e-9, n * tt - t * t);
  Step p;
  p << side.offset[0] + (y - slope * t) / n, side.offset[1] + slope, side.offset[2], 0.5 * (dark + light),
      0.5 * (light - dark), 0.8;
  return p;
}

constexpr int kRows = 7;  // six derivatives, the residual

/// Derivatives of the step's grey levels and residuals of n samples; zero from `count` on.
SEATER_VECTOR_CLONES void compare(const float* t, const float* s, const float* grey, int count, int n, const float* p,
                                  float (*__restrict rows)[kChunk]) {
  const float inverse = 1.0F / p[5];
  for (int i = 0; i < n; ++i) {
    const float used = i < count ? 1.0F : 0.0F, ti = t[i];
    const float h = (s[i] - (p[0] + ti * (p[1] + ti * p[2]))) * inverse;
    const NormalValue normal = normalAt(h);
    const float step = 2.0F * normal.distribution - 1.0F, slope = 2.0F * normal.density * p[4] * inverse;
    rows[0][i] = -used * slope;
    rows[1][i] = -used * slope * ti;
    rows[2][i] = -used * slope * ti * ti;
    rows[3][i] = used;
    rows[4][i] = used * step;
    rows[5][i] = -used * slope * h;
    rows[6][i] = used * (grey[i] - (p[3] + p[4] * step));
  }
}

/// Normal equations of the step at p; the residuals' squares are the last diagonal element.
Eigen::Matrix<double, kRows, kRows> equations(const Samples& samples, const Step& step) {
  float p[6];
  for (int k = 0; k < 6; ++k) p[k] = static_cast<float>(step[k]);
  double sum[kRows][kRows] = {};
  const int count = static_cast<int>(samples.count);
  alignas(64) float rows[kRows][kChunk];
  for (int first = 0; first < count; first += kChunk) {
    const int here = std::min(kChunk, count - first), n = (here + kStep - 1) / kStep * kStep;
    compare(samples.t.data() + first, samples.s.data() + first, samples.grey.data() + first, here, n, p, rows);
    addColumnProducts(rows[0], kChunk, n, kRows, sum[0], kRows);
  }
  Eigen::Matrix<double, kRows, kRows> result;
  for (int i = 0; i < kRows; ++i) {
    for (int j = i; j < kRows; ++j) result(i, j) = result(j, i) = sum[i][j];
  }
  return result;
}

/// x with A x = b, A positive definite (L D L'); not finite where it is not.
Vector6d solvedPositive(Matrix6d A, Vector6d b) {
  for (int k = 0; k < 6; ++k) {
    const double inverse = 1.0 / A(k, k);
    for (int i = k + 1; i < 6; ++i) {
      const double l = A(i, k) * inverse;
      for (int j = k + 1; j <= i; ++j) A(i, j) -= l * A(j, k);
      b[i] -= l * b[k];
    }
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) b[i] -= A(k, i) * b[k];
    b[i] /= A(i, i);
  }
  return b;
}

/// One Gauss-Newton fit of the step to the samples, rms residual [grey levels]; false when it does not look like an
/// edge.
bool fitStep(const Samples& samples, bool bent, double band, double done, Step& step, double& residual) {
  for (int i = 0; i < kSteps; ++i) {
    const auto all = equations(samples, step);
    Matrix6d A = all.topLeftCorner<6, 6>();
    Vector6d g = all.topRightCorner<6, 1>();
    residual = std::sqrt(all(6, 6) / static_cast<double>(samples.count));
    if (!bent) {
      A.row(2).setZero();
      A.col(2).setZero();
      A(2, 2) = 1.0;
      g[2] = 0.0;
    }
    A.diagonal() += 1e-6 * A.diagonal() + Vector6d::Constant(1e-9);
    Vector6d change = solvedPositive(A, g);
    if (!change.allFinite()) return false;
    const double largest = change.head<3>().cwiseAbs().maxCoeff();
    if (largest > 0.5 * band) change *= 0.5 * band / largest;
    step += change;
    step[5] = std::clamp(step[5], 0.2, band);
    if (largest < done) break;
  }
  const double contrast = 2.0 * step[4];
  return contrast > kSmallestContrast && residual < kLargestResidual * contrast;
}

bool fitSide(const cv::Mat& grey, double band, Side& side) {
  if (!(2.0 * side.half >= kShortestFit) || !(side.middle.norm() + side.half < kFarthest)) return false;
  const bool bent = 2.0 * side.half > kBentFrom;
  Samples samples;
  Step step;
  // The band follows the edge: one that is centred on it leaves out as much on the dark as on the light side.
  for (int round = 0; round < 3; ++round) {
    if (!collect(grey, side, band, samples)) return false;
    if (round == 0) step = start(side, samples, band);
    if (!fitStep(samples, bent, band, round == 0 ? kNearlyDone : kDone, step, side.residual)) return false;
    const Eigen::Vector3d moved = step.head<3>() - side.offset;
    side.offset = step.head<3>();
    if (side.offset.cwiseAbs().maxCoeff() > 3.0 * band + 1.0) return false;
    side.width = step[5];
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

std::optional<FittedEdges> fitOnce(const cv::Mat& grey, const Quad& corners, double half_band) {
  const Eigen::Vector2d inside = centre(corners);
  std::array<Side, 4> sides;  // side i: from corner i to corner i + 1
  for (std::size_t i = 0; i < 4; ++i) {
    sides[i] = between(corners[i], corners[(i + 1) % 4], inside);
    if (!fitSide(grey, half_band, sides[i])) return std::nullopt;
  }
  FittedEdges result;
  double variance = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto corner = meet(sides[(i + 3) % 4], sides[i]);
    if (!corner) return std::nullopt;
    result.corners[i] = *corner;
    variance += 0.25 * sides[i].width * sides[i].width;
    squares += 0.25 * sides[i].residual * sides[i].residual;
  }
  result.psf_sd = std::sqrt(std::max(kSmallestPsf * kSmallestPsf, variance - 1.0 / 12.0));
  result.residual = std::sqrt(squares);
  return result;
}

}  // namespace

std::optional<FittedEdges> fitEdges(const cv::Mat& grey, const Quad& corners, double half_band) {
  Quad from = corners;
  for (int pass = 0; pass < kPasses; ++pass) {
    const auto result = fitOnce(grey, from, half_band);
    if (!result) return std::nullopt;
    double moved = 0.0;
    for (std::size_t i = 0; i < 4; ++i) moved = std::max(moved, (result->corners[i] - from[i]).norm());
    if (moved > kLargestMove * half_band) return std::nullopt;
    // Ends of sides that were far off took pixels of the next side along.
    if (moved < kSmallMove * half_band) return result;
    from = result->corners;
  }
  return std::nullopt;
}

}  // namespace seater_perception
