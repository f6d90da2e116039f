// Markers in image files, without ROS: see --help.

#include <cmath>
#include <filesystem>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "seater_perception/dock_detector.h"
#include "seater_perception/draw.h"
#include "seater_perception/errors.h"
#include "seater_perception/report.h"
#include "seater_perception/strict_yaml.h"

namespace {

namespace fs = std::filesystem;
using namespace seater_perception;

constexpr int kSuccess = 0, kBadImage = 1, kBadUse = 2;

const char* const kHelp = R"(usage: detect_image --camera camera.yaml --markers dock.yaml [options] image...
       detect_image --camera camera.yaml --dictionary NAME --size M [options] image...

Finds markers in images and prints a table (or JSON); finding none is a normal result.

  --camera FILE       calibration, in the format of camera_calibration (config/cameras/d455.yaml)
  --rectified         the images are rectified: use P; without it they are raw: use K and D
  --markers FILE      a dock (config/docks/default.yaml): only its markers are reported, and its pose
  --dictionary NAME   with --size and without a dock: report every marker of this dictionary (DICT_4X4_50 ...);
                      with --markers: in place of the file's dictionary
  --size M            side of the black square [m]; with --markers: of the markers that the file does not know,
                      which are then reported too
  --selection NAME    bundle or lowest_id: which markers the dock's pose is computed from
  --parameters FILE   config/perception.yaml; without it the same values, which are built in
  --pitch DEG         how far the camera looks down (0), to tell an upright marker's two possible poses apart
  --roll DEG          the camera's roll (0)
  --json              JSON: one object per line and image, in metres, radians and pixels
  --draw OUT          write the annotated image: a file name, or a folder (which takes several)
  --help              this text

Table: distance from camera to marker centre; lateral: right of the optical axis; angle: by which the print is turned
from square on, about the vertical, positive: its right edge is nearer; side: mean side in the image; error: rms
reprojection error; ambiguity: likelihood of the other possible pose over that of this one, near 1: undecided.
Exit code: 0 done, 1 an image could not be worked through (the others were), 2 wrong use, parameters or calibration.
)";

struct Options {
  std::string camera, markers, dictionary, selection, parameters, draw;
  double size = 0.0, pitch = 0.0, roll = 0.0;
  bool rectified = false, json = false, help = false;
  std::vector<std::string> images;
};

double number(const std::string& option, const std::string& text) {
  std::size_t end = 0;
  double value = NAN;
  try {
    value = std::stod(text, &end);
  } catch (const std::logic_error&) {
  }
  if (end != text.size() || !std::isfinite(value)) {
    throw ConfigurationError(option + ": is '" + text + "', must be a number");
  }
  return value;
}

Options parse(const std::vector<std::string>& arguments) {
  Options o;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& name = arguments[i];
    const auto next = [&]() -> const std::string& {
      if (i + 1 >= arguments.size()) throw ConfigurationError(name + ": needs a value");
      return arguments[++i];
    };
    if (name == "--help" || name == "-h")
      o.help = true;
    else if (name == "--json")
      o.json = true;
    else if (name == "--rectified")
      o.rectified = true;
    else if (name == "--camera")
      o.camera = next();
    else if (name == "--markers")
      o.markers = next();
    else if (name == "--dictionary")
      o.dictionary = next();
    else if (name == "--selection")
      o.selection = next();
    else if (name == "--parameters")
      o.parameters = next();
    else if (name == "--draw")
      o.draw = next();
    else if (name == "--size")
      o.size = number(name, next());
    else if (name == "--pitch")
      o.pitch = number(name, next()) * M_PI / 180.0;
    else if (name == "--roll")
      o.roll = number(name, next()) * M_PI / 180.0;
    else if (name.size() > 1 && name[0] == '-')
      throw ConfigurationError(name + ": unknown option; see --help");
    else
      o.images.push_back(name);
  }
  return o;
}

DockLayout layoutFrom(const Options& o) {
  if (o.markers.empty()) {
    if (o.dictionary.empty() || o.size == 0.0) {
      throw ConfigurationError("give --markers, or both --dictionary and --size; see --help");
    }
    return layoutOfEqualMarkers(o.dictionary, o.size);
  }
  YAML::Node node = loadYamlFile(o.markers);
  if (!o.dictionary.empty() && node.IsMap()) node["dictionary"] = o.dictionary;
  DockLayout layout = loadDockLayout(node, o.markers);
  if (o.size != 0.0) layout.size_of_others = layoutOfEqualMarkers(layout.family, o.size).size_of_others;
  return layout;
}

DockDetector detectorFrom(const Options& o) {
  if (o.camera.empty()) throw ConfigurationError("--camera is missing; see --help");
  if (o.images.empty()) throw ConfigurationError("no image given; see --help");
  const Calibration calibration = loadCalibration(o.camera);
  PerceptionParameters parameters;
  if (!o.parameters.empty()) parameters = loadPerceptionParameters(loadYamlFile(o.parameters), o.parameters);
  if (!o.selection.empty()) {
    if (o.selection != "bundle" && o.selection != "lowest_id") {
      throw ConfigurationError("--selection: is '" + o.selection + "', must be one of bundle, lowest_id");
    }
    parameters.selection = o.selection;
  }
  CameraMount mount;
  mount.pitch = o.pitch;
  mount.roll = o.roll;
  try {
    const CameraModel camera = o.rectified ? CameraModel::rectified(calibration) : CameraModel::raw(calibration);
    return DockDetector(camera, layoutFrom(o), parameters, mount);
  } catch (const CalibrationError& error) {
    throw ConfigurationError(o.camera + ": " + error.what());
  }
}

/// Where the annotated image goes.
fs::path drawingPath(const Options& o, const std::string& image) {
  if (!fs::is_directory(o.draw)) return o.draw;
  return fs::path(o.draw) / (fs::path(image).stem().string() + "_detected.png");
}

void workThrough(const Options& o, DockDetector& detector, const std::string& image) {
  const cv::Mat grey = cv::imread(image, cv::IMREAD_GRAYSCALE);
  if (grey.empty()) throw ImageError("cannot be read as an image");
  const DetectionResult result = detector.detect(grey);
  std::optional<std::string> drawing;
  if (!o.draw.empty()) {
    drawing = drawingPath(o, image).string();
    bool written = false;
    try {
      written = cv::imwrite(*drawing, annotate(grey, detector.camera(), detector.layout(), result));
    } catch (const cv::Exception&) {  // unknown ending of the file name
    }
    if (!written) throw ImageError("the annotated image cannot be written to " + *drawing);
  }
  if (o.json) {
    std::cout << json(image, result, drawing) << std::endl;
    return;
  }
  std::cout << image << "\n" << table(result);
  if (result.refused > 0) std::cout << result.refused << " found, but refused: no believable pose\n";
  if (drawing) std::cout << "annotated: " << *drawing << "\n";
}

int run(const std::vector<std::string>& arguments) {
  const Options o = parse(arguments);
  if (o.help) {
    std::cout << kHelp;
    return kSuccess;
  }
  DockDetector detector = detectorFrom(o);
  if (!o.draw.empty() && o.images.size() > 1 && !fs::is_directory(o.draw)) {
    throw ConfigurationError("--draw: is '" + o.draw + "', must be an existing folder for several images");
  }
  int code = kSuccess;
  for (const std::string& image : o.images) {
    try {
      workThrough(o, detector, image);
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
