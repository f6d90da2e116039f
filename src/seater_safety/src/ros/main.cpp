// Program entry of the node safety_gate: on every way out that a program can take, the chair is braked first.
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <ros/xmlrpc_manager.h>

#include <atomic>
#include <csignal>
#include <stdexcept>

#include "load_parameters.h"
#include "safety_gate_node.h"

namespace {

// ROS's own handlers close the connections before the last command is sent.
std::atomic<bool> interrupted{false};

void onSignal(int) {
  interrupted = true;
}

// `rosnode kill`, and the master when another node takes this name.
void onShutdown(XmlRpc::XmlRpcValue&, XmlRpc::XmlRpcValue& result) {
  interrupted = true;
  result = ros::xmlrpc::responseInt(1, "", 0);
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "safety_gate", ros::init_options::NoSigintHandler);
  ros::XMLRPCManager::instance()->unbind("shutdown");
  ros::XMLRPCManager::instance()->bind("shutdown", onShutdown);
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
  std::signal(SIGHUP, onSignal);
  ros::NodeHandle private_handle("~");
  try {
    const seater_safety::GateParameters parameters = seater_safety::loadParameters(private_handle);
    seater_safety::SafetyGateNode node(parameters, seater_safety::loadSources(private_handle),
                                       private_handle.param("lock_step", false));
    while (ros::ok() && !interrupted) ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.02));
    node.stop();
    ros::WallDuration(0.1).sleep();
  } catch (const std::invalid_argument& error) {
    ROS_FATAL("safety_gate: wrong parameter: %s", error.what());
    return 1;
  }
  ros::shutdown();
  return 0;
}
