#pragma once

#include <vector>

#include "numerics/quad.h"
#include "search/outline/dark_pixels.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// What a search looks for.
struct QuadSearch : DarkPixels {
  double min_side = 8.0;  ///< [px] shortest side
};

/// Outlines of dark quadrilaterals, clockwise as seen in the image (y down), on lighter ground in a CV_8UC1 image (or a
/// part of one: coordinates count from its own first pixel). The image is thresholded once against the local mean; the
/// convex hull of each outline is reduced to four sides by leaving out the side whose neighbours, prolonged, add the
/// least area. So corners that blur has rounded off come back.
/// `known`: places in which none is looked for, with what little lies round them.
std::vector<Quad> findQuads(const cv::Mat& grey, const QuadSearch& search, const std::vector<Quad>& known = {});

/// Whether both are the same outline: each corner has one of the other's within 4 % of the side or 1 px.
bool sameOutline(const Quad& a, const Quad& b);

}  // namespace seater_perception
