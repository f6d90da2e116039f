#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "seater_perception/parameters.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// A marker in the picture.
struct MarkerCorners {
  int id = 0;
  /// [px] in the picture as given (not undistorted), top-left, top-right, bottom-right, bottom-left as the print is
  /// read.
  std::array<Eigen::Vector2d, 4> corners;
  bool edges_fitted =
      false;  ///< true: corners are intersections of fitted edges; false: of cornerSubPix, less accurate

  double side() const;     ///< mean side [px]
  double minSide() const;  ///< shortest side [px]
  Eigen::Vector2d centre() const;
};

/// Finds markers of one dictionary (OpenCV's detectMarkers) and refines their corners: cornerSubPix with a window that
/// follows each marker's size, so that it never reaches the next cell of the print (the code inside would pull the
/// corner away); from there, fitEdges where it succeeds.
class MarkerDetector {
 public:
  /// Throws ConfigurationError for an unknown dictionary.
  MarkerDetector(const std::string& dictionary, const DetectorParameters& parameters);
  ~MarkerDetector();
  MarkerDetector(MarkerDetector&&) noexcept;

  /// Markers in ascending id. An id that stands at two places of the picture is left out: nothing tells which one is
  /// meant. `grey` is CV_8UC1. Throws PictureError.
  std::vector<MarkerCorners> detect(const cv::Mat& grey) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace seater_perception
