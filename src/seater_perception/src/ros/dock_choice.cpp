#include "dock_choice.h"

#include <algorithm>
#include <utility>

#include "seater_perception/errors.h"

namespace seater_perception {
namespace {

bool sameMarker(const DockMarker& a, const DockMarker& b) {
  return a.id == b.id && a.size == b.size && a.position == b.position && a.normal_yaw == b.normal_yaw;
}

bool sameLayout(const DockLayout& a, const DockLayout& b) {
  return a.family.name() == b.family.name() && a.markers.size() == b.markers.size() &&
         std::equal(a.markers.begin(), a.markers.end(), b.markers.begin(),
                    [](const auto& left, const auto& right) { return sameMarker(left.second, right.second); });
}

YAML::Node parse(const seater_msgs::DockInUse& message) {
  try {
    return YAML::Load(message.content);
  } catch (const YAML::Exception& error) {
    throw ConfigurationError(message.source + ": " + error.what());
  }
}

}  // namespace

DockChoice::DockChoice(DockLayout layout, std::string name) : layout_(std::move(layout)), name_(std::move(name)) {}

bool DockChoice::take(const seater_msgs::DockInUse& message) {
  DockLayout layout = loadDockLayout(parse(message), message.source);
  const bool changed = !sameLayout(layout, layout_);
  layout_ = std::move(layout);
  name_ = message.name;
  revision_ = message.revision;
  return changed;
}

}  // namespace seater_perception
