#include "numerics/symmetric.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace seater_perception {
namespace {

/// Column by column: Eigen's solver of many right sides is made for large matrices.
template <typename Factor>
SmallMatrix solvedColumns(const Factor& factor, const SmallMatrix& b) {
  SmallMatrix x(b.rows(), b.cols());
  for (Eigen::Index k = 0; k < b.cols(); ++k) x.col(k) = factor.solve(SmallVector(b.col(k)));
  return x;
}

}  // namespace

SmallVector solvedSymmetric(const SmallMatrix& A, const SmallVector& b) {
  return A.ldlt().solve(b);
}

SmallMatrix solvedSymmetricColumns(const SmallMatrix& A, const SmallMatrix& b) {
  return solvedColumns(A.ldlt(), b);
}

std::optional<SmallMatrix> choleskyRoot(const SmallMatrix& A) {
  const Eigen::LLT<SmallMatrix> factor(A);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return SmallMatrix(factor.matrixL());
}

std::optional<SmallMatrix> solvedPositive(const SmallMatrix& A, const SmallMatrix& b) {
  const Eigen::LLT<SmallMatrix> factor(A);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return solvedColumns(factor, b);
}

std::optional<SymmetricModes> modesOf(const SmallMatrix& A) {
  const Eigen::SelfAdjointEigenSolver<SmallMatrix> solver(A);
  if (solver.info() != Eigen::Success) return std::nullopt;
  return SymmetricModes{solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace seater_perception
