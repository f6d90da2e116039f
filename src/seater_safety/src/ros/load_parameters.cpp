#include "load_parameters.h"

#include <XmlRpcValue.h>

#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace seater_safety {
namespace {

double number(const ros::NodeHandle& handle, const std::string& key) {
  double value = 0.0;
  if (!handle.getParam(key, value)) throw std::invalid_argument(handle.resolveName(key) + ": is missing or no number");
  return value;
}

void refuseUnknown(const ros::NodeHandle& handle, const std::string& file) {
  XmlRpc::XmlRpcValue values;
  if (!handle.getParam(file, values) || values.getType() != XmlRpc::XmlRpcValue::TypeStruct) {
    throw std::invalid_argument(handle.resolveName(file) + ": is missing");
  }
  std::vector<std::string> keys;
  for (const auto& [key, value] : values) keys.push_back(key);
  const std::string problem = checkKeys(file, keys);
  if (!problem.empty()) throw std::invalid_argument(handle.resolveName(file) + "/" + problem);
}

}  // namespace

GateParameters loadParameters(const ros::NodeHandle& handle) {
  refuseUnknown(handle, "safety");
  GateParameters parameters;
  for (const GateParameter& parameter : gateParameters()) {
    parameters.*parameter.value = number(handle, std::string(parameter.file) + "/" + parameter.key);
  }
  const std::string problem = parameters.check();
  if (problem.empty()) return parameters;
  const std::string key = problem.substr(0, problem.find(':'));
  for (const GateParameter& parameter : gateParameters()) {
    if (key == parameter.key) throw std::invalid_argument(handle.resolveName(parameter.file) + "/" + problem);
  }
  throw std::invalid_argument(problem);
}

std::vector<std::string> loadSources(const ros::NodeHandle& handle) {
  std::istringstream words(handle.param<std::string>("obstacle_sources", ""));
  return {std::istream_iterator<std::string>(words), {}};
}

}  // namespace seater_safety
