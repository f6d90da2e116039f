#pragma once

#include <optional>
#include <vector>

#include "numerics/quad.h"
#include "search/decoder/marker_decoder.h"
#include "seater_perception/parameters.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// An outline that may be a print's.
struct JudgedOutline {
  Quad corners;           ///< clockwise in the image; where a code shows, as the print is read [px]
  std::optional<int> id;  ///< the most likely code; nothing when none shows
  double evidence = 0.0;  ///< of that code
  bool decoded = false;   ///< there is evidence enough
  double side = 0.0;      ///< mean [px]
};

/// For people who ask why a marker is not found: all outlines that the own search would look at, down to 0.6 of the
/// smallest side, and what the decoder makes of them. Not thread-safe.
class OutlineJudge {
 public:
  OutlineJudge(const MarkerFamily& family, const DetectorParameters& parameters);
  std::vector<JudgedOutline> judge(const cv::Mat& grey) const;

 private:
  DetectorParameters parameters_;
  MarkerDecoder decoder_;
};

}  // namespace seater_perception
