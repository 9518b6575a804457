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


SDF = """<sdf version="1.9"><model name="arm">
  <link name="base"/>
  <link name="upper"><pose relative_to="shoulder">0 0 0 0 0 0</pose>
    <collision name="c"><pose>0.25 0 0 0 0 0</pose><geometry><box><size>0.4 0.04 0.04</size></box></geometry></collision></link>
  <joint name="shoulder" type="revolute"><pose relative_to="base">0 0 1 0 0 0</pose><parent>base</parent><child>upper</child>
    <axis><xyz>0 1 0</xyz><limit><lower>-2</lower><upper>2</upper></limit></axis></joint>
</model></sdf>
"""


def test_sdf(tmp_path):
    file = tmp_path / "arm.sdf"
    file.write_text(SDF)
    robot = leeway.Robot(file)
    assert robot.name == "arm" and list(robot.joint_names) == ["shoulder"] and list(robot.links) == ["base", "upper"]
    assert robot.lower[0] == -2 and robot.upper[0] == 2
    assert robot.pose("upper", [np.pi / 2])[:3, 3] == pytest.approx([0, 0, 1])
    assert leeway.plan(robot, leeway.World(), [-1.0], [1.0])
    file.write_text(SDF.replace("box>", "bx>"))
    with pytest.raises(leeway.InputError, match=r"arm.sdf:4: the geometry <bx> is not read; box"):
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
        ({"wheels": {}}, "joint 'wheels' is planar; bounds of x and y are expected"),
        ({"wheel": {}}, "no joint is named 'wheel'; did you mean 'wheels'"),
    ]:
        with pytest.raises(ValueError, match=words):
            leeway.Robot(file, bounds=bounds)
    with pytest.raises((TypeError, ValueError), match="bounds"):
        leeway.Robot(file, bounds={"wheels": 3})
    with pytest.raises((TypeError, ValueError), match="bounds"):
        leeway.Robot(file, bounds=[1])


def test_lengths_reach_ten_kilometres(tmp_path):
    file = tmp_path / "cart.urdf"
    file.write_text(CART)
    robot = leeway.Robot(file, bounds={"wheels": {"x": (2000, 20000), "y": (-2, 2)}})
    assert leeway.plan(robot, leeway.World(), [2500, 0, 0], [9000, 0, 0])
    with pytest.raises(leeway.InputError, match="'wheels/x' at 10001; at most 10000 m is expected"):
        leeway.plan(robot, leeway.World(), [2500, 0, 0], [10001, 0, 0])
    with pytest.raises(leeway.InputError, match="'wheels/x' at 20000, which is its limit; at most 10000 m"):
        leeway.plan(robot, leeway.World(), [2500, 0, 0], ["any", 0, 0])


def test_several_arms_have_goals_of_their_own():
    files = "robots/dual_arm/dual_arm.urdf", "robots/dual_arm/dual_arm.srdf"
    robot = leeway.Robot(*files, group=["right", "left"])
    assert robot.group == "right, left" and list(robot.joint_names[:1]) == ["right_pan_joint"] and len(robot.joint_names) == 12
    mixed = leeway.Robot(*files, group=["right_pan_joint", "left"])
    assert mixed.group == "right_pan_joint, left" and mixed.joint_names[0] == "right_pan_joint" and len(mixed.joint_names) == 7
    chain = leeway.Robot(*files, chain=("left_tool", "right_tool"))
    assert sorted(chain.joint_names) == sorted(robot.joint_names)
    for wrong, words in [(dict(chain=("left_tool",)), "a pair of links"), (dict(chain=("left_tool", "nothing")), "no link 'nothing'"),
                         (dict(chain=("left_tool", "left_tool")), "no joint between"), (dict(chain=("left_tool", "right_tool"), group="left"), "group and chain both")]:
        with pytest.raises((TypeError, ValueError), match=words):
            leeway.Robot(*files, **wrong)
    assert robot.with_group(("left",)).group == "left" and robot.with_group("both").group == "both"
    up = [0, -1.5708, 0, -1.5708, 0, 0]
    turned = [0.5, *up[1:]]
    problem = leeway.Problem(robot, leeway.World(), start={"left": up, "right": "up"}, goal={"left": turned, "right": {"right_pan_joint": (-1, -0.5), **{f"right_{name}_joint": 0 for name in ("lift", "elbow", "wrist1", "wrist2", "wrist3")}}})
    assert problem.robot.group == "right, left"
    assert list(problem.start) == up + up
    assert problem.goal[0].tolist() == [-1, -0.5] and problem.goal[6].tolist() == [0.5, 0.5]
    problem.goal = {"left": turned, "right": "up"}
    result = leeway.plan(problem)
    assert result and leeway.verify(problem, result.path)
    other = leeway.Problem(robot.with_group(["left", "right"]), leeway.World(), start={"left": up, "right": "up"}, goal={"left": turned, "right": "up"})
    for measure in (leeway.clearance, leeway.verify):
        with pytest.raises(ValueError, match="path is a result of the joints right_pan_joint, .*; left_pan_joint, "):
            measure(other, result)
    problem.goal = {"left": turned, "right": "any"}
    assert np.isfinite(problem.goal).all() and problem.goal[0, 0] < problem.goal[0, 1]
    pose = leeway.FramePose("left_tool", position=robot.pose("left_tool", up + turned)[:3, 3])
    problem.goal = {"left": pose, "right": "any"}
    assert len(problem.goal) == 1 and leeway.plan(problem)
    problem.start = {"left": turned, "right": up}
    assert list(problem.start) == up + turned
    for group, words in [(["left", "both"], "groups 'left' and 'both' both have joint 'left_pan_joint'"), (["left", "left"], "group 'left' stands twice"),
                         (["lft"], "no group 'lft'; did you mean 'left'"), ([], "the name of a group, or a list"), ([1], "the name of a group, or a list")]:
        with pytest.raises((TypeError, ValueError), match=words):
            robot.with_group(group)
    for goal, words in [({"left": turned}, "goal says nothing of joint 'right_pan_joint'"), ({"left": [1], "right": up}, "6"),
                        ({"left": turned, "right": up, "left_pan_joint": 0}, "goal gives joint 'left_pan_joint' twice"),
                        ({"left": pose, "right": up}, "joint values beside the pose of a group"), ({"right": pose}, "no joint of group 'right' moves 'left_tool'"),
                        ({"left": turned, "right": "down"}, "no group state 'down'")]:
        with pytest.raises(ValueError, match=words):
            problem.goal = goal
    with pytest.raises(ValueError, match="names joint 'right_pan_joint', which the group does not have"):
        problem.start = {"left": {"right_pan_joint": 0}}
    with pytest.raises(ValueError, match="goal names joint 'right_pan_joint', which is not planned"):
        leeway.Problem(robot.with_group("left"), leeway.World(), start=up, goal={"left": turned, "right": up})


def test_a_state_that_lacks_joints_names_them():
    robot = leeway.Robot("robots/arm7/arm7.urdf", "robots/arm7/arm7.srdf")
    with pytest.raises(ValueError, match="group state 'open' lacks joints 'joint1', 'joint2'"):
        robot.state("open")


def test_warnings_of_path_files_are_python_warnings(robot, tmp_path):
    file = tmp_path / "path.csv"
    file.write_text("0,-0.6,0,-2.05,0,1.6,0\n0.1,-0.6,0,-2.05,0,1.6,0")
    problem = leeway.Problem(robot, leeway.World(), start=[0, -0.6, 0, -2.05, 0, 1.6, 0], goal=[0.1, -0.6, 0, -2.05, 0, 1.6, 0])
    with pytest.warns(UserWarning, match="path.csv:2: "):
        assert leeway.verify(problem, file)


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


def test_packages_exist(tmp_path):
    with pytest.raises(ValueError, match="package 'a' has no folder '/nothere'; an existing folder is expected"):
        leeway.Robot("robots/arm7/arm7.urdf", packages={"a": "/nothere"})
    assert leeway.Robot("robots/arm7/arm7.urdf", packages={"a": tmp_path})


def test_interpolation_ends_at_the_ends(robot):
    for t in (1.5, -1e-9, float("nan"), [0.5, 2]):
        with pytest.raises(ValueError, match="t is .*; 0 to 1 is expected|finite"):
            robot.interpolate(robot.state("ready") if "ready" in robot.states else np.zeros(7), np.zeros(7), t)


def test_joints_that_stand_outside_their_limits(tmp_path):
    """They are not planned: a warning says so."""
    (tmp_path / "r.urdf").write_text(
        '<robot name="r"><link name="a"/>'
        + "".join(
            f'<link name="{name}"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
            f'<joint name="{name}" type="revolute"><parent link="a"/><child link="{name}"/><axis xyz="0 0 1"/>'
            '<limit lower="-0.5" upper="0.5" velocity="1" effort="1"/></joint>'
            for name in "jk"
        )
        + "</robot>"
    )
    robot = leeway.Robot(tmp_path / "r.urdf").with_group("j")
    problem = leeway.Problem(robot, None, [0.0], [0.3], others={"k": 0.9})
    off = "joint 'k' at 0.9, outside its limits of -0.5 to 0.5; it is not planned and stays there"
    assert f"start has {off}" in leeway.plan(problem).warnings
    problem.save(tmp_path / "p.yaml")
    loaded = leeway.load(tmp_path / "p.yaml", cache=False)
    assert [w for w in leeway.plan(loaded).warnings if "outside" in w][0].endswith(f": joints has {off}")
    assert len([w for w in leeway.plan(loaded).warnings if "outside" in w]) == 1
