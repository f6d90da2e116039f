// What detect_image prints and draws of an image, beside what report.h and draw.h have.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/family_search.h"
#include "seater_perception/detection.h"
#include "seater_perception/report.h"

namespace seater_perception {

/// How an image was worked through.
struct ImageNotes {
  std::string image;                      ///< its file
  std::optional<std::string> dictionary;  ///< when it was not known before
  bool turned = false;                    ///< as its EXIF orientation says
  std::optional<double> fov;              ///< assumed [rad]; the poses are approximate
  double reading = 0.0, detection = 0.0;  ///< wall time [s]
  std::optional<std::string> drawing;     ///< the annotated image's file
  std::optional<FocalCheck> focal;        ///< of the dock
  std::vector<RefusedCandidate> refused;  ///< what looks like a marker and is none of the result
};

/// Ids of markers whose second pose is at least 0.05 as probable as the first: of these only the distance is certain.
std::vector<int> distanceOnly(const DetectionResult& result);

/// report.h's table, and below it what is to be said of these results.
std::string describe(const DetectionResult& result, const ImageNotes& notes);
std::string describe(const std::vector<PlainMarker>& markers, const ImageNotes& notes);

/// report.h's JSON object with more keys: `dictionary`, `turned_by_exif`, `approximate`, `distance_only` (ids),
/// `calibration_contradicted`, `focal_excess` and its `sigma` or null, `repeated` (ids that stand at several places,
/// with corners), `refused_candidates` (`id` or null, `corners`, `why`), `time` (seconds).
std::string describeJson(const DetectionResult& result, const ImageNotes& notes);
/// Without poses: of each marker `id`, `corners`, `side_px`.
std::string describeJson(const std::vector<PlainMarker>& markers, const ImageNotes& notes);

/// The image (CV_8UC1) in colours with outlines, first corners and ids.
cv::Mat annotatePlain(const cv::Mat& grey, const std::vector<PlainMarker>& markers);

}  // namespace seater_perception
