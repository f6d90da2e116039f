#include "master_watch.h"

#include <XmlRpcValue.h>
#include <ros/master.h>
#include <ros/this_node.h>
#include <ros/time.h>

namespace seater_safety {
namespace {

constexpr double kMasterTimeout = 2.0;  // [s]
constexpr double kPeriod = 0.5;         // [s]

double steadyNow() {
  return ros::SteadyTime::now().toSec();
}

}  // namespace

MasterWatch::MasterWatch() : answered_(steadyNow()), thread_([this] { watch(); }) {}

MasterWatch::~MasterWatch() {
  ending_ = true;
  thread_.join();
}

std::string MasterWatch::check() const {
  if (replaced_) return "the ROS master was started anew: start all nodes anew";
  return steadyNow() - answered_ > kMasterTimeout ? "the ROS master does not answer" : std::string();
}

void MasterWatch::watch() {
  while (!ending_) {
    XmlRpc::XmlRpcValue request, response, process;
    request[0] = ros::this_node::getName();
    if (ros::master::execute("getPid", request, response, process, false)) {
      answered_ = steadyNow();
      const int found = process;
      if (process_ != 0 && found != process_) replaced_ = true;
      process_ = found;
    }
    for (double waited = 0.0; waited < kPeriod && !ending_; waited += 0.05) ros::WallDuration(0.05).sleep();
  }
}

}  // namespace seater_safety
