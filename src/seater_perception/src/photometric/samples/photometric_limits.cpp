#include "photometric/samples/photometric_limits.h"

#include <algorithm>
#include <cmath>

#include "photometric/samples/photometric_samples.h"

namespace seater_perception {
namespace {

// [px^2] variances of the point spread function that a ray sees. Narrower than a sub-pixel's own area (1/12 -
// sqrt(1/240) = 0.019) nothing can be; 10 px are wider than the cells of any marker that is found.
constexpr double kNarrowest = 0.02, kWidest = 100.0;

}  // namespace

SpreadCovariance withArea(const SpreadCovariance& psf, int rays_per_pixel) {
  const double area = areaVariance(rays_per_pixel);
  return {psf.uu + area, psf.uv, psf.vv + area};
}

bool possible(const SpreadCovariance& s) {
  const double mean = 0.5 * (s.uu + s.vv), half = std::hypot(0.5 * (s.uu - s.vv), s.uv);
  return mean - half > kNarrowest && mean + half < kWidest;
}

void keepPossible(SpreadCovariance& psf, int rays_per_pixel) {
  const SpreadCovariance s = withArea(psf, rays_per_pixel);
  const double mean = 0.5 * (s.uu + s.vv), half = std::hypot(0.5 * (s.uu - s.vv), s.uv);
  const double wide = std::clamp(mean + half, 1.1 * kNarrowest, 0.9 * kWidest);
  const double narrow = std::clamp(mean - half, 1.1 * kNarrowest, 0.9 * kWidest);
  const double shrink = half > 1e-12 ? 0.5 * (wide - narrow) / half : 0.0, area = areaVariance(rays_per_pixel);
  const double centre = 0.5 * (wide + narrow), difference = 0.5 * (s.uu - s.vv) * shrink;
  psf = {centre + difference - area, s.uv * shrink, centre - difference - area};
}

}  // namespace seater_perception
