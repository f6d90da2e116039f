#pragma once

#include <string>
#include <vector>

namespace seater_perception {

/// What detect_image is asked for; see kHelp.
struct Options {
  std::string camera, markers, dictionary, selection, parameters, draw;
  double size = 0.0, fov = 0.0;    ///< [m], [rad]; 0: not given
  double pitch = 0.0, roll = 0.0;  ///< [rad]
  bool rectified = false, json = false, help = false;
  bool honour_exif = true;
  std::vector<std::string> images;

  bool approximate() const { return fov > 0.0; }
  /// Neither a dock nor a side: where markers are in the image, and no poses.
  bool plain() const { return markers.empty() && size == 0.0; }
};

extern const char* const kHelp;

/// Throws ConfigurationError naming the option.
Options parseOptions(const std::vector<std::string>& arguments);

}  // namespace seater_perception
