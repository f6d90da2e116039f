// What DockDetector and DockTracker have in common: from markers found in an image to poses.
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <vector>

#include "pose/dock_pose.h"
#include "search/marker_detector.h"
#include "seater_perception/camera_model.h"
#include "seater_perception/dock_layout.h"
#include "seater_perception/parameters.h"
#include "stage/dock_stage.h"

namespace seater_perception {

/// What an image tells of its camera.
struct Tone {
  double exponent = 1.0;  ///< of the light that markers are fitted to (image/exposure.h)
  /// [px] Shifts that fits to grey levels show where those to light are taken: in part the tone curve's doing, in part
  /// not, which nothing tells.
  double shift_sigma = 0.0;
};

/// One image's markers and dock, with all that the next image's fits begin with.
struct ImageEstimate {
  std::vector<MarkerEstimate> markers;  ///< ascending id
  std::vector<DockHypothesis> dock;     ///< most probable first
  int refused = 0;                      ///< found, but no believable pose
  Tone tone;
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
  /// `tone`: as of the image before, where that has told it.
  ImageEstimate evaluate(const SearchResult& found, const std::map<int, MarkerEstimate>& last = {},
                         const std::optional<Tone>& tone = {});

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
  /// All markers of an image by the light of its grey levels.
  struct ImageFits {
    cv::Mat levels;
    Tone tone;
    std::vector<std::optional<Fit>> of;
  };
  /// What they begin with.
  struct FitStart {
    const std::vector<MarkerEstimate>& markers;
    const std::set<int>& tracked;
    const std::vector<DockHypothesis>& dock;
  };

  PosePrior priorOf(int id) const;
  std::optional<MarkerEstimate> expected(const MarkerCorners& found, const std::map<int, MarkerEstimate>& last) const;
  void keepDecided(const std::vector<DockHypothesis>& dock, MarkerEstimate& marker) const;
  Fit fit(const PhotometricContext& context, const std::vector<DockHypothesis>& dock, const MarkerEstimate& marker,
          bool tracked) const;
  static ImageFits fitsBy(const cv::Mat& grey, const Tone& tone, std::size_t count);
  PhotometricContext contextOf(const ImageFits& image);
  MarkerEstimate litMarker(const ImageFits& image, const MarkerEstimate& marker, bool tracked) const;
  void fitMarker(const FitStart& start, std::size_t i, ImageFits& fits);
  double leftOver(const FitStart& start, const std::vector<std::size_t>& asked, ImageFits& first, ImageFits& other);
  ImageFits bestTone(const cv::Mat& grey, const FitStart& start);
  void keepGrey(const cv::Mat& grey, const FitStart& start, std::size_t i, ImageFits& fits);
  ImageFits fitImage(const cv::Mat& grey, const std::optional<Tone>& tone, const FitStart& start);
  double shiftSigma(const ImageFits& image, const Fit* of) const;
  MarkerEstimate settled(const PhotometricContext& context, const std::vector<DockHypothesis>& dock, double shift_sigma,
                         const Fit& fit) const;
  /// The levels by which they are refined.
  ImageFits refineMarkers(const cv::Mat& grey, const std::optional<Tone>& tone, const std::set<int>& tracked,
                          ImageEstimate& result);
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
