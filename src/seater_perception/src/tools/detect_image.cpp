// Markers in image files, without ROS: see --help.

#include <chrono>
#include <filesystem>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "seater_perception/draw.h"
#include "seater_perception/errors.h"
#include "tools/detectors.h"
#include "tools/image_file.h"
#include "tools/image_report.h"
#include "tools/options.h"

namespace {

namespace fs = std::filesystem;
using namespace seater_perception;
using Clock = std::chrono::steady_clock;

constexpr int kSuccess = 0, kBadImage = 1, kBadUse = 2;

double secondsSince(const Clock::time_point& begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Where the annotated image goes. In a folder a second image of the same name gets a number, too.
fs::path drawingPath(const Options& o, const std::string& image, const std::string& suffix) {
  if (!fs::is_directory(o.draw)) return o.draw;
  static std::set<fs::path> taken;
  const std::string name = fs::path(image).stem().string() + suffix;
  fs::path path = fs::path(o.draw) / (name + "_detected.png");
  for (int i = 2; !taken.insert(path).second; ++i) {
    path = fs::path(o.draw) / (name + "_" + std::to_string(i) + "_detected.png");
  }
  return path;
}

std::optional<std::string> drawn(const Options& o, const ImageNotes& notes, const cv::Mat& picture, bool several) {
  if (o.draw.empty()) return std::nullopt;
  const std::string path = drawingPath(o, notes.image, several ? "_" + *notes.dictionary : "").string();
  bool written = false;
  try {
    written = cv::imwrite(path, picture);
  } catch (const cv::Exception&) {  // unknown ending of the file name
  }
  if (!written) throw ImageError("the annotated image cannot be written to " + path);
  return path;
}

/// An image of the camera's other orientation is most often one that EXIF has turned.
void requireSize(const cv::Mat& grey, const CameraModel& camera) {
  if (grey.cols == camera.width() && grey.rows == camera.height()) return;
  std::string text = "the image is " + std::to_string(grey.cols) + " x " + std::to_string(grey.rows) +
                     ", its calibration is for " + std::to_string(camera.width()) + " x " +
                     std::to_string(camera.height());
  if (grey.cols == camera.height() && grey.rows == camera.width()) {
    text += ": it is turned; --orientation exif or stored says whether its EXIF orientation counts";
  }
  throw ImageError(text);
}

void print(const Options& o, const std::string& text, const std::string& json) {
  std::cout << (o.json ? json + "\n" : text) << std::flush;
}

void reportPlain(const Options& o, const cv::Mat& grey, const std::vector<PlainMarker>& markers, bool several,
                 ImageNotes notes) {
  notes.drawing = drawn(o, notes, annotatePlain(grey, markers), several);
  print(o, describe(markers, notes), describeJson(markers, notes));
}

void reportPoses(const Options& o, const cv::Mat& grey, Detectors& detectors, const MarkerFamily& family, bool several,
                 ImageNotes notes) {
  DockDetector& detector = detectors.of(family, grey.size());
  requireSize(grey, detector.camera());
  const Clock::time_point begin = Clock::now();
  const DetectionResult result = detector.detect(grey);
  notes.detection += secondsSince(begin);
  notes.refused = detectors.refusals(grey, result);
  notes.focal = detectors.focalLength(detector, result);
  if (o.approximate()) notes.fov = o.fov;
  if (!o.draw.empty()) {
    notes.drawing = drawn(o, notes, annotate(grey, detector.camera(), detector.layout(), result), several);
  }
  print(o, describe(result, notes), describeJson(result, notes));
}

void workThrough(const Options& o, Detectors& detectors, const std::string& name) {
  ImageNotes notes;
  notes.image = name;
  const Clock::time_point begin = Clock::now();
  const ImageFile image = readImageFile(name, o.honour_exif);
  notes.turned = image.turned;
  notes.reading = secondsSince(begin);
  if (!detectors.search()) {
    reportPoses(o, image.grey, detectors, detectors.family(), false, notes);
    return;
  }
  const Clock::time_point search = Clock::now();
  const std::vector<FamilyMarkers> found = detectors.search()->detect(image.grey);
  notes.detection = secondsSince(search);
  if (found.empty()) notes.refused = detectors.refusals(image.grey, std::vector<PlainMarker>());
  if (found.empty()) reportPlain(o, image.grey, {}, false, notes);
  for (const FamilyMarkers& seen : found) {
    if (o.dictionary == "any") notes.dictionary = seen.family.name();
    if (o.plain()) {
      notes.refused = detectors.refusals(image.grey, seen.markers);
      reportPlain(o, image.grey, seen.markers, found.size() > 1, notes);
    } else {
      reportPoses(o, image.grey, detectors, seen.family, found.size() > 1, notes);
    }
  }
}

int run(const std::vector<std::string>& arguments) {
  const Options o = parseOptions(arguments);
  if (o.help) {
    std::cout << kHelp;
    return kSuccess;
  }
  Detectors detectors(o);
  for (const std::string& problem : detectors.leftOut()) {
    std::cerr << "detect_image: warning: no marker family, left out: " << problem << std::endl;
  }
  if (!o.draw.empty() && o.images.size() > 1 && !fs::is_directory(o.draw)) {
    throw ConfigurationError("--draw: is '" + o.draw + "', must be an existing folder for several images");
  }
  std::error_code none;  // no such file
  if (fs::equivalent(o.draw, o.images.front(), none)) {
    throw ConfigurationError("--draw: is '" + o.draw + "', the image itself; give another name");
  }
  int code = kSuccess;
  for (const std::string& image : o.images) {
    try {
      workThrough(o, detectors, image);
    } catch (const ImageError& error) {
      std::cerr << "detect_image: " << image << ": " << error.what() << std::endl;
      code = kBadImage;
    }
  }
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(std::vector<std::string>(argv + 1, argv + argc));
  } catch (const std::exception& error) {
    std::cerr << "detect_image: " << error.what() << std::endl;
    return kBadUse;
  }
}
