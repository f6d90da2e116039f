#pragma once

#include <Eigen/Core>
#include <string>

#include "seater_perception/strict_yaml.h"

namespace seater_perception {

/// How markers are found in the image. Every struct here holds default, unit, range and meaning of a value in one
/// place.
struct DetectorParameters {
  std::string search = "own";
  int threshold_window_min = 3;
  int threshold_window_max = 23;
  int threshold_window_step = 10;
  double threshold_constant = 7.0;
  double min_side = 11.0;
  int search_window = 25;
  double search_constant = 4.0;
  double min_evidence = 3.3;
  double error_correction_rate = 0.6;
  double corner_window = 0.4;
  int corner_window_min = 2;
  int corner_window_max = 15;
  bool edge_fit = true;
  double edge_band = 0.6;
  double edge_band_min = 2.0;
  double edge_band_max = 4.0;

  template <typename Visitor>
  void visit(Visitor& v) {
    v.choice("search", search, {"own", "opencv"}, "outlines by the own search, or by OpenCV's detectMarkers");
    v.integer("search_window", search_window, "px", 5, 255, "own search: window of the adaptive threshold, odd");
    v.number("search_constant", search_constant, "grey levels", 0.5, 100.0,
             "own search: how much darker than its surroundings the print is");
    v.number("min_evidence", min_evidence, "", 0.5, 20.0,
             "own search: smallest evidence of a code of DICT_4X4_50; others need less or more, by their rarity");
    v.integer("threshold_window_min", threshold_window_min, "px", 3, 255, "smallest window of the adaptive threshold");
    v.integer("threshold_window_max", threshold_window_max, "px", 3, 255, "largest window of the adaptive threshold");
    v.integer("threshold_window_step", threshold_window_step, "px", 1, 255, "step between the windows");
    v.number("threshold_constant", threshold_constant, "grey levels", 0.0, 100.0,
             "how much darker than its surroundings the print is");
    v.number("min_side", min_side, "px", 5.0, 500.0, "smallest marker side looked for");
    v.number("error_correction_rate", error_correction_rate, "", 0.0, 1.0,
             "fraction of the code's correctable bits that is used");
    v.number("corner_window", corner_window, "marker cells", 0.1, 0.8, "half window of the corner refinement");
    v.integer("corner_window_min", corner_window_min, "px", 1, 20, "smallest half window of the corner refinement");
    v.integer("corner_window_max", corner_window_max, "px", 1, 60, "largest half window of the corner refinement");
    v.boolean("edge_fit", edge_fit, "fit the four edges; corners are their intersections");
    v.number("edge_band", edge_band, "marker cells", 0.2, 0.9, "half width of the band around an edge");
    v.number("edge_band_min", edge_band_min, "px", 1.0, 10.0, "smallest half width of the band");
    v.number("edge_band_max", edge_band_max, "px", 1.0, 20.0, "largest half width of the band");
  }
};

/// How poses are computed, chosen and refused.
struct PoseParameters {
  double corner_sigma = 0.05;
  double corner_sigma_coarse = 0.25;
  double model_sigma = 0.1;
  double tilt_sigma = 0.035;
  double min_hypothesis_weight = 0.02;
  double max_reprojection_error = 1.0;
  double max_reprojection_fraction = 0.05;
  double placement_tolerance = 0.005;
  double placement_sigma = 0.0005;

  template <typename Visitor>
  void visit(Visitor& v) {
    v.number("corner_sigma", corner_sigma, "px", 0.001, 5.0, "standard deviation of a corner coordinate");
    v.number("corner_sigma_coarse", corner_sigma_coarse, "px", 0.001, 5.0, "the same where the edge fit failed");
    v.number(
        "model_sigma", model_sigma, "px", 0.0, 5.0,
        "photometric: shifts of parts of the image that are usual where markers do not tell; 0: exactly as modelled");
    v.number("tilt_sigma", tilt_sigma, "rad", 0.001, 1.0, "how far markers and camera are from upright");
    v.number("min_hypothesis_weight", min_hypothesis_weight, "", 0.0, 0.5, "less probable poses are not published");
    v.number("max_reprojection_error", max_reprojection_error, "px", 0.05, 20.0,
             "rms error above which a marker is refused, if also");
    v.number("max_reprojection_fraction", max_reprojection_fraction, "sides", 0.0, 0.2,
             "it exceeds this fraction of the marker's side");
    v.number("placement_sigma", placement_sigma, "m", 0.0, 0.05, "standard deviation of the markers' places");
    v.number("placement_tolerance", placement_tolerance, "m", 0.0, 0.1, "how far a marker may be from its place");
  }
};

/// How a pose is fitted to the grey levels.
struct PhotometricParameters {
  std::string psf_model = "directed";  ///< YAML key `blur`; see PsfModel: given, isotropic, anisotropic
  double psf_sd = 0.7;                 ///< YAML key `blur_sd`
  bool illumination_slope = true;
  double quiet_zone = 1.0;
  double noise_sd = 0.0;
  double saturation = 0.0;
  double reach = 2.5;
  double margin = 0.7;
  int max_pixels = 8000;
  int max_iterations = 40;
  double tukey = 6.0;
  double max_shift = 0.3;
  double min_inlier_share = 0.5;
  double min_contrast = 4.0;

  template <typename Visitor>
  void visit(Visitor& v) {
    v.choice(
        "blur", psf_model, {"given", "estimated", "directed"},
        "point spread function: as given; one width estimated; a width along each direction estimated (motion blur)");
    v.number("blur_sd", psf_sd, "px", 0.0, 10.0,
             "standard deviation of the lens' point spread function, without the pixel's own area");
    v.boolean("illumination_slope", illumination_slope, "estimate how brightness changes across the marker");
    v.number("quiet_zone", quiet_zone, "cells", 0.0, 2.0, "white margin around a marker that can be relied on");
    v.number("noise_sd", noise_sd, "grey levels", 0.0, 10000.0, "known noise, for reduced_chi_square; 0: unknown");
    v.number("saturation", saturation, "grey levels", 0.0, 65535.0, "where the sensor clips; 0: largest of the type");
    v.number("reach", reach, "standard deviations", 1.0, 4.0,
             "of the point spread function; pixels farther from every edge are thinned out");
    v.number("margin", margin, "px", 0.0, 10.0, "added to reach, for the error of the initial pose");
    v.integer("max_pixels", max_pixels, "", 200, 1000000, "largest number of pixels of one marker");
    v.integer("max_iterations", max_iterations, "", 1, 1000, "largest number of evaluations of the image");
    v.number("tukey", tukey, "standard deviations", 3.0, 20.0, "of the noise; residuals above are outliers");
    v.number("max_shift", max_shift, "sides", 0.01, 2.0, "a fit that moves a marker farther in the image fails");
    v.number("min_inlier_share", min_inlier_share, "", 0.1, 1.0, "a fit with a smaller fraction of inliers fails");
    v.number("min_contrast", min_contrast, "grey levels", 0.5, 10000.0,
             "a fit with less between black and white fails");
  }
};

/// How markers are tracked from image to image.
struct TrackingParameters {
  bool enabled = true;
  int full_search_every = 15;
  double margin = 0.6;
  double margin_min = 12.0;
  double min_evidence = 3.2;

  template <typename Visitor>
  void visit(Visitor& v) {
    v.boolean("enabled", enabled, "search near predicted places; false: every image as a whole");
    v.integer("full_search_every", full_search_every, "images", 1, 100000, "a full search at least so often");
    v.number("margin", margin, "sides", 0.1, 5.0, "how far around the predicted place is searched");
    v.number("margin_min", margin_min, "px", 2.0, 500.0, "smallest distance around it");
    v.number("min_evidence", min_evidence, "", 0.5, 20.0, "smallest evidence of an expected code");
  }
};

/// When the diagnostics of the node call something a warning.
struct DiagnosticsParameters {
  double min_rate = 5.0;
  double max_latency = 0.2;

  template <typename Visitor>
  void visit(Visitor& v) {
    v.number("min_rate", min_rate, "Hz", 0.0, 1000.0, "a lower image rate is a warning");
    v.number("max_latency", max_latency, "s", 0.001, 10.0, "more time from stamp to publication is a warning");
  }
};

/// config/perception.yaml.
struct PerceptionParameters {
  std::string selection = "bundle";  ///< "bundle": all visible markers; "lowest_id": the paper's choice
  /// "photometric": poses fitted to the grey levels; "corners_visp": to the corners alone.
  std::string refinement = "photometric";
  DetectorParameters detector;
  PoseParameters pose;
  PhotometricParameters photometric;
  TrackingParameters tracking;
  DiagnosticsParameters diagnostics;

  template <typename Visitor>
  void visit(Visitor& v) {
    v.choice("selection", selection, {"bundle", "lowest_id"}, "which markers the dock's pose is computed from");
    v.choice("refinement", refinement, {"photometric", "corners_visp"}, "what the poses are fitted to");
    v.group("detector", detector, "how markers are found");
    v.group("pose", pose, "how poses are computed");
    v.group("photometric", photometric, "how poses are fitted to the grey levels");
    v.group("tracking", tracking, "how markers are tracked from image to image");
    v.group("diagnostics", diagnostics, "limits for warnings");
  }
};

/// Pose of camera_link in base_link (the part `camera` of config/chair.yaml).
struct CameraMount {
  double x = 0.45, y = 0.0, z = 0.70;         ///< [m]
  double roll = 0.0, pitch = 0.0, yaw = 0.0;  ///< [rad], as in URDF; pitch > 0 looks down

  template <typename Visitor>
  void visit(Visitor& v) {
    v.number("x", x, "m", -2.0, 2.0, "ahead of the driven axle");
    v.number("y", y, "m", -1.0, 1.0, "left of the middle");
    v.number("z", z, "m", 0.0, 2.0, "above the floor");
    v.number("roll", roll, "rad", -3.1416, 3.1416, "about x");
    v.number("pitch", pitch, "rad", -1.6, 1.6, "about y; positive looks down");
    v.number("yaw", yaw, "rad", -3.1416, 3.1416, "about z; positive looks left");
  }

  /// Unit vector pointing up, in the optical frame, when the chair stands on level floor.
  Eigen::Vector3d upInOptical() const;
};

/// Both throw ConfigurationError; `prefix` names the mapping in messages.
PerceptionParameters loadPerceptionParameters(const YAML::Node& node, const std::string& prefix);
CameraMount loadCameraMount(const YAML::Node& node, const std::string& prefix);

}  // namespace seater_perception
