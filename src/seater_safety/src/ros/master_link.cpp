#include "master_link.h"

#include <XmlRpcValue.h>
#include <ros/master.h>
#include <ros/param.h>
#include <ros/this_node.h>
#include <ros/time.h>

namespace seater_safety {
namespace {

constexpr double kMasterTimeout = 2.0;  // [s]
constexpr double kAskPeriod = 0.5;      // [s] between two questions
constexpr double kNap = 0.05;           // [s]

double steadyNow() {
  return ros::SteadyTime::now().toSec();
}

}  // namespace

MasterLink::MasterLink() : answered_(steadyNow()), pressed_(wasPressed()), thread_([this] { work(); }) {}

MasterLink::~MasterLink() {
  ending_ = true;
  thread_.join();
}

std::string MasterLink::check() const {
  if (replaced_) return "the ROS master was started anew: start all nodes anew";
  return steadyNow() - answered_ > kMasterTimeout ? "the ROS master does not answer" : std::string();
}

bool MasterLink::wasPressed() {
  XmlRpc::XmlRpcValue kept;
  if (!ros::param::get("~emergency_stop_pressed", kept)) return false;
  // What somebody has set by hand may be a number or a word; only a plain "no" releases the chair.
  return kept.getType() != XmlRpc::XmlRpcValue::TypeBoolean || static_cast<bool>(kept);
}

void MasterLink::work() {
  double asked = -1e9;
  bool stored = pressed_;
  while (!ending_) {
    const bool pressed = pressed_;
    if (pressed != stored) ros::param::set("~emergency_stop_pressed", pressed);
    stored = pressed;
    if (steadyNow() - asked > kAskPeriod) {
      asked = steadyNow();
      ask();
    }
    ros::WallDuration(kNap).sleep();
  }
}

void MasterLink::ask() {
  XmlRpc::XmlRpcValue request, response, process;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getPid", request, response, process, false)) return;
  answered_ = steadyNow();
  const int found = process;
  if (process_ != 0 && found != process_) replaced_ = true;
  process_ = found;
}

}  // namespace seater_safety
