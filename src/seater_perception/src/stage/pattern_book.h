#pragma once

#include <map>

#include "seater_perception/marker_family.h"
#include "seater_perception/photometric.h"

namespace seater_perception {

/// The patterns of a family, made once per id.
class PatternBook {
 public:
  explicit PatternBook(const MarkerFamily& family) : family_(family) {}

  const MarkerPattern& of(int id) {
    const auto known = patterns_.find(id);
    if (known != patterns_.end()) return known->second;
    return patterns_.emplace(id, family_.pattern(id)).first->second;
  }

 private:
  MarkerFamily family_;
  std::map<int, MarkerPattern> patterns_;
};

}  // namespace seater_perception
