#pragma once

#include <yaml-cpp/yaml.h>

#include <set>
#include <string>
#include <vector>

namespace seater_perception {

/// Reads one YAML mapping strictly: each key asked for has to be there, of the right type and within its range; every
/// other key is a problem. All problems are collected, each with the full key, the value and what is allowed.
///
/// Parameter structs describe themselves by a member template `visit(visitor)` that calls
/// `visitor.number(key, member, unit, low, high, meaning)` and so on for every field; defaults are the members'
/// initialisers.
class StrictReader {
 public:
  /// `prefix` names the mapping in messages ("~perception/pose").
  StrictReader(const YAML::Node& node, std::string prefix, std::vector<std::string>& problems);

  void number(const char* key, double& value, const char* unit, double low, double high, const char* meaning);
  void integer(const char* key, int& value, const char* unit, int low, int high, const char* meaning);
  void boolean(const char* key, bool& value, const char* meaning);
  void choice(const char* key, std::string& value, const std::vector<std::string>& allowed, const char* meaning);
  void text(const char* key, std::string& value, const char* meaning);
  void numbers(const char* key, std::vector<double>& values, std::size_t length, const char* unit, const char* meaning);

  /// A nested parameter struct.
  template <typename Struct>
  void group(const char* key, Struct& value, const char* meaning) {
    const YAML::Node child = take(key, meaning, "");
    if (!child.IsDefined()) return;
    StrictReader reader(child, full(key), problems_);
    value.visit(reader);
    reader.refuseUnknown();
  }

  /// The node of a key, or an undefined node after a missing key has been noted.
  YAML::Node take(const char* key, const char* meaning, const char* unit);
  /// Notes every key of the mapping that was not asked for.
  void refuseUnknown();
  std::string full(const std::string& key) const { return prefix_ + "/" + key; }
  void problem(const std::string& key, const YAML::Node& value, const std::string& allowed);

 private:
  YAML::Node node_;
  std::string prefix_;
  std::vector<std::string>& problems_;
  std::set<std::string> taken_;
};

/// A YAML file; also one that OpenCV's FileStorage has written, whose first line, "%YAML:1.0", is no YAML. Throws
/// ConfigurationError naming the file.
YAML::Node loadYamlFile(const std::string& path);

/// Throws ConfigurationError when there are problems; `what` is its first line.
void throwProblems(const std::vector<std::string>& problems, const std::string& what);

/// A finite plain number, false for anything else (quoted text, lists, nan).
bool readNumber(const YAML::Node& node, double& value);

/// Loads a self-describing parameter struct. Throws ConfigurationError.
template <typename Struct>
Struct loadStrict(const YAML::Node& node, const std::string& prefix) {
  Struct value;
  std::vector<std::string> problems;
  StrictReader reader(node, prefix, problems);
  value.visit(reader);
  reader.refuseUnknown();
  throwProblems(problems, "wrong parameters:");
  return value;
}

}  // namespace seater_perception
