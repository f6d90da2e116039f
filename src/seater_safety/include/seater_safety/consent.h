// Whose requests may pass, and why the last consent ended. No ROS.
//
// A consent is given for one goal and ends once. What ended it stays until the next one is given: this is the latch.
#pragma once

#include <string>

#include "seater_safety/gate_state.h"

namespace seater_safety {

class Consent {
 public:
  void give(const std::string& holder);
  // Without effect when none is held. `cause` kStopped: it ended as it should.
  void end(GateState cause, const std::string& reason);

  bool held() const { return held_; }
  bool heldBy(const std::string& name) const { return held_ && name == holder_; }
  const std::string& holder() const { return holder_; }
  GateState endedBy() const { return ended_by_; }
  const std::string& reason() const { return reason_; }

 private:
  bool held_ = false;
  std::string holder_;
  GateState ended_by_ = GateState::kStopped;
  std::string reason_ = "nobody has asked yet";
};

}  // namespace seater_safety
