// What an image shows: plain results of DockDetector and DockTracker.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace seater_perception {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// One possible pose of a marker or a dock in the optical frame.
struct PoseHypothesis {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< T_optical_object
  /// Order x, y, z [m], rotation about x, y, z of the optical frame [rad]. The error (d, w) of an estimate (R, t) means
  /// t_true = t + d, R_true = exp([w]x) R: the rotation is perturbed from the left, about the object's own origin.
  Matrix6d covariance = Matrix6d::Zero();
  double error = 0.0;  ///< rms reprojection error of the corners [px]
  /// Squared residuals over their variance, no prior in it; comparable among one marker's hypotheses only.
  double chi_squared = 0.0;
  double weight = 1.0;  ///< probability among its competitors, prior included, 0..1
};

/// One possible pose of the dock (T_optical_dock).
struct DockHypothesis : PoseHypothesis {
  std::vector<int> marker_ids;  ///< whose corners went into it, ascending
};

/// Covariance about the first pose of all hypotheses together (second moment of the mixture by their weights): what a
/// single published pose has to say while the image has not decided. `hypotheses` must not be empty.
Matrix6d mixtureCovariance(const std::vector<PoseHypothesis>& hypotheses);
Matrix6d mixtureCovariance(const std::vector<DockHypothesis>& hypotheses);

/// What a pose was fitted to: chosen marker by marker, by what its part of the image supports.
enum class PoseStage {
  corners,     ///< corners of the fitted code (or of cornerSubPix): its edges could not be fitted
  edges,       ///< corners where its fitted edges meet
  photometric  ///< the grey levels of all cells
};

/// "corners", "edges", "photometric".
const char* nameOf(PoseStage stage);

/// [-] Ambiguity from which on both poses of a marker go out, and none counts as certain.
constexpr double kUndecided = 0.05;

/// A marker whose pose is known.
struct DetectedMarker {
  int id = 0;
  double size = 0.0;  ///< side of the black square [m]
  /// [px] in the image as given (not undistorted): top-left, top-right, bottom-right, bottom-left as the print is read.
  std::array<Eigen::Vector2d, 4> corners;
  double side = 0.0;                       ///< mean side in the image [px]
  bool edges_fitted = false;               ///< its four edges were fitted, which makes corners most accurate
  std::vector<PoseHypothesis> hypotheses;  ///< of T_optical_marker: one or two, most probable first
  /// Likelihood of the second hypothesis over that of the first, by the image alone. 0: clear, or there is no second
  /// one; near 1: undecided by the image; above 1: the prior (upright) overruled the image. Both kinds of refinement.
  double ambiguity = 0.0;
  PoseStage stage = PoseStage::corners;  ///< that the hypotheses are of
  double white_cut_off = 0.0;  ///< part of the white in and round it that is at the end of the range: over-exposed

  const PoseHypothesis& best() const { return hypotheses.front(); }
  /// Covariance of best().pose for those who see no other hypothesis: covers all of them.
  Matrix6d covariance() const { return mixtureCovariance(hypotheses); }
};

/// A marker in the image, of which no pose is known.
struct PlainMarker {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;  ///< as of DetectedMarker [px]
};

/// What one image shows.
struct DetectionResult {
  std::vector<DetectedMarker> markers;  ///< ascending id
  std::vector<DockHypothesis> dock;     ///< most probable first; empty when the dock is not seen
  int refused = 0;                      ///< markers of the layout that were found, but whose pose was not believable
  /// Ids of the layout that stand at several places, at each of them (full search): not among the markers and no part
  /// of the dock's pose, for nothing tells which one is meant.
  std::vector<PlainMarker> repeated;
  bool full_search = true;  ///< false: only the predicted places were searched
};

}  // namespace seater_perception
