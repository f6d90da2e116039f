#include "seater_perception/pattern_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>

#include "seater_perception/dock_layout.h"
#include "seater_perception/marker_pattern.h"
#include "seater_perception/photometric_model.h"

namespace seater_perception {
namespace {

constexpr double kBlurSd[] = {0.1, 0.4, 0.7};  // [cells] of the codes that are compared
constexpr double kCellFor[] = {7.0, 3.2};      // [px] cells at least so large are compared with the first, second
constexpr double kQuietAt = 0.4;               // [cells] from the border: where the quiet zone is looked at
constexpr double kSmallestStep = 6.0;          // [grey levels] between border and quiet zone
constexpr double kSmallestMargin = 0.04;       // of correlation, over the next best code
constexpr double kWorthAdjusting = 0.55;       // correlation
constexpr double kGoodOutline = 0.93;          // correlation
constexpr double kLargestBitError = 0.62;      // of the contrast
constexpr int kForgiven = 4;                   // cells of border and quiet zone
constexpr double kSteps[] = {0.2, 0.1, 0.05};  // [cells] corners are moved by, but
constexpr double kLargestStep = 1.0;           // [px]
constexpr double kGridStep = 0.5, kMostGridSteps = 10.0;  // [cells] and number: search for a code alone
constexpr int kFewestSeen = 60;                           // [percent] of the samples

/// Maps the unit square (x right, y down) to a quadrilateral: Heckbert, "Fundamentals of Texture Mapping", 1989.
struct SquareToQuad {
  double a, b, c, d, e, f, g, h;
  explicit SquareToQuad(const Quad& q) {
    const Eigen::Vector2d d1 = q[1] - q[2], d2 = q[3] - q[2], s = q[0] - q[1] + q[2] - q[3];
    const double det = d1.x() * d2.y() - d1.y() * d2.x();
    g = (s.x() * d2.y() - s.y() * d2.x()) / det;
    h = (d1.x() * s.y() - d1.y() * s.x()) / det;
    a = q[1].x() - q[0].x() + g * q[1].x(), b = q[3].x() - q[0].x() + h * q[3].x(), c = q[0].x();
    d = q[1].y() - q[0].y() + g * q[1].y(), e = q[3].y() - q[0].y() + h * q[3].y(), f = q[0].y();
  }
  bool at(double x, double y, double& u, double& v) const {
    const double w = g * x + h * y + 1.0;
    u = (a * x + b * y + c) / w;
    v = (d * x + e * y + f) / w;
    return w > 0.05;
  }
};

/// Bilinear; false outside the picture.
bool greyAt(const cv::Mat& grey, double u, double v, float& value) {
  if (!(u >= 0.0 && v >= 0.0 && u < grey.cols - 1 && v < grey.rows - 1)) return false;
  const int x = static_cast<int>(u), y = static_cast<int>(v);
  const float s = static_cast<float>(u - x), t = static_cast<float>(v - y);
  const uchar *top = grey.ptr<uchar>(y) + x, *below = grey.ptr<uchar>(y + 1) + x;
  value = (1 - t) * ((1 - s) * top[0] + s * top[1]) + t * ((1 - s) * below[0] + s * below[1]);
  return true;
}

/// The print's corners of a quadrilateral whose first corner is the print's corner `turn`.
Quad printed(const Quad& quad, int turn) {
  Quad corners;
  for (std::size_t j = 0; j < 4; ++j) corners[j] = quad[(j + 4 - static_cast<std::size_t>(turn)) % 4];
  return corners;
}

double meanSide(const Quad& q) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum += (q[(i + 1) % 4] - q[i]).norm();
  return 0.25 * sum;
}

void normalise(std::vector<float>& v) {
  float mean = 0.0f, squares = 0.0f;
  for (const float x : v) mean += x / static_cast<float>(v.size());
  for (float& x : v) x -= mean, squares += x * x;
  for (float& x : v) x /= std::sqrt(squares);
}

}  // namespace

PatternReader::PatternReader(const std::string& dictionary, const std::set<int>& ids) {
  const auto known = cv::aruco::getPredefinedDictionary(dictionaryNumber(dictionary, "dictionary"));
  std::set<int> wanted = ids;
  for (int id = 0; ids.empty() && id < known->bytesList.rows; ++id) wanted.insert(id);
  cells_ = known->markerSize + 2;
  side_ = cells_ + 2;
  const double n = cells_;
  for (const int id : wanted) {
    if (id < 0 || id >= known->bytesList.rows) continue;  // a dock may name what its dictionary does not have
    const MarkerPattern pattern = MarkerPattern::fromDictionary(dictionary, id);
    for (int turn = 0; turn < 4; ++turn) {
      Code code;
      code.id = id;
      code.turn = turn;
      for (int row = 0; row < side_; ++row) {
        for (int column = 0; column < side_; ++column) {
          const auto along = [n](int i) { return i == 0 ? -kQuietAt : i == n + 1 ? n + kQuietAt : i - 0.5; };
          const double a = along(column), b = along(row);
          const double x = turn == 0 ? a : turn == 1 ? n - b : turn == 2 ? n - a : b;
          const double y = turn == 0 ? b : turn == 1 ? a : turn == 2 ? n - b : n - a;  // down
          for (std::size_t k = 0; k < kBlurs; ++k) {
            code.values[k].push_back(
                static_cast<float>(smoothedPattern(pattern, x, n - y, kBlurSd[k], kBlurSd[k], 0.0).value));
          }
          const int c = static_cast<int>(std::floor(x)), r = static_cast<int>(std::floor(n - y));
          code.bits.push_back(pattern.at(c, r) > 0.5);
        }
      }
      for (auto& values : code.values) normalise(values);
      codes_.push_back(code);
    }
  }
}

bool PatternReader::sample(const cv::Mat& grey, const Quad& quad, Samples& samples) const {
  const SquareToQuad map(quad);
  const double n = cells_, cell = meanSide(quad) / n;
  const auto along = [n](int i) { return (i == 0 ? -kQuietAt : i == n + 1 ? n + kQuietAt : i - 0.5) / n; };
  const bool several = cell > 6.0;
  samples.grey.assign(static_cast<std::size_t>(side_ * side_), 0.0f);
  samples.seen.assign(samples.grey.size(), 0);
  samples.count = 0;
  for (int row = 0, i = 0; row < side_; ++row) {
    for (int column = 0; column < side_; ++column, ++i) {
      float sum = 0.0f;
      int count = 0;
      for (int k = 0; k < (several ? 5 : 1); ++k) {
        static constexpr double kX[] = {0.0, -0.2, 0.2, -0.2, 0.2}, kY[] = {0.0, -0.2, -0.2, 0.2, 0.2};
        double u = 0.0, v = 0.0;
        float value = 0.0f;
        if (map.at(along(column) + kX[k] / n, along(row) + kY[k] / n, u, v) && greyAt(grey, u, v, value))
          sum += value, ++count;
      }
      if (count == 0) continue;
      samples.grey[static_cast<std::size_t>(i)] = sum / static_cast<float>(count);
      samples.seen[static_cast<std::size_t>(i)] = 1;
      ++samples.count;
    }
  }
  return 100 * samples.count >= kFewestSeen * side_ * side_;
}

double PatternReader::correlate(const Samples& samples, const std::vector<float>& code) const {
  double sg = 0.0, sgg = 0.0, sc = 0.0, scc = 0.0, sgc = 0.0;
  for (std::size_t i = 0; i < code.size(); ++i) {
    const double w = samples.seen[i], g = samples.grey[i], c = w * code[i];
    sg += g, sgg += g * g, sc += c, scc += c * c, sgc += g * c;
  }
  const double n = samples.count, variance = sgg - sg * sg / n, own = scc - sc * sc / n;
  return variance > 1e-6 && own > 1e-9 ? (sgc - sg * sc / n) / std::sqrt(variance * own) : 0.0;
}

/// Dark border, lighter quiet zone: what nearly everything that is no marker lacks.
bool PatternReader::hasBorder(const Samples& samples) const {
  double quiet = 0.0, border = 0.0;
  int quiets = 0, borders = 0;
  for (int row = 0, i = 0; row < side_; ++row) {
    for (int column = 0; column < side_; ++column, ++i) {
      if (!samples.seen[static_cast<std::size_t>(i)]) continue;
      const int ring = std::min({row, column, side_ - 1 - row, side_ - 1 - column});
      if (ring == 0) quiet += samples.grey[static_cast<std::size_t>(i)], ++quiets;
      if (ring == 1) border += samples.grey[static_cast<std::size_t>(i)], ++borders;
    }
  }
  return quiets > 0 && borders > 0 && quiet / quiets - border / borders > kSmallestStep;
}

bool PatternReader::everyBit(const Samples& samples, const Code& code, int blur) const {
  const auto& values = code.values[static_cast<std::size_t>(blur)];
  double sg = 0.0, sc = 0.0, scc = 0.0, sgc = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double w = samples.seen[i], g = samples.grey[i], c = w * values[i];
    sg += g, sc += c, scc += c * c, sgc += g * c;
  }
  const double n = samples.count, gain = (sgc - sg * sc / n) / (scc - sc * sc / n), offset = (sg - gain * sc) / n;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double limit = kLargestBitError * gain * (*high - *low);
  // Of a large marker, a part of border and quiet zone may be covered; the code itself may not.
  int forgiven = blur == 0 ? kForgiven : 0;
  for (int row = 0, i = 0; row < side_; ++row) {
    for (int column = 0; column < side_; ++column, ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (!samples.seen[k] || std::abs(samples.grey[k] - offset - gain * values[k]) <= limit) continue;
      const bool frame = std::min({row, column, side_ - 1 - row, side_ - 1 - column}) < 2;
      if (!frame || --forgiven < 0) return false;
    }
  }
  return gain > 0.0;
}

/// Moves the corners one after the other to where the correlation is larger.
double PatternReader::adjust(const cv::Mat& grey, const Code& code, int blur, double start, Quad& quad,
                             Samples& samples) const {
  double best = start;
  const double cell = meanSide(quad) / cells_;
  for (const double step : kSteps) {
    const double length = std::min(step * cell, kLargestStep);
    bool moved = true;
    for (int round = 0; moved && round < 3; ++round) {
      moved = false;
      for (std::size_t corner = 0; corner < 4; ++corner) {
        for (int k = 0; k < 4; ++k) {
          Quad other = quad;
          other[corner][k / 2] += (k % 2 ? length : -length);
          if (!sample(grey, other, samples)) continue;
          const double now = correlate(samples, code.values[static_cast<std::size_t>(blur)]);
          if (now > best) best = now, quad = other, moved = true;
        }
      }
    }
  }
  sample(grey, quad, samples);
  return best;
}

int PatternReader::blurFor(const Quad& quad) const {
  const double cell = meanSide(quad) / cells_;
  return cell > kCellFor[0] ? 0 : cell > kCellFor[1] ? 1 : 2;
}

std::optional<PatternReading> PatternReader::read(const cv::Mat& grey, const Quad& quad, double min_correlation) const {
  Samples samples;
  if (!sample(grey, quad, samples) || !hasBorder(samples)) return std::nullopt;
  const int blur = blurFor(quad);
  double best = 0.0;
  const Code* code = nullptr;
  for (const Code& c : codes_) {
    const double now = correlate(samples, c.values[static_cast<std::size_t>(blur)]);
    if (now > best) best = now, code = &c;
  }
  if (!code || best < kWorthAdjusting) return std::nullopt;
  Quad corners = quad;
  // Where the outline is good enough, the middles of the cells tell less of the corners than it does.
  if (best < kGoodOutline) best = adjust(grey, *code, blur, best, corners, samples);
  if (best < min_correlation || !everyBit(samples, *code, blur)) return std::nullopt;
  for (const Code& c : codes_) {
    if (&c != code && correlate(samples, c.values[static_cast<std::size_t>(blur)]) > best - kSmallestMargin)
      return std::nullopt;
  }
  return PatternReading{code->id, printed(corners, code->turn), best};
}

std::optional<PatternReading> PatternReader::follow(int id, const cv::Mat& grey, const Quad& corners, double reach,
                                                    double min_correlation) const {
  const auto code =
      std::find_if(codes_.begin(), codes_.end(), [&](const Code& c) { return c.id == id && c.turn == 0; });
  if (code == codes_.end()) return std::nullopt;
  const int blur = blurFor(corners);
  const auto& values = code->values[static_cast<std::size_t>(blur)];
  const double step = std::max(1.0, kGridStep * meanSide(corners) / cells_);
  const int steps = static_cast<int>(std::min(kMostGridSteps, reach / step));
  Samples samples;
  Quad quad = corners;
  double best = 0.0;
  for (int y = -steps; y <= steps; ++y) {
    for (int x = -steps; x <= steps; ++x) {
      Quad shifted = corners;
      for (auto& c : shifted) c += step * Eigen::Vector2d(x, y);
      if (!sample(grey, shifted, samples)) continue;
      const double now = correlate(samples, values);
      if (now > best) best = now, quad = shifted;
    }
  }
  if (best < kWorthAdjusting * min_correlation) return std::nullopt;
  best = adjust(grey, *code, blur, best, quad, samples);
  if (best < min_correlation || !hasBorder(samples) || !everyBit(samples, *code, blur)) return std::nullopt;
  return PatternReading{id, quad, best};
}

}  // namespace seater_perception
