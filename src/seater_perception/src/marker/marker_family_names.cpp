// Families by their name: OpenCV's predefined dictionaries, and the files of SEATER_MARKER_FAMILIES.

#include <algorithm>
#include <array>
#include <bitset>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <opencv2/aruco.hpp>
#include <optional>
#include <sstream>

#include "seater_perception/errors.h"
#include "seater_perception/marker_family.h"
#include "seater_perception/strict_yaml.h"

namespace seater_perception {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolders = "SEATER_MARKER_FAMILIES";
constexpr const char* kExtension = ".yaml";

const std::vector<std::pair<std::string, int>>& predefined() {
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

MarkerFamily fromOpenCv(const std::string& name, int number) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(number);
  std::vector<MarkerCode> codes;
  for (int id = 0; id < dictionary->bytesList.rows; ++id) {
    const cv::Mat bits =
        cv::aruco::Dictionary::getBitsFromByteList(dictionary->bytesList.row(id), dictionary->markerSize);
    MarkerCode code;
    for (int row = 0; row < bits.rows; ++row) code.emplace_back(bits.ptr<uchar>(row), bits.ptr<uchar>(row) + bits.cols);
    codes.push_back(code);
  }
  return MarkerFamily(name, codes, 1, dictionary->maxCorrectionBits);
}

/// All family files in the order of the folders, by name within each.
std::vector<fs::path> familyFiles() {
  std::vector<fs::path> files;
  const char* folders = std::getenv(kFolders);
  std::istringstream list(folders ? folders : "");
  for (std::string folder; std::getline(list, folder, ':');) {
    std::vector<fs::path> here;
    std::error_code missing;  // a folder that is not there has no files
    for (const auto& entry : fs::directory_iterator(folder, missing)) {
      if (entry.path().extension() == kExtension) here.push_back(entry.path());
    }
    std::sort(here.begin(), here.end());
    files.insert(files.end(), here.begin(), here.end());
  }
  return files;
}

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

}  // namespace

MarkerFamily MarkerFamily::load(const std::string& path) {
  YAML::Node file;
  try {
    file = YAML::LoadFile(path);
  } catch (const YAML::Exception& error) {
    throw ConfigurationError(path + ": cannot be read as YAML: " + error.what());
  }
  std::vector<std::string> problems;
  StrictReader reader(file, path, problems);
  int bits = 0, border = 1, correctable_bits = 0;
  reader.integer("bits", bits, "", kFewestBits, kMostBits, "bits along a side");
  reader.integer("border", border, "cells", 1, kWidestBorder, "width of the black border");
  reader.integer("correctable_bits", correctable_bits, "", 0, kMostBits * kMostBits, "wrong bits that are mended");
  const YAML::Node list = reader.take("codes", "the codes in the order of their ids", "");
  reader.refuseUnknown();
  std::vector<MarkerCode> codes;
  for (std::size_t i = 0; list.IsDefined() && i < list.size(); ++i) {
    const auto code = parseCode(list[i], bits);
    if (code) codes.push_back(*code);
    if (!code) {
      reader.problem("codes[" + std::to_string(i) + "]", list[i],
                     "a text of " + std::to_string(bits * bits) + " bits, 0 or 1, in quotes or with spaces");
    }
  }
  throwProblems(problems, "wrong marker family:");
  try {
    const std::string name = fs::path(path).stem();
    const MarkerFamily family(name, codes, border, correctable_bits);
    requireDistance(codes, correctable_bits, name);
    return family;
  } catch (const ConfigurationError& error) {
    throw ConfigurationError(path + ": " + error.what());
  }
}

MarkerFamily MarkerFamily::named(const std::string& name, const std::string& key) {
  for (const auto& [known, number] : predefined()) {
    if (known == name) return fromOpenCv(name, number);
  }
  for (const fs::path& file : familyFiles()) {
    if (file.stem() == name) return load(file);
  }
  std::string allowed;
  for (const std::string& known : names()) allowed += (allowed.empty() ? "" : ", ") + known;
  throw ConfigurationError(key + ": is '" + name + "', must be one of " + allowed + " (files of " + kFolders + ")");
}

std::vector<std::string> MarkerFamily::names() {
  std::vector<std::string> names;
  for (const auto& entry : predefined()) names.push_back(entry.first);
  for (const fs::path& file : familyFiles()) names.push_back(file.stem());
  return names;
}

}  // namespace seater_perception
