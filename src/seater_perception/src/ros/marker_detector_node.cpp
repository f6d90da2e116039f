// The nodelet seater_perception/MarkerDetector as a process of its own.

#include <nodelet/loader.h>
#include <ros/ros.h>

int main(int argc, char** argv) {
  ros::init(argc, argv, "marker_detector");
  nodelet::Loader loader(false);  // no services: this process is for one nodelet
  const nodelet::V_string arguments(argv + 1, argv + argc);
  try {
    if (!loader.load(ros::this_node::getName(), "seater_perception/MarkerDetector", ros::names::getRemappings(),
                     arguments)) {
      return 1;
    }
  } catch (const std::exception& error) {
    ROS_FATAL("not started: %s", error.what());
    return 1;
  }
  ros::spin();
  return 0;
}
