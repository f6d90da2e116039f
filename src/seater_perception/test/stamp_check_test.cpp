#include "ros/stamp_check.h"

#include <gtest/gtest.h>

using seater_perception::StampCheck;

namespace {

std::optional<std::string> after(int images, int infos, int pairs) {
  StampCheck check;
  for (int i = 0; i < images; ++i) check.image();
  for (int i = 0; i < infos; ++i) check.info();
  for (int i = 0; i < pairs; ++i) check.pair();
  return check.takeWarning("/camera/image_raw/compressed", "/camera/camera_info", 10.0);
}

}  // namespace

TEST(StampCheck, warnsOfStampsThatDoNotFit) {
  const auto text = after(300, 299, 0);
  ASSERT_TRUE(text);
  for (const char* part : {"'/camera/image_raw/compressed' and '/camera/camera_info'", "last 10s", "received: 300",
                           "received: 299", "stamp: 0"}) {
    EXPECT_NE(text->find(part), std::string::npos) << *text;
  }
  EXPECT_TRUE(after(300, 0, 0)) << "no camera_info at all";
  EXPECT_TRUE(after(300, 30, 30)) << "one in ten";
}

TEST(StampCheck, isSilentWhenTheyFit) {
  EXPECT_FALSE(after(300, 300, 298));
  EXPECT_FALSE(after(0, 0, 0));
}

TEST(StampCheck, countsAnewAfterEachCall) {
  StampCheck check;
  check.image();
  EXPECT_TRUE(check.takeWarning("a", "b", 10.0));
  EXPECT_FALSE(check.takeWarning("a", "b", 10.0));
}
