#include "search/code/pattern_alignment.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace seater_perception {
namespace {

constexpr int kLevels = static_cast<int>(TemplateBook::kTemplateSd.size());
// Chosen by hand: a seventh of the dimmest print's contrast (tracker_cases_test: 40).
constexpr double kSmallestStep = 6.0;  // [grey levels] between border and quiet zone
// Of the quiet zone's lightness over the border, the lightest point of markers in photographs and drawn ones (5700;
// thin white, steep) has 0.78 and more; of what else has a border in photographs, nine of ten have less than 0.05.
constexpr float kLightestBit = 0.15f;
constexpr int kSteps = 10;             // ends what does not converge
constexpr double kLongestStep = 0.5;   // [cells] of a corner: the template is linear only so near
constexpr double kShortestPace = 0.4;  // of a step; chosen by hand
constexpr double kDone = 0.01;         // [cells] a third of the corners' accuracy on large markers (0.03 cells)
// Enough to choose the blur, whose finest levels differ by as much. Chosen by hand; it saves time.
constexpr double kRoughly = 0.05;  // [cells]
// Chosen by hand; it saves time: a marker that is cut off so far does not show every bit, and is refused later.
constexpr int kFewestSeen = 60;  // [percent] of the samples
// Of fewer pixels a cell, noise and a wrong code look like something that covers: images without markers reach an
// evidence of 5.3 with samples left out, 3.6 without (docs/results/perception.md). The three were chosen by hand;
// perception_range (false detections) guards them.
constexpr double kCoverable = 5.0;     // [px] cells from which on a part of border and quiet zone may be covered
constexpr double kCovered = 0.3;       // of the contrast: a sample that deviates more there is covered
constexpr double kMostCovered = 0.15;  // of all samples
// [px] Paths of a moving image that are tried, and the psf_sd of one that stands still: 8 px is the motion blur that
// tracker_cases_test asks for. Chosen by hand.
constexpr double kPaths[] = {5.0, 8.0}, kStillPsf = 1.1;
constexpr int kDirections = 4;  // 45 deg apart
// From 60 deg on, cells are twice as long as wide in the image, and no round PSF in cells is one in pixels. The widths,
// with the pixel's own area, are those of sharp to soft lenses. Chosen by hand.
constexpr double kSteep = 1.8, kSteepPsf[] = {0.7, 1.0, 1.5};  // [px]

/// How the image changes by a cell's length along each axis, at the print's middle [px].
Eigen::Matrix2d cellInImage(const Quad& quad, int cells) {
  const SquareToQuad map(quad);
  const double step = 1.0 / cells;
  Eigen::Matrix2d by_cell;
  by_cell << (map({step, 0.0}) - map({-step, 0.0})), (map({0.0, step}) - map({0.0, -step}));
  return by_cell;
}

}  // namespace

const PatternTemplate& PatternAligner::templateOf(const Alignment& a) const {
  return a.own ? *a.own : book_.of(a.id, a.level);
}

bool PatternAligner::look(const ImageLevels& image, Alignment& a) const {
  image.sample(a.quad, book_.grid(), a.samples);
  if (a.free.size() > 0) {
    a.samples.weights.array() *= a.free.array();
    a.samples.grey.array() *= a.free.array();
  }
  return 100 * a.samples.seen >= kFewestSeen * book_.grid().size();
}

namespace {

/// Mean grey levels of the quiet zone and the border, and the lightest within.
struct Rings {
  float quiet = 0.0f, border = 0.0f, lightest = 0.0f;
  bool known = false;
};

Rings ringsOf(const PatternGrid& grid, const ImageLevels::Samples& samples) {
  const int along = grid.along(), border = grid.border();
  const Eigen::Map<const Eigen::MatrixXf> grey(samples.grey.data(), along, along);
  const Eigen::Map<const Eigen::MatrixXf> weights(samples.weights.data(), along, along);
  // What lies within the outermost `ring` points.
  const auto within = [along](const auto& points, int ring) {
    return points.block(ring, ring, along - 2 * ring, along - 2 * ring);
  };
  const int bits = 1 + 2 * border;
  const float print = within(grey, 1).sum(), seen = within(weights, 1).sum();
  const float quiet_seen = weights.sum() - seen, border_seen = seen - within(weights, bits).sum();
  Rings rings;
  rings.known = quiet_seen > 0.5f && border_seen > 0.5f;
  if (!rings.known) return rings;
  rings.quiet = (grey.sum() - print) / quiet_seen;
  rings.border = (print - within(grey, bits).sum()) / border_seen;
  rings.lightest = std::max(0.0f, within(grey, bits).maxCoeff());
  return rings;
}

}  // namespace

bool PatternAligner::hasBorder(const ImageLevels::Samples& samples) const {
  const Rings rings = ringsOf(book_.grid(), samples);
  return rings.known && rings.quiet - rings.border > kSmallestStep;
}

bool PatternAligner::showsBits(const ImageLevels::Samples& samples) const {
  const Rings rings = ringsOf(book_.grid(), samples);
  return rings.known && rings.lightest - rings.border > kLightestBit * (rings.quiet - rings.border);
}

namespace {

Eigen::Vector2d corner(int i) {
  return {i == 1 || i == 2 ? 1.0 : -1.0, i >= 2 ? 1.0 : -1.0};
}

/// How far each corner goes with a motion [half sides].
Eigen::Matrix<double, 8, 1> cornersMoved(const Eigen::Matrix<double, 8, 1>& motion) {
  Eigen::Matrix<double, 8, 1> moved;
  for (int i = 0; i < 4; ++i) moved.segment<2>(2 * i) = PatternTemplate::moved(motion, corner(i)) - corner(i);
  return moved;
}

/// Of a step, how much of it to go. Where edges are sharper in the image than in the template (aliased, sharpened), its
/// gradient is too small and steps are up to twice too long: the fit would go to and fro. What the last step has
/// changed of the next one tells (secant).
double paceOf(const Eigen::Matrix<double, 8, 1>& last, double last_pace, const Eigen::Matrix<double, 8, 1>& next) {
  const double growth = last.dot(last - next), of = last_pace * last.squaredNorm();
  return growth > of ? std::max(kShortestPace, of / growth) : 1.0;
}

}  // namespace

/// Gauss-Newton, until the next step is shorter than `done` [cells]. The fit is that of the samples.
bool PatternAligner::descend(const ImageLevels& image, double done, Alignment& a) const {
  const PatternTemplate& pattern = templateOf(a);
  const double cell = 2.0 / book_.grid().cells();
  Eigen::Matrix<double, 8, 1> last = Eigen::Matrix<double, 8, 1>::Zero();
  double pace = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    if ((step > 0 || a.samples.grey.size() == 0) && !look(image, a)) return false;
    const auto fit = pattern.fit(a.samples.grey, a.weights(), true);
    if (!fit || !(fit->gain > 0.0) || (step > 2 && fit->explained < kHopeless)) return false;
    a.fit = *fit;
    const Eigen::Matrix<double, 8, 1> next = cornersMoved(fit->motion);
    pace = step > 0 ? paceOf(last, pace, next) : 1.0;
    double longest = 0.0;
    for (int i = 0; i < 4; ++i) longest = std::max(longest, pace * next.segment<2>(2 * i).norm() / cell);
    if (longest < done) return true;
    if (longest > kLongestStep) pace *= kLongestStep / longest;
    last = next;
    const SquareToQuad map(a.quad);
    for (int i = 0; i < 4; ++i)
      a.quad[static_cast<std::size_t>(i)] = map(PatternTemplate::moved(-pace * fit->motion, corner(i)));
    if (!(meanSide(a.quad) > 4.0 && meanSide(a.quad) < 1e5)) return false;
  }
  if (!look(image, a)) return false;
  const auto fit = pattern.fit(a.samples.grey, a.weights(), false);
  if (fit) a.fit = *fit;
  return fit && fit->gain > 0.0;
}

/// The level that explains most, and its fit; false when it is the one at hand.
bool PatternAligner::chooseLevel(Alignment& a) const {
  if (a.own) return false;
  std::optional<PatternTemplate::Fit> fit;
  const auto explained = [&](int level) {
    if (level < 0 || level >= kLevels) return -1.0;
    fit = book_.of(a.id, level).fit(a.samples.grey, a.weights(), false);
    return fit && fit->gain > 0.0 ? fit->explained : -1.0;
  };
  const int before = a.level;
  for (const int direction : {-1, 1}) {
    while (explained(a.level + direction) > a.fit.explained) a.level += direction, a.fit = *fit;
  }
  return a.level != before;
}

bool PatternAligner::align(const ImageLevels& image, Alignment& a, double least) const {
  if (!descend(image, kRoughly, a)) return false;
  for (int round = 0; round < 2; ++round) {
    const bool changed = chooseLevel(a);
    if (a.fit.explained < least) return false;
    if (round > 0 && !changed) break;
    if (!descend(image, kDone, a)) return false;
  }
  return true;
}

BitErrors PatternAligner::bitErrors(const Alignment& a) const {
  const int along = book_.grid().along();
  const Eigen::VectorXf residual = (a.samples.grey - templateOf(a).grey(a.fit)).cwiseProduct(a.samples.weights);
  const double turning = 0.5 * a.fit.gain * templateOf(a).ownFraction();
  BitErrors errors;
  for (int row = 1; row + 2 < along; row += 2) {
    for (int column = 1; column + 2 < along; column += 2) {
      double sum = 0.0, seen = 0.0;
      for (const int i : {row * along + column, row * along + column + 1, (row + 1) * along + column,
                          (row + 1) * along + column + 1}) {
        sum += residual[i];
        seen += a.samples.weights[i];
      }
      // A cell of the code that is out of the image proves nothing; one of the border may be.
      const bool hidden = seen == 0.0 && book_.grid().ring(row, column) == 2;
      if (hidden) return {std::numeric_limits<double>::infinity(), book_.grid().size()};
      const double error = seen > 0.0 ? std::abs(sum / seen) / turning : 0.0;
      errors.worst = std::max(errors.worst, error);
      if (!(error < BitErrors::kLargest)) ++errors.contradicted;
    }
  }
  return errors;
}

bool PatternAligner::leaveOutCovered(Alignment& a) const {
  const PatternGrid& grid = book_.grid();
  if (meanSide(a.quad) < kCoverable * grid.cells()) return false;
  const Eigen::VectorXf residual = a.samples.grey - templateOf(a).grey(a.fit);
  Eigen::VectorXf free = Eigen::VectorXf::Ones(grid.size());
  for (int row = 0, i = 0; row < grid.along(); ++row) {
    for (int column = 0; column < grid.along(); ++column, ++i) {
      if (grid.ring(row, column) < 2 && std::abs(residual[i]) > kCovered * a.fit.gain) free[i] = 0.0f;
    }
  }
  const float covered = static_cast<float>(grid.size()) - free.sum();
  a.free = free;
  a.samples.weights.array() *= free.array();
  a.samples.grey.array() *= free.array();
  return covered > 0.0f && covered < kMostCovered * static_cast<float>(grid.size());
}

std::optional<Alignment> PatternAligner::alignBlurred(const ImageLevels& image, const Alignment& a,
                                                      const Eigen::Matrix2d& spread) const {
  const Eigen::Matrix2d to_cells = cellInImage(a.quad, book_.grid().cells()).inverse();
  if (!to_cells.allFinite()) return std::nullopt;
  const Eigen::Matrix2d in_cells = to_cells * spread * to_cells.transpose();
  Alignment b;
  b.id = a.id;
  b.level = a.level;
  b.quad = a.quad;
  b.own = std::make_shared<PatternTemplate>(book_.grid(), book_.pattern(a.id), in_cells);
  b.own_sd = std::pow(in_cells.determinant(), 0.25);
  return align(image, b) ? std::optional<Alignment>(b) : std::nullopt;
}

bool PatternAligner::alignMotionBlurred(const ImageLevels& image, Alignment& a) const {
  std::optional<Alignment> best;
  for (const double path : kPaths) {
    for (int direction = 0; direction < kDirections; ++direction) {
      const double angle = M_PI * direction / kDirections;
      const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
      const auto b = alignBlurred(
          image, a,
          kStillPsf * kStillPsf * Eigen::Matrix2d::Identity() + path * path / 12.0 * along * along.transpose());
      if (b && (!best || b->fit.explained > best->fit.explained)) best = b;
    }
  }
  if (!best) return false;
  a = *best;
  a.moved = true;
  return true;
}

bool PatternAligner::alignSteep(const ImageLevels& image, Alignment& a) const {
  const Eigen::Vector2d axes = cellInImage(a.quad, book_.grid().cells()).jacobiSvd().singularValues();
  if (!(axes[0] > kSteep * axes[1])) return false;
  std::optional<Alignment> best;
  for (const double sd : kSteepPsf) {
    const auto b = alignBlurred(image, best ? *best : a, sd * sd * Eigen::Matrix2d::Identity());
    if (!b || (best && b->fit.explained < best->fit.explained)) break;
    best = b;
  }
  if (!best) return false;
  a = *best;
  return true;
}

}  // namespace seater_perception
