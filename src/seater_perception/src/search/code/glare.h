#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "search/code/image_levels.h"

namespace seater_perception {

/// A lamp's mirror image on a print: a round or long spot (Gaussian) of light that is added to the print's own.
struct Glare {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();         ///< [px]
  Eigen::Matrix2d precision = Eigen::Matrix2d::Identity();  ///< inverse of its covariance [1/px^2]
  double height = 0.0;                                      ///< of the light that grey level 255 stands for
  cv::Rect region;                                          ///< of the print and its quiet zone [px]

  double light(const Eigen::Vector2d& p) const;
  /// The same in a part of the image that begins at the pixel `origin`.
  Glare seenFrom(const Eigen::Vector2d& origin) const;
};

/// Whether something on the print is clearly brighter than its quiet zone, as glare is.
bool mayHaveGlare(const PatternGrid& grid, const ImageLevels::Samples& samples);

/// The spot that, with this code, explains the samples: of `grid` under `quad` (in the print's order). Nothing when a
/// spot does not explain most of what the code leaves.
std::optional<Glare> findGlare(const PatternGrid& grid, const ImageLevels::Samples& samples,
                               const PatternTemplate& pattern, const Quad& quad);

/// The image (CV_8UC1) without the glare, each in its region: a copy, or the image itself where there is none.
cv::Mat withoutGlare(const cv::Mat& grey, const std::vector<Glare>& glares);

}  // namespace seater_perception
