#include "seater_safety/consent.h"

namespace seater_safety {

void Consent::give(const std::string& holder) {
  held_ = true;
  holder_ = holder;
  ended_by_ = GateState::kStopped;
  reason_.clear();
}

void Consent::end(GateState cause, const std::string& reason) {
  if (!held_) return;
  held_ = false;
  ended_by_ = cause;
  reason_ = reason;
}

}  // namespace seater_safety
