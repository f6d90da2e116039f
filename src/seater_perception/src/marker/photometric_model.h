#pragma once

#include "seater_perception/marker_pattern.h"

namespace seater_perception {

/// Grey level (0 black, 1 white) of a marker's pattern smoothed by a Gaussian, and its derivatives.
struct PatternResponse {
  double value = 0.0;
  double by_x = 0.0, by_y = 0.0;            ///< by the place, per cell
  double by_log_sx = 0.0, by_log_sy = 0.0;  ///< by the logarithm of the Gaussian's standard deviations
  double by_rho = 0.0;                      ///< by its correlation
  bool flat = true;                         ///< true: no cell border within reach, all derivatives are 0
};

/// The pattern at (x, y) [cells from its lower left corner, y up], smoothed by a Gaussian of standard deviations sx, sy
/// [cells] along the cells and correlation rho. Exact for an edge between two cells; where edges cross, the bivariate
/// normal integral is taken from its series in rho up to the fourth order (M. G. Kendall, "Proof of relations connected
/// with the tetrachoric series", Biometrika 1941): 1e-4 of the contrast at |rho| = 0.35, which is a tilt of 45 deg
/// about a diagonal.
PatternResponse smoothedPattern(const MarkerPattern& pattern, double x, double y, double sx, double sy, double rho);

}  // namespace seater_perception
