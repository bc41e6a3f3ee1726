#!/usr/bin/env python3
"""Coordinate: simultaneous, sequential, and every request that cannot be met."""

import math
import time
import unittest
from typing import Any

import rospy
import rostest
from support import Listener, planned, service, wait_until

from social_fleet.coordination.verification import verify
from social_fleet.msg import EncounterWindow, Progress, Schedule
from social_fleet.ros.conversions import schedule_from_message
from social_fleet.srv import Coordinate, CoordinateRequest, CoordinateResponse

EAST, NORTH = [(0.0, 0.0), (20.0, 0.0)], [(10.0, -10.0), (10.0, 10.0)]


class CoordinateTest(unittest.TestCase):
    """Two robots on crossing paths, unless a test says otherwise."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.coordinate = service("fleet_coordinator/coordinate", Coordinate)
        cls.progress = rospy.Publisher("fleet/progress", Progress, queue_size=10)

    def expect(self, status: str, *words: str, **request: Any) -> CoordinateResponse:
        answer = self.coordinate(CoordinateRequest(**request))
        self.assertEqual(answer.status, getattr(CoordinateResponse, status), answer.message)
        for word in words:
            self.assertIn(word, answer.message)
        self.assertEqual(bool(answer.schedules), status == "SUCCESS")
        return answer

    def crossing(self, **values: Any) -> CoordinateResponse:
        return self.expect("SUCCESS", planning=[planned("blue", EAST), planned("gold", NORTH, **values)])

    def test_simultaneous(self) -> None:
        answer = self.crossing()
        self.assertEqual([schedule.robot for schedule in answer.schedules], ["blue", "gold"])
        self.assertEqual(len({schedule.header.stamp for schedule in answer.schedules}), 1)
        self.assertEqual([window.kind for window in answer.windows], [EncounterWindow.INTERSECTION])
        self.assertIn(answer.windows[0].first, ("blue", "gold"))
        self.assertTrue(verify([schedule_from_message(schedule, "map") for schedule in answer.schedules]).safe)
        waiting = [schedule for schedule in answer.schedules if schedule.precedences]
        self.assertEqual(len(waiting), 1)
        self.assertNotEqual(waiting[0].robot, answer.windows[0].first)

    def test_time_zero_lies_ahead(self) -> None:
        answer = self.crossing(depart=5.0)
        self.assertGreater(answer.schedules[0].header.stamp, rospy.Time.now())
        self.assertGreaterEqual(answer.schedules[1].times[0], 5.0)

    def test_sequential(self) -> None:
        first = self.expect("SUCCESS", planning=[planned("blue", EAST)])
        second = self.expect("SUCCESS", planning=[planned("gold", NORTH)], fixed=first.schedules)
        self.assertEqual(second.schedules[0].header.stamp, first.schedules[0].header.stamp)
        self.assertGreater(second.schedules[0].version, first.schedules[0].version)
        both = [schedule_from_message(item, "map") for item in (first.schedules[0], second.schedules[0])]
        self.assertTrue(verify(both).safe)

    def test_robots_under_way_are_told_whom_to_let_pass(self) -> None:
        """Gold is across before blue comes near: blue must not rely on it."""
        first = self.expect("SUCCESS", planning=[planned("blue", EAST)])
        heard = Listener("fleet/schedules", Schedule)
        self.addCleanup(heard.close)
        wait_until(lambda: any(message.robot == "blue" for message in heard.messages), "blue's first schedule")
        near = planned("gold", [(10.0, -2.0), (10.0, 10.0)])
        second = self.expect("SUCCESS", planning=[near], fixed=first.schedules)
        self.assertEqual([schedule.robot for schedule in second.schedules], ["gold"])
        told, = second.amended
        self.assertEqual({rule.other for rule in told.precedences}, {"gold"})
        self.assertEqual(told.precedences[0].other_version, second.schedules[0].version)
        before = first.schedules[0]
        self.assertFalse(before.precedences)
        before.precedences, before.header.seq = told.precedences, told.header.seq  # a publisher counts by itself
        self.assertEqual(told, before)
        wait_until(lambda: any(message.precedences == told.precedences and message.version == told.version
                               for message in heard.messages if message.robot == "blue"), "blue's amended schedule")

    def hear(self, status: str, **progress: Any) -> CoordinateResponse:
        """The answer to a request without red, once what red reports leads to `status`."""
        def ask() -> CoordinateResponse:
            self.progress.publish(Progress(robot="red", **progress))
            answer = self.coordinate(CoordinateRequest(planning=[planned("blue", EAST)]))
            return answer if answer.status == getattr(CoordinateResponse, status) else None
        wait_until(lambda: self.progress.get_num_connections() > 0, "the coordinator to listen")
        return wait_until(ask, status)

    def test_robots_that_may_move_must_not_be_left_out(self) -> None:
        for state in (Progress.DRIVING, Progress.TURNING, Progress.HOLDING):
            self.assertIn("red", self.hear("INVALID_REQUEST", state=state, schedule_version=7).message)
            self.hear("SUCCESS", state=Progress.ARRIVED, schedule_version=7)

    def test_versions_never_repeat(self) -> None:
        version = self.crossing().schedules[0].version
        self.assertGreater(version, time.time() - 3600.0)
        self.assertGreater(self.crossing().schedules[0].version, version)
        heard = version + 100
        wait_until(lambda: self.hear("SUCCESS", state=Progress.ARRIVED, schedule_version=heard
                                     ).schedules[0].version > heard, "versions above those heard of")

    def test_schedules_reach_late_and_forgetful_trackers(self) -> None:
        version = self.expect("SUCCESS", planning=[planned("blue", EAST), planned("pink", NORTH)]).schedules[0].version
        late, windows = Listener("fleet/schedules", Schedule), Listener("fleet/windows", EncounterWindow)
        late.wait(2)
        windows.wait(1)
        self.assertEqual({(message.robot, message.version) for message in late.messages},
                         {("blue", version), ("pink", version)})
        old = Progress(robot="pink", schedule_version=version - 1, state=Progress.ARRIVED)
        old.header.stamp = late.messages[0].header.stamp + rospy.Duration(1.0)
        wait_until(lambda: self.progress.get_num_connections() > 0, "the coordinator to listen")
        self.progress.publish(old)
        self.assertEqual(late.wait(3).robot, "pink")
        self.expect("INVALID_REQUEST", "pink", planning=[planned("blue", EAST)])
        old.schedule_version = version
        self.progress.publish(old)
        self.hear("SUCCESS", state=Progress.ARRIVED)

    def test_infeasible(self) -> None:
        there, back = [(0.0, 0.0), (10.0, 0.0)], [(10.0, 0.0), (0.0, 0.0)]
        self.expect("INFEASIBLE", "blue", "gold", planning=[planned("blue", there), planned("gold", back)])
        self.crossing()

    def test_requests_that_are_wrong(self) -> None:
        blue = planned("blue", EAST)
        cases = {
            "names": [blue, planned("blue", NORTH)],
            "starts": [blue, planned("gold", [(0.3, 0.0), (0.0, 9.0)])],
            "goals": [blue, planned("gold", [(20.0, 9.0), (20.0, 0.3)])],
            "max_speed": [planned("gold", NORTH, max_speed=0.0)],
            "radius": [planned("gold", NORTH, radius=-1.0)],
            "depart": [planned("gold", NORTH, depart=math.nan)],
            "name": [planned("", NORTH)],
            "no robot": [],
            "empty": [planned("gold", NORTH, path=type(blue.path)(header=blue.header))],
        }
        for word, planning in cases.items():
            self.expect("INVALID_REQUEST", word, planning=planning)
        self.expect("INVALID_REQUEST", "time_margin", planning=[blue], time_margin=-1.0)
        self.expect("INVALID_REQUEST", "time_limit", planning=[blue], time_limit=math.nan)
        self.crossing()

    def test_frames_and_quaternions(self) -> None:
        path = planned("gold", NORTH)
        path.path.header.frame_id = "gold/odom"
        self.expect("TF_ERROR", "gold", planning=[path])
        path = planned("gold", NORTH)
        path.path.poses[-1].pose.orientation.w = 3.0
        self.expect("INVALID_REQUEST", "gold", "quaternion", planning=[path])

    def test_fixed_schedules_that_are_wrong(self) -> None:
        fixed = self.expect("SUCCESS", planning=[planned("blue", EAST)]).schedules
        fixed[0].times = fixed[0].times[:-1]
        self.expect("INVALID_REQUEST", "blue", planning=[planned("gold", NORTH)], fixed=fixed)


if __name__ == "__main__":
    rospy.init_node("coordinate_test")
    rostest.rosrun("social_fleet", "coordinate", CoordinateTest)
