// ROS shell of the velocity gate. Topics and service (relative):
//   in   velocity_request (geometry_msgs/TwistStamped), user_cmd_vel (geometry_msgs/Twist),
//        emergency_stop, hold_to_run and charging_contact (std_msgs/Bool), speed_limit (seater_msgs/SpeedLimit),
//        obstacle_points and bay_walls (seater_msgs/ObstaclePoints),
//        not in lock-step: odom (nav_msgs/Odometry), motor_fault (seater_msgs/MotorFault);
//        gate_arm (seater_msgs/GateArm): consent for one goal, of the calling node;
//        gate_reset (std_srvs/Trigger): after an emergency stop
//   out  cmd_vel (geometry_msgs/Twist), cmd_vel_stamped (geometry_msgs/TwistStamped, with the request's stamp),
//        motor_enable (std_msgs/Bool), gate_state (seater_msgs/GateState)
// All callbacks run in one thread.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <seater_msgs/GateArm.h>
#include <seater_msgs/MotorFault.h>
#include <seater_msgs/ObstaclePoints.h>
#include <seater_msgs/SpeedLimit.h>
#include <std_msgs/Bool.h>
#include <std_srvs/Trigger.h>

#include <memory>
#include <string>
#include <vector>

#include "clocks.h"
#include "master_link.h"
#include "neighbours.h"
#include "outputs.h"
#include "seater_safety/motion_monitor.h"
#include "seater_safety/velocity_gate.h"

namespace seater_safety {

class SafetyGateNode {
 public:
  // `sources` of obstacles that are required. Throws std::invalid_argument: see Clocks and VelocityGate.
  SafetyGateNode(const GateParameters& parameters, const std::vector<std::string>& sources, bool lock_step);

  // Brakes and switches the motors off; takes at most kLongestBraking. To be called while ROS still runs.
  void stop();

 private:
  using ArmEvent = ros::ServiceEvent<seater_msgs::GateArm::Request, seater_msgs::GateArm::Response>;

  void onRequest(const ros::MessageEvent<geometry_msgs::TwistStamped const>& event);
  void onUser(const geometry_msgs::Twist& message);
  void onEmergencyStop(const std_msgs::Bool& message);
  void onHold(const std_msgs::Bool& message);
  void onContact(const std_msgs::Bool& message);
  void onSpeedLimit(const seater_msgs::SpeedLimit& message);
  void onObstacles(const seater_msgs::ObstaclePoints& message);
  void onOdometry(const nav_msgs::Odometry& message);
  void onMotorFault(const seater_msgs::MotorFault& message);
  bool onArm(ArmEvent& event);
  bool onReset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  // Outputs at a constant rate, also while standing: silence of the gate means a fault.
  void onTimer(const ros::SteadyTimerEvent&) { send(clocks_.now()); }
  void onLockStepTimer(const ros::TimerEvent&);
  // What the gate does not hear of by a message, and what it says of itself.
  void onSupervision(const ros::SteadyTimerEvent&);

  void send(double now);
  void cutPower();
  void noticeFaults();
  std::string surroundings();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  Clocks clocks_;
  VelocityGate gate_;
  MotionMonitor motion_;
  Outputs out_;
  Neighbours neighbours_;
  std::unique_ptr<MasterLink> master_;  // in lock-step none: how fast it answers depends on the machine
  ros::Subscriber request_, user_, emergency_stop_, speed_limit_, hold_, contact_, odometry_, motor_fault_, obstacles_,
      walls_;
  ros::ServiceServer arm_, reset_;
  ros::Timer lock_step_timer_;
  ros::SteadyTimer timer_, supervision_;
  diagnostic_updater::Updater updater_;
  std::uint64_t consent_ = 0;
  unsigned supervisions_ = 0;
  ros::Time last_stamp_;
  double last_output_ = 0.0;
  bool silent_ = false;
};

}  // namespace seater_safety
