"""Goals and starts as poses, groups of names, and tasks."""

import os
import subprocess

import numpy as np
import pytest

import leeway
from leeway import FramePose, TaskStep, Waypoint


@pytest.fixture
def tray(world):
    world.add_box("tray", (0.2, 0.2, 0.02), position=(0.3, 0.4, 0.2))
    return world


def test_a_pose_as_goal_is_reached_and_reads_back(robot, tray):
    start = robot.state("ready")
    start[0] = -0.8
    above = FramePose("grip", (0, 0, (0.2, 0.25)), rpy=(np.pi, 0, "any"), relative_to="tray")
    assert above.position.tolist() == [[0, 0], [0, 0], [0.2, 0.25]] and above.rpy[2].tolist() == [-np.pi, np.pi]
    problem = leeway.Problem(robot, tray, start, above, frames={"grip": ("hand", (0, 0, 0.09))}, margin=0.01)
    link, X_LF = problem.frames["grip"]
    result = leeway.plan(problem)
    assert result and link == "hand" and leeway.verify(problem, result)
    X_WF = robot.pose("hand", result.path[-1]) @ X_LF
    assert np.allclose(X_WF[:2, 3], (0.3, 0.4), atol=1e-8) and 0.4 - 1e-8 <= X_WF[2, 3] <= 0.45 + 1e-8
    assert np.allclose(X_WF[:3, 2], (0, 0, -1), atol=1e-8)
    assert leeway.Scene(problem).check("goal").valid
    # What a problem holds is a goal again: of another problem, without the names.
    again = leeway.Problem(robot, tray, start, problem.goal, margin=0.01)
    assert [pose.frame for pose in again.goal] == ["hand"]
    assert leeway.plan(again).path.tobytes() == result.path.tobytes()
    either = leeway.plan(problem, goals=[FramePose("hand", (3, 0, 0)), problem.goal])
    assert either and either.goal == 1 and len(either.problem.goals) == 2


def test_a_pose_as_start_becomes_joint_values(robot, world):
    X = robot.pose("hand", robot.state("ready"))
    X[:3, 3] += (0, -0.3, 0)
    start = FramePose("hand", X[:3, 3], rpy=(np.pi, 0, "any"))
    problem = leeway.Problem(robot, world, start, "tucked", margin=0.01)
    assert np.allclose(robot.pose("hand", problem.start)[:3, 3], X[:3, 3], atol=1e-8)
    assert leeway.check(problem).valid and leeway.plan(problem)
    problem.start = robot.state("ready")
    problem.start = start
    assert np.allclose(robot.pose("hand", problem.start)[:3, 3], X[:3, 3], atol=1e-8)
    with pytest.raises(leeway.InputError, match="start: out of reach"):
        leeway.Problem(robot, world, FramePose("hand", (3, 0, 0)), "tucked")
    far = leeway.Problem(robot, world, "tucked", FramePose("hand", (3, 0, 0)))
    with pytest.raises(leeway.InputError, match="goal 'goal': out of reach"):  # not the start
        leeway.check(far, state="goal")


def test_an_unreachable_pose_is_proven_so(robot, world):
    result = leeway.plan(robot, world, "tucked", FramePose("hand", (3, 0, 0)))
    assert not result and result.status == "invalid_goal" and result.unreachable and "out of reach" in result.reason
    for wrong, message in ((FramePose("hnd", (0, 0, 0)), "did you mean 'hand'"), (FramePose("hand", (0, 0, 0), relative_to="pst"), "'pst'"),
                           ([FramePose("hand", (0, 0, 0)), 1], "poses alone")):
        with pytest.raises((ValueError, TypeError), match=message):
            leeway.plan(robot, world, "tucked", wrong)


def test_margins_of_groups(robot, tray):
    problem = leeway.Problem(robot, tray, "tucked", "ready", margins={("robot", ("post", "tray")): 0.02, ("hand", "tray"): 0.03})
    assert problem.margins == {("robot", "post"): 0.02, ("robot", "tray"): 0.02, ("hand", "tray"): 0.03}
    problem.allowed = [(("hand", "tool"), "post")]
    assert problem.allowed == [("hand", "post"), ("tool", "post")]
    for wrong in ({("hand", "pst"): 1}, {("hand", "hand"): 1}, {("hand",): 1}, {("hand", (1, 2)): 1}):
        with pytest.raises((ValueError, TypeError), match="margins"):
            problem.margins = wrong


def test_the_shipped_task_and_its_twin_in_python(tmp_path):
    command = os.environ["LEEWAY_COMMAND"]
    shipped = leeway.load("problems/pick_place/can.yaml")
    result = leeway.plan(shipped)
    assert result and [step.name for step in result.steps] == [step.name for step in shipped.steps]
    assert result.steps[0].first == 0 and result.steps[-1].last == len(result.path) - 1
    assert all(step.deviation <= 1e-3 for step in result.steps) and result.certificate.world.closest
    assert leeway.verify(shipped, result) and leeway.verify(shipped, result.path).status == "refuted"
    result.save(tmp_path / "ours.json")
    subprocess.run([command, "plan", "problems/pick_place/can.yaml", "--output", tmp_path / "its.json"], check=True, capture_output=True)
    assert (tmp_path / "ours.json").read_bytes() == (tmp_path / "its.json").read_bytes()

    down, up = (np.pi, 0, "any"), dict(relative_to="world")
    robot = shipped.robot
    made = leeway.Problem(
        robot, shipped.world, "ready", others={"finger_joint": 0.034}, frames=shipped.frames, margin=0.005, time=20,
        margins={("can", ("finger_left", "finger_right", "hand")): 0, ("can", "bin"): 0.001},
        steps=[TaskStep.move(FramePose("grip", (0, 0, 0.12), rpy=down, relative_to="can"), name="above"),
               TaskStep.line("grip", (0, 0, 0.1), name="approach"),
               TaskStep.attach("can", "hand", ["finger_left", "finger_right"]),
               TaskStep.line("grip", (0, 0, 0.08), **up, allowed=[("can", "table")]),
               TaskStep.move(FramePose("can", ((-0.08, 0.08), (-0.08, 0.08), 0.2), rpy=(0, 0, "any"), relative_to="bin")),
               TaskStep.line("can", (0, 0, -0.128), **up), TaskStep.detach("can"),
               TaskStep.line("grip", (0, 0, -0.12)), TaskStep.move("ready")])
    twin = leeway.plan(made)
    assert [step.name for step in twin.steps] == ["above", "approach", "attach", "line", "move", "line 2", "detach", "line 3", "move 2"]
    assert twin.path.tobytes() == result.path.tobytes()
    assert [s.kind for s in made.steps] == ["move", "line", "attach", "line", "move", "line", "detach", "line", "move"]
    made.steps = made.steps  # as they read back
    assert leeway.plan_many([made])[0].path.tobytes() == result.path.tobytes()


def test_moves_to_values_are_saved(robot, tmp_path):
    values = robot.state("upright")
    for goal in (values, list(values), dict(zip(robot.joint_names, values)), "upright"):
        for name in (None, "home"):
            problem = leeway.Problem(robot, leeway.World(), "ready", steps=[TaskStep.move(goal, name=name), TaskStep.move("ready")])
            problem.save(tmp_path / "task.yaml")
            assert leeway.plan(leeway.load(tmp_path / "task.yaml")).path.tobytes() == leeway.plan(problem).path.tobytes()


def test_a_task_that_fails_says_where(robot, world):
    start = robot.state("ready")
    start[0] = -0.8
    problem = leeway.Problem(robot, world, start, steps=[TaskStep.move(start), TaskStep.move("ready")])
    problem.steps.append(TaskStep.move(start))
    assert [step.name for step in problem.copy().steps] == ["move", "move 2", "move 3"]
    stuck = leeway.plan(robot, world, start, steps=[TaskStep.move(start), TaskStep.move("ready", name="into the post")], margin=0.01)
    assert not stuck and "step 2 (into the post)" in stuck.reason and "post" in stuck.reason
    for steps in ([TaskStep.detach("post")], [TaskStep.attach("post", "nothing")], [TaskStep.line("nothing", (0, 0, 1))], ["ready"]):
        with pytest.raises((ValueError, TypeError)) as error:
            leeway.plan(robot, world, start, steps=steps)
        assert "\n" not in str(error.value)
    with pytest.raises(ValueError, match="beside a goal"):
        leeway.plan(robot, world, start, "tucked", steps=[TaskStep.move("ready")])
    assert leeway.plan(stuck.problem, goal="tucked").steps == []


def test_a_line_goes_through_poses(robot):
    world = leeway.World()
    X = robot.pose("hand", robot.state("ready"))
    X[:3, 3] = (0.5, 0.1, 0.45)
    way = [Waypoint((0.5, 0.1, 0.45), rpy=(3, 0.1, 3)), Waypoint((0.5, -0.1, 0.45), via=(0.47, 0, 0.47))]
    for poses, count in ((way, 2), (np.array([[0.5, 0.1, 0.45], [0.5, 0, 0.45]]), 2), ([X], 1), ([(0.5, 0.1, 0.45, 0.8, 0.6, 0, 0)], 1)):
        result = leeway.plan(robot, world, "ready", steps=[TaskStep.line("hand", poses=poses)])
        assert result and result.line_end is None, result.reason
        assert result.steps[0].places[0] == 0 and result.steps[0].places[-1] == count
        assert len(result.steps[0].places) == len(result.path) and result.steps[0].deviation <= 1e-3
        assert leeway.verify(result.problem, result)
    assert "Waypoint at (0.5, 0.1, 0.45)" in repr(way[0]) and way[0].position.tolist() == [0.5, 0.1, 0.45]


def test_a_line_that_ends_early_gives_its_part(robot, tmp_path):
    result = leeway.plan(robot, leeway.World(), "ready", steps=[TaskStep.line("hand", poses=[(0.5, 0.1, 0.45), (0.5, 0.1, 2)], name="up")])
    assert result.status == "partial" and not result and len(result.path) > 1 and "it ends after" in result.reason
    assert result.line_end["step"] == "up" and result.line_end["waypoint"] == 1 and 0 < result.line_end["share"] < 1
    assert result.line_end["why"] in ("limit", "singularity")
    assert result.steps[0].places[-1] == 1 + result.line_end["share"] and result.certificate.certified
    assert leeway.verify(result.problem, result).status == "refuted"
    result.save(tmp_path / "part.json")
    assert result.trajectory().duration > 0


def test_a_line_turns(robot):
    result = leeway.plan(robot, leeway.World(), "ready", steps=[TaskStep.line("hand", (0, 0, 0.05), rpy=(0, 0, 0.3)), TaskStep.line("hand", rpy=(0, 0, -0.3))])
    assert result and leeway.verify(result.problem, result)


def test_a_line_of_a_file(robot, tmp_path):
    file = tmp_path / "way.csv"
    file.write_text("x,y,z\n0.5,0.1,0.45\n")
    result = leeway.plan(robot, leeway.World(), "ready", steps=[TaskStep.load_line(file, "hand")])
    assert result and result.steps[0].places[-1] == 1
    with pytest.raises(leeway.InputError, match="does not say which frame"):
        TaskStep.load_line(file)
    (tmp_path / "long.csv").write_text("0.5,0.1,0.45,1.00001,0,0,0\n")
    with pytest.warns(UserWarning, match="long.csv:1"):
        TaskStep.load_line(tmp_path / "long.csv", "hand")


def test_wrong_lines_are_refused(robot):
    for arguments, message in (({}, "goes nowhere"), ({"by": (0, 0, 0)}, "of no length"), ({"by": (0, 0, 1), "poses": [(0, 0, 1)]}, "stands beside poses"),
                               ({"poses": []}, "poses is empty"), ({"poses": [(0, 0)]}, "poses"), ({"rpy": (0, 0, float("nan"))}, "rpy")):
        with pytest.raises(ValueError, match=message):
            TaskStep.line("hand", **arguments)
    with pytest.raises(leeway.InputError, match="did you mean 'hand'"):
        leeway.plan(robot, leeway.World(), "ready", steps=[TaskStep.line("hnd", poses=[(0.5, 0, 0.4)])])
