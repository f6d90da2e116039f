// How well a code with one spot of light on it explains what is seen.
#pragma once

#include <Eigen/Core>

#include "search/code/image_levels.h"

namespace seater_perception {

/// Middle and widths (logarithms of the standard deviations) of a spot in the square -1 .. 1 of the print.
struct Spot {
  double x = 0.0, y = 0.0, log_first = 0.0, log_second = 0.0, turn = 0.0;

  static constexpr int kUnknowns = 5;
  double& operator[](int i);
  Eigen::Matrix2d precision() const;
};

/// Least squares of the samples' light, (grey level / 255)^gamma: offset, two slopes, the code's contrast, what its
/// quiet zone is lighter, and the spot's height.
class SpotFit {
 public:
  SpotFit(const PatternGrid& grid, const ImageLevels::Samples& samples, const PatternTemplate& pattern, double gamma);

  struct Result {
    double left = 0.0;    ///< sum of squares of the light that is left
    double height = 0.0;  ///< of the spot; 0: this is none, `left` is larger than any without it
  };
  Result without() const;
  Result with(const Spot& spot) const;
  /// The best spot that is found, from a grid of round ones on.
  Spot best(Result& result) const;

 private:
  static constexpr int kUnknowns = 6;
  using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
  using Column = Eigen::Matrix<double, kUnknowns, 1>;

  Spot coarse(Result& result) const;
  void refine(Spot& spot, Result& result) const;

  float cell_;
  Eigen::Matrix<float, Eigen::Dynamic, kUnknowns - 1> rows_;
  Eigen::VectorXf light_;
  Eigen::ArrayXf x_, y_;
  Normal normal_ = Normal::Zero();
  Column right_ = Column::Zero();
  double squares_ = 0.0;
};

}  // namespace seater_perception
