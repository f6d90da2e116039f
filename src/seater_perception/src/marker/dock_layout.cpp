#include "seater_perception/dock_layout.h"

#include "seater_perception/errors.h"
#include "seater_perception/strict_yaml.h"

namespace seater_perception {
namespace {

constexpr double kMinSize = 0.005, kMaxSize = 2.0;  // [m]
constexpr int kAnyId = 1 << 20;                     // where the family is wrong already, ids are not judged

/// One entry of the list `markers`, as the strict reader fills it.
struct MarkerEntry {
  int id = 0;
  double size = 0.1;
  std::vector<double> position;
  double normal_yaw = 0.0;
  int highest_id = 0;

  void visit(StrictReader& v) {
    v.integer("id", id, "", 0, highest_id, "number in the family");
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

DockLayout layoutOfEqualMarkers(const MarkerFamily& family, double size) {
  if (!(size >= kMinSize && size <= kMaxSize)) {
    throw ConfigurationError("size: is " + std::to_string(size) + ", must be a number from 0.005 to 2 [m]");
  }
  DockLayout layout;
  layout.family = family;
  layout.size_of_others = size;
  return layout;
}

DockLayout layoutOfEqualMarkers(const std::string& family, double size) {
  return layoutOfEqualMarkers(MarkerFamily::named(family), size);
}

DockLayout loadDockLayout(const YAML::Node& node, const std::string& prefix) {
  std::vector<std::string> problems;
  StrictReader reader(node, prefix, problems);
  DockLayout layout;
  std::string family;
  reader.choice("dictionary", family, MarkerFamily::names(), "name of the marker family");
  const YAML::Node list = reader.take("markers", "the printed markers at the dock", "");
  int highest_id = kAnyId;
  if (!family.empty()) {
    layout.family = MarkerFamily::named(family);
    highest_id = layout.family.count() - 1;
  }
  if (list.IsDefined()) readMarkers(list, prefix + "/markers", highest_id, layout, problems);
  throwProblems(problems, "wrong dock:");
  return layout;
}

}  // namespace seater_perception
