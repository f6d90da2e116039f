#pragma once

namespace seater_perception {

/// Grey level = (offset + gain * white) * (1 + slope . p), white 0 or 1, p from -1 to 1 across the marker's box in the
/// picture.
struct Brightness {
  bool used = false;                ///< false: the marker is not in the picture
  double offset = 0.0, gain = 0.0;  ///< [grey levels]
  double slope_u = 0.0, slope_v = 0.0;
};

}  // namespace seater_perception
