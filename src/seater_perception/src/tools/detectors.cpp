#include "tools/detectors.h"

#include <cmath>
#include <set>

#include "seater_perception/errors.h"
#include "seater_perception/strict_yaml.h"

namespace seater_perception {
namespace {

PerceptionParameters parametersFrom(const Options& o) {
  PerceptionParameters parameters;
  if (!o.parameters.empty()) parameters = loadPerceptionParameters(loadYamlFile(o.parameters), o.parameters);
  if (o.selection.empty()) return parameters;
  if (o.selection != "bundle" && o.selection != "lowest_id") {
    throw ConfigurationError("--selection: is '" + o.selection + "', must be one of bundle, lowest_id");
  }
  parameters.selection = o.selection;
  return parameters;
}

/// Of a dock file, or of all markers of a family.
DockLayout layoutFrom(const Options& o, const MarkerFamily& family) {
  if (o.markers.empty()) return layoutOfEqualMarkers(family, o.size);
  YAML::Node node = loadYamlFile(o.markers);
  if (!o.dictionary.empty() && node.IsMap()) node["dictionary"] = MarkerFamily::named(o.dictionary).name();
  DockLayout layout = loadDockLayout(node, o.markers);
  if (o.size != 0.0) layout.size_of_others = layoutOfEqualMarkers(layout.family, o.size).size_of_others;
  return layout;
}

/// A pinhole of this field of view across the image's width [rad], square pixels, its axis in the middle.
Calibration assumed(const cv::Size& image, double fov) {
  Calibration c;
  const double f = 0.5 * image.width / std::tan(0.5 * fov);
  const double cx = 0.5 * (image.width - 1), cy = 0.5 * (image.height - 1);
  c.width = image.width;
  c.height = image.height;
  c.K = {f, 0, cx, 0, f, cy, 0, 0, 1};
  c.P = {f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0};
  return c;
}

}  // namespace

Detectors::Detectors(const Options& options) : options_(options), parameters_(parametersFrom(options)) {
  if (!options.camera.empty()) calibration_ = loadCalibration(options.camera);
  const bool any = options.dictionary == "any";
  if (!any && !options.dictionary.empty()) family_ = MarkerFamily::named(options.dictionary, "--dictionary");
  if (any || options.plain()) {
    const auto families = any ? allFamilies(left_out_) : std::vector<MarkerFamily>{family_};
    search_ = std::make_unique<FamilySearch>(families, parameters_.detector);
  }
  // What is wrong is said before any image is read.
  if (calibration_) cameraFor(cv::Size());
  if (!options.plain() && !any) {
    layout_ = layoutFrom(options, family_);
    family_ = layout_->family;
  }
  if (!any) explainer_ = std::make_unique<FamilySearch>(std::vector<MarkerFamily>{family_}, parameters_.detector);
}

std::vector<RefusedCandidate> Detectors::refusals(const cv::Mat& grey, const std::vector<PlainMarker>& found) {
  return explainer_ ? explainer_->refusals(grey, found) : std::vector<RefusedCandidate>();
}

/// What the search finds and the result has not is refused by its pose, or is no marker of the dock.
std::vector<RefusedCandidate> Detectors::refusals(const cv::Mat& grey, const DetectionResult& result) {
  if (!explainer_) return {};
  std::vector<PlainMarker> found;
  std::set<int> known;
  for (const DetectedMarker& m : result.markers) found.push_back({m.id, m.corners});
  found.insert(found.end(), result.repeated.begin(), result.repeated.end());
  for (const PlainMarker& m : found) known.insert(m.id);
  std::vector<RefusedCandidate> refused;
  for (const FamilyMarkers& family : explainer_->detect(grey)) {
    for (const PlainMarker& m : family.markers) {
      if (known.count(m.id)) continue;
      const bool reported = layout_->sizeOf(m.id).has_value();
      refused.push_back(
          {m.corners, m.id, reported ? "its corners allow no believable pose" : "the dock has no such id"});
      found.push_back(m);
    }
  }
  for (const RefusedCandidate& candidate : explainer_->refusals(grey, found)) refused.push_back(candidate);
  return refused;
}

std::optional<FocalCheck> Detectors::focalLength(const DockDetector& detector, const DetectionResult& result) const {
  return checkFocalLength(detector.camera(), detector.layout(), result, parameters_.pose.placement_sigma);
}

DockDetector& Detectors::of(const MarkerFamily& family, const cv::Size& image) {
  const auto size = options_.approximate() ? std::make_pair(image.width, image.height) : std::make_pair(0, 0);
  const auto key = std::make_pair(family.name(), size);
  const auto known = detectors_.find(key);
  if (known != detectors_.end()) return known->second;
  CameraMount mount;
  mount.pitch = options_.pitch;
  mount.roll = options_.roll;
  DockDetector detector(cameraFor(image), layoutFrom(options_, family), parameters_, mount);
  return detectors_.emplace(key, std::move(detector)).first->second;
}

CameraModel Detectors::cameraFor(const cv::Size& image) const {
  const Calibration c = options_.approximate() ? assumed(image, options_.fov) : *calibration_;
  try {
    return options_.rectified ? CameraModel::rectified(c) : CameraModel::raw(c);
  } catch (const CalibrationError& error) {
    throw ConfigurationError(options_.camera + ": " + error.what());
  }
}

}  // namespace seater_perception
