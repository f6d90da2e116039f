#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

namespace seater_perception {

/// Finds each image its camera_info: that of the same stamp, whichever comes first. The last few of both that came wait
/// for each other. (message_filters' synchroniser keeps those of the latest stamps: one image or camera_info of the
/// future that has no partner, or a clock that is set back, and no later image finds its own any more.)
///
/// `ImagePtr`, `InfoPtr`: pointers to ROS messages with a header.
template <typename ImagePtr, typename InfoPtr>
class ImagePairs {
 public:
  using Pair = std::pair<ImagePtr, InfoPtr>;

  /// An image came: with its camera_info when that is here.
  std::optional<Pair> image(const ImagePtr& image) {
    const InfoPtr info = match(image, images_, infos_);
    return info ? std::optional<Pair>({image, info}) : std::nullopt;
  }

  /// The same for a camera_info.
  std::optional<Pair> info(const InfoPtr& info) {
    const ImagePtr image = match(info, infos_, images_);
    return image ? std::optional<Pair>({image, info}) : std::nullopt;
  }

  /// What waits is forgotten.
  void clear() {
    images_.clear();
    infos_.clear();
  }

 private:
  static constexpr std::size_t kWaiting = 3;

  /// The partner of what came, or nothing; what came before either of them waits no longer.
  template <typename Came, typename Partner>
  static Partner match(const Came& came, std::deque<Came>& same, std::deque<Partner>& others) {
    const auto found = std::find_if(others.begin(), others.end(),
                                    [&](const Partner& other) { return other->header.stamp == came->header.stamp; });
    if (found != others.end()) {
      const Partner partner = *found;
      others.erase(others.begin(), found + 1);
      same.clear();
      return partner;
    }
    same.push_back(came);
    if (same.size() > kWaiting) same.pop_front();
    return {};
  }

  std::deque<ImagePtr> images_;
  std::deque<InfoPtr> infos_;
};

}  // namespace seater_perception
