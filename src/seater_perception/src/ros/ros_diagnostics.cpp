#include "ros_diagnostics.h"

#include <algorithm>

namespace seater_perception {
namespace {

// Part of the white at the end of the range, from which on bloom moves edges by some tenths of a pixel
// (marker_fits.cpp).
constexpr double kOverExposed = 0.3;

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

}  // namespace

Diagnostics::Diagnostics(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle, const std::string& name,
                         const DiagnosticsParameters& parameters)
    : parameters_(parameters), updater_(handle, private_handle, name) {
  updater_.setHardwareID("camera");
  updater_.add("marker detection", this, &Diagnostics::report);
  // Wall time: a paused simulation must not silence it. The nodelet's own queue calls it, so nothing runs beside an
  // image.
  timer_ =
      handle.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) { updater_.force_update(); });
}

void Diagnostics::published(const ImageReport& image) {
  latency_.push_back(image.latency);
  processing_.push_back(image.processing_time);
  seen_ += image.dock_seen ? 1 : 0;
  full_searches_ += image.full_search ? 1 : 0;
  odometry_ += image.odometry ? 1 : 0;
  ambiguous_ += image.ambiguous ? 1 : 0;
  markers_ += image.markers;
  photometric_ += image.photometric;
  cut_off_ += image.cut_off;
  total_full_searches_ += image.full_search ? 1 : 0;
  ++total_images_;
}

void Diagnostics::failed(const std::string& reason) {
  ++errors_;
  ++total_errors_;
  last_error_ = reason;
}

void Diagnostics::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const ros::WallTime now = ros::WallTime::now();
  const double rate = static_cast<double>(latency_.size()) / std::max(1e-3, (now - since_).toSec());
  const double cut_off = markers_ > 0 ? cut_off_ / markers_ : 0.0;
  if (!listening_) {
    status.summary(DiagnosticStatus::OK, "idle: nobody listens");
  } else if (errors_ > 0) {
    status.summary(DiagnosticStatus::ERROR, last_error_);
  } else if (rate < parameters_.min_rate) {
    status.summary(DiagnosticStatus::WARN, "too few images");
  } else if (largest(latency_) > parameters_.max_latency) {
    status.summary(DiagnosticStatus::WARN, "late");
  } else if (cut_off > kOverExposed) {
    status.summary(DiagnosticStatus::WARN, "over-exposed: lower the camera's exposure");
  } else {
    status.summary(DiagnosticStatus::OK, "working");
  }
  status.add("rate [Hz]", rate);
  status.add("smallest rate [Hz]", parameters_.min_rate);
  status.add("latency, stamp to publication, median [ms]", 1e3 * median(latency_));
  status.add("latency, stamp to publication, largest [ms]", 1e3 * largest(latency_));
  status.add("largest latency allowed [ms]", 1e3 * parameters_.max_latency);
  status.add("processing time, median [ms]", 1e3 * median(processing_));
  status.add("images with the dock", seen_);
  status.add("images with two poses of the dock", ambiguous_);
  status.add("images with odometry", odometry_);
  status.add("full searches", full_searches_);
  status.add("markers", markers_);
  status.add("markers fitted to grey levels [%]", markers_ > 0 ? 100.0 * photometric_ / markers_ : 0.0);
  status.add("white of and round markers that is cut off [%]", 100.0 * cut_off);
  status.add("errors", errors_);
  status.add("images since start", total_images_);
  status.add("full searches since start", total_full_searches_);
  status.add("errors since start", total_errors_);
  status.add("last error", last_error_);
  since_ = now;
  latency_.clear();
  processing_.clear();
  seen_ = full_searches_ = odometry_ = ambiguous_ = errors_ = 0;
  markers_ = photometric_ = 0;
  cut_off_ = 0.0;
}

}  // namespace seater_perception
