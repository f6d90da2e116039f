#pragma once

#include <atomic>
#include <string>
#include <thread>

namespace seater_safety {

// Asks in a thread of its own whether the ROS master answers: a call to a master that has gone may block.
class MasterWatch {
 public:
  MasterWatch();
  ~MasterWatch();
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;

  // Empty, or what is wrong: no answer for kMasterTimeout, or another master than at the start, which knows none of
  // the nodes.
  std::string check() const;

 private:
  void watch();

  std::atomic<double> answered_;  // [s] steady clock
  std::atomic<bool> replaced_{false};
  std::atomic<bool> ending_{false};
  int process_ = 0;  // of the master
  std::thread thread_;
};

}  // namespace seater_safety
