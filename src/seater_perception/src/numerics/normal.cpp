#include "numerics/normal.h"

#include <cmath>

namespace seater_perception {

double normalDistribution(double h) {
  return 0.5 * std::erfc(-h * M_SQRT1_2);
}

double normalDensity(double h) {
  return std::exp(-0.5 * h * h) / std::sqrt(2.0 * M_PI);
}

}  // namespace seater_perception
