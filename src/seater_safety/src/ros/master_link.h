#pragma once

#include <atomic>
#include <string>
#include <thread>

namespace seater_safety {

// What the gate needs of the ROS master, in a thread of its own: a call to a master that has gone may block.
class MasterLink {
 public:
  MasterLink();
  ~MasterLink();
  MasterLink(const MasterLink&) = delete;
  MasterLink& operator=(const MasterLink&) = delete;

  // Empty, or what is wrong: no answer for two seconds, or another master than at the start, which knows none of the
  // nodes.
  std::string check() const;

  // Keeps on the parameter server (~emergency_stop_pressed) whether the emergency stop is pressed, for a gate that is
  // started anew. It is there within 0.1 s.
  void remember(bool pressed) { pressed_ = pressed; }
  // What the last gate remembered. Blocks; to be called at the start.
  static bool wasPressed();

 private:
  void work();
  void ask();

  std::atomic<double> answered_;  // [s] steady clock
  std::atomic<bool> replaced_{false};
  std::atomic<bool> ending_{false};
  std::atomic<bool> pressed_;
  int process_ = 0;  // of the master
  std::thread thread_;
};

}  // namespace seater_safety
