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


CART = """<robot name="cart"><link name="odom"/><link name="base"><collision><geometry><box size="0.6 0.4 0.2"/></geometry></collision></link>
<joint name="wheels" type="planar"><parent link="odom"/><child link="base"/><axis xyz="0 0 1"/></joint></robot>"""


def test_bounds_and_base_poses(tmp_path):
    file = tmp_path / "cart.urdf"
    file.write_text(CART)
    start, goal = [-3, 0, 0], [3, 0, 0]
    with pytest.raises(leeway.InputError, match="'wheels/x' has no limits; .* under 'bounds'"):
        leeway.plan(leeway.Robot(file), leeway.World(), start, goal)
    robot = leeway.Robot(file, bounds={"wheels": {"x": (-5, 4), "y": (-2, 2)}}, base_pose=(0, 10, 0, 0, 0, 0, 1))
    assert list(robot.lower[:2]) == [-5, -2] and list(robot.upper[:2]) == [4, 2] and np.isinf(robot.upper[2])
    assert list(robot.state("middle")) == [-0.5, 0, 0] and list(robot.state("zero")) == [0, 0, 0]
    assert robot.pose("base", [1, 0, 0])[:3, 3] == pytest.approx([1, 10, 0])
    world = leeway.World()
    world.add_box("crate", (1, 1, 1), position=(0, 10, 0))
    result = leeway.plan(robot, world, start, goal)
    assert result and result.length > 6
    for bounds, words in [
        ({"wheel": {"x": (0, 1)}}, "no joint is named 'wheel'; did you mean 'wheels'"),
        ({"wheels": {"z": (0, 1)}}, "axis 'z' is not known; x or y is expected"),
        ({"wheels": {"x": (1, 0)}}, "the lower bound 1 of joint 'wheels/x' is above the upper bound 0"),
        ({"wheels": {"x": (0,)}}, "bounds: wheels"),
        ({"wheels": (0, 1)}, "joint 'wheels' is planar; bounds of x and y are expected"),
    ]:
        with pytest.raises(ValueError, match=words):
            leeway.Robot(file, bounds=bounds)
    with pytest.raises((TypeError, ValueError), match="bounds"):
        leeway.Robot(file, bounds={"wheels": 3})
    with pytest.raises((TypeError, ValueError), match="bounds"):
        leeway.Robot(file, bounds=[1])


BALLS = """<robot name="balls"><link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="neck"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<link name="hub"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="a" type="revolute"><parent link="base"/><child link="neck"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="b" type="revolute"><parent link="neck"/><child link="hub"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
</robot>"""


def test_auto_allows_links_that_touch_at_rest(tmp_path):
    file = tmp_path / "balls.urdf"
    file.write_text(BALLS)
    robot, world = leeway.Robot(file), leeway.World()
    world.add_sphere("far", 0.1, position=(1, 0, 0))
    assert leeway.plan(robot, world, [0, 0], [1, 1]).status == "invalid_start"
    for allowed in ("auto", ["auto"], [("hub", "far"), "auto"]):
        problem = leeway.Problem(robot, world, start=[0, 0], goal=[1, 1], allowed=allowed)
        assert problem.allowed[-1] == ("base", "hub")
        assert "'auto' allows a pair of links, which touch with all joints at zero" in problem.warnings[-1]
        assert leeway.plan(problem)
    with pytest.raises(TypeError, match="allowed"):
        leeway.Problem(robot, world, start=[0, 0], goal=[1, 1], allowed="all")


def test_margins_of_the_whole_world_hold_for_what_comes_later(robot):
    problem = leeway.Problem(robot, start="ready", goal=[0, -0.6, 0, -2.05, 0, 1.6, 0], margins={("robot", "world"): 5})
    assert problem.margins == {("robot", "world"): 5}
    assert leeway.plan(problem)
    problem.world.add_box("later", (0.1, 0.1, 0.1), position=(3, 0, 0))
    assert leeway.plan(problem).status == "invalid_start"
    problem.margins["hand", "world"] = 0.1
    assert problem.margins == {("robot", "world"): 5, ("hand", "world"): 0.1}


BOOM = """<robot name="boom"><link name="base"/><link name="boom"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="boom"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""


def test_limits_of_joints(tmp_path):
    file = tmp_path / "boom.urdf"
    file.write_text(BOOM)
    limits = tmp_path / "joint_limits.yaml"
    limits.write_text("joint_limits: {turn: {max_velocity: 0.5, max_position: 2}}")
    robot = leeway.Robot(file, joint_limits=limits)
    assert (robot.lower[0], robot.upper[0]) == (-3, 2)
    assert leeway.plan(robot, leeway.World(), [0], [1]).trajectory().duration > 2  # at 0.5 rad/s
    robot = leeway.Robot(file, joint_limits=limits, bounds={"turn": (-1, 1)})
    assert (robot.lower[0], robot.upper[0]) == (-1, 1)
    robot = leeway.Robot(file, bounds={"turn": {"range": (-4, 5), "widen": True}})
    assert (robot.lower[0], robot.upper[0]) == (-4, 5)
    for bounds, words in [
        ({"turn": (-4, 5)}, "the bounds of joint 'turn' are -4 to 5, outside its own limits"),
        ({"turn": {"range": (-4, 5)}}, "a range within -3 to 3, or 'widen', is expected"),
        ({"turn": {"range": (-4, 5), "x": (0, 1)}}, "turn has 'x' beside 'range'"),
        ({"turn": {"widen": True}}, "no 'range' beside 'widen'"),
        ({"turn": {"range": (-4, 5), "widen": 1}}, "widen: True or False is expected"),
    ]:
        with pytest.raises((TypeError, ValueError), match=words):
            leeway.Robot(file, bounds=bounds)
    limits.write_text("joint_limits: {trun: {max_velocity: 1}}")
    with pytest.raises(leeway.InputError, match="no joint 'trun'; did you mean 'turn'"):
        leeway.Robot(file, joint_limits=limits)


def test_unsolved_says_what_was_in_the_way(tmp_path):
    file = tmp_path / "boom.urdf"
    file.write_text(BOOM)
    world = leeway.World()
    world.add_box("post", (0.2, 0.2, 1), position=(0.7, 0, 0))
    result = leeway.plan(leeway.Robot(file), world, [-2], [2], iterations=200)
    assert result.status == "unsolved"
    assert result.blocked[0][:2] == ("boom", "post") and result.blocked[0][2] > 0
    distance, start, goal = result.gap
    assert start[0] < 0 < goal[0] and distance > 0.2
    assert result.long_turns == ["turn"]
    wide = leeway.Robot(file, bounds={"turn": {"range": (-6, 6), "widen": True}})
    assert leeway.plan(wide, world, [-2], [2 - 2 * np.pi]) and leeway.plan(wide, world, [-2], [-1]).gap is None
