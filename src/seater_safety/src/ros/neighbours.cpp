#include "neighbours.h"

namespace seater_safety {

Neighbours::Neighbours(ros::NodeHandle& handle) {
  command_ = handle.subscribe<geometry_msgs::Twist>(
      "cmd_vel", 10,
      boost::function<void(const ros::MessageEvent<geometry_msgs::Twist const>&)>(
          [this](const auto& event) { hear(event.getPublisherName()); }));
  state_ = handle.subscribe<seater_msgs::GateState>(
      "gate_state", 10,
      boost::function<void(const ros::MessageEvent<seater_msgs::GateState const>&)>(
          [this](const auto& event) { hear(event.getPublisherName()); }));
}

void Neighbours::hear(const std::string& publisher) {
  if (publisher != ros::this_node::getName()) stranger_ = publisher;
}

std::string Neighbours::check() const {
  for (const ros::Subscriber& own : {command_, state_}) {
    if (own.getNumPublishers() <= 1) continue;
    const std::string who = stranger_.empty() ? "another node" : stranger_;
    return who + " publishes " + own.getTopic() + " beside the safety gate";
  }
  for (const auto& [input, allowed] : inputs_) {
    const std::size_t count = input.getNumPublishers();
    const std::string most = allowed == 1 ? "one is" : std::to_string(allowed) + " are";
    if (count > allowed) return std::to_string(count) + " nodes publish " + input.getTopic() + ", " + most + " allowed";
  }
  return {};
}

}  // namespace seater_safety
