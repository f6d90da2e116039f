#include "seater_perception/dock_layout.h"

#include <opencv2/aruco.hpp>

#include "seater_perception/errors.h"
#include "seater_perception/strict_yaml.h"

namespace seater_perception {
namespace {

constexpr double kMinSize = 0.005, kMaxSize = 2.0;  // [m]

const std::vector<std::pair<std::string, int>>& dictionaries() {
  using namespace cv::aruco;
  static const std::vector<std::pair<std::string, int>> table = {
      {"DICT_4X4_50", DICT_4X4_50},
      {"DICT_4X4_100", DICT_4X4_100},
      {"DICT_4X4_250", DICT_4X4_250},
      {"DICT_4X4_1000", DICT_4X4_1000},
      {"DICT_5X5_50", DICT_5X5_50},
      {"DICT_5X5_100", DICT_5X5_100},
      {"DICT_5X5_250", DICT_5X5_250},
      {"DICT_5X5_1000", DICT_5X5_1000},
      {"DICT_6X6_50", DICT_6X6_50},
      {"DICT_6X6_100", DICT_6X6_100},
      {"DICT_6X6_250", DICT_6X6_250},
      {"DICT_6X6_1000", DICT_6X6_1000},
      {"DICT_7X7_50", DICT_7X7_50},
      {"DICT_7X7_100", DICT_7X7_100},
      {"DICT_7X7_250", DICT_7X7_250},
      {"DICT_7X7_1000", DICT_7X7_1000},
      {"DICT_ARUCO_ORIGINAL", DICT_ARUCO_ORIGINAL},
      {"DICT_APRILTAG_16h5", DICT_APRILTAG_16h5},
      {"DICT_APRILTAG_25h9", DICT_APRILTAG_25h9},
      {"DICT_APRILTAG_36h10", DICT_APRILTAG_36h10},
      {"DICT_APRILTAG_36h11", DICT_APRILTAG_36h11},
  };
  return table;
}

/// One entry of the list `markers`, as the strict reader fills it.
struct MarkerEntry {
  int id = 0;
  double size = 0.1;
  std::vector<double> position;
  double normal_yaw = 0.0;
  int highest_id = 0;

  void visit(StrictReader& v) {
    v.integer("id", id, "", 0, highest_id, "number in the dictionary");
    v.number("size", size, "m", kMinSize, kMaxSize, "side of the black square");
    v.numbers("position", position, 3, "m", "centre in the dock frame, x y z");
    v.number("normal_yaw", normal_yaw, "rad", -3.1416, 3.1416, "direction in which the print faces");
  }
};

void readMarkers(const YAML::Node& list, const std::string& prefix, int highest_id, DockLayout& layout,
                 std::vector<std::string>& problems) {
  if (!list.IsSequence() || list.size() == 0) {
    problems.push_back(prefix + ": must be a list with at least one marker");
    return;
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string key = prefix + "[" + std::to_string(i) + "]";
    const std::size_t before = problems.size();
    StrictReader reader(list[i], key, problems);
    MarkerEntry entry;
    entry.highest_id = highest_id;
    entry.visit(reader);
    reader.refuseUnknown();
    if (problems.size() > before) continue;
    const Eigen::Vector3d position(entry.position[0], entry.position[1], entry.position[2]);
    const DockMarker marker{entry.id, entry.size, position, entry.normal_yaw};
    if (!layout.markers.emplace(entry.id, marker).second) {
      problems.push_back(key + "/id: is " + std::to_string(entry.id) + ", must differ from the other markers' ids");
    }
  }
}

}  // namespace

std::array<Eigen::Vector3d, 4> markerCorners(double size) {
  const double h = 0.5 * size;
  return {Eigen::Vector3d(-h, h, 0.0), Eigen::Vector3d(h, h, 0.0), Eigen::Vector3d(h, -h, 0.0),
          Eigen::Vector3d(-h, -h, 0.0)};
}

Eigen::Isometry3d DockMarker::T_dock_marker() const {
  const Eigen::Vector3d normal(std::cos(normal_yaw), std::sin(normal_yaw), 0.0);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << up.cross(normal), up, normal;
  T.translation() = position;
  return T;
}

std::optional<double> DockLayout::sizeOf(int id) const {
  const auto found = markers.find(id);
  return found != markers.end() ? std::optional<double>(found->second.size) : size_of_others;
}

std::vector<std::string> dictionaryNames() {
  std::vector<std::string> names;
  for (const auto& entry : dictionaries()) names.push_back(entry.first);
  return names;
}

int dictionaryNumber(const std::string& name, const std::string& key) {
  std::string known;
  for (const auto& [known_name, number] : dictionaries()) {
    if (known_name == name) return number;
    known += (known.empty() ? "" : ", ") + known_name;
  }
  throw ConfigurationError(key + ": is '" + name + "', must be one of " + known);
}

DockLayout layoutOfEqualMarkers(const std::string& dictionary, double size) {
  dictionaryNumber(dictionary, "dictionary");
  if (!(size >= kMinSize && size <= kMaxSize)) {
    throw ConfigurationError("size: is " + std::to_string(size) + ", must be a number from 0.005 to 2 [m]");
  }
  DockLayout layout;
  layout.dictionary = dictionary;
  layout.size_of_others = size;
  return layout;
}

DockLayout loadDockLayout(const YAML::Node& node, const std::string& prefix) {
  std::vector<std::string> problems;
  StrictReader reader(node, prefix, problems);
  DockLayout layout;
  reader.choice("dictionary", layout.dictionary, dictionaryNames(), "OpenCV's name of the marker dictionary");
  const YAML::Node list = reader.take("markers", "the printed markers at the dock", "");
  int highest_id = 1 << 20;
  if (!layout.dictionary.empty()) {
    highest_id = cv::aruco::getPredefinedDictionary(dictionaryNumber(layout.dictionary, ""))->bytesList.rows - 1;
  }
  if (list.IsDefined()) readMarkers(list, prefix + "/markers", highest_id, layout, problems);
  throwProblems(problems, "wrong dock:");
  return layout;
}

}  // namespace seater_perception
