#include "seater_perception/photometric_samples.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace seater_perception {
namespace {

constexpr int kNodeStep = 8;           // [px] between the nodes of the ray grid
constexpr int kTile = 8;               // [px] tiles without an edge give a single sample
constexpr int kSparseArea = 1000;      // [px] a sparse collection looks at about so many
constexpr double kEdgesPerCell = 0.8;  // sides of cells with an edge, over cells: of a usual code
constexpr int kRowShift = 7;
constexpr int kThinning = 2;             // of flat pixels elsewhere: every second one of every second row
constexpr double kSheetClearance = 2.2;  // [standard deviations] kept from the sheet's outer edge
// The mean over a pixel's box is that over four Gaussians at these offsets up to the fifth moment: a = (1/240)^(1/4).
constexpr double kSubOffset = 0.25406637;
constexpr double kBoxVariance = 1.0 / 12.0;
constexpr double kNarrowBlur = 0.45;  // [px] below, the box's own shape shows: 0.3 % of the contrast

using Poses = std::vector<Eigen::Isometry3d>;

struct Box {
  int u0, v0, u1, v1;  // last ones included
};

/// The marker's sheet in the picture; nothing when it is not in it.
std::optional<Box> sheetBox(const CameraModel& camera, const PatternPlacement& placement, const Poses& poses,
                            double quiet_zone) {
  const double h = placement.size * (0.5 + quiet_zone / placement.pattern.cells());
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (const Eigen::Isometry3d& pose : poses) {
    for (int i = 0; i < 8; ++i) {  // corners and the middles between: distortion bends the sides outwards
      static constexpr int kX[] = {-1, 0, 1, 1, 1, 0, -1, -1}, kY[] = {-1, -1, -1, 0, 1, 1, 1, 0};
      const auto pixel = camera.project(pose * Eigen::Vector3d(kX[i] * h, kY[i] * h, 0.0));
      if (!pixel) return std::nullopt;
      low = low.cwiseMin(*pixel);
      high = high.cwiseMax(*pixel);
    }
  }
  const auto clip = [](double value, int limit) { return static_cast<int>(std::clamp(value, -1.0, limit + 1.0)); };
  const Box box{std::max(0, clip(std::floor(low.x()), camera.width())),
                std::max(0, clip(std::floor(low.y()), camera.height())),
                std::min(camera.width() - 1, clip(std::ceil(high.x()), camera.width())),
                std::min(camera.height() - 1, clip(std::ceil(high.y()), camera.height()))};
  if (box.u1 - box.u0 < 4 || box.v1 - box.v0 < 4) return std::nullopt;
  return box;
}

/// Reads 8 and 16 bit pictures alike.
struct Reader {
  const cv::Mat& grey;
  bool deep;
  double operator()(int u, int v) const { return deep ? grey.ptr<ushort>(v)[u] : grey.ptr<uchar>(v)[u]; }
};

/// Walks over a marker's box and sorts its pixels.
class Collector {
 public:
  Collector(const PatternPlacement& placement, const Poses& poses, double blur_sd, double margin, int every,
            const PhotometricParameters& parameters, const RayGrid& grid)
      : pattern_(placement.pattern),
        planes_(poses.begin(), poses.end()),
        parameters_(parameters),
        grid_(grid),
        margin_(margin),
        every_(every),
        variance_(blur_sd * blur_sd + kBoxVariance),
        per_metre_(placement.pattern.cells() / placement.size) {}

  void collect(const Reader& read, const Box& box, MarkerSamples& out) const {
    const double half = 0.5 * std::max(box.u1 - box.u0, box.v1 - box.v0);
    const double mu = 0.5 * (box.u0 + box.u1), mv = 0.5 * (box.v0 + box.v1);
    const auto add = [&](int u, int v, bool edge) {
      const double step = edge ? 0.0 : read(u == read.grey.cols - 1 ? u - 1 : u + 1, v) - read(u, v);
      out.pixels.push_back({read(u, v), (u - mu) / half, (v - mv) / half, edge, step});
      out.edges += edge;
      addRays(u, v, out);
    };
    for (int v0 = box.v0; v0 <= box.v1; v0 += kTile) {
      for (int u0 = box.u0; u0 <= box.u1; u0 += kTile) {
        const int u1 = std::min(u0 + kTile - 1, box.u1), v1 = std::min(v0 + kTile - 1, box.v1);
        const Kind kind = look(0.5 * (u0 + u1), 0.5 * (v0 + v1), 0.71 * kTile);
        if (kind == Kind::flat) add((u0 + u1) / 2, (v0 + v1) / 2, false);
        if (kind != Kind::edge) continue;
        for (int v = v0; v <= v1; ++v) {
          // One pixel of every_ in a row, shifted from row to row.
          for (int u = u0 + every_ - 1 - (u0 + kRowShift * v) % every_; u <= u1; u += every_) {
            const Kind pixel = look(u, v, 0.0);
            if (pixel == Kind::edge) add(u, v, true);
            if (pixel == Kind::flat && u % kThinning == 0 && v % kThinning == 0) add(u, v, false);
          }
        }
      }
    }
  }

 private:
  enum class Kind { outside, flat, edge };

  /// What is within `radius` [px] of a place, for all poses together. A region partly outside the sheet counts as edge:
  /// to be looked at closely.
  Kind look(double u, double v, double radius) const {
    const PixelRay ray = grid_.at(u, v);
    Kind result = Kind::flat;
    for (const MarkerPlane& plane : planes_) {
      const Kind kind = look(plane, ray, radius);
      if (kind == Kind::outside) return Kind::outside;
      if (kind == Kind::edge) result = Kind::edge;
    }
    return result;
  }

  Kind look(const MarkerPlane& plane, const PixelRay& ray, double radius) const {
    MarkerHit hit;
    if (!plane.hit(ray, {variance_, 0.0, variance_}, hit)) return Kind::outside;
    const double n = pattern_.cells();
    const double x = hit.x * per_metre_ + 0.5 * n, y = hit.y * per_metre_ + 0.5 * n;
    const double sx = hit.sx * per_metre_, sy = hit.sy * per_metre_;
    const double px = sx / std::sqrt(variance_), py = sy / std::sqrt(variance_);  // cells per pixel
    const double qx = std::max(0.0, parameters_.quiet_zone - kSheetClearance * sx);
    const double qy = std::max(0.0, parameters_.quiet_zone - kSheetClearance * sy);
    const double rx = radius * px, ry = radius * py;
    if (x + rx < -qx || x - rx > n + qx || y + ry < -qy || y - ry > n + qy) return Kind::outside;
    const bool within = x - rx >= -qx && x + rx <= n + qx && y - ry >= -qy && y + ry <= n + qy;
    if (!within) return radius > 0.0 ? Kind::edge : Kind::outside;
    const double wx = rx + parameters_.reach * sx + margin_ * px;
    const double wy = ry + parameters_.reach * sy + margin_ * py;
    return uniform(x - wx, x + wx, y - wy, y + wy) ? Kind::flat : Kind::edge;
  }

  bool uniform(double x0, double x1, double y0, double y1) const {
    const auto cell = [this](double x) {
      return static_cast<int>(std::floor(std::clamp(x, -0.5, pattern_.cells() + 0.5)));
    };
    const int c0 = cell(x0), c1 = cell(x1), r0 = cell(y0), r1 = cell(y1);
    const double value = pattern_.at(c0, r0);
    for (int r = r0; r <= r1; ++r) {
      for (int c = c0; c <= c1; ++c) {
        if (pattern_.at(c, r) != value) return false;
      }
    }
    return true;
  }

  void addRays(int u, int v, MarkerSamples& out) const {
    if (out.rays_per_pixel == 1) {
      out.rays.push_back(grid_.at(u, v));
      return;
    }
    for (const double dv : {-kSubOffset, kSubOffset}) {
      for (const double du : {-kSubOffset, kSubOffset}) out.rays.push_back(grid_.at(u + du, v + dv));
    }
  }

  const MarkerPattern& pattern_;
  const std::vector<MarkerPlane> planes_;
  const PhotometricParameters& parameters_;
  const RayGrid& grid_;
  const double margin_;
  const int every_;
  const double variance_, per_metre_;
};

/// Leaves out pixels evenly until at most `limit` are left.
void thinOut(std::size_t limit, MarkerSamples& samples) {
  const std::size_t count = samples.pixels.size(), k = static_cast<std::size_t>(samples.rays_per_pixel);
  if (count <= limit) return;
  samples.edges = 0;
  for (std::size_t i = 0; i < limit; ++i) {
    const std::size_t from = i * count / limit;
    samples.pixels[i] = samples.pixels[from];
    samples.edges += samples.pixels[i].edge;
    for (std::size_t j = 0; j < k; ++j) samples.rays[i * k + j] = samples.rays[from * k + j];
  }
  samples.pixels.resize(limit);
  samples.rays.resize(limit * k);
}

}  // namespace

double areaVariance(int rays_per_pixel) {
  return rays_per_pixel == 1 ? kBoxVariance : kBoxVariance - kSubOffset * kSubOffset;
}

int raysPerPixel(double blur_sd) {
  return blur_sd < kNarrowBlur ? 4 : 1;
}

std::optional<RayGrid> RayGrid::make(const CameraModel& camera, int u0, int v0, int u1, int v1) {
  RayGrid grid;
  grid.u0_ = u0;
  grid.v0_ = v0;
  grid.columns_ = 2 * ((u1 - u0) / (2 * kNodeStep) + 1) + 1;
  grid.rows_ = 2 * ((v1 - v0) / (2 * kNodeStep) + 1) + 1;
  grid.fx_ = camera.fx(), grid.fy_ = camera.fy(), grid.cx_ = camera.cx(), grid.cy_ = camera.cy();
  grid.nodes_.reserve(static_cast<std::size_t>(grid.columns_ * grid.rows_));
  double deviation = 0.0;
  for (int row = 0; row < grid.rows_; ++row) {
    for (int column = 0; column < grid.columns_; ++column) {
      const Eigen::Vector2d pixel(u0 + column * kNodeStep, v0 + row * kNodeStep);
      const auto ray = camera.undistort(pixel);
      if (!ray) return std::nullopt;
      const Eigen::Vector2d straight((pixel.x() - grid.cx_) / grid.fx_, (pixel.y() - grid.cy_) / grid.fy_);
      deviation = std::max(deviation, (*ray - straight).cwiseAbs().maxCoeff());
      grid.nodes_.push_back(*ray);
    }
  }
  grid.linear_ = deviation < 1e-10;
  return grid;
}

PixelRay RayGrid::at(double u, double v) const {
  if (linear_) return {(u - cx_) / fx_, (v - cy_) / fy_, 1.0 / fx_, 0.0, 0.0, 1.0 / fy_};
  const double x = (u - u0_) / kNodeStep, y = (v - v0_) / kNodeStep;
  const int column = std::clamp(2 * static_cast<int>(x / 2.0), 0, columns_ - 3);
  const int row = std::clamp(2 * static_cast<int>(y / 2.0), 0, rows_ - 3);
  const double s = x - column, t = y - row;
  const double ls[] = {0.5 * (s - 1.0) * (s - 2.0), s * (2.0 - s), 0.5 * s * (s - 1.0)};
  const double lt[] = {0.5 * (t - 1.0) * (t - 2.0), t * (2.0 - t), 0.5 * t * (t - 1.0)};
  const double ds[] = {s - 1.5, 2.0 - 2.0 * s, s - 0.5}, dt[] = {t - 1.5, 2.0 - 2.0 * t, t - 0.5};
  PixelRay ray;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector2d& node = nodes_[static_cast<std::size_t>((row + i) * columns_ + column + j)];
      const double w = lt[i] * ls[j], wu = lt[i] * ds[j] / kNodeStep, wv = dt[i] * ls[j] / kNodeStep;
      ray.x += w * node.x();
      ray.y += w * node.y();
      ray.x_by_u += wu * node.x();
      ray.x_by_v += wv * node.x();
      ray.y_by_u += wu * node.y();
      ray.y_by_v += wv * node.y();
    }
  }
  return ray;
}

MarkerSamples collectSamples(const cv::Mat& grey, const CameraModel& camera, const PatternPlacement& placement,
                             const Poses& T_optical_marker, double blur_sd, double margin, bool sparse,
                             const PhotometricParameters& parameters) {
  MarkerSamples samples;
  const auto box = sheetBox(camera, placement, T_optical_marker, parameters.quiet_zone);
  if (!box) return samples;
  const auto grid = RayGrid::make(camera, box->u0, box->v0, box->u1, box->v1);
  if (!grid) return samples;
  samples.rays_per_pixel = raysPerPixel(blur_sd);
  samples.side = camera.fx() * placement.size / std::max(1e-6, T_optical_marker.front().translation().z());
  const auto expected =
      static_cast<std::size_t>(std::min(parameters.max_pixels, (box->u1 - box->u0 + 1) * (box->v1 - box->v0 + 1)));
  samples.pixels.reserve(expected);
  samples.rays.reserve(expected * static_cast<std::size_t>(samples.rays_per_pixel));
  const int area = (box->u1 - box->u0 + 1) * (box->v1 - box->v0 + 1);
  // Of a large marker, most pixels are near no edge, and those that are, are more than needed.
  const double cells = placement.pattern.cells() + 2.0 * parameters.quiet_zone, side = std::sqrt(area);
  const double band = 2.0 * (parameters.reach * std::sqrt(blur_sd * blur_sd + kBoxVariance) + margin);
  const double edges =
      std::min<double>(area, kEdgesPerCell * placement.pattern.cells() * cells * (side / cells) * band);
  const int every = std::clamp(static_cast<int>(sparse ? area / kSparseArea : edges / parameters.max_pixels), 1, 100);
  Collector(placement, T_optical_marker, blur_sd, margin, every, parameters, *grid)
      .collect({grey, grey.depth() == CV_16U}, *box, samples);
  thinOut(static_cast<std::size_t>(parameters.max_pixels), samples);
  return samples;
}

}  // namespace seater_perception
