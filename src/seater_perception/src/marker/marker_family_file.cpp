// Families from files: the project's own format, and that of OpenCV's custom dictionaries.

#include <algorithm>
#include <array>
#include <bitset>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "seater_perception/errors.h"
#include "seater_perception/marker_family.h"
#include "seater_perception/strict_yaml.h"

namespace seater_perception {
namespace {

constexpr int kMostMarkers = 100000;

/// The code as one number, the print turned clockwise by `turn` quarters.
std::uint64_t packed(const MarkerCode& code, int turn) {
  const std::size_t n = code.size(), last = n - 1;
  std::uint64_t word = 0;
  for (std::size_t row = 0; row < n; ++row) {
    for (std::size_t column = 0; column < n; ++column) {
      const std::size_t r[] = {row, last - column, last - row, column};
      const std::size_t c[] = {column, row, last - column, last - row};
      word = 2 * word + (code[r[turn]][c[turn]] != 0 ? 1 : 0);
    }
  }
  return word;
}

/// Correction of k bits needs a distance of 2 k + 1 between any two codes in any orientation.
void requireDistance(const std::vector<MarkerCode>& codes, int correctable_bits, const std::string& family) {
  const auto least = static_cast<std::size_t>(2 * correctable_bits + 1);
  std::vector<std::array<std::uint64_t, 4>> turned;
  for (const MarkerCode& code : codes) {
    turned.push_back({packed(code, 0), packed(code, 1), packed(code, 2), packed(code, 3)});
  }
  for (std::size_t i = 0; i < codes.size(); ++i) {
    for (std::size_t j = i; j < codes.size(); ++j) {
      for (std::size_t turn = i == j ? 1 : 0; turn < 4; ++turn) {
        const std::size_t distance = std::bitset<64>(turned[i][0] ^ turned[j][turn]).count();
        if (distance >= least) continue;
        throw ConfigurationError(family + "/codes[" + std::to_string(i) + "]: differs from codes[" + std::to_string(j) +
                                 "], turned by " + std::to_string(90 * turn) + " degrees, by " +
                                 std::to_string(distance) + " bits, must differ by at least " + std::to_string(least) +
                                 " (" + std::to_string(correctable_bits) + " correctable)");
      }
    }
  }
}

/// Of one string with a character per bit, row by row from the top; spaces separate rows for the reader.
std::optional<MarkerCode> parseCode(const YAML::Node& node, int bits) {
  if (!node.IsScalar()) return std::nullopt;
  // Neither quotes nor spaces: for YAML, 010 is a number.
  if (node.Tag() != "!" && node.Scalar().find(' ') == std::string::npos) return std::nullopt;
  std::vector<int> values;
  for (const char c : node.Scalar()) {
    if (c == ' ') continue;
    if (c != '0' && c != '1') return std::nullopt;
    values.push_back(c - '0');
  }
  if (values.size() != static_cast<std::size_t>(bits * bits)) return std::nullopt;
  MarkerCode code;
  for (auto row = values.begin(); row != values.end(); row += bits) code.emplace_back(row, row + bits);
  return code;
}

/// What a file holds.
struct FamilyFile {
  int bits = 0, border = 1, correctable_bits = 0;
  std::vector<MarkerCode> codes;

  void add(StrictReader& reader, const std::string& key, const YAML::Node& node) {
    const auto code = parseCode(node, bits);
    if (code) codes.push_back(*code);
    if (!code) {
      reader.problem(key, node, "a text of " + std::to_string(bits * bits) + " bits, 0 or 1, in quotes or with spaces");
    }
  }
};

FamilyFile readOwn(StrictReader& reader) {
  FamilyFile file;
  reader.integer("bits", file.bits, "", MarkerFamily::kFewestBits, MarkerFamily::kMostBits, "bits along a side");
  reader.integer("border", file.border, "cells", 1, MarkerFamily::kWidestBorder, "width of the black border");
  reader.integer("correctable_bits", file.correctable_bits, "", 0, MarkerFamily::kMostBits * MarkerFamily::kMostBits,
                 "wrong bits that are mended");
  const YAML::Node list = reader.take("codes", "the codes in the order of their ids", "");
  for (std::size_t i = 0; list.IsDefined() && i < list.size(); ++i) {
    file.add(reader, "codes[" + std::to_string(i) + "]", list[i]);
  }
  return file;
}

/// cv::aruco::Dictionary::writeDictionary.
FamilyFile readOpenCv(StrictReader& reader) {
  FamilyFile file;
  int count = 0;
  reader.integer("nmarkers", count, "", 1, kMostMarkers, "number of markers");
  reader.integer("markersize", file.bits, "", MarkerFamily::kFewestBits, MarkerFamily::kMostBits, "bits along a side");
  reader.integer("maxCorrectionBits", file.correctable_bits, "", 0, MarkerFamily::kMostBits * MarkerFamily::kMostBits,
                 "wrong bits that are mended");
  for (int id = 0; id < count; ++id) {
    const std::string key = "marker_" + std::to_string(id);
    const YAML::Node node = reader.take(key.c_str(), "bits, row by row from the top", "");
    if (node.IsDefined()) file.add(reader, key, node);
  }
  return file;
}

}  // namespace

MarkerFamily MarkerFamily::load(const std::string& path) {
  const YAML::Node root = loadYamlFile(path);
  std::vector<std::string> problems;
  StrictReader reader(root, path, problems);
  const bool opencv = root.IsMap() && root["nmarkers"].IsDefined();
  const FamilyFile file = opencv ? readOpenCv(reader) : readOwn(reader);
  reader.refuseUnknown();
  throwProblems(problems, "wrong marker family:");
  try {
    const std::string name = std::filesystem::path(path).stem();
    const MarkerFamily family(name, file.codes, file.border, file.correctable_bits);
    requireDistance(file.codes, file.correctable_bits, name);
    return family;
  } catch (const ConfigurationError& error) {
    throw ConfigurationError(path + ": " + error.what());
  }
}

}  // namespace seater_perception
