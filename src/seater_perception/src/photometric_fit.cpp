#include "seater_perception/photometric_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace seater_perception {
namespace {

constexpr double kHuber = 1.345;         // [scales] 95 % efficient with normal noise
constexpr double kClipReach = 4.0;       // [standard deviations] from the sensor's limits: nothing is clipped beyond
constexpr double kClipSd = 0.02;         // [of the range] most noise that clipping is smoothed with
constexpr double kLargestStretch = 1.3;  // of a step
constexpr double kBlind = 0.2;           // a pixel that feels less of a change than this is clipped
constexpr double kSlopeSd =
    0.3;  // steps of a slope are damped as if this were known of it: keeps tiny markers solvable
constexpr double kNarrowest = 0.02;            // [px^2] of the point-spread function with the pixel's area
constexpr double kWidest = 100.0;              // [px^2]
constexpr double kSmallestEigenvalue = 1e-10;  // of the normal matrix scaled to a unit diagonal

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

double lossOf(double r, double scale, RobustLoss loss, double tukey) {
  const double a = std::abs(r);
  if (loss == RobustLoss::huber) {
    const double k = kHuber * scale;
    return a <= k ? 0.5 * a * a : k * (a - 0.5 * k);
  }
  const double c = tukey * scale, u = 1.0 - (a / c) * (a / c);
  return a < c ? c * c / 6.0 * (1.0 - u * u * u) : c * c / 6.0;
}

/// `a`: residual in scales.
double weightOf(double a, RobustLoss loss, double tukey) {
  a = std::abs(a);
  if (loss == RobustLoss::huber) return a <= kHuber ? 1.0 : kHuber / a;
  const double u = a / tukey;
  return u < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
}

SpreadCovariance withArea(const SpreadCovariance& blur, int rays_per_pixel) {
  const double area = areaVariance(rays_per_pixel);
  return {blur.uu + area, blur.uv, blur.vv + area};
}

bool possible(const SpreadCovariance& s) {
  const double mean = 0.5 * (s.uu + s.vv), half = std::hypot(0.5 * (s.uu - s.vv), s.uv);
  return mean - half > kNarrowest && mean + half < kWidest;
}

/// Keeps the estimated blur where the model is valid: a whole point-spread function of at least kNarrowest.
void keepPossible(SpreadCovariance& blur, int rays_per_pixel) {
  SpreadCovariance s = withArea(blur, rays_per_pixel);
  const double mean = 0.5 * (s.uu + s.vv), half = std::hypot(0.5 * (s.uu - s.vv), s.uv);
  const double wide = std::clamp(mean + half, 1.1 * kNarrowest, 0.9 * kWidest);
  const double narrow = std::clamp(mean - half, 1.1 * kNarrowest, 0.9 * kWidest);
  const double shrink = half > 1e-12 ? 0.5 * (wide - narrow) / half : 0.0, area = areaVariance(rays_per_pixel);
  const double centre = 0.5 * (wide + narrow), difference = 0.5 * (s.uu - s.vv) * shrink;
  blur = {centre + difference - area, s.uv * shrink, centre - difference - area};
}

}  // namespace

double clippedMean(double mean, double sd, const ClipRange& range, double& by_mean) {
  by_mean = 1.0;
  double result = mean;
  const auto overshoot = [sd](double z, double& beyond) {  // mean of max(0, n - z) for standard normal n
    beyond = 0.5 * std::erfc(z * M_SQRT1_2);
    return sd * (std::exp(-0.5 * z * z) / std::sqrt(2.0 * M_PI) - z * beyond);
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

PhotometricProblem::PhotometricProblem(const std::vector<PatternPlacement>& placements,
                                       const std::vector<MarkerSamples>& samples, Blur blur, bool slopes,
                                       ClipRange range)
    : placements_(placements),
      samples_(samples),
      blur_(static_cast<int>(blur)),
      brightness_(slopes ? 4 : 2),
      range_(range),
      blocks_(samples.size(), Block::Zero()) {
  const auto count = static_cast<std::size_t>(pixels());
  residuals_.reserve(count);
  edge_.reserve(count);
  sorted_.reserve(count);
}

int PhotometricProblem::pixels() const {
  std::size_t count = 0;
  for (const MarkerSamples& s : samples_) count += s.pixels.size();
  return static_cast<int>(count);
}

int PhotometricProblem::edgePixels() const {
  int count = 0;
  for (const MarkerSamples& s : samples_) count += s.edges;
  return count;
}

int PhotometricProblem::unknowns() const {
  int count = 6 + blur_;
  for (const MarkerSamples& s : samples_) count += s.empty() ? 0 : brightness_;
  return count;
}

void PhotometricProblem::startBrightness(PhotometricState& state) const {
  state.brightness.assign(samples_.size(), {});
  std::vector<std::pair<double, double>> seen;  // white, grey
  for (std::size_t m = 0; m < samples_.size(); ++m) {
    const MarkerSamples& samples = samples_[m];
    if (samples.empty()) continue;
    const MarkerPattern& pattern = placements_[m].pattern;
    const MarkerPlane plane(state.pose * placements_[m].T_object_marker);
    const double per_metre = pattern.cells() / placements_[m].size, middle = 0.5 * pattern.cells();
    const SpreadCovariance spread = withArea(state.blur, samples.rays_per_pixel);
    const auto k = static_cast<std::size_t>(samples.rays_per_pixel);
    seen.clear();
    for (std::size_t i = 0; i < samples.pixels.size(); ++i) {
      MarkerHit hit;
      if (!plane.hit(samples.rays[i * k], spread, hit)) continue;
      const auto response = smoothedPattern(pattern, hit.x * per_metre + middle, hit.y * per_metre + middle,
                                            hit.sx * per_metre, hit.sy * per_metre, hit.rho);
      seen.emplace_back(response.value, samples.pixels[i].grey);
    }
    if (seen.size() < 8) continue;
    std::sort(seen.begin(), seen.end());
    const std::size_t quarter = seen.size() / 4;
    const auto typical = [quarter](auto first) {  // median grey and mean white of a quarter of the pixels
      double white = 0.0;
      std::vector<double> grey;
      for (auto it = first; it != first + static_cast<std::ptrdiff_t>(quarter); ++it) {
        white += it->first / static_cast<double>(quarter);
        grey.push_back(it->second);
      }
      std::nth_element(grey.begin(), grey.begin() + static_cast<std::ptrdiff_t>(quarter / 2), grey.end());
      return std::make_pair(white, grey[quarter / 2]);
    };
    const auto dark = typical(seen.begin()), light = typical(seen.end() - static_cast<std::ptrdiff_t>(quarter));
    Brightness& b = state.brightness[m];
    b.used = true;
    b.gain = std::max(1.0, (light.second - dark.second) / std::max(0.05, light.first - dark.first));
    b.offset = dark.second - b.gain * dark.first;
  }
}

bool PhotometricProblem::evaluate(const PhotometricState& state, double scale, RobustLoss loss, double tukey,
                                  int stride) {
  residuals_.clear();
  edge_.clear();
  slope_damping_ = scale * scale / (kSlopeSd * kSlopeSd);
  for (std::size_t m = 0; m < samples_.size(); ++m) {
    blocks_[m].setZero();
    if (samples_[m].empty()) continue;
    if (!state.brightness[m].used || !(state.brightness[m].gain > 0.0)) return false;
    if (!possible(withArea(state.blur, samples_[m].rays_per_pixel))) return false;
    bool good = false;
    const bool slopes = brightness_ == 4;
    if (blur_ == 0) {
      good = slopes ? accumulate<0, 4>(m, state, scale, loss, tukey, stride)
                    : accumulate<0, 2>(m, state, scale, loss, tukey, stride);
    } else if (blur_ == 1) {
      good = slopes ? accumulate<1, 4>(m, state, scale, loss, tukey, stride)
                    : accumulate<1, 2>(m, state, scale, loss, tukey, stride);
    } else {
      good = slopes ? accumulate<3, 4>(m, state, scale, loss, tukey, stride)
                    : accumulate<3, 2>(m, state, scale, loss, tukey, stride);
    }
    if (!good) return false;
    toObject(m, state);
  }
  return true;
}

template <int kBlur, int kBrightness>
bool PhotometricProblem::accumulate(std::size_t marker, const PhotometricState& state, double scale, RobustLoss loss,
                                    double tukey, int stride) {
  constexpr int kFirst = 6 + kBlur, kAll = kFirst + kBrightness, kSize = kAll + 1;
  const MarkerSamples& samples = samples_[marker];
  const PatternPlacement& placement = placements_[marker];
  const MarkerPlane plane(state.pose * placement.T_object_marker);
  const SpreadCovariance spread = withArea(state.blur, samples.rays_per_pixel);
  const Brightness& b = state.brightness[marker];
  const double per_metre = placement.pattern.cells() / placement.size;
  const double middle = 0.5 * placement.pattern.cells();
  const int rays = samples.rays_per_pixel;
  const double clip_sd = std::min(scale, kClipSd * (range_.high - range_.low));
  const double half_inverse = 0.5 / spread.uu;  // a round point-spread function's relative change with its variance
  const double inverse_scale = 1.0 / scale, inverse_rays = 1.0 / rays;
  double sum[kSize][kSize] = {};
  for (std::size_t i = 0; i < samples.pixels.size(); i += static_cast<std::size_t>(stride)) {
    const PixelSample& pixel = samples.pixels[i];
    double white = 0.0, by[9] = {};
    bool flat = true;
    for (int k = 0; k < rays; ++k) {
      MarkerHit hit;
      if (!plane.hit(samples.rays[i * static_cast<std::size_t>(rays) + static_cast<std::size_t>(k)], spread, hit))
        return false;
      const auto response = smoothedPattern(placement.pattern, hit.x * per_metre + middle, hit.y * per_metre + middle,
                                            hit.sx * per_metre, hit.sy * per_metre, hit.rho);
      white += response.value;
      if (response.flat) continue;
      flat = false;
      double motion[6];
      plane.derivativeByMotion(hit, response, per_metre, motion);
      for (int j = 0; j < 6; ++j) by[j] += motion[j];
      if (kBlur == 1) by[6] += half_inverse * (response.by_log_sx + response.by_log_sy);
      if (kBlur < 3) continue;
      double blur[3];
      derivativeBySpread(hit, response, blur);
      for (int j = 0; j < 3; ++j) by[6 + j] += blur[j];
    }
    white *= inverse_rays;
    const double light = 1.0 + b.slope_u * pixel.pu + b.slope_v * pixel.pv, base = b.offset + b.gain * white;
    double pass = 1.0;
    const double mean = clippedMean(light * base, clip_sd, range_, pass);
    const double residual = pixel.grey - mean;
    const bool blind = pass < kBlind && std::abs(residual) < scale;
    residuals_.push_back(blind ? std::numeric_limits<double>::quiet_NaN() : residual);
    edge_.push_back(pixel.edge);
    const double weight = weightOf(residual * inverse_scale, loss, tukey);
    if (weight == 0.0) continue;
    double J[kSize];
    const double by_white = pass * light * b.gain * inverse_rays;
    for (int j = 0; j < kFirst; ++j) J[j] = by_white * by[j];
    J[kFirst] = pass * light;
    J[kFirst + 1] = pass * light * white;
    if (kBrightness == 4) {
      J[kAll - 2] = pass * base * pixel.pu;
      J[kAll - 1] = pass * base * pixel.pv;
    }
    J[kAll] = residual;
    for (int row = flat ? kFirst : 0; row < kSize; ++row) {
      const double w = weight * J[row];
      for (int column = row; column < kSize; ++column) sum[row][column] += w * J[column];
    }
  }
  Block& block = blocks_[marker];
  for (int row = 0; row < kSize; ++row) {
    for (int column = row; column < kSize; ++column) block(row, column) = block(column, row) = sum[row][column];
  }
  return true;
}

/// From motions along the marker's axes about its own origin to motions of the object as pose.h defines them.
void PhotometricProblem::toObject(std::size_t marker, const PhotometricState& state) {
  const Eigen::Isometry3d& T = placements_[marker].T_object_marker;
  const Eigen::Matrix3d axes = (state.pose.linear() * T.linear()).transpose();
  Matrix6d motion = Matrix6d::Zero();
  motion.topLeftCorner<3, 3>() = axes;
  motion.topRightCorner<3, 3>() = -axes * cross(state.pose.linear() * T.translation());
  motion.bottomRightCorner<3, 3>() = axes;
  Block& block = blocks_[marker];
  block.topRows<6>() = (motion.transpose() * block.topRows<6>()).eval();
  block.leftCols<6>() = (block.leftCols<6>() * motion).eval();
}

double PhotometricProblem::cost(double scale, RobustLoss loss, double tukey) const {
  double sum = 0.0;
  for (const double r : residuals_) sum += std::isnan(r) ? 0.0 : lossOf(r, scale, loss, tukey);
  return sum;
}

double PhotometricProblem::stretch(double scale, RobustLoss loss, double tukey) const {
  double weights = 0.0, slopes = 0.0;
  for (const double r : residuals_) {
    if (std::isnan(r)) continue;
    const double a = std::abs(r) / scale, u2 = (a / tukey) * (a / tukey);
    if (loss == RobustLoss::huber) {
      weights += a < kHuber ? 1.0 : kHuber / a;
      slopes += a < kHuber ? 1.0 : 0.0;
    } else if (u2 < 1.0) {
      weights += (1.0 - u2) * (1.0 - u2);
      slopes += (1.0 - u2) * (1.0 - 5.0 * u2);
    }
  }
  return slopes > 0.0 ? std::min(kLargestStretch, weights / slopes) : 1.0;
}

double PhotometricProblem::spread(double quantile) const {
  sorted_.clear();
  for (std::size_t i = 0; i < residuals_.size(); ++i) {
    if (edge_[i] && !std::isnan(residuals_[i])) sorted_.push_back(std::abs(residuals_[i]));
  }
  if (sorted_.size() < 30) return 0.0;
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(quantile * static_cast<double>(sorted_.size()));
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  return *middle / (quantile > 0.4 ? 0.67449 : 0.31864);  // of a normal distribution
}

double PhotometricProblem::flatNoise() const {
  sorted_.clear();
  for (const MarkerSamples& samples : samples_) {
    for (const PixelSample& pixel : samples.pixels) {
      const bool clipped = pixel.grey <= range_.low || pixel.grey >= range_.high;
      if (!pixel.edge && !clipped) sorted_.push_back(std::abs(pixel.step));
    }
  }
  if (sorted_.size() < 12) return 0.0;
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  return *middle / 0.67449 * M_SQRT1_2;
}

double PhotometricProblem::greySquares() const {
  double squares = 0.0;
  for (const MarkerSamples& samples : samples_) {
    double sum = 0.0, square = 0.0;
    for (const PixelSample& pixel : samples.pixels) sum += pixel.grey, square += pixel.grey * pixel.grey;
    if (!samples.empty()) squares += square - sum * sum / static_cast<double>(samples.pixels.size());
  }
  return squares;
}

Eigen::MatrixXd PhotometricProblem::brightnessInformation(std::size_t marker, double damping) const {
  Eigen::MatrixXd H = blocks_[marker].block(6 + blur_, 6 + blur_, brightness_, brightness_);
  if (brightness_ == 4) H.diagonal().tail<2>().array() += slope_damping_;
  H.diagonal() *= 1.0 + damping;
  H.diagonal().array() += 1e-9;
  return H;
}

PhotometricProblem::Shared PhotometricProblem::reduced(double damping, SharedVector& right) const {
  const int n = 6 + blur_, residual = n + brightness_;
  Shared H = Shared::Zero(n, n), correction = Shared::Zero(n, n);
  right = SharedVector::Zero(n);
  for (std::size_t m = 0; m < blocks_.size(); ++m) {
    if (samples_[m].empty()) continue;
    const Block& block = blocks_[m];
    const Eigen::MatrixXd mixed = block.block(0, n, n, brightness_);
    const Eigen::MatrixXd solved = brightnessInformation(m, damping).ldlt().solve(mixed.transpose());
    H += block.topLeftCorner(n, n);
    correction += mixed * solved;
    right += block.col(residual).head(n) - solved.transpose() * block.col(residual).segment(n, brightness_);
  }
  H.diagonal() *= 1.0 + damping;
  return H - correction;
}

std::optional<PhotometricState> PhotometricProblem::step(const PhotometricState& state, double damping, double stretch,
                                                         double& length) const {
  const int n = 6 + blur_, residual = n + brightness_;
  SharedVector right;
  const Shared H = reduced(damping, right);
  const SharedVector scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Shared scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const SharedVector change = stretch * (scale.asDiagonal() * scaled.ldlt().solve(scale.asDiagonal() * right));
  if (!change.allFinite()) return std::nullopt;
  length = change.dot(H * change);
  PhotometricState next = state;
  next.pose.translation() += change.head<3>();
  const Eigen::Vector3d turn = change.segment<3>(3);
  if (turn.norm() > 0.5 || change.head<3>().norm() > 0.5 * state.pose.translation().norm()) return std::nullopt;
  if (turn.norm() > 0.0) {
    next.pose.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * state.pose.linear();
  }
  if (blur_ == 1) {
    next.blur.uu += change[6];
    next.blur.vv += change[6];
  } else if (blur_ == 3) {
    next.blur.uu += change[6];
    next.blur.uv += change[7];
    next.blur.vv += change[8];
  }
  for (std::size_t m = 0; m < samples_.size(); ++m) {
    if (samples_[m].empty()) continue;
    if (blur_ > 0) keepPossible(next.blur, samples_[m].rays_per_pixel);
    const Block& block = blocks_[m];
    const Eigen::VectorXd open =
        stretch * block.col(residual).segment(n, brightness_) - block.block(n, 0, brightness_, n) * change;
    const Eigen::VectorXd own = brightnessInformation(m, damping).ldlt().solve(open);
    if (!own.allFinite()) return std::nullopt;
    Brightness& b = next.brightness[m];
    b.offset += own[0];
    b.gain += own[1];
    if (brightness_ == 4) {
      b.slope_u += own[2];
      b.slope_v += own[3];
    }
  }
  return next;
}

std::optional<Matrix6d> PhotometricProblem::inversePoseInformation() const {
  SharedVector right;
  const Shared H = reduced(0.0, right);
  const SharedVector scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Shared scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  if (solver.info() != Eigen::Success || !(solver.eigenvalues()[0] > kSmallestEigenvalue)) return std::nullopt;
  const Eigen::MatrixXd inverse =
      solver.eigenvectors() * solver.eigenvalues().cwiseInverse().asDiagonal() * solver.eigenvectors().transpose();
  const Matrix6d result = scale.head<6>().asDiagonal() * inverse.topLeftCorner<6, 6>() * scale.head<6>().asDiagonal();
  if (!result.allFinite()) return std::nullopt;
  return Matrix6d(0.5 * (result + result.transpose()));
}

}  // namespace seater_perception
