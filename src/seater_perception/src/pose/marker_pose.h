#pragma once

#include <optional>
#include <vector>

#include "pose/hypotheses.h"
#include "search/marker_detector.h"

namespace seater_perception {

/// A marker whose pose is known, with all that the next stages and the next image's fit begin with.
struct MarkerEstimate {
  MarkerCorners image;                     ///< id and corners in the image
  double size = 0.0;                       ///< side of the print [m]
  std::vector<PoseHypothesis> hypotheses;  ///< of T_optical_marker: one or two, most probable first
  double ambiguity = 0.0;                  ///< see DetectedMarker
  PoseStage stage = PoseStage::corners;    ///< that the hypotheses are of
  double model_sigma = 0.0;                ///< [px] of a corner, by what its grey levels deviate from the model
  double shift_sigma = 0.0;                ///< [px] of smooth shifts of the image, that the covariances allow for
  bool model_holds = false;                ///< the grey levels are as the image model has them
  double white_cut_off = 0.0;              ///< as of DetectedMarker
  bool branch_known = false;               ///< other markers or images tell which of the two poses it is

  const PoseHypothesis& best() const { return hypotheses.front(); }
};

/// The four corners of a marker of side `size` [m], in its own frame; nothing when they cannot be undistorted.
std::optional<Correspondences> markerCorrespondences(const CameraModel& camera, const MarkerCorners& marker,
                                                     double size, const PoseParameters& parameters);

/// Both poses of a square under which its corners are seen here, to first order about its middle (Collins and Bartoli,
/// "Infinitesimal plane-based pose estimation", IJCV 2014), smaller error first. They are equal for an exactly frontal
/// one. `corners.object`: as of markerCorners. Nothing when three corners are in a line.
std::vector<Eigen::Isometry3d> squareSolutions(const Correspondences& corners);

/// Pose of one marker: both solutions, each refined, weighed by reprojection error and prior. Nothing when the pose is
/// degenerate or its reprojection error is larger than parameters allow.
std::optional<MarkerEstimate> estimateMarker(const CameraModel& camera, const MarkerCorners& marker, double size,
                                             const PosePrior& prior, const PoseParameters& parameters);

}  // namespace seater_perception
