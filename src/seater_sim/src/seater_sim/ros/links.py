"""Topics and services of the node, and the waiting of the lock-step."""

from __future__ import annotations

from collections import Counter
from typing import Any, Protocol

import rospy
import tf2_ros
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Bool, UInt32
from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse

from seater_msgs.msg import InputDone, MarkerDetectionArray, ObstacleArray
from seater_sim.camera.camera import Camera
from seater_sim.chair.interface import OdometrySample
from seater_sim.loop.lockstep import Answers
from seater_sim.loop.simulator import SimulatedImage, Simulator, Truth
from seater_sim.ros import messages
from seater_sim.ros.options import Options
from seater_sim.ros.peers import publishers_of, sends_to, subscribers_of


class Receiver(Protocol):
    """Receives what arrives: the node. Called in ROS's threads."""

    def on_command(self, v: float, omega: float, stamped: bool) -> None:
        """A velocity command [m/s, rad/s]."""

    def on_run(self, run: bool) -> None:
        """Let the time pass, or stand."""

    def on_cover(self, cover: bool) -> None:
        """Hide all markers, or show them again."""


class Links:
    """Everything that connects the simulator with other nodes. Callbacks only store and notify."""

    def __init__(self, options: Options, node: Receiver) -> None:
        self._options = options
        self._tells_obstacles = options.publish_obstacles and bool(options.simulator.obstacles)
        self._answers: Answers[Any] = Answers()
        self._contact_answers = 0
        self._advertise()
        self._static = tf2_ros.StaticTransformBroadcaster()
        self._transforms = tf2_ros.TransformBroadcaster()

        def subscribe(topic: str, kind: type, callback: Any) -> rospy.Subscriber:
            return rospy.Subscriber(topic, kind, callback, queue_size=100, tcp_nodelay=True)

        def on_twist(message: Twist) -> None:
            node.on_command(message.linear.x, message.angular.z, stamped=False)

        def on_stamped(message: TwistStamped) -> None:
            node.on_command(message.twist.linear.x, message.twist.angular.z, stamped=True)
            self._answers.put("cmd_vel_stamped", message.header.stamp.to_nsec(), message)

        def on_done(message: InputDone) -> None:
            key = message.header.stamp.to_nsec()
            if message.input == "charging_contact":  # its message has no stamp: the answers are counted
                key = self._contact_answers = self._contact_answers + 1
            self._answers.put("input_done/" + message.input, key, message)

        def on_detections(message: rospy.AnyMsg) -> None:
            self._answers.put("detections", _stamp_of(message), True)

        self._subscribers = {
            "cmd_vel": subscribe("cmd_vel", Twist, on_twist),
            "cmd_vel_stamped": subscribe("cmd_vel_stamped", TwistStamped, on_stamped),
        }
        if options.lock_step:
            self._subscribers["input_done"] = subscribe("input_done", InputDone, on_done)
            # Only the stamp is read; listening also wakes perception, which works only when someone listens.
            self._subscribers["detections"] = subscribe("detections", MarkerDetectionArray, on_detections)
        self._services = [
            rospy.Service("~run", SetBool, lambda request: _done(node.on_run, request)),
            rospy.Service("~cover", SetBool, lambda request: _done(node.on_cover, request)),
        ]

    def _advertise(self) -> None:
        def publisher(topic: str, kind: type, latch: bool = False) -> rospy.Publisher:
            # Long queues: in lock-step nobody falls behind, and a recorder shall not lose images.
            return rospy.Publisher(topic, kind, queue_size=100, latch=latch, tcp_nodelay=True)

        self._clock = publisher("/clock", Clock)
        # Latched: while the time stands, who comes late still learns where the chair is.
        self._odometry = publisher("odom", Odometry, latch=True)
        self._truth = publisher("ground_truth", Odometry, latch=True)
        self._contact = publisher("charging_contact", Bool, latch=True)
        self._collisions = publisher("collisions", UInt32, latch=True)
        self._obstacles = publisher("obstacles", ObstacleArray, latch=True) if self._tells_obstacles else None
        self._image = publisher("camera/color/image_raw", Image)
        self._compressed = publisher("camera/color/image_raw/compressed", CompressedImage)
        self._camera_info = publisher("camera/color/camera_info", CameraInfo)

    @property
    def missed(self) -> Counter[str]:
        """Answers that were given up, by topic."""
        return self._answers.missed

    # Sending --------------------------------------------------------------------------------------------------------

    def publish_static(self, simulator: Simulator) -> None:
        """Where the camera sits."""
        self._static.sendTransform(messages.camera_transforms(self._options.told_chair.camera, simulator.time_ns))

    def publish_clock(self, time_ns: int) -> None:
        """Simulated time."""
        self._clock.publish(Clock(messages.stamp(time_ns)))

    def publish_odometry(self, sample: OdometrySample) -> None:
        """odom and its transform; the transform first, so that it is there for who acts on odom."""
        message = messages.odometry_message(sample)
        self._transforms.sendTransform(messages.odometry_transform(message))
        self._odometry.publish(message)

    def publish_truth(self, truth: Truth) -> None:
        """True pose, for the evaluation."""
        self._truth.publish(messages.truth_message(truth))

    def publish_contact(self, closed: bool) -> None:
        """Charging contact; latched. In lock-step the docking node knows it before the time goes on."""
        expected = self._contact_answers + 1
        self._contact.publish(Bool(closed))
        if "input_done" in self._subscribers and self._present("input_done"):
            self._wait("input_done/charging_contact", "input_done", expected)

    def publish_obstacles(self, time_ns: int) -> None:
        """What stands in the way, once; latched. In lock-step the docking node knows it before the time goes on."""
        if self._obstacles is None:
            return
        self._obstacles.publish(messages.obstacles_message(self._options.simulator.obstacles, time_ns))
        if "input_done" in self._subscribers and self._present("input_done"):
            self._wait("input_done/obstacles", "input_done", time_ns)

    def publish_collisions(self, count: int) -> None:
        """How often the chair ran into something; latched."""
        self._collisions.publish(UInt32(count))

    def publish_image(self, image: SimulatedImage, camera: Camera | None) -> bool:
        """Image and camera_info; drawn only when someone listens. True when someone does."""
        assert camera is not None
        self._camera_info.publish(messages.camera_info_message(camera.model, image))
        raw, compressed = (p.get_num_connections() > 0 for p in (self._image, self._compressed))
        if not (raw or compressed):
            return False
        pixels = image.render()
        if raw:
            self._image.publish(messages.image_message(image, pixels))
        if compressed:
            self._compressed.publish(messages.compressed_message(image, pixels, camera.settings))
        return True

    # Lock-step ------------------------------------------------------------------------------------------------------

    def wait_for_odometry_answers(self, stamp_ns: int) -> None:
        """The docking node's input_done, and the command that follows when it made a request."""
        if not self._present("input_done"):
            return
        done = self._wait("input_done/odom", "input_done", stamp_ns)
        if done is not None and done.requested and self._present("cmd_vel_stamped"):
            self._wait("cmd_vel_stamped", "cmd_vel_stamped", stamp_ns)

    def wait_for_image_answers(self, stamp_ns: int) -> None:
        """Perception's detections, then the docking node's input_done about them."""
        if not self._present("detections"):
            return
        found = self._wait("detections", "detections", stamp_ns)
        if found is not None and self._present("input_done"):
            self._wait("input_done/detections", "input_done", stamp_ns)

    def _present(self, topic: str) -> bool:
        return bool(publishers_of(self._subscribers[topic]))

    def _wait(self, answer: str, topic: str, stamp_ns: int) -> Any:
        before = self.missed[answer]
        limit = self._options.answer_timeout
        names = publishers_of(self._subscribers[topic])
        result = self._answers.wait(answer, stamp_ns, limit, lambda: self._present(topic))
        if self.missed[answer] > before:
            who = ", ".join(sorted(names))
            text = "%s did not answer with %s to stamp %.3f s within %.0f s of wall time; going on without."
            rospy.logerr(text, who, answer, 1e-9 * stamp_ns, limit)
        return result

    def missing(self) -> str | None:
        """What is not connected yet of what the lock-step needs; None when everything is."""
        wanted = self._options.participants
        nodes = {topic: publishers_of(self._subscribers[topic]) for topic in wanted}
        for topic, names in nodes.items():
            if not names:
                return f"nobody publishes {rospy.resolve_name(topic)}"
            deaf = names - subscribers_of(self._clock)
            if deaf and rospy.get_param("/use_sim_time", False):
                return f"{', '.join(sorted(deaf))} does not listen to /clock"
        detectors, controllers, gates = (
            nodes.get(topic, set()) for topic in ("detections", "input_done", "cmd_vel_stamped")
        )
        images = subscribers_of(self._image) | subscribers_of(self._compressed)
        if detectors and not (detectors & images and detectors & subscribers_of(self._camera_info)):
            return f"{', '.join(sorted(detectors))} does not listen to the images and camera_info"
        if controllers and not controllers & subscribers_of(self._odometry):
            return f"{', '.join(sorted(controllers))} does not listen to {rospy.resolve_name('odom')}"
        if self._obstacles is not None and controllers and not controllers & subscribers_of(self._obstacles):
            return f"{', '.join(sorted(controllers))} does not listen to {rospy.resolve_name('obstacles')}"
        return _unlinked(detectors, "detections", controllers) or _unlinked(controllers, "velocity_request", gates)

    def close(self) -> None:
        """End all waits."""
        self._answers.close()


def _unlinked(sources: set[str], topic: str, sinks: set[str]) -> str | None:
    """The link between two other nodes that does not stand yet; None when all do, or there is none to check."""
    resolved = rospy.resolve_name(topic)
    for source in sorted(sources - sinks) if sinks else []:
        lacking = sinks - sends_to(source, resolved)
        if lacking:
            return f"{', '.join(sorted(lacking))} does not listen to {resolved} of {source}"
    return None


def _done(action: Any, request: SetBoolRequest) -> SetBoolResponse:
    action(request.data)
    return SetBoolResponse(success=True, message="")


def _stamp_of(message: MarkerDetectionArray) -> int:
    return int(message.header.stamp.to_nsec())
