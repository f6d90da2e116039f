#include "seater_perception/photometric_samples.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "pixel_walk.h"

namespace seater_perception {
namespace {

constexpr double kBoxVariance = 1.0 / 12.0;
constexpr double kSubVariance = 0.0645497224;  // of the four rays of a pixel: sqrt(1 / 240)
constexpr double kNarrowBlur = 0.45;           // [px] below, the box's own shape shows: 0.3 % of the contrast
constexpr int kMostBorders = 6;
constexpr double kFeltReach = 3.4;  // [standard deviations] beyond it a border is not felt: 3e-4
constexpr int kBuckets = 4;         // pixels are dealt into so many, one after the other

/// Reads 8 and 16 bit pictures alike.
float greyAt(const cv::Mat& grey, int u, int v) {
  return grey.depth() == CV_16U ? static_cast<float>(grey.ptr<ushort>(v)[u])
                                : static_cast<float>(grey.ptr<uchar>(v)[u]);
}

/// How many borders along an axis each pixel has to look at: nearest ones of this blur [cells], which is `off` wrong.
int bordersFelt(double sd, double off) {
  return std::clamp(static_cast<int>(std::ceil(2.0 * (kFeltReach * sd + off))), 1, kMostBorders);
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

/// The pattern round the borders of pixel i, see PixelBatch::pattern.
void fillPattern(const MarkerPattern& pattern, int column, int row, std::size_t i, PixelBatch& batch) {
  const int n = pattern.cells(), K = batch.borders;
  const auto cell = [&](int c, int r) {
    return static_cast<float>(pattern.at(std::clamp(c, -1, n), std::clamp(r, -1, n)));
  };
  const float base = cell(column - 1, row - 1);
  batch.plane(0)[i] = base;
  for (int k = 0; k < K; ++k) {
    batch.plane(1 + k)[i] = cell(column + k, row - 1) - cell(column + k - 1, row - 1);
    batch.plane(1 + K + k)[i] = cell(column - 1, row + k) - cell(column - 1, row + k - 1);
  }
  for (int b = 0; b < K; ++b) {
    for (int a = 0; a < K; ++a) {
      batch.plane(1 + 2 * K + b * K + a)[i] = cell(column + a, row + b) - cell(column + a - 1, row + b) -
                                              cell(column + a, row + b - 1) + cell(column + a - 1, row + b - 1);
    }
  }
}

}  // namespace

double areaVariance(int rays_per_pixel) {
  return rays_per_pixel == 1 ? kBoxVariance : kBoxVariance - kSubVariance;
}

int raysPerPixel(double blur_sd) {
  return blur_sd < kNarrowBlur ? 4 : 1;
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
                              const Eigen::Isometry3d& T_optical_marker, double blur_sd, double margin, int most,
                              const PhotometricParameters& parameters, MarkerSamples& samples) {
  samples.clear();
  PixelBox box;
  if (!sheetBox(camera, placement, T_optical_marker, parameters.quiet_zone, box)) return;
  if (!grid_.make(camera, box.u0, box.v0, box.u1, box.v1)) return;
  samples.rays_per_pixel = raysPerPixel(blur_sd);
  candidates_.clear();
  PixelWalk walk(grey, placement, T_optical_marker, std::sqrt(blur_sd * blur_sd + kBoxVariance), margin, parameters,
                 grid_);
  walk.run(box, candidates_, samples);
  if (candidates_.empty()) return;
  samples.batch.borders = bordersFelt(walk.widest(), walk.off());
  fill(grey, camera, placement.pattern, box, most, samples);
}

void SampleCollector::fill(const cv::Mat& grey, const CameraModel& camera, const MarkerPattern& pattern,
                           const PixelBox& box, int most, MarkerSamples& samples) {
  const auto all = static_cast<std::int64_t>(candidates_.size());
  const int count = static_cast<int>(std::min<std::int64_t>(all, most));
  PixelBatch& batch = samples.batch;
  resize(batch, count, batch.borders, !grid_.linear());
  const double half = 0.5 * std::max(box.u1 - box.u0, box.v1 - box.v0);
  const double mu = 0.5 * (box.u0 + box.u1), mv = 0.5 * (box.v0 + box.v1);
  const PixelRay middle = grid_.at(mu, mv);
  samples.ray_x = middle.x;
  samples.ray_y = middle.y;
  const float centre = 0.5F * static_cast<float>(pattern.cells()),
              before = 0.5F * static_cast<float>(batch.borders - 1);
  const double fx = camera.fx(), fy = camera.fy();
  batch.x_min = batch.y_min = 1e9F;
  batch.x_max = batch.y_max = -1e9F;
  // Dealt into buckets that follow one another: the first one alone is spread over the whole marker.
  std::size_t i = 0;
  const auto add = [&](const PixelCandidate& c) {
    batch.grey[i] = greyAt(grey, c.u, c.v);
    batch.pu[i] = static_cast<float>((c.u - mu) / half);
    batch.pv[i] = static_cast<float>((c.v - mv) / half);
    if (!batch.bent) {
      batch.x[i] = static_cast<float>(c.u - mu);
      batch.y[i] = static_cast<float>(c.v - mv);
    } else {
      const PixelRay ray = grid_.at(c.u, c.v);
      batch.x[i] = static_cast<float>(fx * (ray.x - middle.x));
      batch.y[i] = static_cast<float>(fy * (ray.y - middle.y));
      batch.xu[i] = static_cast<float>(fx * ray.x_by_u - 1.0);
      batch.xv[i] = static_cast<float>(fx * ray.x_by_v);
      batch.yu[i] = static_cast<float>(fy * ray.y_by_u);
      batch.yv[i] = static_cast<float>(fy * ray.y_by_v - 1.0);
    }
    batch.x_min = std::min(batch.x_min, batch.x[i]), batch.x_max = std::max(batch.x_max, batch.x[i]);
    batch.y_min = std::min(batch.y_min, batch.y[i]), batch.y_max = std::max(batch.y_max, batch.y[i]);
    const int column = static_cast<int>(std::floor(c.x - before + 0.5F));
    const int row = static_cast<int>(std::floor(c.y - before + 0.5F));
    batch.column[i] = static_cast<float>(column) - centre;
    batch.row[i] = static_cast<float>(row) - centre;
    fillPattern(pattern, column, row, i, batch);
    ++i;
  };
  for (int bucket = 0; bucket < kBuckets; ++bucket) {
    for (int k = bucket; k < count; k += kBuckets) add(candidates_[static_cast<std::size_t>(k * all / count)]);
  }
  while (i < static_cast<std::size_t>(batch.padded)) add(candidates_.front());
}

}  // namespace seater_perception
