#include "photometric/samples/pixel_walk.h"

#include <algorithm>
#include <cmath>

namespace seater_perception {
namespace {

constexpr int kTile = 8;                 // [px] shares one linearisation; chosen by hand
constexpr double kFlatReach = 3.4;       // [standard deviations] from a border, it is not felt: 3e-4
constexpr double kWidestBand = 3.5;      // [cells] keeps the table within kRing
constexpr double kSheetClearance = 2.2;  // [standard deviations] from the sheet's outer edge: it is felt by 1.4 %
constexpr double kRimClearance = 0.8;    // the same where the fit knows of a rim; chosen by hand

/// Mean of the flat pixels of one colour in a tile.
struct Sum {
  double grey = 0.0, u = 0.0, v = 0.0;
  int count = 0;

  void add(double value, int pu, int pv) { grey += value, u += pu, v += pv, ++count; }
  void give(double white, const PixelBox& box, MarkerSamples& samples) const {
    if (count == 0) return;
    const double half = 0.5 * std::max(box.u1 - box.u0, box.v1 - box.v0), n = count;
    samples.blocks.push_back(
        {grey / n, (u / n - 0.5 * (box.u0 + box.u1)) / half, (v / n - 0.5 * (box.v0 + box.v1)) / half, white, n});
  }
};

}  // namespace

PixelWalk::PixelWalk(const cv::Mat& grey, const PatternPlacement& placement, const Eigen::Isometry3d& T_optical_marker,
                     double sd, double margin, const PhotometricParameters& parameters, const RayGrid& grid, bool rim)
    : grey_(grey),
      plane_(T_optical_marker),
      parameters_(parameters),
      grid_(grid),
      clearance_(rim ? kRimClearance : kSheetClearance),
      sd_(sd),
      margin_(margin),
      per_metre_(placement.pattern.cells() / placement.size),
      count_(placement.pattern.cells()),
      limit_(parameters.saturation > 0.0 ? parameters.saturation
             : grey.depth() == CV_16U    ? 65535.0
                                         : 255.0),
      side_(placement.pattern.cells() + 2 * kRing),
      cells_(static_cast<std::size_t>(side_ * side_), 1) {
  const int n = placement.pattern.cells();
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column)
      cells_[static_cast<std::size_t>((row + kRing) * side_ + column + kRing)] =
          placement.pattern.at(column, row) > 0.5;
  }
}

void PixelWalk::run(const PixelBox& box, std::vector<PixelCandidate>& candidates, MarkerSamples& samples) {
  grey_.depth() == CV_16U ? walk<ushort>(box, candidates, samples) : walk<uchar>(box, candidates, samples);
}

template <typename Grey>
void PixelWalk::walk(const PixelBox& box, std::vector<PixelCandidate>& candidates, MarkerSamples& samples) {
  for (int v0 = box.v0; v0 <= box.v1; v0 += kTile) {
    for (int u0 = box.u0; u0 <= box.u1; u0 += kTile) {
      const PixelBox part{u0, v0, std::min(u0 + kTile - 1, box.u1), std::min(v0 + kTile - 1, box.v1)};
      Tile tile;
      if (!look(0.5 * (part.u0 + part.u1), 0.5 * (part.v0 + part.v1), tile)) continue;
      const Kind kind = kindOf(tile, 0.5 * kTile);
      if (kind == Kind::flat) addBlock<Grey>(part, tile, box, samples);
      if (kind == Kind::mixed) sort<Grey>(part, tile, box, candidates, samples);
    }
  }
}

bool PixelWalk::look(double u, double v, Tile& tile) {
  MarkerHit hit;
  if (!plane_.hit(grid_.at(u, v), hit)) return false;
  tile.x = hit.x * per_metre_ + 0.5 * count_;
  tile.y = hit.y * per_metre_ + 0.5 * count_;
  tile.xu = hit.gxu * per_metre_, tile.xv = hit.gxv * per_metre_;
  tile.yu = hit.gyu * per_metre_, tile.yv = hit.gyv * per_metre_;
  const double px = std::sqrt(tile.xu * tile.xu + tile.xv * tile.xv);
  const double py = std::sqrt(tile.yu * tile.yu + tile.yv * tile.yv);  // cells per pixel
  const auto f = [](double value) { return static_cast<float>(value); };
  const auto band = [&](double reach, double per_pixel) {
    return f(std::min(kWidestBand, (reach * sd_ + margin_) * per_pixel));
  };
  tile.wx = band(parameters_.reach, px), tile.wy = band(parameters_.reach, py);
  tile.fx = band(kFlatReach, px), tile.fy = band(kFlatReach, py);
  const auto zone = [&](double clearance, double per_pixel) {
    return f(std::max(0.0, parameters_.quiet_zone - clearance * sd_ * per_pixel));
  };
  tile.qx = zone(clearance_, px), tile.qy = zone(clearance_, py);
  tile.sx = zone(kSheetClearance, px), tile.sy = zone(kSheetClearance, py);
  widest_ = std::max({widest_, sd_ * px, sd_ * py});
  off_ = std::max({off_, margin_ * px, margin_ * py});
  return true;
}

PixelWalk::Kind PixelWalk::kindOf(const Tile& t, double radius) const {
  const double rx = radius * (std::abs(t.xu) + std::abs(t.xv)), ry = radius * (std::abs(t.yu) + std::abs(t.yv));
  if (t.x + rx < -t.qx || t.x - rx > count_ + t.qx || t.y + ry < -t.qy || t.y - ry > count_ + t.qy)
    return Kind::outside;
  const bool within = t.x - rx >= -t.sx && t.x + rx <= count_ + t.sx && t.y - ry >= -t.sy && t.y + ry <= count_ + t.sy;
  const bool flat = within && uniform(static_cast<float>(t.x), static_cast<float>(t.y), t.fx + static_cast<float>(rx),
                                      t.fy + static_cast<float>(ry));
  return flat ? Kind::flat : Kind::mixed;
}

/// Whether all cells that this rectangle touches have one colour.
bool PixelWalk::uniform(float x, float y, float wx, float wy) const {
  const int c0 = index(x - wx), c1 = index(x + wx), r0 = index(y - wy), r1 = index(y + wy);
  if (c0 == c1 && r0 == r1) return true;  // of most pixels
  const char colour = cells_[static_cast<std::size_t>(r0 * side_ + c0)];
  for (int r = r0; r <= r1; ++r) {
    for (int c = c0; c <= c1; ++c) {
      if (cells_[static_cast<std::size_t>(r * side_ + c)] != colour) return false;
    }
  }
  return true;
}

/// Clipped pixels tell no noise.
void PixelWalk::addStep(double a, double b, MarkerSamples& samples) const {
  if (std::min(a, b) > 0.0 && std::max(a, b) < limit_) samples.steps.push_back(static_cast<float>(b - a));
}

template <typename Grey>
void PixelWalk::addBlock(const PixelBox& part, const Tile& tile, const PixelBox& whole, MarkerSamples& samples) const {
  std::int64_t sum = 0;
  for (int v = part.v0; v <= part.v1; ++v) {
    const Grey* row = grey_.ptr<Grey>(v);
    for (int u = part.u0; u <= part.u1; ++u) sum += row[u];
    if (part.u1 > part.u0) addStep(row[part.u0], row[part.u0 + 1], samples);
  }
  const int n = (part.u1 - part.u0 + 1) * (part.v1 - part.v0 + 1);
  const Sum all{static_cast<double>(sum), 0.5 * n * (part.u0 + part.u1), 0.5 * n * (part.v0 + part.v1), n};
  all.give(white(static_cast<float>(tile.x), static_cast<float>(tile.y)), whole, samples);
}

template <typename Grey>
void PixelWalk::sort(const PixelBox& part, const Tile& tile, const PixelBox& whole,
                     std::vector<PixelCandidate>& candidates, MarkerSamples& samples) const {
  Sum sums[2];  // black, white
  const auto f = [](double value) { return static_cast<float>(value); };
  const float xu = f(tile.xu), yu = f(tile.yu), right = f(count_) + tile.qx, top = f(count_) + tile.qy;
  const float right_flat = f(count_) + tile.sx, top_flat = f(count_) + tile.sy;
  const double mu = 0.5 * (part.u0 + part.u1), mv = 0.5 * (part.v0 + part.v1);
  for (int v = part.v0; v <= part.v1; ++v) {
    const Grey* row = grey_.ptr<Grey>(v);
    float x = f(tile.x + tile.xv * (v - mv) + tile.xu * (part.u0 - mu));
    float y = f(tile.y + tile.yv * (v - mv) + tile.yu * (part.u0 - mu));
    int flat = part.u0 - 2;  // the last flat pixel of this row
    for (int u = part.u0; u <= part.u1; ++u, x += xu, y += yu) {
      if (x < -tile.qx || x > right || y < -tile.qy || y > top) continue;
      if (!uniform(x, y, tile.wx, tile.wy)) {
        candidates.push_back({u, v, x, y});
      } else if (x >= -tile.sx && x <= right_flat && y >= -tile.sy && y <= top_flat &&
                 uniform(x, y, tile.fx, tile.fy)) {
        sums[white(x, y)].add(row[u], u, v);
        if (flat == u - 1) addStep(row[u - 1], row[u], samples);
        flat = u;
      }
    }
  }
  sums[0].give(0.0, whole, samples);
  sums[1].give(1.0, whole, samples);
}

}  // namespace seater_perception
