// Symmetric matrices of a fit's unknowns. Each of Eigen's decompositions takes the compiler seconds for each type of
// matrix in each file that uses it: these are for one type, in one file.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace seater_perception {

constexpr int kMostRows = 18;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostRows, kMostRows>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostRows, 1>;

/// x with A x = b, by LDL' with pivoting, of the lower triangle of A; A semi-definite.
SmallVector solvedSymmetric(const SmallMatrix& A, const SmallVector& b);
SmallMatrix solvedSymmetricColumns(const SmallMatrix& A, const SmallMatrix& b);

/// L with A = L L'; nothing where A is not positive definite.
std::optional<SmallMatrix> choleskyRoot(const SmallMatrix& A);

/// x with A x = b; nothing where A is not positive definite.
std::optional<SmallMatrix> solvedPositive(const SmallMatrix& A, const SmallMatrix& b);

struct SymmetricModes {
  SmallVector values;   ///< ascending
  SmallMatrix vectors;  ///< columns
};
/// Eigenvalues and eigenvectors; nothing where they are not found.
std::optional<SymmetricModes> modesOf(const SmallMatrix& A);

}  // namespace seater_perception
