// Where the photometric model is valid.
#pragma once

#include "marker/marker_plane.h"

namespace seater_perception {

/// The lens' PSF and the pixel's area, as a ray sees it.
SpreadCovariance withArea(const SpreadCovariance& psf, int rays_per_pixel);
/// Whether the model holds for this point-spread function.
bool possible(const SpreadCovariance& spread);
/// Brings an estimated PSF back to where the model holds.
void keepPossible(SpreadCovariance& psf, int rays_per_pixel);

}  // namespace seater_perception
