#include "ros_parameters.h"

#include <cstdio>
#include <functional>

#include "seater_perception/errors.h"

namespace seater_perception {
namespace {

using XmlRpc::XmlRpcValue;

YAML::Node read(const ros::NodeHandle& handle, const std::string& key) {
  XmlRpcValue value;
  if (!handle.getParam(key, value)) return YAML::Node(YAML::NodeType::Undefined);
  return toYaml(value);
}

/// Runs one of the loaders and keeps what it complains about.
void collect(std::string& problems, const std::function<void()>& loader) {
  try {
    loader();
  } catch (const ConfigurationError& error) {
    problems += std::string(problems.empty() ? "" : "\n") + error.what();
  }
}

void readBoolean(const ros::NodeHandle& handle, const std::string& key, bool required, bool& value) {
  XmlRpcValue found;
  const std::string name = handle.resolveName(key);
  if (!handle.getParam(key, found)) {
    if (required) throw ConfigurationError(name + ": is missing, must be true (rectified images) or false (raw)");
    return;
  }
  if (found.getType() != XmlRpcValue::TypeBoolean) {
    throw ConfigurationError(name + ": is " + found.toXml() + ", must be true or false");
  }
  value = static_cast<bool>(found);
}

std::string readTransport(const ros::NodeHandle& handle) {
  XmlRpcValue found;
  if (!handle.getParam("image_transport", found)) return "raw";
  const std::string name = found.getType() == XmlRpcValue::TypeString ? static_cast<std::string>(found) : found.toXml();
  if (name == "raw" || name == "compressed") return name;
  throw ConfigurationError(handle.resolveName("image_transport") + ": is '" + name + "', must be raw or compressed");
}

/// Empty where the key is not set. `meaning`: what a message says that the text must be.
std::string readText(const ros::NodeHandle& handle, const std::string& key, const std::string& meaning) {
  XmlRpcValue found;
  if (!handle.getParam(key, found)) return "";
  if (found.getType() == XmlRpcValue::TypeString) return static_cast<std::string>(found);
  throw ConfigurationError(handle.resolveName(key) + ": is " + found.toXml() + ", must be " + meaning);
}

YAML::Node toYamlMap(XmlRpcValue value) {
  YAML::Node node(YAML::NodeType::Map);
  for (auto& [key, child] : value) node[key] = toYaml(child);
  return node;
}

YAML::Node toYamlList(XmlRpcValue value) {
  YAML::Node node(YAML::NodeType::Sequence);
  for (int i = 0; i < value.size(); ++i) node.push_back(toYaml(value[i]));
  return node;
}

}  // namespace

YAML::Node toYaml(const XmlRpc::XmlRpcValue& given) {
  XmlRpcValue value = given;  // its conversions are not const
  YAML::Node node;
  char text[40];
  switch (value.getType()) {
    case XmlRpcValue::TypeBoolean:
      return YAML::Node(static_cast<bool>(value) ? "true" : "false");
    case XmlRpcValue::TypeInt:
      return YAML::Node(std::to_string(static_cast<int>(value)));
    case XmlRpcValue::TypeDouble:
      std::snprintf(text, sizeof(text), "%.17g", static_cast<double>(value));
      return YAML::Node(std::string(text));
    case XmlRpcValue::TypeString:
      node = static_cast<std::string>(value);
      node.SetTag("!");
      return node;
    case XmlRpcValue::TypeStruct:
      return toYamlMap(value);
    case XmlRpcValue::TypeArray:
      return toYamlList(value);
    default:
      return YAML::Node(YAML::NodeType::Null);
  }
}

NodeParameters loadNodeParameters(const ros::NodeHandle& handle) {
  NodeParameters p;
  std::string problems;
  const auto name = [&](const char* key) { return handle.resolveName(key); };
  collect(problems, [&] { p.dock = loadDockLayout(read(handle, "dock"), name("dock")); });
  collect(problems, [&] { p.dock_name = readText(handle, "dock/name", "a text"); });
  collect(problems, [&] { p.perception = loadPerceptionParameters(read(handle, "perception"), name("perception")); });
  collect(problems, [&] { p.mount = loadCameraMount(read(handle, "chair/camera"), name("chair/camera")); });
  collect(problems, [&] { readBoolean(handle, "rectified", true, p.rectified); });
  collect(problems, [&] { readBoolean(handle, "lazy", false, p.lazy); });
  collect(problems, [&] { p.image_transport = readTransport(handle); });
  collect(problems, [&] {
    p.odometry_frame = readText(handle, "odometry_frame", "the name of a TF frame (text), or empty for none");
  });
  if (!problems.empty()) throw ConfigurationError(problems);
  return p;
}

}  // namespace seater_perception
