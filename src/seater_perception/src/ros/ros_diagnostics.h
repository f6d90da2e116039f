#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

#include <optional>
#include <string>
#include <vector>

#include "seater_perception/parameters.h"
#include "seater_perception/report.h"

namespace seater_perception {

/// What one image came to.
struct ImageReport {
  double latency = 0.0;          ///< [s] stamp to publication
  double processing_time = 0.0;  ///< [s]
  bool dock_seen = false;
  bool full_search = false;  ///< the whole image was searched
  bool odometry = false;     ///< TF knew how the camera moved
  bool ambiguous = false;    ///< more than one pose of the dock went out
  int markers = 0;           ///< with a pose
  int photometric = 0;       ///< of them, those whose pose was fitted to grey levels
  std::optional<FocalCheck> focal;
  double cut_off = 0.0;  ///< sum of the markers' DetectedMarker::white_cut_off
};

/// The stages camera, detection and pose on /diagnostics, each of the time since the last word: once per second of wall
/// time. A stage that only waits for the one before it is in order.
class Diagnostics {
 public:
  Diagnostics(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle, const std::string& name,
              const DiagnosticsParameters& parameters);

  void published(const ImageReport& image);
  void failed(const std::string& reason);
  /// Whether images of this topic are asked for.
  void setListening(bool listening, const std::string& topic);

 private:
  void camera(diagnostic_updater::DiagnosticStatusWrapper& status);
  void detection(diagnostic_updater::DiagnosticStatusWrapper& status);
  void pose(diagnostic_updater::DiagnosticStatusWrapper& status);
  void beginAnew();

  DiagnosticsParameters parameters_;
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
  ros::WallTime since_ = ros::WallTime::now(), last_image_ = since_;
  bool listening_ = false;
  std::string topic_;
  double rate_ = 0.0;  // [Hz] of images, between the last two reports
  // Since the last report, and (total_) since the start:
  std::vector<double> latency_, processing_;
  int seen_ = 0, full_searches_ = 0, odometry_ = 0, ambiguous_ = 0, errors_ = 0;
  int markers_ = 0, photometric_ = 0;
  double cut_off_ = 0.0;
  std::vector<double> focal_excess_;  // of images that tell
  int contradicted_ = 0;              // images of them
  long total_images_ = 0, total_full_searches_ = 0, total_errors_ = 0;
  std::string last_error_;
};

}  // namespace seater_perception
