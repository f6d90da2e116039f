// Families by their name: OpenCV's predefined dictionaries, and the files of SEATER_MARKER_FAMILIES.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <opencv2/aruco.hpp>
#include <sstream>
#include <utility>

#include "seater_perception/errors.h"
#include "seater_perception/marker_family.h"

namespace seater_perception {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolders = "SEATER_MARKER_FAMILIES";
const std::string kPrefix = "DICT_";  // of OpenCV's names, which people leave out

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
    codes.push_back(std::move(code));
  }
  return MarkerFamily(name, std::move(codes), 1, dictionary->maxCorrectionBits);
}

bool isFamilyFile(const fs::path& path) {
  return path.extension() == ".yaml" || path.extension() == ".yml";
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
      if (isFamilyFile(entry.path())) here.push_back(entry.path());
    }
    std::sort(here.begin(), here.end());
    files.insert(files.end(), here.begin(), here.end());
  }
  return files;
}

}  // namespace

MarkerFamily MarkerFamily::named(const std::string& name, const std::string& key) {
  for (const auto& [known, number] : predefined()) {
    if (known == name || known == kPrefix + name) return fromOpenCv(known, number);
  }
  for (const fs::path& file : familyFiles()) {
    if (file.stem() == name || file.stem() == kPrefix + name) return load(file);
  }
  if (isFamilyFile(name)) return load(name);
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
