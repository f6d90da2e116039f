#include <gtest/gtest.h>

#include "scene.h"
#include "seater_perception/errors.h"

using namespace seater_perception;

namespace {

/// What a loader complains about; empty when it is content.
template <typename Loader>
std::string complaint(const Loader& load) {
  try {
    load();
  } catch (const ConfigurationError& error) {
    return error.what();
  }
  return "";
}

void expectParts(const std::string& text, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " not in\n" << text;
}

YAML::Node perceptionFile() {
  return YAML::LoadFile(SEATER_CONFIG_DIR "/perception.yaml");
}
YAML::Node dockFile() {
  return YAML::LoadFile(SEATER_CONFIG_DIR "/docks/default.yaml");
}

/// Every number of a parameter tree, in visiting order.
struct Flatten {
  std::vector<double> values;
  std::string text;
  void number(const char*, double& v, const char*, double low, double high, const char*) {
    values.push_back(v);
    EXPECT_GE(v, low);
    EXPECT_LE(v, high);
  }
  void integer(const char*, int& v, const char*, int low, int high, const char*) {
    values.push_back(v);
    EXPECT_GE(v, low);
    EXPECT_LE(v, high);
  }
  void boolean(const char*, bool& v, const char*) { values.push_back(v); }
  void choice(const char*, std::string& v, const std::vector<std::string>&, const char*) { text += v; }
  template <typename Struct>
  void group(const char*, Struct& value, const char*) {
    value.visit(*this);
  }
};

}  // namespace

TEST(Parameters, fileHoldsTheDefaults) {
  PerceptionParameters loaded = loadPerceptionParameters(perceptionFile(), "~perception"), built_in;
  Flatten a, b;
  loaded.visit(a);
  built_in.visit(b);
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(a.text, b.text);
  EXPECT_EQ(a.values.size(), 45u);
}

TEST(Parameters, everyProblemIsNamedAtOnce) {
  YAML::Node node = perceptionFile();
  node["selection"] = "best";
  node["detector"]["min_side"] = -3.0;
  node["detector"]["corner_window_min"] = 2.5;
  node["detector"]["edge_fit"] = "maybe";
  node["pose"].remove("corner_sigma");
  node["pose"]["conrer_sigma"] = 0.1;
  node["pose"]["tilt_sigma"] = ".nan";
  node["diagnostics"] = 3;
  const std::string text = complaint([&] { loadPerceptionParameters(node, "~perception"); });
  expectParts(text, {"~perception/selection: is best, must be one of bundle, lowest_id",
                     "~perception/detector/min_side: is -3, must be a number from 5 to 500 [px]",
                     "~perception/detector/corner_window_min: is 2.5, must be a whole number",
                     "~perception/detector/edge_fit: is maybe, must be true or false",
                     "~perception/pose/corner_sigma: is missing (standard deviation of a corner coordinate [px])",
                     "~perception/pose/conrer_sigma: unknown key", "~perception/pose/tilt_sigma: is .nan",
                     "~perception/diagnostics: is 3, must be a mapping"});
}

TEST(Parameters, quotedNumberIsText) {
  YAML::Node node = perceptionFile();
  node["pose"]["tilt_sigma"] = YAML::Load("\"0.1\"");
  expectParts(complaint([&] { loadPerceptionParameters(node, "p"); }), {"p/pose/tilt_sigma: is \"0.1\""});
}

TEST(Parameters, windowsMustBeOrdered) {
  YAML::Node node = perceptionFile();
  node["detector"]["threshold_window_min"] = 51;
  expectParts(complaint([&] { loadPerceptionParameters(node, "p"); }), {"p/detector/threshold_window_min: is 51"});
}

TEST(Parameters, missingTreeIsNamed) {
  expectParts(complaint([&] { loadPerceptionParameters(YAML::Node(YAML::NodeType::Undefined), "~perception"); }),
              {"~perception: is empty, must be a mapping"});
  expectParts(complaint([&] { loadDockLayout(YAML::Node(YAML::NodeType::Undefined), "~dock"); }), {"~dock"});
}

TEST(CameraMount, upFollowsPitchAndRoll) {
  CameraMount mount;
  EXPECT_LT((mount.upInOptical() - Eigen::Vector3d(0, -1, 0)).norm(), 1e-12);
  mount.yaw = 0.7;
  EXPECT_LT((mount.upInOptical() - Eigen::Vector3d(0, -1, 0)).norm(), 1e-12);
  mount.yaw = 0.0;
  mount.pitch = 0.2;  // looks down: up leans towards the scene's far side, away from it
  EXPECT_LT((mount.upInOptical() - Eigen::Vector3d(0, -std::cos(0.2), -std::sin(0.2))).norm(), 1e-12);
  mount.pitch = 0.0;
  mount.roll = 0.3;  // about the viewing axis, right side down: up leans to the image's left
  EXPECT_LT((mount.upInOptical() - Eigen::Vector3d(-std::sin(0.3), -std::cos(0.3), 0)).norm(), 1e-12);
}

TEST(DockLayout, readsTheDefaultDock) {
  const DockLayout layout = loadDockLayout(dockFile(), "~dock");
  EXPECT_EQ(layout.family.name(), "DICT_4X4_50");
  ASSERT_EQ(layout.markers.size(), 3u);
  EXPECT_EQ(layout.sizeOf(0), 0.1);
  EXPECT_FALSE(layout.sizeOf(7));
  // Print of marker 1, on the wall and looking at the arriving chair: its right is the dock's right, its up the dock's
  // up.
  const Eigen::Isometry3d T = layout.markers.at(1).T_dock_marker();
  Eigen::Matrix4d expected;
  expected << 0, 0, -1, 0.9, -1, 0, 0, 0.35, 0, 1, 0, 0.7, 0, 0, 0, 1;
  EXPECT_LT((T.matrix() - expected).norm(), 1e-9);
}

TEST(DockLayout, strictOnItsOwnKeysOnly) {
  YAML::Node node = dockFile();
  node["something_of_others"] = 5;
  EXPECT_EQ(complaint([&] { loadDockLayout(node, "~dock"); }), "");
  node["dictionary"] = "DICT_9X9";
  node["markers"][0]["szie"] = 0.1;
  node["markers"][1].remove("position");
  node["markers"][2]["id"] = -1;
  expectParts(complaint([&] { loadDockLayout(node, "~dock"); }),
              {"~dock/dictionary: is DICT_9X9, must be one of DICT_4X4_50", "~dock/markers[0]/szie: unknown key",
               "~dock/markers[1]/position: is missing", "~dock/markers[2]/id: is -1"});
  node = dockFile();
  node["markers"][2]["id"] = 1;
  expectParts(complaint([&] { loadDockLayout(node, "~dock"); }), {"~dock/markers[2]/id: is 1, must differ"});
  node["markers"][2]["id"] = 50;
  expectParts(complaint([&] { loadDockLayout(node, "~dock"); }), {"~dock/markers[2]/id: is 50", "from 0 to 49"});
}

TEST(Images, badOnesAreRefusedWithAReason) {
  DockDetector detector(CameraModel::raw(scene::calibration()), scene::defaultDock(), PerceptionParameters(),
                        CameraMount());
  const auto reason = [&](const cv::Mat& image) -> std::string {
    try {
      detector.detect(image);
    } catch (const ImageError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(reason(cv::Mat()).find("empty"), std::string::npos);
  EXPECT_NE(reason(cv::Mat(720, 1280, CV_8UC3)).find("CV_8UC3"), std::string::npos);
  const cv::Mat nan(720, 1280, CV_32F, cv::Scalar(std::nan("")));
  EXPECT_NE(reason(nan).find("CV_32FC1"), std::string::npos);
  EXPECT_NE(reason(cv::Mat::zeros(720, 640, CV_8U)).find("640 x 720"), std::string::npos);
  EXPECT_EQ(reason(cv::Mat::zeros(720, 1280, CV_8U)), "");
}
