// Marker families: OpenCV's as OpenCV draws them; one of three by three bits from a file is found like any other.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "scene.h"
#include "search/marker_detector.h"
#include "seater_perception/dock_detector.h"
#include "seater_perception/errors.h"

using namespace seater_perception;

namespace {

const char* const kSmallFamily = R"(
bits: 3
border: 1
correctable_bits: 0
codes:
  - "110 010 001"
  - "101 100 110"
)";

/// A folder with one family file, and SEATER_MARKER_FAMILIES set to it.
class FamilyFolder : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / "seater_marker_families";
    std::filesystem::create_directories(folder_);
    setenv("SEATER_MARKER_FAMILIES", ("/does/not/exist:" + folder_.string()).c_str(), 1);
  }
  void TearDown() override {
    unsetenv("SEATER_MARKER_FAMILIES");
    std::filesystem::remove_all(folder_);
  }
  std::string write(const std::string& text) const {
    const std::string path = folder_ / "small.yaml";
    std::ofstream(path) << text;
    return path;
  }
  /// What loading this text says.
  std::string complaint(const std::string& text) const {
    try {
      MarkerFamily::load(write(text));
    } catch (const ConfigurationError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  return text.replace(text.find(what), what.size(), by);
}

/// Prints of ids 0 and 1, side by side.
std::vector<scene::Print> twoPrints() {
  return {{0, 0.1, scene::upright({-0.15, 0.0, 0.8}, 0.3)}, {1, 0.1, scene::upright({0.15, 0.0, 0.9}, -0.2, 0.0, 0.5)}};
}

void expectFound(const MarkerFamily& family, const PerceptionParameters& parameters) {
  const Calibration c = scene::calibration();
  DockDetector detector(CameraModel::raw(c), layoutOfEqualMarkers(family, 0.1), parameters, CameraMount());
  const auto result = detector.detect(scene::draw(c, family, twoPrints(), scene::Look(), 1));
  ASSERT_EQ(result.markers.size(), 2u) << parameters.detector.search;
  for (std::size_t i = 0; i < 2; ++i) {
    const scene::Print print = twoPrints()[i];
    EXPECT_EQ(result.markers[i].id, print.id);
    const auto truth = scene::trueCorners(c, print);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_LT((result.markers[i].corners[k] - truth[k]).norm(), 0.3) << parameters.detector.search;
    }
  }
}

}  // namespace

TEST(MarkerFamily, isWhatOpenCvDraws) {
  using namespace cv::aruco;
  for (const auto& [name, number] : {std::make_pair("DICT_4X4_50", DICT_4X4_50),
                                     {"DICT_7X7_1000", DICT_7X7_1000},
                                     {"DICT_ARUCO_ORIGINAL", DICT_ARUCO_ORIGINAL},
                                     {"DICT_APRILTAG_36h11", DICT_APRILTAG_36h11}}) {
    const MarkerFamily family = MarkerFamily::named(name);
    const auto dictionary = getPredefinedDictionary(number);
    ASSERT_EQ(family.count(), dictionary->bytesList.rows) << name;
    EXPECT_EQ(family.correctableBits(), dictionary->maxCorrectionBits) << name;
    EXPECT_EQ(family.cells(), dictionary->markerSize + 2) << name;
    for (int id = 0; id < family.count(); id += 7) {
      cv::Mat drawn;
      dictionary->drawMarker(id, family.cells(), drawn, 1);
      EXPECT_EQ(cv::norm(scene::cellsOf(family.pattern(id)), drawn, cv::NORM_L1), 0.0) << name << " " << id;
    }
  }
}

TEST(MarkerFamily, everyNameOfOpenCvIsOne) {
  for (const std::string& name : MarkerFamily::names()) EXPECT_GT(MarkerFamily::named(name).count(), 0) << name;
}

TEST(MarkerFamily, anUnknownNameOrIdIsRefused) {
  EXPECT_THROW(MarkerFamily::named("DICT_4"), ConfigurationError);
  EXPECT_THROW(MarkerFamily::named("DICT_4X4_50").pattern(50), ConfigurationError);
  EXPECT_THROW(MarkerFamily::named("DICT_4X4_50").pattern(-1), ConfigurationError);
  EXPECT_THROW(MarkerDetector(MarkerFamily(), DetectorParameters()), ConfigurationError);
}

TEST_F(FamilyFolder, aFileIsFoundByItsName) {
  write(kSmallFamily);
  const MarkerFamily family = MarkerFamily::named("small");
  EXPECT_EQ(family.name(), "small");
  EXPECT_EQ(family.count(), 2);
  EXPECT_EQ(family.cells(), 5);
  EXPECT_EQ(family.code(1), (MarkerCode{{1, 0, 1}, {1, 0, 0}, {1, 1, 0}}));
  EXPECT_EQ(MarkerFamily::names().back(), "small");
  YAML::Node dock =
      YAML::Load("{dictionary: small, markers: [{id: 2, size: 0.1, position: [0, 0, 0], normal_yaw: 0}]}");
  try {
    loadDockLayout(dock, "dock");
    FAIL() << "there are ids 0 and 1 only";
  } catch (const ConfigurationError& error) {
    EXPECT_NE(std::string(error.what()).find("dock/markers[0]/id: is 2"), std::string::npos) << error.what();
  }
  dock["markers"][0]["id"] = 1;
  EXPECT_EQ(loadDockLayout(dock, "dock").family.name(), "small");
}

TEST_F(FamilyFolder, aDictionaryOfOpenCvIsRead) {
  const auto drawn = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_50);
  const std::string path = folder_ / "custom.yml";
  {
    cv::FileStorage file(path, cv::FileStorage::WRITE);
    file << "nmarkers" << 50 << "markersize" << 5 << "maxCorrectionBits" << 3;
    for (int id = 0; id < 50; ++id) {
      const cv::Mat bits = cv::aruco::Dictionary::getBitsFromByteList(drawn->bytesList.row(id), 5);
      std::string text;
      for (const uchar bit : cv::Mat_<uchar>(bits)) text += bit ? '1' : '0';
      file << "marker_" + std::to_string(id) << text;
    }
  }
  const MarkerFamily predefined = MarkerFamily::named("5X5_50");
  EXPECT_EQ(predefined.name(), "DICT_5X5_50");
  for (const MarkerFamily& family : {MarkerFamily::named("custom"), MarkerFamily::named(path)}) {
    EXPECT_EQ(family.name(), "custom");
    EXPECT_EQ(family.correctableBits(), 3);
    ASSERT_EQ(family.count(), 50);
    for (int id = 0; id < 50; ++id) EXPECT_EQ(family.code(id), predefined.code(id)) << id;
  }
  std::ofstream(path) << "nmarkers: 2\nmarkersize: 3\nmaxCorrectionBits: 0\nmarker_0: '110010001'\n";
  try {
    MarkerFamily::named("custom");
    FAIL();
  } catch (const ConfigurationError& error) {
    EXPECT_NE(std::string(error.what()).find("custom.yml/marker_1: is missing"), std::string::npos) << error.what();
  }
}

// config/marker_families, against what is published of it: 250 codes that differ by 12 bits.
TEST(MarkerFamily, recommendedFamilyOfAruco) {
  setenv("SEATER_MARKER_FAMILIES", SEATER_CONFIG_DIR "/marker_families", 1);
  const MarkerFamily family = MarkerFamily::named("ARUCO_MIP_36h12");
  unsetenv("SEATER_MARKER_FAMILIES");
  EXPECT_EQ(family.name(), "DICT_ARUCO_MIP_36h12");
  EXPECT_EQ(family.count(), 250);
  EXPECT_EQ(family.bits(), 6);
  EXPECT_EQ(family.correctableBits(), 5);  // load has checked that they differ by 11 or more
  expectFound(family, PerceptionParameters());
}

TEST_F(FamilyFolder, aFamilyOfAFileIsDetected) {
  PerceptionParameters parameters;
  for (const char* search : {"own", "opencv"}) {
    parameters.detector.search = search;
    expectFound(MarkerFamily::load(write(kSmallFamily)), parameters);
    expectFound(MarkerFamily::load(write(replaced(kSmallFamily, "border: 1", "border: 2"))), parameters);
  }
}

TEST_F(FamilyFolder, aWrongFileSaysWhatIsWrong) {
  const std::string good = kSmallFamily;
  const std::pair<std::string, std::string> cases[] = {
      {replaced(good, "bits: 3", "bits: 9"), "small.yaml/bits: is 9"},
      {replaced(good, "border: 1\n", ""), "small.yaml/border: is missing"},
      {good + "colour: red\n", "small.yaml/colour: unknown key"},
      {replaced(good, "\"110 010 001\"", "110010001"), "small.yaml/codes[0]: is 110010001, must be a text"},
      {replaced(good, "110 010 001", "110 010 00"), "codes[0]: is \"110 010 00\", must be a text of 9 bits"},
      {replaced(good, "110 010 001", "110 010 002"), "codes[0]"},
      {replaced(good, "110 010 001", "101 010 101"),
       "codes[0]: differs from codes[0], turned by 90 degrees, by 0 bits"},
      {replaced(good, "110 010 001", "111 100 001"), "codes[0]: differs from codes[1], turned by 90 degrees, by 0"},
      {replaced(good, "correctable_bits: 0", "correctable_bits: 3"), "must differ by at least 7"},
      {"codes: [", "cannot be read as YAML"},
  };
  for (const auto& [text, expected] : cases) {
    EXPECT_NE(complaint(text).find(expected), std::string::npos) << complaint(text) << "\nexpected: " << expected;
  }
  EXPECT_THROW(MarkerFamily("none", {}, 1, 0), ConfigurationError);
  EXPECT_THROW(MarkerFamily("ragged", {{{1, 0, 1}, {1, 0}, {0, 0, 0}}}, 1, 0), ConfigurationError);
}
