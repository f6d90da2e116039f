#include "search/outline_judge.h"

#include <algorithm>

#include "image/image_checks.h"
#include "search/code/image_levels.h"
#include "search/outline/quad_search.h"
#include "search/own_search.h"

namespace seater_perception {
namespace {

// From so little evidence and so small a side on, a person is told of a code.
constexpr double kShownEvidence = 0.5, kShownSide = 0.6;

}  // namespace

OutlineJudge::OutlineJudge(const MarkerFamily& family, const DetectorParameters& parameters)
    : parameters_(parameters), decoder_(family, {}) {}

std::vector<JudgedOutline> OutlineJudge::judge(const cv::Mat& grey) const {
  checkImage(grey);
  QuadSearch search;
  search.window = parameters_.search_window | 1;
  search.constant = parameters_.search_constant;
  search.min_side = kShownSide * parameters_.min_side;
  std::vector<Quad> quads = findQuads(grey, search);
  search = closeSearch(parameters_);
  search.min_side *= kShownSide;
  for (const Quad& quad : findQuads(grey, search)) {
    const auto same = [&quad](const Quad& other) { return sameOutline(quad, other); };
    if (std::none_of(quads.begin(), quads.end(), same)) quads.push_back(quad);
  }
  const ImageLevels image(grey);
  std::vector<JudgedOutline> outlines;
  for (const Quad& quad : quads) {
    JudgedOutline outline;
    auto decoded = decoder_.decode(image, quad, parameters_.min_evidence);
    outline.decoded = decoded.has_value();
    if (!decoded) decoded = decoder_.decode(image, quad, kShownEvidence);
    outline.corners = decoded ? decoded->corners : quad;
    outline.side = meanSide(outline.corners);
    if (decoded) {
      outline.id = decoded->id;
      outline.evidence = decoded->evidence;
    }
    outlines.push_back(outline);
  }
  return outlines;
}

}  // namespace seater_perception
