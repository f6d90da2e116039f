#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace seater_perception {

/// An image from a file, ready for a detector.
struct ImageFile {
  cv::Mat grey;         ///< CV_8UC1
  bool turned = false;  ///< as the file's EXIF orientation says
};

/// Any format that OpenCV reads. 16 bits per pixel, of which a camera of 10, 12 or 14 bits fills the low ones, are
/// brought to 8 as in the node (reduceTo8Bits). `honour_exif`: turned upright as photographs are shown; false: as the
/// sensor has it. Throws ImageError.
ImageFile readImageFile(const std::string& path, bool honour_exif);

}  // namespace seater_perception
