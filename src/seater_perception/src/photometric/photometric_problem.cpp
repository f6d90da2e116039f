#include "photometric/photometric_problem.h"

#include <algorithm>
#include <cmath>

#include "photometric/samples/photometric_limits.h"

namespace seater_perception {
namespace {

// Steps of a slope are damped as if this were known of it: keeps tiny markers solvable.
constexpr double kSlopeSd = 0.3;
constexpr double kRimSd = 0.4;              // the same of the rim, in ranges of the sensor
constexpr std::size_t kSpreadPixels = 600;  // are enough for a median

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

}  // namespace

void PhotometricProblem::set(const CameraModel& camera, const std::vector<PatternPlacement>& placements,
                             const std::vector<MarkerSamples>& samples, Blur blur, bool slopes) {
  placements_ = &placements;
  samples_ = &samples;
  fx_ = camera.fx(), fy_ = camera.fy();
  blur_ = static_cast<int>(blur);
  const bool rim = std::any_of(samples.begin(), samples.end(), [](const auto& s) { return s.half_sheet > 0.0; });
  brightness_ = slopes ? (rim ? 5 : 4) : 2;
  blocks_.assign(samples.size(), Block::Zero());
  if (residuals_.size() < samples.size()) {
    residuals_.resize(samples.size());
    valid_.resize(samples.size());
  }
  evaluated_.assign(samples.size(), 0);
  for (std::size_t m = 0; m < samples.size(); ++m) {
    residuals_[m].resize(static_cast<std::size_t>(samples[m].batch.padded));
    valid_[m].resize(static_cast<std::size_t>(samples[m].batch.padded));
  }
}

int PhotometricProblem::pixels() const {
  int count = 0;
  for (const MarkerSamples& s : *samples_) count += s.batch.count;
  return count;
}

int PhotometricProblem::unknowns() const {
  int count = 6 + blur_;
  for (const MarkerSamples& s : *samples_) count += s.empty() ? 0 : brightness_;
  return count;
}

bool PhotometricProblem::view(std::size_t m, const PhotometricState& state, MarkerView& view) const {
  const MarkerSamples& samples = (*samples_)[m];
  const PatternPlacement& placement = (*placements_)[m];
  const SpreadCovariance spread = withArea(state.blur, samples.rays_per_pixel);
  const double per_metre = placement.pattern.cells() / placement.size;
  return possible(spread) && MarkerView::make(state.pose * placement.T_object_marker, per_metre, samples.half_sheet,
                                              fx_, fy_, spread, samples, view);
}

bool PhotometricProblem::evaluate(const PhotometricState& state, const Weighing& weighing, double part) {
  slope_damping_ = std::pow(weighing.scale / kSlopeSd, 2);
  rim_damping_ = std::pow(weighing.scale / (kRimSd * (weighing.range.high - weighing.range.low)), 2);
  block_squares_ = 0.0;
  for (std::size_t m = 0; m < samples_->size(); ++m) {
    blocks_[m].setZero();
    if (!(*samples_)[m].empty() && !evaluateMarker(m, state, weighing, part)) return false;
  }
  return true;
}

bool PhotometricProblem::evaluateMarker(std::size_t m, const PhotometricState& state, const Weighing& weighing,
                                        double part) {
  const MarkerSamples& samples = (*samples_)[m];
  const Brightness& brightness = state.brightness[m];
  MarkerView seen;
  if (!brightness.used || !(brightness.gain > 0.0) || !view(m, state, seen)) return false;
  evaluated_[m] = static_cast<int>(std::ceil(part * samples.batch.count));
  double sum[kColumns][kColumns] = {};
  accumulateBatch(samples.batch, evaluated_[m], seen, blur_, brightness_, brightness, weighing, sum,
                  residuals_[m].data(), valid_[m].data());
  addBlocks(m, brightness, weighing, sum);
  const int size = 6 + blur_ + brightness_ + 1;
  for (int row = 0; row < size; ++row) {
    for (int column = row; column < size; ++column)
      blocks_[m](row, column) = blocks_[m](column, row) = sum[row][column];
  }
  toObject(m, state);
  return true;
}

/// A block counts as all its pixels, but is an outlier when its mean is one.
void PhotometricProblem::addBlocks(std::size_t m, const Brightness& b, const Weighing& weighing,
                                   double sum[kColumns][kColumns]) {
  const int first = 6 + blur_;
  const double sd = std::min(weighing.scale, 0.02 * (weighing.range.high - weighing.range.low));
  for (const FlatBlock& block : (*samples_)[m].blocks) {
    const double light = 1.0 + b.slope_u * block.pu + b.slope_v * block.pv, base = b.offset + b.gain * block.white;
    double pass = 1.0;
    const double r = block.grey - clippedMean(light * base, sd, weighing.range, pass);
    block_squares_ += block.count * r * r;
    const double a = std::abs(r) / weighing.scale, u = std::min(1.0, a / weighing.tukey);
    const double tukey = (1.0 - u * u) * (1.0 - u * u), huber = a < kHuber ? 1.0 : kHuber / a;
    const double w = block.count * (weighing.loss == RobustLoss::tukey ? tukey : huber);
    double J[6] = {pass * light, pass * light * block.white, pass * base * block.pu, pass * base * block.pv, 0.0, r};
    J[brightness_] = r;
    for (int i = 0; i <= brightness_; ++i) {
      for (int j = i; j <= brightness_; ++j) sum[first + i][first + j] += w * J[i] * J[j];
    }
  }
}

/// From motions along the marker's axes about its own origin, in cells, to motions of the object as pose.h defines
/// them.
void PhotometricProblem::toObject(std::size_t m, const PhotometricState& state) {
  const PatternPlacement& placement = (*placements_)[m];
  const Eigen::Isometry3d& T = placement.T_object_marker;
  const Eigen::Matrix3d axes = (state.pose.linear() * T.linear()).transpose();
  const double per_metre = placement.pattern.cells() / placement.size;
  Matrix6d motion = Matrix6d::Zero();
  motion.topLeftCorner<3, 3>() = per_metre * axes;
  motion.topRightCorner<3, 3>() = -per_metre * axes * cross(state.pose.linear() * T.translation());
  motion.bottomRightCorner<3, 3>() = axes;
  Block& block = blocks_[m];
  block.topRows<6>() = (motion.transpose() * block.topRows<6>()).eval();
  block.leftCols<6>() = (block.leftCols<6>() * motion).eval();
}

LossSums PhotometricProblem::loss(const Weighing& weighing, double part) const {
  LossSums total;
  for (std::size_t m = 0; m < samples_->size(); ++m) {
    const int wanted = static_cast<int>(std::ceil(part * (*samples_)[m].batch.count));
    const LossSums s = sumLoss(residuals_[m].data(), valid_[m].data(), std::min(wanted, evaluated_[m]), weighing.scale,
                               weighing.loss, weighing.tukey);
    total.all += s.all, total.inliers += s.inliers, total.cost += s.cost, total.weights += s.weights;
    total.slopes += s.slopes, total.squares += s.squares, total.weighted += s.weighted, total.psi2 += s.psi2;
  }
  return total;
}

double PhotometricProblem::spread(double quantile) const {
  sorted_.clear();
  for (std::size_t m = 0; m < samples_->size(); ++m) {
    const auto count = static_cast<std::size_t>(evaluated_[m]), stride = count / kSpreadPixels + 1;
    for (std::size_t i = 0; i < count; i += stride) {
      if (valid_[m][i] > 0.0F) sorted_.push_back(std::abs(residuals_[m][i]));
    }
  }
  if (sorted_.size() < 30) return 0.0;
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(quantile * static_cast<double>(sorted_.size()));
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  return *middle / (quantile > 0.4 ? 0.67449 : 0.31864);  // of a normal distribution
}

double PhotometricProblem::residualSquares() const {
  double squares = block_squares_;
  for (std::size_t m = 0; m < samples_->size(); ++m) {
    for (int i = 0; i < evaluated_[m]; ++i) {
      const double r = residuals_[m][static_cast<std::size_t>(i)];
      squares += r * r;
    }
  }
  return squares;
}

double PhotometricProblem::greySquares() const {
  double squares = 0.0;
  for (std::size_t m = 0; m < samples_->size(); ++m) {
    double sum = 0.0, square = 0.0, count = 0.0;
    const auto add = [&](double grey, double n) { sum += n * grey, square += n * grey * grey, count += n; };
    for (int i = 0; i < evaluated_[m]; ++i) add((*samples_)[m].batch.grey[static_cast<std::size_t>(i)], 1.0);
    for (const FlatBlock& block : (*samples_)[m].blocks) add(block.grey, block.count);
    if (count > 0.0) squares += square - sum * sum / count;
  }
  return squares;
}

}  // namespace seater_perception
