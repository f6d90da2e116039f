#include "photometric/shift_evidence.h"

#include <algorithm>
#include <cmath>

#include "numerics/column_products.h"
#include "numerics/symmetric.h"
#include "pose/shift_field.h"

namespace seater_perception {
namespace {

constexpr int kAcross = 3, kPlaces = kAcross * kAcross, kUnknowns = 2 * kPlaces;
static_assert(kUnknowns <= kMostRows);
constexpr int kMostPixels = 800;         // of a print: the first ones are spread evenly over it
constexpr double kEdgeOn = 0.02;         // [px^2 per cell^2] smallest area of a cell in the image
constexpr double kDamping = 1e-6;        // of the normal matrix scaled to a unit diagonal: keeps it solvable
constexpr double kSmallestMode = 1e-4;   // of the largest information; less is rounding
constexpr double kSmallestScale = 1e-9;  // [grey levels^2] of an unknown that the pixels do not feel

/// Shares of three places along a side, at both ends and in the middle, in what lies at `at` [cells from the middle]:
/// quadratic interpolation. What a pose can follow (shifts that are linear and a little more) is in it exactly; shifts
/// that jump from part to part would leave over what smooth ones do not.
Eigen::Vector3d sharesOf(double at, int cells) {
  const double u = 2.0 * at / cells;
  return {0.5 * u * (u - 1.0), 1.0 - u * u, 0.5 * u * (u + 1.0)};
}

/// Covariance of the places' shifts along one axis, of a field of 1 px.
SmallMatrix fieldOf(const Eigen::Matrix2d& pixel_by_cell, int cells, double smoothness) {
  SmallMatrix alike(kPlaces, kPlaces);
  const double step = static_cast<double>(cells) / (kAcross - 1);
  for (int a = 0; a < kPlaces; ++a) {
    for (int b = 0; b < kPlaces; ++b) {
      const Eigen::Vector2d apart(step * (a % kAcross - b % kAcross), step * (a / kAcross - b / kAcross));
      alike(a, b) = shiftCorrelation(pixel_by_cell * apart, smoothness);
    }
  }
  return alike;
}

/// Products of all columns: unknowns of the fit and residual, then the shifts (along one axis and the other, place by
/// place).
using Products = Eigen::Matrix<double, kColumns + kUnknowns, kColumns + kUnknowns, Eigen::RowMajor>;

Products productsOf(const PhotometricProblem& problem, const PhotometricState& state, const Eigen::MatrixXf& rows,
                    const Eigen::Matrix2d& pixel_by_cell) {
  constexpr Eigen::Index kLanes = PixelBatch::kLanes;
  const Eigen::Index count = rows.rows(), known = rows.cols(), padded = (count + kLanes - 1) / kLanes * kLanes;
  Eigen::MatrixXf columns = Eigen::MatrixXf::Zero(padded, known + kUnknowns);
  columns.topLeftCorner(count, known) = rows;
  // A shift of a place is a motion of what is near it along the marker's own axes.
  const Eigen::Matrix2f to_pixel = pixel_by_cell.inverse().transpose().cast<float>();
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector2f by = to_pixel * Eigen::Vector2f(rows(i, 0), rows(i, 1));
    const Eigen::Vector2d at = problem.placeOf(state, static_cast<int>(i));
    const Eigen::Vector3d along = sharesOf(at.x(), problem.cells()), up = sharesOf(at.y(), problem.cells());
    for (int k = 0; k < kPlaces; ++k) {
      const auto share = static_cast<float>(along[k % kAcross] * up[k / kAcross]);
      columns(i, known + k) = share * by.x();
      columns(i, known + kPlaces + k) = share * by.y();
    }
  }
  Products products = Products::Zero();
  const auto length = static_cast<int>(padded);
  addColumnProducts(columns.data(), length, length, static_cast<int>(columns.cols()), products.data(),
                    static_cast<int>(products.cols()));
  return products;
}

/// Information on the shifts, and that times their estimate; whatever else is fitted is eliminated.
struct Normal {
  SmallMatrix information;
  SmallVector gradient;
};

std::optional<Normal> eliminated(const Products& products, Eigen::Index known) {
  const Eigen::Index n = known - 1;  // of the unknowns; the residual is last
  const Products all = products.selfadjointView<Eigen::Upper>();
  const SmallMatrix H = all.topLeftCorner(n, n);
  const SmallVector right = all.col(n).head(n);
  Normal normal{all.block(known, known, kUnknowns, kUnknowns), all.col(n).segment(known, kUnknowns)};
  const SmallVector scale = H.diagonal().cwiseMax(kSmallestScale).cwiseSqrt().cwiseInverse();
  SmallMatrix scaled = scale.asDiagonal() * H * scale.asDiagonal();
  scaled.diagonal().array() += kDamping;
  const SmallMatrix open = scale.asDiagonal() * all.block(0, known, n, kUnknowns);
  const auto solved = solvedPositive(scaled, open);
  if (!solved) return std::nullopt;
  normal.information -= open.transpose().lazyProduct(*solved);
  normal.gradient -= solved->transpose().lazyProduct(scale.cwiseProduct(right));
  return normal;
}

/// Logarithm of the likelihood of `seen`, drawn with the covariance alike + variance T, T tridiagonal.
double logLikelihood(const Tridiagonal& T, const SmallVector& seen, double alike, double variance) {
  double square = 0.0, determinant = 1.0, pivot = 1.0, rest = 0.0;
  for (Eigen::Index k = 0; k < seen.size(); ++k) {
    const double below = k > 0 ? variance * T.below[k - 1] : 0.0;
    rest = seen[k] - below / pivot * rest;
    pivot = std::max(alike, alike + variance * T.diagonal[k] - below * below / pivot);
    square += rest * rest / pivot;
    determinant *= pivot;
  }
  return -0.5 * (std::log(determinant) + square);
}

/// What is left over along the directions that tell something, each with a noise of 1.
struct LeftOver {
  SmallVector seen;
  SmallMatrix by_shift;  ///< shifts by direction
};

std::optional<LeftOver> leftOver(const Normal& normal, double variance) {
  if (!normal.information.allFinite() || !normal.gradient.allFinite()) return std::nullopt;
  const auto modes = modesOf(normal.information / variance);
  if (!modes || !(modes->values.maxCoeff() > 0.0)) return std::nullopt;
  const Eigen::Index told = (modes->values.array() > kSmallestMode * modes->values.maxCoeff()).count();
  const SmallVector root = modes->values.tail(told).cwiseSqrt();
  const SmallMatrix directions = modes->vectors.rightCols(told);
  const SmallVector gradient = directions.transpose().lazyProduct(normal.gradient) / variance;
  return LeftOver{gradient.cwiseQuotient(root), directions * root.asDiagonal()};
}

/// Covariance of what is left over by the field, of 1 px.
Tridiagonal spreadOf(const LeftOver& left, const SmallMatrix& field) {
  SmallMatrix spread = SmallMatrix::Zero(left.seen.size(), left.seen.size());
  for (const Eigen::Index first : {0, kPlaces}) {  // along both axes
    const SmallMatrix by_shift = left.by_shift.middleRows(first, kPlaces);
    const SmallMatrix half = by_shift.transpose().lazyProduct(field);
    spread += half.lazyProduct(by_shift);
  }
  return tridiagonalOf(spread);
}

}  // namespace

ShiftEvidence shiftEvidence(const PhotometricProblem& problem, const PhotometricState& state, const Weighing& weighing,
                            double variance) {
  const Eigen::Matrix2d pixel_by_cell = problem.pixelByCell(state);
  const auto rows = problem.weightedRows(state, weighing, kMostPixels);
  if (!rows || !(std::abs(pixel_by_cell.determinant()) > kEdgeOn)) return {};
  const auto normal = eliminated(productsOf(problem, state, *rows, pixel_by_cell), rows->cols());
  const auto left = normal ? leftOver(*normal, variance) : std::nullopt;
  if (!left) return {};
  std::array<Tridiagonal, ShiftGrid::kSmoothness.size()> spread;
  std::array<SmallVector, ShiftGrid::kSmoothness.size()> seen;
  for (std::size_t s = 0; s < spread.size(); ++s) {
    spread[s] = spreadOf(*left, fieldOf(pixel_by_cell, problem.cells(), ShiftGrid::kSmoothness[s]));
    seen[s] = spread[s].Q.transpose().lazyProduct(left->seen);
  }
  ShiftEvidence evidence;
  bool finite = true;
  ShiftGrid::forEach([&](int alike, int shift, int smoothness, std::size_t i) {
    const auto s = static_cast<std::size_t>(smoothness);
    const double sigma = ShiftGrid::shift(shift);
    evidence.log_likelihood[i] = logLikelihood(spread[s], seen[s], ShiftGrid::alike(alike), sigma * sigma);
    finite &= std::isfinite(evidence.log_likelihood[i]);
  });
  return finite ? evidence : ShiftEvidence{};
}

}  // namespace seater_perception
