#pragma once

#include <stdexcept>

namespace seater_perception {

/// A parameter, dock or calibration file is wrong. what() names the full key, the value and what is allowed, one per
/// line.
class ConfigurationError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A camera calibration that cannot be used (K[0] = 0, not finite, wrong sizes, unknown model).
class CalibrationError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// An image that cannot be worked through (empty, wrong type, not of the calibration's size).
class ImageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace seater_perception
