#include "ros/inputs/stamp_check.h"

#include <gtest/gtest.h>

#include <memory>

#include "ros/inputs/image_pairs.h"

using seater_perception::StampCheck;

namespace {

std::optional<std::string> after(int images, int infos, int pairs) {
  StampCheck check;
  for (int i = 0; i < images; ++i) check.image();
  for (int i = 0; i < infos; ++i) check.info();
  for (int i = 0; i < pairs; ++i) check.pair();
  return check.takeWarning("/camera/image_raw/compressed", "/camera/camera_info", 10.0);
}

struct Message {
  struct {
    int stamp;
  } header;
};
using Ptr = std::shared_ptr<const Message>;
using Pairs = seater_perception::ImagePairs<Ptr, Ptr>;

Ptr at(int stamp) {
  return std::make_shared<Message>(Message{{stamp}});
}

bool pairs(Pairs& pairs, int stamp) {
  pairs.image(at(stamp));
  const auto pair = pairs.info(at(stamp));
  return pair && pair->first->header.stamp == stamp && pair->second->header.stamp == stamp;
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

TEST(ImagePairs, eachImageFindsItsCameraInfoWhicheverComesFirst) {
  Pairs waiting;
  EXPECT_FALSE(waiting.image(at(1)));
  EXPECT_TRUE(waiting.info(at(1)));
  EXPECT_FALSE(waiting.info(at(2)));
  EXPECT_FALSE(waiting.info(at(3)));
  EXPECT_TRUE(waiting.image(at(2))) << "the next one came before";
  EXPECT_TRUE(waiting.image(at(3)));
  EXPECT_FALSE(waiting.image(at(3))) << "once";
}

TEST(ImagePairs, nothingOfTheFutureKeepsLaterImagesFromTheirs) {
  Pairs waiting;
  for (int stamp = 1000; stamp < 1010; ++stamp) waiting.image(at(stamp));
  for (int stamp = 2000; stamp < 2010; ++stamp) waiting.info(at(stamp));
  EXPECT_TRUE(pairs(waiting, 5));
  EXPECT_TRUE(pairs(waiting, 3000));
  EXPECT_TRUE(pairs(waiting, 6)) << "a clock that was set back";
}

TEST(ImagePairs, onlyTheLastFewWait) {
  Pairs waiting;
  for (int stamp = 1; stamp <= 5; ++stamp) waiting.image(at(stamp));
  EXPECT_FALSE(waiting.info(at(1)));
  EXPECT_TRUE(waiting.info(at(4)));
  EXPECT_TRUE(waiting.info(at(5)));
  waiting.image(at(6));
  waiting.clear();
  EXPECT_FALSE(waiting.info(at(6)));
}
