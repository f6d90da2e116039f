// What DockDetector and DockTracker have in common: from markers found in an image to poses.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "pose/dock_pose.h"
#include "search/marker_detector.h"
#include "seater_perception/camera_model.h"
#include "seater_perception/dock_layout.h"
#include "seater_perception/parameters.h"
#include "stage/dock_stage.h"

namespace cv {
class Mat;
}

namespace seater_perception {

/// One image's markers and dock, with all that the next image's fits begin with.
struct ImageEstimate {
  std::vector<MarkerEstimate> markers;  ///< ascending id
  std::vector<DockHypothesis> dock;     ///< most probable first
  int refused = 0;                      ///< found, but no believable pose
};

/// The part of an estimate that is published.
DetectionResult resultOf(const ImageEstimate& estimate, bool full_search);

/// One per thread: `evaluate` writes into memory that the next call uses again.
class DetectionPipeline {
 public:
  /// Throws ConfigurationError for a layout whose family has no markers.
  DetectionPipeline(const CameraModel& camera, const DockLayout& layout, const PerceptionParameters& parameters,
                    const CameraMount& mount);

  /// Poses of markers that have been found in this image, and of the dock. `last`: markers of the image before, by id,
  /// where they are expected in this one: fits begin at their poses. Throws ImageError.
  ImageEstimate evaluate(const SearchResult& found, const std::map<int, MarkerEstimate>& last = {});

  const MarkerDetector& search() const { return search_; }
  const PerceptionParameters& parameters() const { return parameters_; }
  const CameraModel& camera() const { return camera_; }
  const DockLayout& layout() const { return layout_; }

 private:
  /// A marker's fit and what it began with.
  struct Fit {
    MarkerEstimate found;
    RefinedMarker refined;
    bool as_tracked = false;
  };

  PosePrior priorOf(int id) const;
  std::optional<MarkerEstimate> expected(const MarkerCorners& found, const std::map<int, MarkerEstimate>& last) const;
  void keepDecided(const std::vector<DockHypothesis>& dock, MarkerEstimate& marker) const;
  Fit fit(const PhotometricContext& context, const std::vector<DockHypothesis>& dock, const MarkerEstimate& marker,
          bool tracked) const;
  double shiftSigma(const std::vector<Fit>& fits, const Fit& of) const;
  MarkerEstimate settled(const PhotometricContext& context, const std::vector<DockHypothesis>& dock, double shift_sigma,
                         const Fit& fit) const;
  void refineMarkers(const cv::Mat& grey, const std::set<int>& tracked, ImageEstimate& result);
  void keepCorners(const std::vector<DockHypothesis>& dock, MarkerEstimate& marker) const;
  void leaveOpen(const std::vector<DockHypothesis>& dock, const MarkerEstimate& found, MarkerEstimate& refined) const;
  bool startAgain(const cv::Mat& grey, MarkerEstimate& marker) const;

  CameraModel camera_;
  DockLayout layout_;
  PerceptionParameters parameters_;
  Eigen::Vector3d up_;  // in the optical frame
  MarkerDetector search_;
  PhotometricRefiner refiner_;
  PatternBook patterns_;  // filled as ids are seen
};

}  // namespace seater_perception
