#include "seater_perception/pattern_alignment.h"

#include <algorithm>
#include <cmath>

namespace seater_perception {
namespace {

constexpr int kBlurs = static_cast<int>(TemplateBook::kBlurs.size());
constexpr double kSmallestStep = 6.0;  // [grey levels] between border and quiet zone
constexpr int kSteps = 10;
constexpr double kLongestStep = 0.5;  // [cells] of a corner
constexpr double kDone = 0.01;        // [cells]
constexpr double kHopeless = 0.2;     // part explained after some steps
constexpr int kFewestSeen = 60;       // [percent] of the samples
constexpr double kCoverable = 5.0;    // [px] cells from which on a part of border and quiet zone may be covered
constexpr double kCovered = 0.3;      // of the contrast: a sample that deviates more there is covered
constexpr double kMostCovered = 0.2;  // of all samples

/// Share of a cell's own brightness that remains in its four samples when the pattern is blurred by `sd` cells: what a
/// bit would change there. Mean over the points a quarter from the borders, along one axis, squared.
double ownShare(double sd) {
  const auto below = [sd](double at) { return 0.5 * std::erfc(-at / (sd * M_SQRT2)); };
  const double along = below(0.75) - below(-0.25);
  return along * along;
}

}  // namespace

bool PatternAligner::look(const PictureLevels& picture, Alignment& a) const {
  picture.sample(a.quad, book_.grid(), a.samples);
  if (a.free.size() > 0) {
    a.samples.weights.array() *= a.free.array();
    a.samples.grey.array() *= a.free.array();
  }
  return 100 * a.samples.seen >= kFewestSeen * book_.grid().size();
}

/// Dark border, lighter quiet zone: what nearly everything that is no marker lacks.
bool PatternAligner::hasBorder(const PictureLevels::Samples& samples) const {
  const PatternGrid& grid = book_.grid();
  float sum[3] = {}, count[3] = {};
  for (int row = 0, i = 0; row < grid.along(); ++row) {
    for (int column = 0; column < grid.along(); ++column, ++i) {
      const int ring = grid.ring(row, column);
      sum[ring] += samples.grey[i];
      count[ring] += samples.weights[i];
    }
  }
  return count[0] > 0.0f && count[1] > 0.0f && sum[0] / count[0] - sum[1] / count[1] > kSmallestStep;
}

/// Gauss-Newton.
bool PatternAligner::descend(const PictureLevels& picture, Alignment& a) const {
  static const Eigen::Vector2d kCorners[] = {{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}};
  const PatternTemplate& pattern = book_.of(a.id, a.blur);
  const double cell = 2.0 / book_.grid().cells();
  for (int step = 0; step < kSteps; ++step) {
    if (!look(picture, a)) return false;
    const auto fit = pattern.fit(a.samples.grey, a.weights(), true);
    if (!fit || !(fit->gain > 0.0) || (step > 2 && fit->explained < kHopeless)) return false;
    a.fit = *fit;
    double longest = 0.0;
    for (const auto& c : kCorners) {
      longest = std::max(longest, (PatternTemplate::moved(fit->motion, c) - c).norm() / cell);
    }
    if (longest < kDone) return true;
    const Eigen::Matrix<double, 8, 1> motion = -std::min(1.0, kLongestStep / longest) * fit->motion;
    const SquareToQuad map(a.quad);
    for (std::size_t i = 0; i < 4; ++i) a.quad[i] = map(PatternTemplate::moved(motion, kCorners[i]));
    if (!(meanSide(a.quad) > 4.0 && meanSide(a.quad) < 1e5)) return false;
  }
  return look(picture, a);
}

/// The blur that explains most; false when it is the one at hand.
bool PatternAligner::chooseBlur(Alignment& a) const {
  const auto explained = [&](int blur) {
    if (blur < 0 || blur >= kBlurs) return -1.0;
    const auto fit = book_.of(a.id, blur).fit(a.samples.grey, a.weights(), false);
    return fit && fit->gain > 0.0 ? fit->explained : -1.0;
  };
  const int before = a.blur;
  double best = explained(a.blur);
  for (const int direction : {-1, 1}) {
    for (double next; (next = explained(a.blur + direction)) > best; best = next) a.blur += direction;
  }
  return a.blur != before;
}

bool PatternAligner::align(const PictureLevels& picture, Alignment& a) const {
  if (!descend(picture, a)) return false;
  for (int round = 0; round < 2 && chooseBlur(a); ++round) {
    if (!descend(picture, a)) return false;
  }
  const auto fit = book_.of(a.id, a.blur).fit(a.samples.grey, a.weights(), false);
  if (fit) a.fit = *fit;
  return fit && fit->gain > 0.0;
}

double PatternAligner::residual(const Alignment& a, const Eigen::VectorXf& values, int row, int column) const {
  const PatternGrid& grid = book_.grid();
  const int i = row * grid.along() + column;
  const double light = a.fit.light[0] + a.fit.light[1] * grid.x(column) + a.fit.light[2] * grid.y(row);
  return a.samples.weights[i] > 0.0f ? a.samples.grey[i] - light - a.fit.gain * values[i] : 0.0;
}

/// Largest deviation of a cell's mean, of what would turn its bit round.
double PatternAligner::worstBit(const Alignment& a) const {
  const Eigen::VectorXf values = book_.of(a.id, a.blur).values();
  const double turning = 0.5 * a.fit.gain * ownShare(TemplateBook::kBlurs[static_cast<std::size_t>(a.blur)]);
  double worst = 0.0;
  for (int row = 1; row + 2 < book_.grid().along(); row += 2) {
    for (int column = 1; column + 2 < book_.grid().along(); column += 2) {
      double sum = 0.0;
      for (int k = 0; k < 4; ++k) sum += residual(a, values, row + k / 2, column + k % 2);
      worst = std::max(worst, std::abs(0.25 * sum) / turning);
    }
  }
  return worst;
}

/// Border and quiet zone of a large marker, without what deviates; false when it is too small or nothing does.
bool PatternAligner::leaveOutCovered(Alignment& a) const {
  const PatternGrid& grid = book_.grid();
  if (meanSide(a.quad) < kCoverable * grid.cells()) return false;
  const Eigen::VectorXf values = book_.of(a.id, a.blur).values();
  Eigen::VectorXf free = Eigen::VectorXf::Ones(grid.size());
  for (int row = 0, i = 0; row < grid.along(); ++row) {
    for (int column = 0; column < grid.along(); ++column, ++i) {
      if (grid.ring(row, column) < 2 && std::abs(residual(a, values, row, column)) > kCovered * a.fit.gain)
        free[i] = 0.0f;
    }
  }
  const float covered = static_cast<float>(grid.size()) - free.sum();
  a.free = free;
  return covered > 0.0f && covered < kMostCovered * static_cast<float>(grid.size());
}

}  // namespace seater_perception
