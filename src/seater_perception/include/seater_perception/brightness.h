#pragma once

namespace seater_perception {

/// Grey level = (offset + gain * white - rim * outside) * (1 + slope . p), white 0 or 1, p from -1 to 1 across the
/// marker's box in the image, outside the share of what a pixel sees beyond the quiet zone.
struct Brightness {
  bool used = false;                ///< false: the marker is not in the image
  double offset = 0.0, gain = 0.0;  ///< [grey levels]
  double slope_u = 0.0, slope_v = 0.0;
  double rim = 0.0;  ///< how much darker than the paper it is beyond the quiet zone [grey levels]
};

}  // namespace seater_perception
