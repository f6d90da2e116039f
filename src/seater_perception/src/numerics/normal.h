// The standard normal law.
#pragma once

namespace seater_perception {

/// Distribution function of the standard normal law, and its density.
double normalDistribution(double h);
double normalDensity(double h);

/// Both in single precision, for loops that a compiler turns into vector code: no call, no table, no branch. Beyond
/// +-kFlat both are those at +-kFlat. The distribution is Abramowitz and Stegun, "Handbook of Mathematical
/// Functions", 7.1.26 (2e-7); the density is exact to 1e-6 of its peak.
constexpr float kFlat = 4.4F;

struct NormalValue {
  float density, distribution;
};

inline NormalValue normalAt(float h) {
  const float a = h < 0.0F ? -h : h, b = a < kFlat ? a : kFlat;
  // exp(-b^2 / 2) as the 16th power of a polynomial; the exponent is at most 0.61.
  const float x = b * b * (-0.5F / 16.0F);
  float e = 1.0F + x * (1.0F + x * (0.5F + x * (1.0F / 6 + x * (1.0F / 24 + x * (1.0F / 120 + x * (1.0F / 720))))));
  e *= e;
  e *= e;
  e *= e;
  e *= e;
  const float t = 1.0F / (1.0F + 0.3275911F * 0.70710678F * b);
  const float tail =
      0.5F * e * t * (0.254829592F + t * (-0.284496736F + t * (1.421413741F + t * (-1.453152027F + t * 1.061405429F))));
  return {0.39894228F * e, h < 0.0F ? tail : 1.0F - tail};
}

}  // namespace seater_perception
