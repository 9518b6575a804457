"""Robots from files."""

import numpy as np
import pytest

import leeway

MJCF = """<mujoco model="arm">
  <compiler angle="radian"/>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1" pos="0 0 -0.3"/>
    <body name="upper">
      <joint name="shoulder" axis="0 1 0" range="-2 2"/>
      <geom type="box" size="0.2 0.02 0.02" pos="0.25 0 0"/>
    </body>
  </worldbody>
  <keyframe><key name="up" qpos="-1"/></keyframe>
</mujoco>
"""


def test_mjcf(tmp_path):
    file = tmp_path / "arm.xml"
    file.write_text(MJCF)
    robot = leeway.Robot(file)
    assert robot.name == "arm" and list(robot.joint_names) == ["shoulder"] and list(robot.links) == ["world", "upper"]
    assert robot.lower[0] == -2 and robot.upper[0] == 2
    assert robot.state("up")[0] == -1 and set(robot.states) == {"up", "qpos0"}
    assert leeway.plan(robot, leeway.World(), robot.state("up"), [0.0])
    with pytest.raises(leeway.InputError, match="goal"):
        leeway.plan(robot, leeway.World(), robot.state("up"), [9.0])
    below = leeway.plan(robot, leeway.World(), robot.state("up"), [1.0])  # in the floor
    assert not below and below.status == "invalid_goal"
    turned = robot.pose("upper", [np.pi / 2])
    assert turned[:3, 0] == pytest.approx([0, 0, -1])


def test_a_mistake_in_mjcf_has_file_and_line(tmp_path):
    file = tmp_path / "arm.xml"
    file.write_text(MJCF.replace('type="box"', 'type="bx"'))
    with pytest.raises(leeway.InputError, match=r'arm.xml:7: type of <geom> is "bx"; .*box'):
        leeway.Robot(file)
