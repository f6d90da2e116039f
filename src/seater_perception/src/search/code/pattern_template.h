#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "seater_perception/marker_pattern.h"

namespace seater_perception {

/// Points of a print at which the image is looked at: two along each cell and into the quiet zone, a quarter of a
/// cell from the borders. Coordinates: x right, y down, the black square is -1 .. 1; row by row from the top.
class PatternGrid {
 public:
  /// `cells`: along the black square, its border of `border` cells on both sides included.
  explicit PatternGrid(int cells, int border = 1);

  int cells() const { return cells_; }
  int border() const { return border_; }
  int along() const { return along_; }  ///< points along a side
  int size() const { return along_ * along_; }
  float x(int column) const { return at_[static_cast<std::size_t>(column)]; }
  float y(int row) const { return at_[static_cast<std::size_t>(row)]; }
  /// 0: quiet zone, 1: border, 2: within.
  int ring(int row, int column) const { return rings_[static_cast<std::size_t>(row * along_ + column)]; }

 private:
  int cells_, border_, along_;
  std::vector<float> at_;
  std::vector<signed char> rings_;
};

/// What the points of a square grid of `along` points a side show (row by row from the top), in the order in which
/// those of the print stand upright, of which corner `turn` is the grid's first.
Eigen::VectorXf turned(const Eigen::VectorXf& points, int along, int turn);

/// What a round point spread function lets the points of a grid see, which is the same for all patterns: it blurs rows
/// and columns by themselves.
struct RoundBlur {
  /// `psf_sd`: standard deviation [cells].
  RoundBlur(const PatternGrid& grid, double psf_sd);

  Eigen::MatrixXd value;      ///< what the points (rows) see of the cells along one axis, the quiet zone's with them
  Eigen::MatrixXd slope;      ///< how that changes with the point [1/cell]
  Eigen::MatrixXd quiet;      ///< of the quiet zone, in each point of the grid
  double own_fraction = 0.0;  ///< PatternTemplate::ownFraction
};

/// A pattern as a camera of a given point spread function sees it at the points of the grid, and how that changes when
/// its corners move. The image's samples are fitted linearly: offset, two slopes of the light, gain, what the quiet
/// zone is lighter than the print's white (negative: dirt, a print cut close on a grey wall), and gain times eight
/// motions of the plane (as S. Baker and I. Matthews, "Lucas-Kanade 20 years on", IJCV 2004, inverse compositional).
class PatternTemplate {
 public:
  static constexpr int kColumns = 13, kGain = 3, kQuiet = 4;
  using Columns = Eigen::Matrix<float, Eigen::Dynamic, kColumns>;
  using Triangle = Eigen::Matrix<double, kColumns, kColumns>;

  PatternTemplate(const PatternGrid& grid, const MarkerPattern& pattern, const RoundBlur& blur);
  /// `psf_covariance`: of the point spread function, the same with motion blur [cells^2], x right, y down.
  PatternTemplate(const PatternGrid& grid, const MarkerPattern& pattern, const Eigen::Matrix2d& psf_covariance);

  /// Fraction of a cell's own brightness that remains in its four points: what its bit changes there.
  double ownFraction() const { return own_fraction_; }

  struct Fit {
    double gain = 0.0;              ///< [grey levels] of white over black
    double quiet = 0.0;             ///< [grey levels] of the quiet zone over the print's white
    double explained = 0.0;         ///< part of the variance, the light's slopes aside, that the pattern explains
    std::array<double, 3> light{};  ///< offset and slopes along x, y [grey levels]
    Eigen::Matrix<double, 8, 1> motion = Eigen::Matrix<double, 8, 1>::Zero();
  };

  /// Of samples, of which only those with weight 1 count (0: do not); nothing when they do not suffice. `weights` may
  /// be null: all count. `with_motion`: with the motions, else without.
  std::optional<Fit> fit(const Eigen::VectorXf& samples, const Eigen::VectorXf* weights, bool with_motion) const;

  /// Where a motion takes a point of the print.
  static Eigen::Vector2d moved(const Eigen::Matrix<double, 8, 1>& motion, const Eigen::Vector2d& point);

  /// Grey levels that a fit gives at the points of the grid.
  Eigen::VectorXf grey(const Fit& fit) const;

 private:
  void setRow(const PatternGrid& grid, int row, int column, double value, double quiet, double by_x, double by_y);
  void factorise();

  Columns columns_;  // zero beyond the grid's points
  Eigen::Index points_;
  double own_fraction_ = 0.0;
  Triangle all_;  // inverse of the Cholesky factor of columns' * columns
};

}  // namespace seater_perception
