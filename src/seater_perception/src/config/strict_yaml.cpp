#include "seater_perception/strict_yaml.h"

#include <cmath>
#include <fstream>
#include <sstream>

#include "seater_perception/errors.h"

namespace seater_perception {
namespace {

bool isQuoted(const YAML::Node& node) {
  return node.Tag() == "!";
}

std::string shown(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return "empty";
  if (node.IsScalar()) return isQuoted(node) ? '"' + node.Scalar() + '"' : node.Scalar();
  YAML::Emitter emitter;
  emitter << YAML::Flow << node;
  return emitter.c_str();
}

}  // namespace

bool readNumber(const YAML::Node& node, double& value) {
  if (!node.IsScalar() || isQuoted(node)) return false;
  return YAML::convert<double>::decode(node, value) && std::isfinite(value);
}

YAML::Node loadYamlFile(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw ConfigurationError(path + ": cannot be read");
  std::string content = text.str();
  if (content.rfind("%YAML:", 0) == 0) content.erase(0, content.find('\n'));
  try {
    return YAML::Load(content);
  } catch (const YAML::Exception& error) {
    throw ConfigurationError(path + ": cannot be read as YAML: " + error.what());
  }
}

void throwProblems(const std::vector<std::string>& problems, const std::string& what) {
  if (problems.empty()) return;
  std::string text = what;
  for (const std::string& problem : problems) text += "\n  " + problem;
  throw ConfigurationError(text);
}

StrictReader::StrictReader(const YAML::Node& node, std::string prefix, std::vector<std::string>& problems)
    : node_(node), prefix_(std::move(prefix)), problems_(problems) {
  if (node_.IsDefined() && node_.IsMap()) return;
  problems_.push_back(prefix_ + ": is " + shown(node_) + ", must be a mapping");
}

YAML::Node StrictReader::take(const char* key, const char* meaning, const char* unit) {
  taken_.insert(key);
  if (!node_.IsDefined() || !node_.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
  const YAML::Node child = static_cast<const YAML::Node&>(node_)[key];
  if (child.IsDefined()) return child;
  problems_.push_back(full(key) + ": is missing (" + meaning + (*unit ? std::string(" [") + unit + "]" : "") + ")");
  return YAML::Node(YAML::NodeType::Undefined);
}

void StrictReader::problem(const std::string& key, const YAML::Node& value, const std::string& allowed) {
  problems_.push_back(full(key) + ": is " + shown(value) + ", must be " + allowed);
}

void StrictReader::number(const char* key, double& value, const char* unit, double low, double high,
                          const char* meaning) {
  const YAML::Node child = take(key, meaning, unit);
  if (!child.IsDefined()) return;
  double read = 0.0;
  if (readNumber(child, read) && read >= low && read <= high) {
    value = read;
    return;
  }
  std::ostringstream allowed;
  allowed << "a number from " << low << " to " << high << (*unit ? std::string(" [") + unit + "]" : "");
  problem(key, child, allowed.str());
}

void StrictReader::integer(const char* key, int& value, const char* unit, int low, int high, const char* meaning) {
  const YAML::Node child = take(key, meaning, unit);
  if (!child.IsDefined()) return;
  int read = 0;
  if (child.IsScalar() && !isQuoted(child) && YAML::convert<int>::decode(child, read) && read >= low && read <= high) {
    value = read;
    return;
  }
  std::ostringstream allowed;
  allowed << "a whole number from " << low << " to " << high << (*unit ? std::string(" [") + unit + "]" : "");
  problem(key, child, allowed.str());
}

void StrictReader::boolean(const char* key, bool& value, const char* meaning) {
  const YAML::Node child = take(key, meaning, "");
  if (!child.IsDefined()) return;
  const bool plain = child.IsScalar() && !isQuoted(child);
  if (plain && (child.Scalar() == "true" || child.Scalar() == "false")) {
    value = child.Scalar() == "true";
  } else {
    problem(key, child, "true or false");
  }
}

void StrictReader::choice(const char* key, std::string& value, const std::vector<std::string>& allowed,
                          const char* meaning) {
  const YAML::Node child = take(key, meaning, "");
  if (!child.IsDefined()) return;
  std::string list;
  for (const std::string& option : allowed) {
    if (child.IsScalar() && child.Scalar() == option) {
      value = option;
      return;
    }
    list += (list.empty() ? "" : ", ") + option;
  }
  problem(key, child, "one of " + list);
}

void StrictReader::text(const char* key, std::string& value, const char* meaning) {
  const YAML::Node child = take(key, meaning, "");
  if (!child.IsDefined()) return;
  if (child.IsScalar() && !child.Scalar().empty()) {
    value = child.Scalar();
  } else {
    problem(key, child, "a text");
  }
}

void StrictReader::numbers(const char* key, std::vector<double>& values, std::size_t length, const char* unit,
                           const char* meaning) {
  const YAML::Node child = take(key, meaning, unit);
  if (!child.IsDefined()) return;
  std::vector<double> read(length);
  bool good = child.IsSequence() && child.size() == length;
  for (std::size_t i = 0; good && i < length; ++i) good = readNumber(child[i], read[i]);
  if (good) {
    values = read;
  } else {
    problem(key, child, "a list of " + std::to_string(length) + " finite numbers");
  }
}

void StrictReader::refuseUnknown() {
  if (!node_.IsDefined() || !node_.IsMap()) return;
  std::string known;
  for (const std::string& key : taken_) known += (known.empty() ? "" : ", ") + key;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : shown(entry.first);
    if (!taken_.count(key)) problems_.push_back(full(key) + ": unknown key; known are " + known);
  }
}

}  // namespace seater_perception
