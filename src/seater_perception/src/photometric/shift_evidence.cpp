#include "photometric/shift_evidence.h"

#include <algorithm>
#include <cmath>

#include "numerics/symmetric.h"
#include "pose/shift_field.h"

namespace seater_perception {
namespace {

constexpr int kAcross = 3, kTiles = kAcross * kAcross, kShifts = 2 * kTiles;
static_assert(kShifts == ShiftEvidence::kModes);
constexpr int kMostPixels = 800;         // of a print: the first ones are spread evenly over it
constexpr double kEdgeOn = 0.02;         // [px^2 per cell^2] smallest area of a cell in the image
constexpr double kDamping = 1e-6;        // of the normal matrix scaled to a unit diagonal: keeps it solvable
constexpr double kSmallestMode = 1e-3;   // of the largest information; less is rounding
constexpr double kSmallestScale = 1e-9;  // [grey levels^2] of an unknown that the pixels do not feel

/// First of both shifts of the tile that a pixel is in.
Eigen::Index shiftOf(const PixelBatch& batch, int pixel, int cells) {
  const float half = 0.5F * static_cast<float>(batch.borders - 1);
  const auto tile = [&](float at) {
    const float part = (at + half) / static_cast<float>(cells) + 0.5F;
    return std::clamp(static_cast<int>(std::floor(part * kAcross)), 0, kAcross - 1);
  };
  const auto i = static_cast<std::size_t>(pixel);
  return 2 * (tile(batch.row[i]) * kAcross + tile(batch.column[i]));
}

/// Root L of the covariance L L^T of the tiles' shifts, of a field of 1 px.
SmallMatrix rootOfField(const Eigen::Matrix2d& pixel_by_cell, int cells) {
  SmallMatrix alike(kTiles, kTiles);
  const double tile = static_cast<double>(cells) / kAcross;
  for (int a = 0; a < kTiles; ++a) {
    for (int b = 0; b < kTiles; ++b) {
      const Eigen::Vector2d apart(tile * (a % kAcross - b % kAcross), tile * (a / kAcross - b / kAcross));
      alike(a, b) = shiftCorrelation(pixel_by_cell * apart, kShownSmoothness);
    }
  }
  alike.diagonal().array() += 1e-9;
  SmallMatrix root = SmallMatrix::Zero(kShifts, kShifts);
  const auto L = choleskyRoot(alike);
  if (!L) return root;
  for (int a = 0; a < kTiles; ++a) {
    for (int b = 0; b <= a; ++b) root(2 * a, 2 * b) = root(2 * a + 1, 2 * b + 1) = (*L)(a, b);
  }
  return root;
}

/// Information on the shifts, and that times their estimate, both times the residuals' variance.
struct Normal {
  SmallMatrix information = SmallMatrix::Zero(kShifts, kShifts);
  SmallVector gradient;
};

std::optional<Normal> eliminated(const PhotometricProblem& problem, const PhotometricProblem::WeightedRows& weighted,
                                 const Eigen::Matrix2d& pixel_by_cell) {
  const auto& rows = weighted.rows;
  const Eigen::Index n = rows.cols() - 1;  // of the unknowns; the residual is last
  const Eigen::Matrix2f to_pixel = pixel_by_cell.inverse().transpose().cast<float>();
  SmallMatrix mixed = SmallMatrix::Zero(kColumns, kShifts);
  Normal normal;
  for (int i = 0; i < rows.rows(); ++i) {
    // A shift of a tile is a motion of that tile along the marker's own axes.
    const Eigen::Vector2f by_shift = to_pixel * Eigen::Vector2f(rows(i, 0), rows(i, 1));
    const Eigen::Index first = shiftOf(problem.samples().front().batch, i, problem.cells());
    const Eigen::Vector2d by = by_shift.cast<double>();
    for (Eigen::Index k = 0; k <= n; ++k) mixed.block<1, 2>(k, first) += double{rows(i, k)} * by.transpose();
    normal.information.block<2, 2>(first, first) += by * by.transpose();
  }
  // Unknowns that the fit does not have are zero, and damping keeps them there.
  constexpr int kMost = kColumns - 1;
  SmallMatrix H = SmallMatrix::Zero(kMost, kMost);
  SmallVector right = SmallVector::Zero(kMost);
  for (Eigen::Index row = 0; row < n; ++row) {
    for (Eigen::Index column = row; column < n; ++column) {
      H(row, column) = H(column, row) = weighted.products(row, column);
    }
    right[row] = weighted.products(row, n);
  }
  const SmallVector by_residual = mixed.row(n);
  mixed.row(n).setZero();
  const SmallVector scale = H.diagonal().cwiseMax(kSmallestScale).cwiseSqrt().cwiseInverse();
  SmallMatrix scaled = scale.asDiagonal() * H * scale.asDiagonal();
  scaled.diagonal().array() += kDamping;
  const SmallMatrix open = scale.asDiagonal() * mixed.topRows(kMost);
  const auto solved = solvedPositive(scaled, open);
  if (!solved) return std::nullopt;
  normal.information -= open.transpose().lazyProduct(*solved);
  normal.gradient = by_residual - solved->transpose().lazyProduct(scale.cwiseProduct(right));
  return normal;
}

}  // namespace

ShiftEvidence shiftEvidence(const PhotometricProblem& problem, const PhotometricState& state, const Weighing& weighing,
                            double variance) {
  ShiftEvidence evidence;
  const Eigen::Matrix2d pixel_by_cell = problem.pixelByCell(state);
  const auto rows = problem.weightedRows(state, weighing, kMostPixels);
  if (!rows || !(std::abs(pixel_by_cell.determinant()) > kEdgeOn)) return evidence;
  const auto normal = eliminated(problem, *rows, pixel_by_cell);
  if (!normal || !normal->information.allFinite() || !normal->gradient.allFinite()) return evidence;
  const SmallMatrix root = rootOfField(pixel_by_cell, problem.cells());
  const SmallMatrix half = root.transpose().lazyProduct(normal->information);
  const auto modes = modesOf(SmallMatrix(half.lazyProduct(root)) / variance);
  if (!modes) return evidence;
  const SmallVector gradient = root.transpose().lazyProduct(normal->gradient);
  const SmallVector seen = modes->vectors.transpose().lazyProduct(gradient) / variance;
  const double smallest = kSmallestMode * modes->values.maxCoeff();
  for (int k = 0; k < kShifts; ++k) {
    if (!(modes->values[k] > std::max(0.0, smallest))) continue;
    evidence.information[static_cast<std::size_t>(k)] = modes->values[k];
    evidence.square[static_cast<std::size_t>(k)] = seen[k] * seen[k];
  }
  return evidence;
}

}  // namespace seater_perception
