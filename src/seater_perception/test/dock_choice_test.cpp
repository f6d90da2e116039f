// Which dock is looked for, without a ROS master.

#include "../src/ros/dock_choice.h"

#include <gtest/gtest.h>

#include <string>

#include "seater_perception/errors.h"

using namespace seater_perception;

namespace {

std::string dock(int id, double size) {
  return "dictionary: DICT_4X4_50\nname: read by others\nmarkers:\n- {id: " + std::to_string(id) +
         ", size: " + std::to_string(size) + ", position: [0.9, 0.0, 0.7], normal_yaw: 3.14}\n";
}

seater_msgs::DockInUse message(const std::string& name, const std::string& content, int revision = 0) {
  seater_msgs::DockInUse dock;
  dock.name = name;
  dock.source = name + ".yaml";
  dock.content = content;
  dock.revision = revision;
  return dock;
}

DockChoice lab() {
  return {loadDockLayout(YAML::Load(dock(3, 0.1)), "dock"), "lab"};
}

}  // namespace

TEST(DockChoiceTest, LooksForTheDockOfTheParametersFirst) {
  const DockChoice choice = lab();
  EXPECT_EQ(choice.name(), "lab");
  EXPECT_EQ(choice.revision(), 0u);
  EXPECT_EQ(choice.layout().markers.count(3), 1u);
}

TEST(DockChoiceTest, TheSameMarkersNeedNoNewDetector) {
  DockChoice choice = lab();
  EXPECT_FALSE(choice.take(message("lab", dock(3, 0.1))));
  EXPECT_FALSE(choice.take(message("other", dock(3, 0.1), 2)));
  EXPECT_EQ(choice.name(), "other");
  EXPECT_EQ(choice.revision(), 2u);
}

TEST(DockChoiceTest, FollowsToAnotherDock) {
  DockChoice choice = lab();
  EXPECT_TRUE(choice.take(message("hall", dock(7, 0.1))));
  EXPECT_EQ(choice.name(), "hall");
  EXPECT_EQ(choice.layout().markers.count(7), 1u);
  EXPECT_EQ(choice.layout().markers.count(3), 0u);
}

TEST(DockChoiceTest, FollowsWhenADockWasLoadedAnew) {
  DockChoice choice = lab();
  EXPECT_TRUE(choice.take(message("lab", dock(3, 0.2), 1)));
  EXPECT_EQ(choice.layout().markers.at(3).size, 0.2);
  EXPECT_EQ(choice.revision(), 1u);
}

TEST(DockChoiceTest, KeepsTheDockWhenTheNewOneCannotBeUsed) {
  DockChoice choice = lab();
  EXPECT_THROW(choice.take(message("hall", "{")), ConfigurationError);
  try {
    choice.take(message("hall", "dictionary: DICT_4X4_50"));
    FAIL();
  } catch (const ConfigurationError& error) {
    EXPECT_NE(std::string(error.what()).find("hall.yaml/markers"), std::string::npos) << error.what();
  }
  EXPECT_EQ(choice.name(), "lab");
  EXPECT_EQ(choice.layout().markers.count(3), 1u);
}
