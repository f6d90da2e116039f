#pragma once

#include <vector>

#include "numerics/quad.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// What a search looks for.
struct QuadSearch {
  int window = 25;        ///< [px] of the adaptive threshold, odd
  double constant = 4.0;  ///< [grey levels] how much darker than the window's mean
  double min_side = 8.0;  ///< [px] shortest side
  bool smooth = true;     ///< by a 3 x 3 window before: noise makes no outlines, but thin light lines vanish
};

/// Outlines of dark quadrilaterals, clockwise as seen in the image (y down), on lighter ground in a CV_8UC1 image (or a
/// part of one: coordinates count from its own first pixel). The image is smoothed by a 3 x 3 window, so that noise
/// makes no outlines, then thresholded once against the local mean; the convex hull of each outline is reduced to four
/// sides by leaving out the side whose neighbours, prolonged, add the least area. So corners that blur has rounded off
/// come back.
/// `known`: places in which none is looked for, with what little lies round them.
std::vector<Quad> findQuads(const cv::Mat& grey, const QuadSearch& search, const std::vector<Quad>& known = {});

/// Whether both are the same outline: each corner has one of the other's within 4 % of the side or 1 px.
bool sameOutline(const Quad& a, const Quad& b);

}  // namespace seater_perception
