#include "ros_diagnostics.h"

#include <algorithm>
#include <cmath>

namespace seater_perception {
namespace {

// Part of the white at the end of the range, from which on bloom moves edges by some tenths of a pixel
// (marker_fits.cpp).
constexpr double kOverExposed = 0.3;

constexpr int kContradicted = 3;  // images, and most of those that tell: one may be blurred or half covered
constexpr double kSilent = 1.5;   // [s] without an image: a report and a half
constexpr const char* kIdle = "idle: nobody listens";

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
  updater_.add("camera", this, &Diagnostics::camera);
  updater_.add("detection", this, &Diagnostics::detection);
  updater_.add("pose", this, &Diagnostics::pose);
  // Wall time: a paused simulation must not silence it. The nodelet's own queue calls it, so nothing runs beside an
  // image.
  timer_ = handle.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) {
    rate_ = static_cast<double>(latency_.size() + errors_) / std::max(1e-3, (ros::WallTime::now() - since_).toSec());
    updater_.force_update();
    beginAnew();
  });
}

void Diagnostics::published(const ImageReport& image) {
  last_image_ = ros::WallTime::now();
  latency_.push_back(image.latency);
  processing_.push_back(image.processing_time);
  seen_ += image.dock_seen ? 1 : 0;
  full_searches_ += image.full_search ? 1 : 0;
  odometry_ += image.odometry ? 1 : 0;
  ambiguous_ += image.ambiguous ? 1 : 0;
  markers_ += image.markers;
  photometric_ += image.photometric;
  cut_off_ += image.cut_off;
  if (image.focal) focal_excess_.push_back(image.focal->excess);
  contradicted_ += image.focal && image.focal->contradicts() ? 1 : 0;
  total_full_searches_ += image.full_search ? 1 : 0;
  ++total_images_;
}

void Diagnostics::failed(const std::string& reason) {
  last_image_ = ros::WallTime::now();
  ++errors_;
  ++total_errors_;
  last_error_ = reason;
}

void Diagnostics::setListening(bool listening, const std::string& topic) {
  listening_ = listening;
  topic_ = topic;
  last_image_ = ros::WallTime::now();
}

// Whether images come, and are not over-exposed.
void Diagnostics::camera(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const double silence = (ros::WallTime::now() - last_image_).toSec();
  const double cut_off = markers_ > 0 ? cut_off_ / markers_ : 0.0;
  if (!listening_) {
    status.summary(DiagnosticStatus::OK, kIdle);
  } else if (silence > kSilent) {
    status.summaryf(DiagnosticStatus::ERROR,
                    "no image with its camera_info on %s for %.1f s: is the camera plugged in, does its driver run, is "
                    "its topic the one of image:=?",
                    topic_.c_str(), silence);
  } else if (rate_ < parameters_.min_rate) {
    status.summaryf(DiagnosticStatus::WARN,
                    "%.1f images a second, %.1f are needed: a higher rate of the camera, USB 3, more light?", rate_,
                    parameters_.min_rate);
  } else if (cut_off > kOverExposed) {
    status.summary(DiagnosticStatus::WARN, "over-exposed: lower the camera's exposure");
  } else {
    status.summary(DiagnosticStatus::OK, "images come");
  }
  status.add("topic", topic_);
  status.add("rate [Hz]", rate_);
  status.add("smallest rate [Hz]", parameters_.min_rate);
  status.add("image age [s]", silence);
}

// Whether images are worked through, in time, and what they show.
void Diagnostics::detection(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  if (!listening_) {
    status.summary(DiagnosticStatus::OK, kIdle);
  } else if (errors_ > 0) {
    status.summary(DiagnosticStatus::ERROR, "image not used: " + last_error_);
  } else if (latency_.empty()) {
    status.summary(DiagnosticStatus::OK, "waits for camera");
  } else if (largest(latency_) > parameters_.max_latency) {
    status.summaryf(
        DiagnosticStatus::WARN,
        "late: up to %.0f ms from the stamp of an image on, up to %.0f of them here: is the computer loaded, "
        "are the stamps those of the exposure?",
        1e3 * largest(latency_), 1e3 * largest(processing_));
  } else {
    status.summary(DiagnosticStatus::OK, markers_ > 0 ? "sees markers" : "no marker in view");
  }
  status.add("latency, stamp to publication, median [ms]", 1e3 * median(latency_));
  status.add("latency, stamp to publication, largest [ms]", 1e3 * largest(latency_));
  status.add("largest latency allowed [ms]", 1e3 * parameters_.max_latency);
  status.add("processing time, median [ms]", 1e3 * median(processing_));
  status.add("images with odometry", odometry_);
  status.add("full searches", full_searches_);
  status.add("markers", markers_);
  status.add("white of and round markers that is cut off [%]", markers_ > 0 ? 100.0 * cut_off_ / markers_ : 0.0);
  status.add("errors", errors_);
  status.add("images since start", total_images_);
  status.add("full searches since start", total_full_searches_);
  status.add("errors since start", total_errors_);
  status.add("last error", last_error_);
}

// Whether markers come to a pose of the dock.
void Diagnostics::pose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  if (!listening_) {
    status.summary(DiagnosticStatus::OK, kIdle);
  } else if (markers_ > 0 && seen_ == 0) {
    status.summary(DiagnosticStatus::WARN,
                   "markers, but no pose of the dock: do their ids, sizes and places fit the dock file?");
  } else if (contradicted_ >= kContradicted && 2 * contradicted_ > static_cast<int>(focal_excess_.size())) {
    const double excess = median(focal_excess_);
    status.summaryf(DiagnosticStatus::WARN,
                    "the dock's markers contradict camera_info, as if its focal length were %.1f %% too %s: calibrate "
                    "the camera, compare the dock file with the dock",
                    100.0 * std::abs(excess), excess > 0.0 ? "long" : "short");
  } else {
    status.summary(DiagnosticStatus::OK, seen_ > 0 ? "sees the dock" : "waits for detection");
  }
  status.add("images with the dock", seen_);
  status.add("images with two poses of the dock", ambiguous_);
  status.add("images that tell the focal length", focal_excess_.size());
  status.add("focal length too long, median [%]", 100.0 * median(focal_excess_));
  status.add("markers fitted to grey levels [%]", markers_ > 0 ? 100.0 * photometric_ / markers_ : 0.0);
}

void Diagnostics::beginAnew() {
  since_ = ros::WallTime::now();
  latency_.clear();
  processing_.clear();
  seen_ = full_searches_ = odometry_ = ambiguous_ = errors_ = 0;
  markers_ = photometric_ = 0;
  cut_off_ = 0.0;
  focal_excess_.clear();
  contradicted_ = 0;
}

}  // namespace seater_perception
