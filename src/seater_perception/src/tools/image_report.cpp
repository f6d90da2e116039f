#include "tools/image_report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "pipeline/format.h"
#include "seater_perception/report.h"
#include "tools/strokes.h"

namespace seater_perception {
namespace {

double sideOf(const PlainMarker& m) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum += (m.corners[i] - m.corners[(i + 1) % 4]).norm();
  return 0.25 * sum;
}

std::string jsonCorners(const std::array<Eigen::Vector2d, 4>& corners) {
  std::string text = "\"corners\": [";
  for (std::size_t i = 0; i < 4; ++i) text += format("%s[%.12g, %.12g]", i ? ", " : "", corners[i].x(), corners[i].y());
  return text + "]";
}

std::string jsonList(const std::vector<PlainMarker>& markers) {
  std::string text;
  for (const PlainMarker& m : markers) {
    text += format("%s{\"id\": %d, ", text.empty() ? "" : ", ", m.id) + jsonCorners(m.corners);
    text += format(", \"side_px\": %.12g}", sideOf(m));
  }
  return "[" + text + "]";
}

std::string jsonList(const std::vector<RefusedCandidate>& candidates) {
  std::string text;
  for (const RefusedCandidate& c : candidates) {
    text += (text.empty() ? "{\"id\": " : ", {\"id\": ") + (c.id ? std::to_string(*c.id) : "null") + ", ";
    text += jsonCorners(c.corners) + ", \"why\": \"" + c.why + "\"}";
  }
  return "[" + text + "]";
}

/// The keys that every object has, to follow others.
std::string jsonNotes(const ImageNotes& notes) {
  std::string text;
  if (notes.dictionary) text += ", \"dictionary\": \"" + *notes.dictionary + "\"";
  text += ", \"refused_candidates\": " + jsonList(notes.refused);
  text += format(", \"turned_by_exif\": %s", notes.turned ? "true" : "false");
  return text + format(", \"time\": {\"reading\": %.6f, \"detection\": %.6f}", notes.reading, notes.detection);
}

/// A JSON object with more keys.
std::string with(std::string object, const std::string& keys) {
  object.insert(object.rfind('}'), keys);
  return object;
}

std::string notesText(const ImageNotes& notes) {
  std::string text;
  if (notes.turned) text += "turned as its EXIF orientation says (--orientation stored leaves it)\n";
  if (notes.dictionary) text += "dictionary: " + *notes.dictionary + "\n";
  return text;
}

std::string endText(const ImageNotes& notes) {
  std::string text;
  for (const RefusedCandidate& c : notes.refused) {
    if (!c.id) continue;  // most of them are no markers
    const Eigen::Vector2d& corner = c.corners[0];
    text +=
        format("refused: what may be marker %d at (%.1f, %.1f): %s\n", *c.id, corner.x(), corner.y(), c.why.c_str());
  }
  text += format("%.0f ms\n", 1e3 * notes.detection);
  if (notes.drawing) text += "annotated: " + *notes.drawing + "\n";
  return text;
}

std::string placesText(const std::vector<PlainMarker>& repeated) {
  std::map<int, std::vector<const PlainMarker*>> places;
  for (const PlainMarker& m : repeated) places[m.id].push_back(&m);
  std::string text;
  for (const auto& [id, markers] : places) {
    text += format("marker %d stands at %zu places, so none of them is used; top left corners:", id, markers.size());
    for (const PlainMarker* m : markers) text += format(" (%.1f, %.1f)", m->corners[0].x(), m->corners[0].y());
    text += "\n";
  }
  return text;
}

std::string focalText(const ImageNotes& notes) {
  if (!notes.focal || !notes.focal->contradicts()) return "";
  return format("the dock's markers contradict the calibration, as if its focal length were %.1f %% too %s (sd %.1f)\n",
                100.0 * std::abs(notes.focal->excess), notes.focal->excess > 0.0 ? "long" : "short",
                100.0 * notes.focal->sigma);
}

std::string jsonFocal(const ImageNotes& notes) {
  const auto& f = notes.focal;
  std::string text = format(", \"calibration_contradicted\": %s, ", f && f->contradicts() ? "true" : "false");
  if (!f) return text + "\"focal_excess\": null";
  return text + format("\"focal_excess\": {\"value\": %.6g, \"sigma\": %.6g}", f->excess, f->sigma);
}

}  // namespace

std::vector<int> distanceOnly(const DetectionResult& result) {
  std::vector<int> ids;
  for (const DetectedMarker& m : result.markers) {
    const auto& h = m.hypotheses;
    if (h.size() > 1 && h[1].weight >= kUndecided * h[0].weight) ids.push_back(m.id);
  }
  return ids;
}

std::string describe(const DetectionResult& result, const ImageNotes& notes) {
  std::string text = notes.image + "\n" + notesText(notes) + table(result);
  for (const int id : distanceOnly(result)) {
    text += format("marker %d: only its distance is certain, two angles explain the image\n", id);
  }
  text += focalText(notes);
  text += placesText(result.repeated);
  const bool unexplained = result.refused > 0 && notes.refused.empty();
  if (unexplained) text += format("%d found, but refused: no believable pose\n", result.refused);
  if (notes.fov) {
    text += format("approximate: no calibration, a field of view of %.1f deg and no distortion are assumed\n",
                   *notes.fov * 180.0 / M_PI);
  }
  return text + endText(notes);
}

std::string describe(const std::vector<PlainMarker>& markers, const ImageNotes& notes) {
  std::string text = notes.image + "\n" + notesText(notes);
  if (markers.empty()) return text + "no markers found\n" + endText(notes);
  text += "   id  side px  corners px: top left, top right, bottom right, bottom left as the print is read\n";
  for (const PlainMarker& m : markers) {
    text += format("%5d  %7.1f ", m.id, sideOf(m));
    for (const auto& c : m.corners) text += format(" (%.2f, %.2f)", c.x(), c.y());
    text += "\n";
  }
  return text + endText(notes);
}

std::string describeJson(const DetectionResult& result, const ImageNotes& notes) {
  std::string ids;
  for (const int id : distanceOnly(result)) ids += (ids.empty() ? "" : ", ") + std::to_string(id);
  std::string keys = ", \"distance_only\": [" + ids + "]" + jsonFocal(notes);
  keys += ", \"repeated\": " + jsonList(result.repeated);
  keys +=
      notes.fov ? format(", \"approximate\": true, \"assumed_fov\": %.12g", *notes.fov) : ", \"approximate\": false";
  return with(json(notes.image, result, notes.drawing), keys + jsonNotes(notes));
}

std::string describeJson(const std::vector<PlainMarker>& markers, const ImageNotes& notes) {
  const std::string empty = json(notes.image, DetectionResult(), notes.drawing);
  const std::string before = "\"markers\": []";
  std::string text = empty;
  text.replace(text.find(before), before.size(), "\"markers\": " + jsonList(markers));
  return with(text, jsonNotes(notes));
}

cv::Mat annotatePlain(const cv::Mat& grey, const std::vector<PlainMarker>& markers) {
  cv::Mat image;
  cv::cvtColor(grey, image, cv::COLOR_GRAY2BGR);
  const double scale = strokeScale(image);
  const int width = strokeWidth(2.0 * scale);
  for (const PlainMarker& m : markers) {
    std::vector<cv::Point> outline;
    for (const auto& c : m.corners) outline.push_back(fine(c));
    cv::polylines(image, outline, true, kOutline, width, cv::LINE_AA, kShift);
    cv::circle(image, outline[0], cvRound(4.0 * scale) << kShift, kRed, width, cv::LINE_AA, kShift);
    const cv::Point at(outline[3].x / (1 << kShift), outline[3].y / (1 << kShift) + cvRound(26.0 * scale));
    cv::putText(image, "id " + std::to_string(m.id), at, cv::FONT_HERSHEY_SIMPLEX, 0.7 * scale, kOutline, width,
                cv::LINE_AA);
  }
  return image;
}

}  // namespace seater_perception
