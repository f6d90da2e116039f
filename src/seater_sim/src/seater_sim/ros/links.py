"""Topics and services of the node, and the waiting of the lock-step."""

from __future__ import annotations

from collections import Counter
from typing import Any, Protocol

import rospy
from geometry_msgs.msg import Twist, TwistStamped
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse

from seater_msgs.msg import InputDone, MarkerDetectionArray, ObstaclePoints
from seater_sim.chair.interface import OdometrySample
from seater_sim.loop.lockstep import Answers
from seater_sim.loop.simulator import SimulatedImage, Simulator, Truth
from seater_sim.ranging.taken import SimulatedRange
from seater_sim.ros import messages
from seater_sim.ros.chair_topics import ChairTopics, RangeTopics, publisher
from seater_sim.ros.image_topics import ImageTopics
from seater_sim.ros.options import Options
from seater_sim.ros.peers import publishers_of, sends_to, subscribers_of
from seater_sim.settings import NO_SENSOR


class Receiver(Protocol):
    """Receives what arrives: the node. Called in ROS's threads."""

    def on_command(self, v: float, omega: float, stamped: bool) -> None:
        """A velocity command [m/s, rad/s]."""

    def on_enable(self, enabled: bool) -> None:
        """Power for the motors, or none."""

    def on_run(self, run: bool) -> None:
        """Let the time pass, or stand."""

    def on_cover(self, cover: bool) -> None:
        """Hide all markers, or show them again."""


class Links:
    """Everything that connects the simulator with other nodes. Callbacks only store and notify."""

    def __init__(self, options: Options, node: Receiver) -> None:
        self._options = options
        self._clock = publisher("/clock", Clock)
        self._chair = ChairTopics(options.simulator.obstacles if options.publish_obstacles else [])
        self._camera = ImageTopics()
        kind = options.simulator.ranging.kind
        self._ranges = None if kind == NO_SENSOR else RangeTopics(kind)
        self._answers: Answers[Any] = Answers()
        self._contact_answers = 0

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

        def on_points(message: ObstaclePoints) -> None:
            self._answers.put("obstacle_points", message.header.stamp.to_nsec(), message)

        self._subscribers = {
            "cmd_vel": subscribe("cmd_vel", Twist, on_twist),
            "cmd_vel_stamped": subscribe("cmd_vel_stamped", TwistStamped, on_stamped),
            "motor_enable": subscribe("motor_enable", Bool, lambda message: node.on_enable(message.data)),
        }
        if options.lock_step:
            self._subscribers["input_done"] = subscribe("input_done", InputDone, on_done)
            # Only the stamp is read; listening also wakes perception, which works only when someone listens.
            self._subscribers["detections"] = subscribe("detections", MarkerDetectionArray, on_detections)
            if self._ranges is not None:
                self._subscribers["obstacle_points"] = subscribe("obstacle_points", ObstaclePoints, on_points)
        self._services = [
            rospy.Service("~run", SetBool, lambda request: _done(node.on_run, request)),
            rospy.Service("~cover", SetBool, lambda request: _done(node.on_cover, request)),
        ]

    @property
    def missed(self) -> Counter[str]:
        """Answers that were given up, by topic."""
        return self._answers.missed

    # Sending --------------------------------------------------------------------------------------------------------

    def publish_static(self, simulator: Simulator) -> None:
        """Where the sensors sit."""
        self._chair.publish_static(self._options.told_chair.camera, simulator.range_sensor, simulator.time_ns)

    def publish_clock(self, time_ns: int) -> None:
        """Simulated time."""
        self._clock.publish(Clock(messages.stamp(time_ns)))

    def publish_odometry(self, sample: OdometrySample) -> None:
        """odom and its transform."""
        self._chair.publish_odometry(sample)

    def publish_truth(self, truth: Truth) -> None:
        """True pose, for the evaluation."""
        self._chair.publish_truth(truth)

    def publish_contact(self, closed: bool) -> None:
        """Charging contact. In lock-step the docking node knows it before the time goes on."""
        expected = self._contact_answers + 1
        self._chair.publish_contact(closed)
        if "input_done" in self._subscribers and self._present("input_done"):
            self._wait("input_done/charging_contact", "input_done", expected)

    def publish_obstacles(self, time_ns: int) -> None:
        """What stands in the way, once. In lock-step the docking node knows it before the time goes on."""
        if self._chair.obstacles is None:
            return
        self._chair.publish_obstacles(time_ns)
        if "input_done" in self._subscribers and self._present("input_done"):
            self._wait("input_done/obstacles", "input_done", time_ns)

    def publish_collisions(self, count: int) -> None:
        """How often the chair ran into something."""
        self._chair.publish_collisions(count)

    def publish_image(self, image: SimulatedImage) -> bool:
        """Image and camera_info; drawn only when someone listens. True when someone does."""
        return self._camera.publish(image)

    def publish_range(self, taken: SimulatedRange) -> bool:
        """A scan or depth image. True when someone listens."""
        return self._ranges is not None and self._ranges.publish(taken)

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

    def wait_for_range_answers(self, stamp_ns: int) -> None:
        """The obstacle node's points, then the docking node's input_done about its outlines."""
        if not self._present("obstacle_points"):
            return
        points = self._wait("obstacle_points", "obstacle_points", stamp_ns)
        if points is not None and not points.blocked and self._present("input_done"):
            self._wait("input_done/obstacles", "input_done", stamp_ns)

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
        images = subscribers_of(self._camera.image) | subscribers_of(self._camera.compressed)
        if detectors and not (detectors & images and detectors & subscribers_of(self._camera.camera_info)):
            return f"{', '.join(sorted(detectors))} does not listen to the images and camera_info"
        if controllers and not controllers & subscribers_of(self._chair.odometry):
            return f"{', '.join(sorted(controllers))} does not listen to {rospy.resolve_name('odom')}"
        told = self._chair.obstacles
        if told is not None and controllers and not controllers & subscribers_of(told):
            return f"{', '.join(sorted(controllers))} does not listen to {rospy.resolve_name('obstacles')}"
        links = [(detectors, "detections", controllers), (controllers, "velocity_request", gates)]
        watchers = nodes.get("obstacle_points", set())
        if watchers and self._ranges is not None and not watchers & subscribers_of(self._ranges.output):
            return f"{', '.join(sorted(watchers))} does not listen to {self._ranges.output.resolved_name}"
        links += [(watchers, "obstacles", controllers), (watchers, "obstacle_points", gates)]
        return next((lacking for link in links if (lacking := _unlinked(*link))), None)

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
