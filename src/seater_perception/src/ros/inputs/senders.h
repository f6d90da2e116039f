#pragma once

#include <optional>
#include <string>

namespace seater_perception {

/// Whether two nodes send on a topic in turns: images of two cameras are none of one. As seater_common's senders.py: a
/// node that takes over from one that has ended is none of the two.
class Senders {
 public:
  /// A message came at `now` [s] of a clock that nobody can set.
  void heard(const std::string& sender, double now) {
    if (last_ && last_->name != sender) {
      if (before_ && before_->name == sender && now - before_->time <= kMemory)
        together_ = Together{last_->name, sender, now};
      before_ = last_;
    }
    last_ = Sent{sender, now};
  }

  /// Empty, or that they do, in words.
  std::string trouble(const std::string& topic, double now) const {
    if (!together_ || now - together_->time > kMemory) return {};
    return "2 nodes publish " + topic + " in turns, " + together_->one + " and " + together_->other +
           ": one is allowed";
  }

 private:
  static constexpr double kMemory = 2.0;  // [s]

  struct Sent {
    std::string name;
    double time;
  };
  struct Together {
    std::string one, other;
    double time;
  };

  std::optional<Sent> last_, before_;  // the newest message, and the newest of another sender
  std::optional<Together> together_;
};

}  // namespace seater_perception
