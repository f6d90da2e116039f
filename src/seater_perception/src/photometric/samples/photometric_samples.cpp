#include "photometric/samples/photometric_samples.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "photometric/samples/pixel_walk.h"

namespace seater_perception {
namespace {

constexpr double kBoxVariance = 1.0 / 12.0;
constexpr double kSubVariance = 0.0645497224;  // of the four rays of a pixel: sqrt(1 / 240)
constexpr double kNarrowPsf = 0.45;            // [px] below, the box's own shape shows: 0.3 % of the contrast
constexpr double kFeltReach = 3.2;             // [standard deviations] beyond it a border is not felt: 7e-4
constexpr double kSheetReach = 2.2;            // [standard deviations] from the sheet's end: felt by 1.4 %
constexpr int kBuckets = 4;                    // pixels are dealt into so many, one after the other

/// How many borders along an axis each pixel has to look at: nearest ones of this PSF [cells], which is `off` wrong.
int bordersFelt(double sd, double off) {
  return std::clamp(static_cast<int>(std::ceil(2.0 * (kFeltReach * sd + off))), 1, PixelBatch::kMostBorders);
}

void resize(PixelBatch& batch, int count, int borders, bool bent) {
  batch.count = count;
  batch.padded = (count + PixelBatch::kLanes - 1) / PixelBatch::kLanes * PixelBatch::kLanes;
  batch.borders = borders;
  batch.bent = bent;
  const auto n = static_cast<std::size_t>(batch.padded);
  for (auto* values : {&batch.grey, &batch.pu, &batch.pv, &batch.x, &batch.y, &batch.column, &batch.row})
    values->resize(n);
  if (bent) {
    for (auto* values : {&batch.xu, &batch.xv, &batch.yu, &batch.yv}) values->resize(n);
  }
  batch.pattern.resize(n * static_cast<std::size_t>(batch.planes()));
}

/// The pattern round borders, from the cell before the first ones in a table of cells; see PixelBatch::pattern.
void patternAt(const float* cell, int side, int K, float* out) {
  *out++ = *cell;
  for (int k = 0; k < K; ++k) *out++ = cell[k + 1] - cell[k];
  for (int k = 0; k < K; ++k) *out++ = cell[(k + 1) * side] - cell[k * side];
  for (int b = 0; b < K; ++b, cell += side) {
    for (int a = 0; a < K; ++a) *out++ = cell[side + a + 1] - cell[side + a] - cell[a + 1] + cell[a];
  }
}

}  // namespace

double areaVariance(int rays_per_pixel) {
  return rays_per_pixel == 1 ? kBoxVariance : kBoxVariance - kSubVariance;
}

int raysPerPixel(double psf_sd) {
  return psf_sd < kNarrowPsf ? 4 : 1;
}

bool SampleCollector::sheetBox(const CameraModel& camera, const PatternPlacement& placement,
                               const Eigen::Isometry3d& pose, double quiet_zone, PixelBox& box) {
  const double h = placement.size * (0.5 + quiet_zone / placement.pattern.cells());
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (int i = 0; i < 8; ++i) {  // corners and the middles between: distortion bends the sides outwards
    static constexpr int kX[] = {-1, 0, 1, 1, 1, 0, -1, -1}, kY[] = {-1, -1, -1, 0, 1, 1, 1, 0};
    const auto pixel = camera.project(pose * Eigen::Vector3d(kX[i] * h, kY[i] * h, 0.0));
    if (!pixel) return false;
    low = low.cwiseMin(*pixel);
    high = high.cwiseMax(*pixel);
  }
  const auto clip = [](double value, int limit) { return static_cast<int>(std::clamp(value, -1.0, limit + 1.0)); };
  box = {std::max(0, clip(std::floor(low.x()), camera.width())),
         std::max(0, clip(std::floor(low.y()), camera.height())),
         std::min(camera.width() - 1, clip(std::ceil(high.x()), camera.width())),
         std::min(camera.height() - 1, clip(std::ceil(high.y()), camera.height()))};
  return box.u1 - box.u0 >= 4 && box.v1 - box.v0 >= 4;
}

void SampleCollector::collect(const cv::Mat& grey, const CameraModel& camera, const PatternPlacement& placement,
                              const Eigen::Isometry3d& T_optical_marker, double psf_sd, double margin, int most,
                              bool rim, const PhotometricParameters& parameters, MarkerSamples& samples) {
  samples.clear();
  PixelBox box;
  if (!sheetBox(camera, placement, T_optical_marker, parameters.quiet_zone, box)) return;
  if (!grid_.make(camera, box.u0, box.v0, box.u1, box.v1)) return;
  samples.rays_per_pixel = raysPerPixel(psf_sd);
  candidates_.clear();
  const double sd = std::sqrt(psf_sd * psf_sd + kBoxVariance), n = placement.pattern.cells();
  const double area = (box.u1 - box.u0) * static_cast<double>(box.v1 - box.v0);
  const double cells_per_pixel = (n + 2.0 * parameters.quiet_zone) / std::sqrt(area);
  // Whether the pixels near the print's outer border see what lies beyond the sheet.
  rim = rim && parameters.quiet_zone < ((parameters.reach + kSheetReach) * sd + margin) * cells_per_pixel;
  samples.half_sheet = rim ? 0.5 * n + parameters.quiet_zone : 0.0;
  PixelWalk walk(grey, placement, T_optical_marker, sd, margin, parameters, grid_, rim);
  walk.run(box, candidates_, samples);
  if (candidates_.empty()) return;
  samples.batch.borders = bordersFelt(walk.widest(), walk.off());
  fill(grey, camera, placement.pattern, box, most, samples);
}

void SampleCollector::tabulate(const MarkerPattern& pattern, const PixelBatch& batch) {
  const int side = pattern.cells() + 2 * ring_ + 1, planes = batch.planes();
  table_.resize(static_cast<std::size_t>(side * side * planes));
  // From one cell before the first border to all that follow the last one.
  const int n = pattern.cells(), along = side + batch.borders;
  cells_.resize(static_cast<std::size_t>(along * along));
  for (int row = 0, i = 0; row < along; ++row) {
    const int r = std::clamp(row - ring_ - 1, -1, n);
    for (int column = 0; column < along; ++column, ++i)
      cells_[static_cast<std::size_t>(i)] = static_cast<float>(pattern.at(std::clamp(column - ring_ - 1, -1, n), r));
  }
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      patternAt(cells_.data() + row * along + column, along, batch.borders,
                table_.data() + static_cast<std::size_t>((row * side + column) * planes));
    }
  }
}

void SampleCollector::fill(const cv::Mat& grey, const CameraModel& camera, const MarkerPattern& pattern,
                           const PixelBox& box, int most, MarkerSamples& samples) {
  const auto all = static_cast<std::int64_t>(candidates_.size());
  const int count = static_cast<int>(std::min<std::int64_t>(all, most));
  PixelBatch& batch = samples.batch;
  resize(batch, count, batch.borders, !grid_.linear());
  float farthest = 0.0F;  // beyond the pattern
  for (const PixelCandidate& c : candidates_) {
    farthest = std::max({farthest, -std::min(c.x, c.y), std::max(c.x, c.y) - static_cast<float>(pattern.cells())});
  }
  ring_ = static_cast<int>(std::ceil(farthest + 0.5F * static_cast<float>(batch.borders))) + 1;
  tabulate(pattern, batch);
  const double half = 0.5 * std::max(box.u1 - box.u0, box.v1 - box.v0);
  const double mu = 0.5 * (box.u0 + box.u1), mv = 0.5 * (box.v0 + box.v1);
  const PixelRay middle = grid_.at(mu, mv);
  samples.ray_x = middle.x;
  samples.ray_y = middle.y;
  setRange(box, camera, samples);
  // Dealt into buckets that follow one another: the first one alone is spread over the whole marker.
  order_.clear();
  for (int bucket = 0; bucket < kBuckets; ++bucket) {
    for (int k = bucket; k < count; k += kBuckets) order_.push_back(static_cast<int>(k * all / count));
  }
  order_.resize(static_cast<std::size_t>(batch.padded), 0);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const PixelCandidate& c = candidates_[static_cast<std::size_t>(order_[i])];
    batch.grey[i] = grey.depth() == CV_16U ? grey.ptr<ushort>(c.v)[c.u] : grey.ptr<uchar>(c.v)[c.u];
    batch.pu[i] = static_cast<float>((c.u - mu) / half);
    batch.pv[i] = static_cast<float>((c.v - mv) / half);
    batch.x[i] = static_cast<float>(c.u - mu);
    batch.y[i] = static_cast<float>(c.v - mv);
  }
  if (batch.bent) bendRays(camera, samples);
  fillPattern(pattern.cells(), batch);
}

/// First borders and pattern of each pixel.
void SampleCollector::fillPattern(int cells, PixelBatch& batch) {
  const int side = cells + 2 * ring_ + 1, planes = batch.planes();
  const float centre = 0.5F * static_cast<float>(cells), before = 0.5F * static_cast<float>(batch.borders);
  const auto ring = static_cast<float>(ring_);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const PixelCandidate& c = candidates_[static_cast<std::size_t>(order_[i])];
    // Nearest ones: floor of what is above -ring_.
    const int column = static_cast<int>(c.x - before + 1.0F + ring);
    const int row = static_cast<int>(c.y - before + 1.0F + ring);
    batch.column[i] = static_cast<float>(column - ring_) - centre;
    batch.row[i] = static_cast<float>(row - ring_) - centre;
    const float* from = table_.data() + static_cast<std::size_t>((row * side + column) * planes);
    float* to = batch.pattern.data() + i;
    for (int k = 0; k < planes; ++k, to += batch.padded) *to = from[k];
  }
}

void SampleCollector::bendRays(const CameraModel& camera, MarkerSamples& samples) {
  PixelBatch& batch = samples.batch;
  const double fx = camera.fx(), fy = camera.fy();
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const PixelCandidate& c = candidates_[static_cast<std::size_t>(order_[i])];
    const PixelRay ray = grid_.at(c.u, c.v);
    batch.x[i] = static_cast<float>(fx * (ray.x - samples.ray_x));
    batch.y[i] = static_cast<float>(fy * (ray.y - samples.ray_y));
    batch.xu[i] = static_cast<float>(fx * ray.x_by_u - 1.0);
    batch.xv[i] = static_cast<float>(fx * ray.x_by_v);
    batch.yu[i] = static_cast<float>(fy * ray.y_by_u);
    batch.yv[i] = static_cast<float>(fy * ray.y_by_v - 1.0);
  }
}

/// Of the box's outline: no ray of a pixel is beyond.
void SampleCollector::setRange(const PixelBox& box, const CameraModel& camera, MarkerSamples& samples) const {
  PixelBatch& batch = samples.batch;
  batch.x_min = batch.y_min = 1e9F;
  batch.x_max = batch.y_max = -1e9F;
  for (int i = 0; i < 8; ++i) {
    static constexpr int kU[] = {0, 1, 2, 2, 2, 1, 0, 0}, kV[] = {0, 0, 0, 1, 2, 2, 2, 1};
    const PixelRay ray =
        grid_.at(0.5 * (box.u0 * (2 - kU[i]) + box.u1 * kU[i]), 0.5 * (box.v0 * (2 - kV[i]) + box.v1 * kV[i]));
    const auto x = static_cast<float>(camera.fx() * (ray.x - samples.ray_x));
    const auto y = static_cast<float>(camera.fy() * (ray.y - samples.ray_y));
    batch.x_min = std::min(batch.x_min, x), batch.x_max = std::max(batch.x_max, x);
    batch.y_min = std::min(batch.y_min, y), batch.y_max = std::max(batch.y_max, y);
  }
}

}  // namespace seater_perception
