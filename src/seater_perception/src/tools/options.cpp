#include "tools/options.h"

#include <cmath>
#include <functional>
#include <map>

#include "seater_perception/errors.h"

namespace seater_perception {

const char* const kHelp = R"(usage: detect_image CAMERA --markers dock.yaml [options] image...
       detect_image CAMERA --dictionary NAME --size M [options] image...
       detect_image --dictionary NAME [options] image...

Finds markers in images and prints a table (or JSON); finding none is a normal result. CAMERA is --camera or --fov. The
last form only says where in the image markers are, and needs neither camera nor size.

  --camera FILE       calibration, of camera_calibration (config/cameras/d455.yaml) or of OpenCV (.yml)
  --fov DEG           without a calibration: field of view across the image's width, such as 69. Lens distortion is
                      taken for none, so poses are approximate, and are marked so
  --rectified         the images are rectified: use P; without it they are raw: use K and D
  --markers FILE      a dock (config/docks/default.yaml): only its markers are reported, and its pose
  --dictionary NAME   without a dock: report every marker of this dictionary (DICT_4X4_50 ..., a family of
                      config/marker_families, or the path of its file); with --markers: in place of the file's.
                      any: tries all dictionaries and says which one it is; without a dock
  --size M            side of the black square [m]; with --markers: of the markers that the file does not know,
                      which are then reported too
  --selection NAME    bundle or lowest_id: which markers the dock's pose is computed from
  --parameters FILE   config/perception.yaml; without it the same values, which are built in
  --pitch DEG         how far the camera looks down (0), to tell an upright marker's two possible poses apart
  --roll DEG          the camera's roll (0)
  --orientation HOW   exif: turn an image upright as its EXIF orientation says (default); stored: leave it as it is
  --json              JSON: one object per line and image, in metres, radians, pixels and seconds
  --draw OUT          write the annotated image: a file name, or a folder (which takes several)
  --help              this text

Table: distance from camera to marker centre; lateral: right of the optical axis; angle: by which the print is turned
from square on, about the vertical, positive: its right edge is nearer; side: mean side in the image; error: rms
reprojection error; ambiguity: likelihood of the other possible pose over that of this one, near 1: undecided. From
0.05 on, only the distance is certain, which is said.
Exit code: 0 done, 1 an image could not be worked through (the others were), 2 wrong use, parameters or calibration.
)";

namespace {

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

double fieldOfView(const std::string& option, const std::string& text) {
  const double degrees = number(option, text);
  if (!(degrees >= 1.0 && degrees <= 170.0)) {
    throw ConfigurationError(option + ": is " + text + ", must be a number from 1 to 170 [deg]");
  }
  return degrees * M_PI / 180.0;
}

bool orientation(const std::string& option, const std::string& text) {
  if (text != "exif" && text != "stored") {
    throw ConfigurationError(option + ": is '" + text + "', must be one of exif, stored");
  }
  return text == "exif";
}

void check(const Options& o) {
  const auto refuse = [](const std::string& text) { throw ConfigurationError(text + "; see --help"); };
  if (o.images.empty()) refuse("no image given");
  if (o.markers.empty() && o.dictionary.empty()) refuse("give --markers, or --dictionary with or without --size");
  if (!o.markers.empty() && o.dictionary == "any") refuse("--dictionary any: not with --markers");
  if (!o.camera.empty() && o.approximate()) refuse("--fov: not with --camera, which says it exactly");
  if (!o.plain() && o.camera.empty() && !o.approximate()) refuse("give --camera, or --fov for approximate poses");
}

}  // namespace

Options parseOptions(const std::vector<std::string>& arguments) {
  Options o;
  const std::map<std::string, std::function<void()>> flags = {
      {"--help", [&] { o.help = true; }},
      {"-h", [&] { o.help = true; }},
      {"--json", [&] { o.json = true; }},
      {"--rectified", [&] { o.rectified = true; }},
  };
  using Text = const std::string&;
  const std::map<std::string, std::function<void(Text, Text)>> values = {
      {"--camera", [&](Text, Text v) { o.camera = v; }},
      {"--fov", [&](Text name, Text v) { o.fov = fieldOfView(name, v); }},
      {"--markers", [&](Text, Text v) { o.markers = v; }},
      {"--dictionary", [&](Text, Text v) { o.dictionary = v; }},
      {"--selection", [&](Text, Text v) { o.selection = v; }},
      {"--parameters", [&](Text, Text v) { o.parameters = v; }},
      {"--orientation", [&](Text name, Text v) { o.honour_exif = orientation(name, v); }},
      {"--draw", [&](Text, Text v) { o.draw = v; }},
      {"--size", [&](Text name, Text v) { o.size = number(name, v); }},
      {"--pitch", [&](Text name, Text v) { o.pitch = number(name, v) * M_PI / 180.0; }},
      {"--roll", [&](Text name, Text v) { o.roll = number(name, v) * M_PI / 180.0; }},
  };
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& name = arguments[i];
    if (flags.count(name)) {
      flags.at(name)();
    } else if (values.count(name)) {
      if (i + 1 >= arguments.size()) throw ConfigurationError(name + ": needs a value");
      values.at(name)(name, arguments[++i]);
    } else if (name.size() > 1 && name[0] == '-') {
      throw ConfigurationError(name + ": unknown option; see --help");
    } else {
      o.images.push_back(name);
    }
  }
  if (!o.help) check(o);
  return o;
}

}  // namespace seater_perception
