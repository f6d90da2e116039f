#include "photometric/photometric_problem.h"

#include <algorithm>
#include <cmath>

#include "numerics/skew.h"
#include "photometric/samples/photometric_limits.h"

namespace seater_perception {
namespace {

// Steps of slope and rim are damped as if these were known of them: keeps tiny markers solvable. Chosen by hand: light
// that changes by 30 % over a marker; surroundings darker by 40 % of the sensor's range.
constexpr double kSlopeSd = 0.3;
constexpr double kPsfChanged = 1e-9;  // [px^2] rounding changes less
constexpr double kRimSd = 0.4;        // the same of the rim, in ranges of the sensor

}  // namespace

PhotometricProblem::PhotometricProblem(const CameraModel& camera, const std::vector<PatternPlacement>& placements,
                                       const std::vector<MarkerSamples>& samples, PsfModel psf, bool slopes,
                                       EvaluationPool& pool)
    : placements_(&placements),
      samples_(&samples),
      pool_(&pool),
      fx_(camera.fx()),
      fy_(camera.fy()),
      psf_(static_cast<int>(psf)),
      brightness_(2) {
  const bool rim = std::any_of(samples.begin(), samples.end(), [](const auto& s) { return s.half_sheet > 0.0; });
  if (slopes) brightness_ = rim ? 5 : 4;
}

int PhotometricProblem::pixels() const {
  int count = 0;
  for (const MarkerSamples& s : *samples_) count += s.batch.count;
  return count;
}

int PhotometricProblem::unknowns() const {
  int count = 6 + psf_;
  for (const MarkerSamples& s : *samples_) count += s.empty() ? 0 : brightness_;
  return count;
}

bool PhotometricProblem::limitPsf(SpreadCovariance& psf) const {
  const SpreadCovariance before = psf;
  for (const MarkerSamples& samples : *samples_) {
    if (!samples.empty()) keepPossible(psf, samples.rays_per_pixel);
  }
  return std::abs(psf.uu - before.uu) + std::abs(psf.vv - before.vv) + std::abs(psf.uv - before.uv) > kPsfChanged;
}

bool PhotometricProblem::view(std::size_t m, const PhotometricState& state, MarkerView& view) const {
  const MarkerSamples& samples = (*samples_)[m];
  const PatternPlacement& placement = (*placements_)[m];
  const SpreadCovariance spread = withArea(state.psf, samples.rays_per_pixel);
  const double per_metre = placement.pattern.cells() / placement.size;
  return possible(spread) && MarkerView::make(state.pose * placement.T_object_marker, per_metre, samples.half_sheet,
                                              fx_, fy_, spread, samples, view);
}

std::optional<Evaluation> PhotometricProblem::evaluate(const PhotometricState& state, const Weighing& weighing,
                                                       double part) const {
  EvaluationPool::Lease out = pool_->take();
  const std::size_t count = samples_->size();
  out->state = state;
  out->blocks.assign(count, EvaluationPool::Block::Zero());
  if (out->residuals.size() < count) out->residuals.resize(count), out->valid.resize(count);
  out->evaluated.assign(count, 0);
  out->slope_damping = std::pow(weighing.scale / kSlopeSd, 2);
  out->rim_damping = std::pow(weighing.scale / (kRimSd * (weighing.range.high - weighing.range.low)), 2);
  out->block_squares = 0.0;
  for (std::size_t m = 0; m < count; ++m) {
    if (!(*samples_)[m].empty() && !evaluateMarker(m, weighing, part, *out)) return std::nullopt;
  }
  return Evaluation(*this, std::move(out));
}

bool PhotometricProblem::evaluateMarker(std::size_t m, const Weighing& weighing, double part, Buffers& out) const {
  const PixelBatch& batch = (*samples_)[m].batch;
  const Brightness& brightness = out.state.brightness[m];
  MarkerView seen;
  if (!brightness.used || !(brightness.gain > 0.0) || !view(m, out.state, seen)) return false;
  out.evaluated[m] = static_cast<int>(std::ceil(part * batch.count));
  out.residuals[m].resize(static_cast<std::size_t>(batch.padded));
  out.valid[m].resize(static_cast<std::size_t>(batch.padded));
  double sum[kColumns][kColumns] = {};
  accumulateBatch(batch, out.evaluated[m], seen, psf_, brightness_, brightness, weighing, sum, out.residuals[m].data(),
                  out.valid[m].data());
  addBlocks(m, brightness, weighing, sum, out);
  const int size = 6 + psf_ + brightness_ + 1;
  for (int row = 0; row < size; ++row) {
    for (int column = row; column < size; ++column)
      out.blocks[m](row, column) = out.blocks[m](column, row) = sum[row][column];
  }
  toObject(m, out);
  return true;
}

/// A block counts as all its pixels, but is an outlier when its mean is one. There are thousands: all five unknowns are
/// summed up in loops of known length, and those that the fit has are kept.
void PhotometricProblem::addBlocks(std::size_t m, const Brightness& b, const Weighing& weighing,
                                   double sum[kColumns][kColumns], Buffers& out) const {
  constexpr int kOwn = 6;  // offset, gain, slopes, rim; residual
  const double sd = std::min(weighing.scale, 0.02 * (weighing.range.high - weighing.range.low));
  const auto place = [this](int i) { return 6 + psf_ + (i + 1 < kOwn ? i : brightness_); };
  const auto used = [this](int i) { return i < brightness_ || i + 1 == kOwn; };
  double H[kOwn][kOwn] = {};
  for (int i = 0; i < kOwn; ++i) {
    for (int j = i; j < kOwn; ++j) H[i][j] = used(i) && used(j) ? sum[place(i)][place(j)] : 0.0;
  }
  for (const FlatBlock& block : (*samples_)[m].blocks) {
    const double light = 1.0 + b.slope_u * block.pu + b.slope_v * block.pv, base = b.offset + b.gain * block.white;
    double pass = 1.0;
    const double r = block.grey - clippedMean(light * base, sd, weighing.range, pass);
    out.block_squares += block.count * r * r;
    const double a = std::abs(r) / weighing.scale, u = std::min(1.0, a / weighing.tukey);
    const double tukey = (1.0 - u * u) * (1.0 - u * u), huber = a < kHuber ? 1.0 : kHuber / a;
    const double w = block.count * (weighing.loss == RobustLoss::tukey ? tukey : huber);
    const double J[kOwn] = {
        pass * light, pass * light * block.white, pass * base * block.pu, pass * base * block.pv, 0.0, r};
    for (int i = 0; i < kOwn; ++i) {
      for (int j = i; j < kOwn; ++j) H[i][j] += w * J[i] * J[j];
    }
  }
  for (int i = 0; i < kOwn; ++i) {
    for (int j = i; j < kOwn; ++j) {
      if (used(i) && used(j)) sum[place(i)][place(j)] = H[i][j];
    }
  }
}

/// From motions along the marker's axes about its own origin, in cells, to motions of the object as pose.h defines
/// them.
void PhotometricProblem::toObject(std::size_t m, Buffers& out) const {
  const PatternPlacement& placement = (*placements_)[m];
  const Eigen::Isometry3d& T = placement.T_object_marker;
  const Eigen::Matrix3d axes = (out.state.pose.linear() * T.linear()).transpose();
  const double per_metre = placement.pattern.cells() / placement.size;
  Matrix6d motion = Matrix6d::Zero();
  motion.topLeftCorner<3, 3>() = per_metre * axes;
  motion.topRightCorner<3, 3>() = -per_metre * axes * skew(out.state.pose.linear() * T.translation());
  motion.bottomRightCorner<3, 3>() = axes;
  EvaluationPool::Block& block = out.blocks[m];
  block.topRows<6>() = (motion.transpose() * block.topRows<6>()).eval();
  block.leftCols<6>() = (block.leftCols<6>() * motion).eval();
}

std::optional<PhotometricProblem::WeightedRows> PhotometricProblem::weightedRows(const PhotometricState& state,
                                                                                 const Weighing& weighing,
                                                                                 int most) const {
  const PixelBatch& batch = samples_->front().batch;
  MarkerView seen;
  if (!view(0, state, seen)) return std::nullopt;
  const int count = std::min(most, batch.count);
  std::vector<float> residual(static_cast<std::size_t>(batch.padded)), valid(residual.size());
  double sum[kColumns][kColumns] = {};
  WeightedRows result;
  result.rows.resize(count, 7 + psf_ + brightness_);
  accumulateBatch(batch, count, seen, psf_, brightness_, state.brightness.front(), weighing, sum, residual.data(),
                  valid.data(), result.rows.data());
  for (int row = 0; row < kColumns; ++row) {
    for (int column = 0; column < kColumns; ++column) result.products(row, column) = sum[row][column];
  }
  return result;
}

Eigen::Matrix2d PhotometricProblem::pixelByCell(const PhotometricState& state) const {
  const PatternPlacement& placement = placements_->front();
  const Eigen::Isometry3d T = state.pose * placement.T_object_marker;
  const Eigen::Vector3d t = T.translation();
  Eigen::Matrix<double, 2, 3> by_point;
  by_point << fx_ / t.z(), 0.0, -fx_ * t.x() / (t.z() * t.z()), 0.0, fy_ / t.z(), -fy_ * t.y() / (t.z() * t.z());
  return by_point * T.linear().leftCols<2>() * (placement.size / placement.pattern.cells());
}

}  // namespace seater_perception
