#include "search/code/pattern_template.h"

#include <algorithm>
#include <cmath>

#include "marker/photometric_model.h"
#include "numerics/column_products.h"
#include "numerics/normal.h"

namespace seater_perception {
namespace {

constexpr double kQuarter = 0.25;  // [cells] of the points from the cells' borders: two points a cell, evenly spaced
// Above what single precision leaves of sums over some 200 samples; damps motions that the samples do not tell.
constexpr double kDamping = 1e-5;       // of the normal equations' diagonal
constexpr double kFewest = 4.0;         // samples for each unknown; chosen by hand
constexpr double kSmallestGain = 1e-3;  // [grey levels] less would divide by nothing

/// The pattern with a black ring instead of its quiet zone; its coordinates are a cell larger.
MarkerPattern withDarkRing(const MarkerPattern& pattern) {
  const int n = pattern.cells() + 2;
  std::vector<std::vector<int>> rows(static_cast<std::size_t>(n), std::vector<int>(static_cast<std::size_t>(n), 0));
  for (int row = 1; row + 1 < n; ++row) {
    for (int column = 1; column + 1 < n; ++column) {
      rows[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
          pattern.at(column - 1, n - 2 - row) > 0.5 ? 1 : 0;  // its rows count from the bottom
    }
  }
  return MarkerPattern::fromCells(rows);
}

/// Mean over the two points of a cell along one axis.
double fractionAlong(double sd) {
  return normalDistribution((1.0 - kQuarter) / sd) - normalDistribution(-kQuarter / sd);
}

/// What blackens a cell: -1 where the pattern is black. From the top, with the quiet zone.
Eigen::MatrixXd inkOf(const MarkerPattern& pattern) {
  const int n = pattern.cells(), last = n + 1;
  Eigen::MatrixXd ink(n + 2, n + 2);
  for (int row = 0; row <= last; ++row) {
    for (int column = 0; column <= last; ++column) ink(row, column) = pattern.at(column - 1, n - row) - 1.0;
  }
  return ink;
}

/// L^-1 of the lower triangle of what L L' is, damped (addColumnProducts gives the upper one by rows, which is that).
/// Not finite where it is not positive.
PatternTemplate::Triangle inverseFactor(PatternTemplate::Triangle normal) {
  normal.diagonal() *= 1.0 + kDamping;
  constexpr int n = PatternTemplate::kColumns;
  PatternTemplate::Triangle L = PatternTemplate::Triangle::Zero(), inverse = L;
  for (int j = 0; j < n; ++j) {
    const double pivot = std::sqrt(normal(j, j) - L.row(j).squaredNorm());
    L(j, j) = pivot;
    for (int i = j + 1; i < n; ++i) L(i, j) = (normal(i, j) - L.row(i).dot(L.row(j))) / pivot;
  }
  for (int j = 0; j < n; ++j) {
    inverse(j, j) = 1.0 / L(j, j);
    for (int i = j + 1; i < n; ++i) {
      double sum = 0.0;
      for (int k = j; k < i; ++k) sum += L(i, k) * inverse(k, j);
      inverse(i, j) = -sum / L(i, i);
    }
  }
  return inverse;
}

/// As addColumnProducts wants it.
Eigen::Index padded(int count) {
  constexpr int kStep = 16;
  return (count + kStep - 1) / kStep * kStep;
}

}  // namespace

PatternGrid::PatternGrid(int cells, int border) : cells_(cells), border_(border), along_(2 * cells + 2) {
  for (int i = 0; i < along_; ++i) at_.push_back(static_cast<float>((-kQuarter + 0.5 * i) * 2.0 / cells - 1.0));
  for (int row = 0; row < along_; ++row) {
    for (int column = 0; column < along_; ++column) {
      const int nearest = std::min({row, column, along_ - 1 - row, along_ - 1 - column});
      rings_.push_back(nearest == 0 ? 0 : nearest <= 2 * border ? 1 : 2);
    }
  }
}

Eigen::VectorXf turned(const Eigen::VectorXf& points, int along, int turn) {
  if (turn == 0) return points;
  Eigen::VectorXf upright(points.size());
  const int last = along - 1;
  for (int row = 0, i = 0; row < along; ++row) {
    for (int column = 0; column < along; ++column, ++i) {
      const int r[] = {row, column, last - row, last - column};
      const int c[] = {column, last - row, last - column, row};
      upright[r[turn] * along + c[turn]] = points[i];
    }
  }
  return upright;
}

RoundBlur::RoundBlur(const PatternGrid& grid, double psf_sd)
    : value(grid.along(), grid.cells() + 2), slope(value), own_fraction(std::pow(fractionAlong(psf_sd), 2)) {
  for (int point = 0; point < grid.along(); ++point) {
    const double at = 0.5 * grid.cells() * (1.0 + grid.x(point));
    const auto line = [at, psf_sd](int border) { return (border - at) / psf_sd; };
    double before = normalDistribution(line(-1)), density = normalDensity(line(-1));
    for (int cell = -1; cell <= grid.cells(); ++cell) {
      const double after = normalDistribution(line(cell + 1)), next = normalDensity(line(cell + 1));
      value(point, cell + 1) = after - before;
      slope(point, cell + 1) = (density - next) / psf_sd;
      before = after, density = next;
    }
  }
  Eigen::MatrixXd dark = Eigen::MatrixXd::Constant(grid.cells() + 2, grid.cells() + 2, 1.0);
  dark.block(1, 1, grid.cells(), grid.cells()).setZero();
  quiet = (value * dark).eval() * value.transpose();
}

PatternTemplate::PatternTemplate(const PatternGrid& grid, const MarkerPattern& pattern, const RoundBlur& blur)
    : columns_(Columns::Zero(padded(grid.size()), kColumns)), points_(grid.size()), own_fraction_(blur.own_fraction) {
  const Eigen::MatrixXd ink = inkOf(pattern), down = blur.value * ink;
  const Eigen::MatrixXd value = down * blur.value.transpose(), by_u = down * blur.slope.transpose();
  const Eigen::MatrixXd by_v = (blur.slope * ink).eval() * blur.value.transpose();
  const double half = 0.5 * grid.cells();
  for (int column = 0; column < grid.along(); ++column) {
    for (int row = 0; row < grid.along(); ++row) {
      setRow(grid, row, column, 1.0 + value(row, column), blur.quiet(row, column), half * by_u(row, column),
             half * by_v(row, column));
    }
  }
  factorise();
}

PatternTemplate::PatternTemplate(const PatternGrid& grid, const MarkerPattern& pattern, const Eigen::Matrix2d& psf)
    : columns_(Columns::Zero(padded(grid.size()), kColumns)), points_(grid.size()) {
  const double sx = std::sqrt(psf(0, 0)), sy = std::sqrt(psf(1, 1)), rho = -psf(0, 1) / (sx * sy);  // pattern: y up
  own_fraction_ = fractionAlong(sx) * fractionAlong(sy);
  const MarkerPattern dark = withDarkRing(pattern);
  const double half = 0.5 * grid.cells();
  for (int row = 0; row < grid.along(); ++row) {
    for (int column = 0; column < grid.along(); ++column) {
      const float x = grid.x(column), y = grid.y(row);
      const PatternResponse p = smoothedPattern(pattern, half * (1.0 + x), half * (1.0 - y), sx, sy, rho);
      const PatternResponse ring = smoothedPattern(dark, half * (1.0 + x) + 1.0, half * (1.0 - y) + 1.0, sx, sy, rho);
      setRow(grid, row, column, p.value, p.value - ring.value, half * p.by_x, -half * p.by_y);
    }
  }
  factorise();
}

void PatternTemplate::setRow(const PatternGrid& grid, int row, int column, double value, double quiet, double by_x,
                             double by_y) {
  const float x = grid.x(column), y = grid.y(row), dx = static_cast<float>(by_x), dy = static_cast<float>(by_y);
  const float radial = x * dx + y * dy;
  columns_.row(row * grid.along() + column) << 1.0f, x, y, static_cast<float>(value), static_cast<float>(quiet), dx,
      x * dx, y * dx, dy, x * dy, y * dy, x * radial, y * radial;
}

void PatternTemplate::factorise() {
  double sum[kColumns * kColumns] = {};  // of a row-major triangle on the right
  const int rows = static_cast<int>(columns_.rows());
  addColumnProducts(columns_.data(), rows, rows, kColumns, sum, kColumns);
  all_ = inverseFactor(Eigen::Map<const Triangle>(sum));
}

Eigen::Vector2d PatternTemplate::moved(const Eigen::Matrix<double, 8, 1>& m, const Eigen::Vector2d& p) {
  const double radial = m[6] * p.x() + m[7] * p.y();
  return p + Eigen::Vector2d(m[0] + m[1] * p.x() + m[2] * p.y() + radial * p.x(),
                             m[3] + m[4] * p.x() + m[5] * p.y() + radial * p.y());
}

Eigen::VectorXf PatternTemplate::grey(const Fit& fit) const {
  Eigen::Matrix<float, kQuiet + 1, 1> c;
  for (std::size_t k = 0; k < 3; ++k) c[static_cast<Eigen::Index>(k)] = static_cast<float>(fit.light[k]);
  c[kGain] = static_cast<float>(fit.gain);
  c[kQuiet] = static_cast<float>(fit.quiet);
  return columns_.topLeftCorner(points_, kQuiet + 1).lazyProduct(c);
}

std::optional<PatternTemplate::Fit> PatternTemplate::fit(const Eigen::VectorXf& samples, const Eigen::VectorXf* weights,
                                                         bool with_motion) const {
  constexpr int kFixed = kQuiet + 1;
  const int used = with_motion ? kColumns : kFixed;  // those before them do not depend on the motions' columns
  Triangle some;
  const Triangle* W = &all_;
  Eigen::VectorXf seen;
  if (weights) {
    if (weights->sum() < kFewest * kColumns) return std::nullopt;
    const Columns weighted = weights->asDiagonal() * columns_.topRows(points_);
    some = inverseFactor((weighted.transpose() * columns_.topRows(points_)).cast<double>());
    if (!some.allFinite()) return std::nullopt;
    W = &some;
    seen = samples.cwiseProduct(*weights);
  }
  const Eigen::VectorXf& counted = weights ? seen : samples;
  Eigen::Matrix<float, kColumns, 1> products = Eigen::Matrix<float, kColumns, 1>::Zero();
  columnDots(columns_.data(), static_cast<int>(columns_.rows()), static_cast<int>(points_), used, counted.data(),
             products.data());
  const Eigen::Matrix<double, kColumns, 1> b = products.cast<double>();
  // Each element of z is what its column takes away from the root of the squares, after those before it.
  Eigen::Matrix<double, kColumns, 1> z = Eigen::Matrix<double, kColumns, 1>::Zero();
  if (with_motion)
    z = W->lazyProduct(b);
  else
    z.head<kFixed>() = W->topLeftCorner<kFixed, kFixed>().lazyProduct(b.head<kFixed>());
  const double varying = static_cast<double>(counted.dot(samples)) - z.head<kGain>().squaredNorm();
  Fit fit;
  if (!(varying > 0.0)) return std::nullopt;
  fit.explained = z.segment<2>(kGain).squaredNorm() / varying;
  const Eigen::Matrix<double, kFixed, 1> c =
      W->topLeftCorner<kFixed, kFixed>().transpose().lazyProduct(z.head<kFixed>());
  fit.gain = c[kGain];
  fit.quiet = c[kQuiet];
  for (int k = 0; k < kGain; ++k) fit.light[static_cast<std::size_t>(k)] = c[k];
  if (with_motion) {
    const Eigen::Matrix<double, kColumns, 1> all = W->transpose().lazyProduct(z);
    if (!(std::abs(all[kGain]) > kSmallestGain)) return std::nullopt;
    fit.motion = all.tail<8>() / all[kGain];
    if (!fit.motion.allFinite()) return std::nullopt;
  }
  return fit;
}

}  // namespace seater_perception
