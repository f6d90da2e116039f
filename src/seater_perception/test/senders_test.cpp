#include "ros/inputs/senders.h"

#include <gtest/gtest.h>

using seater_perception::Senders;

namespace {

// What is said after messages of these nodes, one letter each and `period` [s] apart, and `later` [s] more.
std::string after(const std::string& names, double period, double later = 0.0) {
  Senders senders;
  double now = 0.0;
  for (const char name : names) senders.heard(std::string("/") + name, now += period);
  return senders.trouble("/camera/camera_info", now + later);
}

}  // namespace

TEST(Senders, TwoInTurnsAreNamedUntilOneHasGone) {
  for (const char* names : {"aaaaba", "bababa", "aaabbaaba"}) {
    EXPECT_EQ(after(names, 0.1), "2 nodes publish /camera/camera_info in turns, /b and /a: one is allowed") << names;
    EXPECT_EQ(after(names, 0.1, 2.1), "") << names;
  }
}

TEST(Senders, WhoTakesOverIsNoSecondOne) {
  for (const char* names : {"aaaa", "aaabbbb", "aaabbbccc"}) EXPECT_EQ(after(names, 0.1), "") << names;
  EXPECT_EQ(after("abbbba", 1.0), "");
}
