#pragma once

#include <optional>
#include <string>

namespace seater_perception {

/// Whether images find their camera_info: both are taken together when their stamps are equal, and otherwise nothing
/// happens, which nobody notices. The same rule and text as image_transport's.
class StampCheck {
 public:
  void image() { ++images_; }
  void info() { ++infos_; }
  void pair() { ++pairs_; }

  /// What is to be said of the messages since the last call; nothing when they fit. Of these topics.
  std::optional<std::string> takeWarning(const std::string& image_topic, const std::string& info_topic,
                                         double seconds) {
    const bool apart = images_ > 3 * pairs_ || infos_ > 3 * pairs_;
    std::optional<std::string> text;
    if (apart) {
      text = "Topics '" + image_topic + "' and '" + info_topic + "' do not appear to be synchronized. In the last " +
             std::to_string(static_cast<int>(seconds)) + "s: images received: " + std::to_string(images_) +
             ", CameraInfo messages received: " + std::to_string(infos_) +
             ", pairs of the same stamp: " + std::to_string(pairs_);
    }
    images_ = infos_ = pairs_ = 0;
    return text;
  }

 private:
  int images_ = 0, infos_ = 0, pairs_ = 0;
};

}  // namespace seater_perception
