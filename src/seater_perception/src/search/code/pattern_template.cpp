#include "search/code/pattern_template.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "marker/photometric_model.h"
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

/// What the grid's points (rows) see of the cells (columns) along one axis, the quiet zone's first and last; and how
/// that changes with the point.
struct AxisShares {
  Eigen::MatrixXd value, slope;
  AxisShares(const PatternGrid& grid, double sd) : value(grid.along(), grid.cells() + 2), slope(value) {
    for (int point = 0; point < grid.along(); ++point) {
      const double at = 0.5 * grid.cells() * (1.0 + grid.x(point));
      const auto line = [at, sd](int border) { return (border - at) / sd; };
      double before = normalDistribution(line(-1)), density = normalDensity(line(-1));
      for (int cell = -1; cell <= grid.cells(); ++cell) {
        const double after = normalDistribution(line(cell + 1)), next = normalDensity(line(cell + 1));
        value(point, cell + 1) = after - before;
        slope(point, cell + 1) = (density - next) / sd;
        before = after, density = next;
      }
    }
  }
};

/// What blackens a cell: -1 where the pattern is black; `ring`: where its quiet zone begins instead. From the top.
Eigen::MatrixXd inkOf(const MarkerPattern& pattern, bool ring) {
  const int n = pattern.cells(), last = n + 1;
  Eigen::MatrixXd ink(n + 2, n + 2);
  for (int row = 0; row <= last; ++row) {
    for (int column = 0; column <= last; ++column) {
      const bool outside = row == 0 || column == 0 || row == last || column == last;
      ink(row, column) = ring ? (outside ? -1.0 : 0.0) : pattern.at(column - 1, n - row) - 1.0;
    }
  }
  return ink;
}

}  // namespace

PatternGrid::PatternGrid(int cells, int border) : cells_(cells), border_(border), along_(2 * cells + 2) {
  for (int i = 0; i < along_; ++i) at_.push_back(static_cast<float>((-kQuarter + 0.5 * i) * 2.0 / cells - 1.0));
}

int PatternGrid::ring(int row, int column) const {
  const int nearest = std::min({row, column, along_ - 1 - row, along_ - 1 - column});
  return nearest == 0 ? 0 : nearest <= 2 * border_ ? 1 : 2;
}

/// A round point spread function blurs rows and columns by themselves.
PatternTemplate::PatternTemplate(const PatternGrid& grid, const MarkerPattern& pattern, double psf_sd)
    : columns_(grid.size(), kColumns), own_fraction_(std::pow(fractionAlong(psf_sd), 2)) {
  const AxisShares shares(grid, psf_sd);
  const Eigen::MatrixXd ink = inkOf(pattern, false), down = shares.value * ink;
  const Eigen::MatrixXd value = down * shares.value.transpose(), by_u = down * shares.slope.transpose();
  const Eigen::MatrixXd by_v = (shares.slope * ink).eval() * shares.value.transpose();
  const Eigen::MatrixXd quiet = (shares.value * inkOf(pattern, true)).eval() * shares.value.transpose();
  const double half = 0.5 * grid.cells();
  for (int row = 0; row < grid.along(); ++row) {
    for (int column = 0; column < grid.along(); ++column) {
      setRow(grid, row, column, 1.0 + value(row, column), -quiet(row, column), half * by_u(row, column),
             half * by_v(row, column));
    }
  }
  factorise();
}

PatternTemplate::PatternTemplate(const PatternGrid& grid, const MarkerPattern& pattern, const Eigen::Matrix2d& psf)
    : columns_(grid.size(), kColumns) {
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
  Triangle normal = (columns_.transpose() * columns_).cast<double>();
  normal.diagonal() *= 1.0 + kDamping;
  all_ = normal.llt().matrixL();
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
  return columns_.leftCols<kQuiet + 1>() * c;
}

std::optional<PatternTemplate::Fit> PatternTemplate::fit(const Eigen::VectorXf& samples, const Eigen::VectorXf* weights,
                                                         bool with_motion) const {
  Eigen::Matrix<double, kColumns, 1> b;
  double squares = 0.0;
  Triangle some;
  const Triangle* L = &all_;
  if (weights) {
    if (weights->sum() < kFewest * kColumns) return std::nullopt;
    const Columns weighted = weights->asDiagonal() * columns_;
    some = (weighted.transpose() * columns_).cast<double>();
    some.diagonal() *= 1.0 + kDamping;
    const Eigen::LLT<Triangle> factor(some);
    if (factor.info() != Eigen::Success) return std::nullopt;
    some = factor.matrixL();
    L = &some;
    b = (weighted.transpose() * samples).cast<double>();
    squares = static_cast<double>(samples.cwiseAbs2().dot(*weights));
  } else {
    b = (columns_.transpose() * samples).cast<double>();
    squares = static_cast<double>(samples.squaredNorm());
  }
  // Each element of z is what its column takes away from the root of the squares, after those before it.
  const Eigen::Matrix<double, kColumns, 1> z = L->triangularView<Eigen::Lower>().solve(b);
  const double varying = squares - z.head<kGain>().squaredNorm();
  Fit fit;
  if (!(varying > 0.0)) return std::nullopt;
  fit.explained = z.segment<2>(kGain).squaredNorm() / varying;
  Eigen::Matrix<double, kColumns, 1> c = Eigen::Matrix<double, kColumns, 1>::Zero();
  constexpr int kFixed = kQuiet + 1;
  c.head<kFixed>() =
      L->topLeftCorner<kFixed, kFixed>().triangularView<Eigen::Lower>().transpose().solve(z.head<kFixed>());
  fit.gain = c[kGain];
  fit.quiet = c[kQuiet];
  for (int k = 0; k < kGain; ++k) fit.light[static_cast<std::size_t>(k)] = c[k];
  if (with_motion) {
    c = L->triangularView<Eigen::Lower>().transpose().solve(z);
    if (!(std::abs(c[kGain]) > kSmallestGain)) return std::nullopt;
    fit.motion = c.tail<8>() / c[kGain];
    if (!fit.motion.allFinite()) return std::nullopt;
  }
  return fit;
}

}  // namespace seater_perception
