#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "search/code/image_levels.h"

namespace seater_perception {

/// A straight edge of a shadow that lies across a print. The light beyond it is weaker by a factor; grey levels are
/// taken as proportional to the light.
struct ShadowEdge {
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  ///< unit vector in the image, out of the shadow
  double offset = 0.0;                                ///< normal . p of the edge [px]
  double factor = 1.0;                                ///< light in the shadow over that outside, below 1
  double width = 1.0;                                 ///< standard deviation of the transition [px]
  cv::Rect region;                                    ///< of the print and its quiet zone [px]

  /// Of the pixel p, of the light outside: factor .. 1.
  double light(const Eigen::Vector2d& p) const;
  /// The same in a part of the image that begins at the pixel `origin`.
  ShadowEdge seenFrom(const Eigen::Vector2d& origin) const;
};

/// The edge that the quiet zone shows, which would be all of one brightness: its samples have two levels, and there are
/// two places where one passes into the other. Nothing when that is not so, or the levels differ by less than 10 %.
/// `samples`: of `grid` under `quad`, as ImageLevels::sample gives them.
std::optional<ShadowEdge> findShadowEdge(const PatternGrid& grid, const ImageLevels::Samples& samples,
                                         const Quad& quad);

/// The image (CV_8UC1) as without these shadows, each in its region: a copy, or the image itself where there is none.
/// Where regions overlap, a pixel is lifted once, by the shadow of the print that it is nearest to.
cv::Mat withoutShadows(const cv::Mat& grey, const std::vector<ShadowEdge>& shadows);

}  // namespace seater_perception
