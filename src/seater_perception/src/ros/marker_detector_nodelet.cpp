#include <cv_bridge/cv_bridge.h>
#include <image_transport/camera_common.h>
#include <image_transport/image_transport.h>
#include <nodelet/nodelet.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>

#include "dock_choice.h"
#include "odometry_motion.h"
#include "ros/inputs/image_pairs.h"
#include "ros/inputs/senders.h"
#include "ros/inputs/stamp_check.h"
#include "ros_diagnostics.h"
#include "ros_messages.h"
#include "ros_parameters.h"
#include "seater_perception/dock_tracker.h"
#include "seater_perception/draw.h"
#include "seater_perception/errors.h"
#include "seater_perception/report.h"

namespace seater_perception {

/// Images to detections: only converts messages and parameters; DockTracker does the work. Topics:
/// docs/reference/interfaces.md.
///
/// Threads: everything runs in the nodelet's single-threaded queue, but for TF, whose buffer has its own lock; the
/// mutex is there because a subscriber may connect while onInit is still advertising.
class MarkerDetectorNodelet : public nodelet::Nodelet {
 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kStampPeriod = 10.0;  // [s] wall time, as image_transport's

  static double steadyTime() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

  void onInit() override {
    try {
      parameters_ = loadNodeParameters(getPrivateNodeHandle());
    } catch (const std::exception& error) {
      NODELET_FATAL("%s", error.what());
      throw;
    }
    choice_ = std::make_unique<DockChoice>(parameters_.dock, parameters_.dock_name);
    const std::lock_guard<std::mutex> lock(connect_mutex_);
    ros::NodeHandle& nh = getNodeHandle();
    dock_in_use_ = nh.subscribe("dock_in_use", 1, &MarkerDetectorNodelet::onDock, this);
    transport_ = std::make_unique<image_transport::ImageTransport>(nh);
    diagnostics_ =
        std::make_unique<Diagnostics>(nh, getPrivateNodeHandle(), getName(), parameters_.perception.diagnostics);
    const ros::SubscriberStatusCallback changed = [this](const ros::SingleSubscriberPublisher&) { connect(); };
    const image_transport::SubscriberStatusCallback image_changed =
        [this](const image_transport::SingleSubscriberPublisher&) { connect(); };
    detections_ = nh.advertise<seater_msgs::MarkerDetectionArray>("detections", 1, changed, changed);
    dock_pose_ = nh.advertise<geometry_msgs::PoseWithCovarianceStamped>("dock_pose", 1, changed, changed);
    annotated_ = transport_->advertise("detections/image", 1, image_changed, image_changed);
    if (!parameters_.odometry_frame.empty()) {
      listenToTransforms();
      odometry_ = std::make_unique<OdometryMotion>(tf_buffer_, parameters_.odometry_frame);
    }
    if (!parameters_.lazy) subscribe();
  }

  /// In a thread of its own, as tf2_ros does: images wait for none of them.
  void listenToTransforms() {
    ros::NodeHandle nh(getNodeHandle());
    nh.setCallbackQueue(&tf_queue_);
    const auto topic = [&](const std::string& name, bool fixed) {
      return nh.subscribe<tf2_msgs::TFMessage>(
          name, 100, [this, fixed](const ros::MessageEvent<const tf2_msgs::TFMessage>& event) {
            const std::string& sender = event.getPublisherName();
            if (transforms_.take(ros::Time::now(), event.getMessage()->transforms, sender, fixed) == 0) return;
            NODELET_WARN_THROTTLE(10.0, "transforms that cannot be used, from %s", sender.c_str());
          });
    };
    tf_ = topic("/tf", false);
    tf_static_ = topic("/tf_static", true);
    tf_spinner_ = std::make_unique<ros::AsyncSpinner>(1, &tf_queue_);
    tf_spinner_->start();
  }

  /// Follows the listeners: with none, the camera is left alone.
  void connect() {
    const std::lock_guard<std::mutex> lock(connect_mutex_);
    if (!parameters_.lazy) return;
    const bool wanted =
        detections_.getNumSubscribers() + dock_pose_.getNumSubscribers() + annotated_.getNumSubscribers() > 0;
    if (wanted && !subscribed_) subscribe();
    if (!wanted && subscribed_) unsubscribe();
  }

  void subscribe() {
    forget();
    ros::NodeHandle& nh = getNodeHandle();
    const ros::TransportHints tcp = ros::TransportHints().tcpNoDelay();
    const std::string image = nh.resolveName("image");
    if (parameters_.image_transport == "raw") {
      const image_transport::TransportHints hints("raw", tcp, getPrivateNodeHandle());
      raw_ = transport_->subscribe("image", 1, &MarkerDetectorNodelet::onRaw, this, hints);
    } else {
      compressed_ = nh.subscribe(image + "/compressed", 1, &MarkerDetectorNodelet::onCompressed, this, tcp);
    }
    info_ = nh.subscribe(image_transport::getCameraInfoTopic(image), 1, &MarkerDetectorNodelet::onInfo, this, tcp);
    stamp_timer_ = nh.createWallTimer(ros::WallDuration(kStampPeriod), &MarkerDetectorNodelet::checkStamps, this);
    subscribed_ = true;
    diagnostics_->setListening(true, nh.resolveName("image"));
  }

  void unsubscribe() {
    stamp_timer_.stop();
    raw_.shutdown();
    compressed_.shutdown();
    info_.shutdown();
    raw_pairs_.clear();
    compressed_pairs_.clear();
    subscribed_ = false;
    diagnostics_->setListening(false, "");
  }

  void onRaw(const sensor_msgs::ImageConstPtr& image) {
    stamps_.image();
    take(raw_pairs_.image(image));
  }

  void onCompressed(const sensor_msgs::CompressedImageConstPtr& image) {
    stamps_.image();
    take(compressed_pairs_.image(image));
  }

  void onInfo(const ros::MessageEvent<const sensor_msgs::CameraInfo>& event) {
    const sensor_msgs::CameraInfoConstPtr& info = event.getConstMessage();
    cameras_.heard(event.getPublisherName(), steadyTime());
    stamps_.info();
    take(raw_pairs_.info(info));
    take(compressed_pairs_.info(info));  // no image of one of them ever comes
  }

  template <typename Pair>
  void take(const std::optional<Pair>& pair) {
    if (!pair) return;
    stamps_.pair();
    guarded([&](const Clock::time_point& begin) {
      const std::string trouble = cameras_.trouble(info_.getTopic(), steadyTime());
      if (!trouble.empty()) throw std::runtime_error(trouble);
      followCalibration(*pair->second);
      process(toGrey(*pair->first), pair->first->header, begin);
    });
  }

  void checkStamps(const ros::WallTimerEvent&) {
    const auto text = stamps_.takeWarning(getNodeHandle().resolveName("image"), info_.getTopic(), kStampPeriod);
    if (text) NODELET_WARN("%s", text->c_str());
  }

  /// Another dock is looked for from the next image on, as a first image.
  void onDock(const seater_msgs::DockInUseConstPtr& dock) {
    try {
      if (!choice_->take(*dock)) return;
      forget();
      detector_.reset();
      NODELET_INFO("looks for dock %s (%s)", dock->name.c_str(), dock->source.c_str());
    } catch (const std::exception& error) {
      NODELET_ERROR("still looks for dock %s: %s", choice_->name().c_str(), error.what());
    }
  }

  /// An image that cannot be worked through is reported and leaves no trace in the outputs.
  template <typename Work>
  void guarded(const Work& work) {
    const Clock::time_point begin = Clock::now();
    try {
      work(begin);
    } catch (const std::exception& error) {
      if (odometry_) odometry_->reset();  // its last image is no longer the tracker's
      diagnostics_->failed(error.what());
      NODELET_ERROR_THROTTLE(1.0, "image not used: %s", error.what());
    }
  }

  /// The calibration comes with every image; the model is made anew only when it differs.
  void followCalibration(const sensor_msgs::CameraInfo& info) {
    const Calibration calibration = toCalibration(info);
    if (detector_ && calibration == calibration_) return;
    forget();
    detector_.reset();
    const CameraModel camera =
        parameters_.rectified ? CameraModel::rectified(calibration) : CameraModel::raw(calibration);
    detector_ = std::make_unique<DockTracker>(camera, choice_->layout(), parameters_.perception, parameters_.mount);
    calibration_ = calibration;
  }

  /// The next image has nothing to do with the last one.
  void forget() {
    if (detector_) detector_->reset();
    if (odometry_) odometry_->reset();
    last_stamp_ = ros::Time();
  }

  void process(const cv::Mat& grey, const std_msgs::Header& header, const Clock::time_point& begin) {
    // A bag or a simulation that begins anew; another camera.
    if (header.stamp < last_stamp_ || header.frame_id != last_frame_) forget();
    last_stamp_ = header.stamp;
    last_frame_ = header.frame_id;
    std::optional<Eigen::Isometry3d> T_now_last;
    if (odometry_) T_now_last = odometry_->next(header.frame_id, header.stamp);
    const DetectionResult result = detector_->detect(grey, T_now_last);
    if (!result.repeated.empty()) {
      NODELET_WARN_THROTTLE(10.0, "marker %d is seen at several places: none of them is used", result.repeated[0].id);
    }
    seater_msgs::MarkerDetectionArray message = toMessage(result, header);
    message.dock_name = choice_->name();
    message.dock_revision = choice_->revision();
    message.processing_time = std::chrono::duration<double>(Clock::now() - begin).count();
    detections_.publish(message);
    if (!message.dock.empty()) {
      geometry_msgs::PoseWithCovarianceStamped dock;
      dock.header = header;
      PoseHypothesis pose = result.dock.front();
      pose.covariance = mixtureCovariance(result.dock);  // this topic knows no other hypotheses
      dock.pose = toMessage(pose);
      dock_pose_.publish(dock);
    }
    const double latency = (ros::Time::now() - header.stamp).toSec();
    const auto& markers = result.markers;
    const auto photometric = std::count_if(markers.begin(), markers.end(),
                                           [](const DetectedMarker& m) { return m.stage == PoseStage::photometric; });
    double cut_off = 0.0;
    for (const DetectedMarker& m : markers) cut_off += m.white_cut_off;
    const auto focal =
        checkFocalLength(detector_->camera(), choice_->layout(), result, parameters_.perception.pose.placement_sigma);
    diagnostics_->published({latency, message.processing_time, !message.dock.empty(), result.full_search,
                             T_now_last.has_value(), result.dock.size() > 1, static_cast<int>(markers.size()),
                             static_cast<int>(photometric), focal, cut_off});
    if (annotated_.getNumSubscribers() > 0) publishAnnotated(grey, header, result, latency, message.processing_time);
  }

  void publishAnnotated(const cv::Mat& grey, const std_msgs::Header& header, const DetectionResult& result,
                        double latency, double processing_time) {
    char line[120];
    std::snprintf(line, sizeof(line), "latency %.0f ms, processing %.1f ms", 1e3 * latency, 1e3 * processing_time);
    const cv::Mat image = annotate(grey, detector_->camera(), choice_->layout(), result, {line});
    annotated_.publish(cv_bridge::CvImage(header, "bgr8", image).toImageMsg());
  }

  NodeParameters parameters_;
  std::unique_ptr<DockChoice> choice_;
  ros::Subscriber dock_in_use_;
  std::unique_ptr<DockTracker> detector_;
  Calibration calibration_;  // of detector_
  std::mutex connect_mutex_;
  bool subscribed_ = false;
  std::unique_ptr<image_transport::ImageTransport> transport_;
  image_transport::Subscriber raw_;
  ros::Subscriber compressed_, info_;
  ImagePairs<sensor_msgs::ImageConstPtr, sensor_msgs::CameraInfoConstPtr> raw_pairs_;
  ImagePairs<sensor_msgs::CompressedImageConstPtr, sensor_msgs::CameraInfoConstPtr> compressed_pairs_;
  StampCheck stamps_;
  Senders cameras_;
  ros::WallTimer stamp_timer_;
  ros::Publisher detections_, dock_pose_;
  image_transport::Publisher annotated_;
  std::unique_ptr<Diagnostics> diagnostics_;
  tf2::BufferCore tf_buffer_;
  TransformInput transforms_{tf_buffer_};
  ros::CallbackQueue tf_queue_;
  ros::Subscriber tf_, tf_static_;
  std::unique_ptr<ros::AsyncSpinner> tf_spinner_;  // fills the buffer
  std::unique_ptr<OdometryMotion> odometry_;       // nothing when there is no odometry to look up
  ros::Time last_stamp_;                           // of the last image
  std::string last_frame_;
};

}  // namespace seater_perception

PLUGINLIB_EXPORT_CLASS(seater_perception::MarkerDetectorNodelet, nodelet::Nodelet)
