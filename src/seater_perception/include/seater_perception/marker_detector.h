#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <set>
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
      false;             ///< true: corners are intersections of fitted edges; false: of cornerSubPix, less accurate
  double blur_sd = 0.0;  ///< of the lens, from the fitted edges; 0: not known [px]

  double side() const;     ///< mean side [px]
  double minSide() const;  ///< shortest side [px]
  Eigen::Vector2d centre() const;
};

/// Finds markers of one dictionary and refines their corners. Outlines and ids come from findQuads and PatternReader
/// (`search: own`) or from OpenCV's detectMarkers (`opencv`). Corners: fitEdges where it succeeds; else cornerSubPix
/// with a window that follows each marker's size, so that it never reaches the next cell of the print.
class MarkerDetector {
 public:
  /// `ids`: markers looked for; empty: all of the dictionary. Throws ConfigurationError for an unknown dictionary.
  MarkerDetector(const std::string& dictionary, const DetectorParameters& parameters, const std::set<int>& ids = {});
  ~MarkerDetector();
  MarkerDetector(MarkerDetector&&) noexcept;

  /// Markers in ascending id. An id that stands at two places of the picture is left out: nothing tells which one is
  /// meant. `grey` is CV_8UC1. Throws PictureError.
  std::vector<MarkerCorners> detect(const cv::Mat& grey) const;

  /// One marker near the place where its corners were predicted [px], at most `reach` [px] away: first by its outline,
  /// then, when that does not show, by its code alone. Every bit of the code has to be on its side, the correlation at
  /// least `min_correlation`. Nothing when it is not there. Throws PictureError.
  std::optional<MarkerCorners> follow(const cv::Mat& grey, int id, const std::array<Eigen::Vector2d, 4>& predicted,
                                      double reach, double min_correlation) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace seater_perception
