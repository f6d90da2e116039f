#include "seater_safety/speed_history.h"

#include <algorithm>

namespace seater_safety {

void SpeedHistory::add(double time, const Velocity& velocity) {
  entries_.push_back({time, velocity});
  while (entries_.size() > 1 && entries_[1].time <= time - span_) entries_.pop_front();
}

Velocity SpeedHistory::at(double time) const {
  const auto after = std::upper_bound(entries_.begin(), entries_.end(), time,
                                      [](double value, const Entry& entry) { return value < entry.time; });
  return after == entries_.begin() ? Velocity{} : std::prev(after)->velocity;
}

SpeedHistory::Range SpeedHistory::range(double since, double Velocity::*of) const {
  if (entries_.empty()) return {0.0, 0.0};
  Range range{entries_.back().velocity.*of, entries_.back().velocity.*of};
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    range = {std::min(range.least, entry->velocity.*of), std::max(range.most, entry->velocity.*of)};
    if (entry->time <= since) break;
  }
  return range;
}

}  // namespace seater_safety
