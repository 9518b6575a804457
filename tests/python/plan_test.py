"""Plans, proofs, files and times, as a user of the command has them."""

import json
import math
import os
import subprocess
import sys
import threading

import numpy as np
import pytest

import leeway


def turned(robot, angle):
    q = robot.state("ready")
    q[0] = angle
    return q


def same(a, b):
    return a.path.tobytes() == b.path.tobytes() and a.certificate.edges.tobytes() == b.certificate.edges.tobytes()


def test_plan_is_certified_and_verified(robot, world):
    result = leeway.plan(robot, world, turned(robot, -0.8), turned(robot, 0.8), margin=0.01)
    assert result and result.status == "solved"
    assert result.certificate.lower >= 0.01
    assert result.certificate.certified
    assert np.array_equal(result.path[0], turned(robot, -0.8)) and np.array_equal(result.path[-1], turned(robot, 0.8))
    assert result.certificate.edges.shape == (len(result.path) - 1, 2)
    assert result.length == pytest.approx(sum(robot.distance(a, b) for a, b in zip(result.path, result.path[1:])))
    verified = leeway.verify(result.problem, result)
    assert verified.status == "certified" and 0.01 <= verified.lower <= result.certificate.upper
    straight = np.array([result.path[0], result.path[-1]])
    assert leeway.verify(result.problem, straight).status == "refuted"
    measured = leeway.clearance(result.problem, result, parts=2)
    assert len(measured.edges) == 2 * (len(result.path) - 1)
    assert measured.lower <= result.certificate.upper and result.certificate.lower <= measured.upper


def test_the_same_bytes_as_the_cpp_twin(robot, world):
    """README's C++ program and the same in Python."""
    twin = os.environ["LEEWAY_PYTHON_TWIN"]
    printed = subprocess.run([twin], capture_output=True, text=True, check=True).stdout.splitlines()
    result = leeway.plan(robot, world, turned(robot, -0.8), turned(robot, 0.8), margin=0.01)
    numbers = [*result.path.ravel(), *result.certificate.edges.ravel(), result.length]
    assert numbers == [float(line) for line in printed]


def test_command_and_module_write_the_same_file(tmp_path):
    command = os.environ["LEEWAY_COMMAND"]
    problem = leeway.load("problems/table/posts.yaml")
    leeway.plan(problem, seed=3).save(tmp_path / "ours.json")
    subprocess.run([command, "plan", "problems/table/posts.yaml", "--seed", "3", "--output", tmp_path / "its.json"], check=True,
                   capture_output=True)
    assert (tmp_path / "ours.json").read_bytes() == (tmp_path / "its.json").read_bytes()
    assert leeway.verify(problem, tmp_path / "its.json")


def test_settings_of_a_call_do_not_change_the_problem(shelf):
    before = shelf.seed, shelf.margin
    result = leeway.plan(shelf, seed=7, margin=0.005)
    assert result.seed == 7 and result.problem.margin == 0.005
    assert (shelf.seed, shelf.margin) == before


def test_problems_are_values(robot, world):
    problem = leeway.Problem(robot, world, "ready", "tucked", margin=0.01)
    other = problem.copy()
    other.margin = 0.02
    other.goal = {name: 0 for name in robot.joint_names} | {"joint1": (-1, 1), "joint2": "any"}
    assert problem.margin == 0.01 and other.margin == 0.02
    assert other.goal.shape == (7, 2) and list(other.goal[0]) == [-1, 1]
    world.add_sphere("ball", 0.1)
    assert problem.world.names == ["post"]
    result = leeway.plan(problem, iterations=1)
    problem.seed = 9
    assert result.problem.seed == 1


def test_every_setting_reads_back(robot, world):
    settings = dict(name="n", margin=0.01, margins={("post", "hand"): 0.02}, allowed=[("post", "base")], objective="clearance",
                    clearance_of="all", at_most_longer=0.2, push=False, planner="RRTConnect", parameters={"range": "0.5"}, simplify=False, time=0.5, iterations=10, seed=4, start_time=1.0,
                    step=0.1, duration=3.0, speed=0.5, velocities={"joint1": 1.0}, accelerations={"joint2": 2.0}, jerks={},
                    acceleration_scale=0.5, jerk_scale=0.25, corners="stop", foresight="speed_bound", look_ahead=0.3, buffer=0.0, patience=0.0)
    problem = leeway.Problem(robot, world, "ready", "tucked", **settings)
    for name, value in settings.items():
        assert getattr(problem, name) == value, name
        setattr(problem, name, value)
    costs = {"weighted": {"length": 1.0, "integral": [{"hinge": 0.1, "of": "world", "weight": 2.0}],
                          "worst": [{"inverse": 0.02, "of": "all", "weight": 1.0}]}}
    problem.objective = costs
    assert problem.objective == costs and problem.at_most_longer is None
    problem.objective = "length"
    problem.wishes = {("robot", "post"): 0.1, ("hand", ("post",)): (0.2, 3.0)}
    assert problem.wishes[("hand", "post")] == (0.2, 3.0) and len(problem.wishes) == 2
    problem.wishes = {}
    problem.keep = 0.02
    assert problem.keep == 0.02 and problem.clearance_of is None
    problem.keep = None
    assert problem.keep is None
    assert problem.others["finger_joint"] == 0
    problem.others = {"finger_joint": 0.03}
    assert problem.others["finger_joint"] == 0.03


def test_costs_are_told_as_intervals_and_wishes_as_kept_or_not(robot, world):
    problem = leeway.Problem(robot, world, turned(robot, -0.8), turned(robot, 0.8), margin=0.005, iterations=300, time=20)
    plain = leeway.plan(problem)
    assert plain.cost is None and plain.wishes == []
    cost = leeway.plan(problem, objective={"weighted": {"length": 0.2, "integral": {"hinge": 0.1}}})
    lower, upper = cost.cost
    assert 0.2 * cost.length <= upper and lower <= upper <= 1.02 * lower
    for weight in (1e-3, 30):
        wished = leeway.plan(problem, wishes={("robot", "post"): (0.04, weight)})
        [wish] = wished.wishes
        assert wish["between"] == "robot and post" and wish["wish"] == 0.04
        assert wish["kept"] is (wish["clearance"][0] >= 0.04)
        assert (wish["cost"][1] == 0) == wish["kept"] and wish["cost"][0] <= wish["cost"][1]
    safest = leeway.plan(problem, objective="clearance", at_most_longer=0.1)
    assert safest.certificate.world.lower >= plain.certificate.world.lower
    for wrong in ({"integral": {}}, {"integral": {"hinge": 0}}, {"integral": {"hinge": 1, "weight": 1}}, {"weighted": {"size": 1}}, {"total": 1}):
        with pytest.raises(ValueError):
            problem.objective = wrong
    with pytest.raises(ValueError):
        leeway.plan(problem, objective={"weighted": {}})
    with pytest.raises(ValueError, match="beside the objective clearance"):
        leeway.plan(problem, objective="clearance", wishes={("robot", "post"): 0.04})
    with pytest.raises(ValueError):
        problem.at_most_longer = 0.1


def test_world_and_self_are_told_apart_and_a_clearance_is_kept(robot, world):
    problem = leeway.Problem(robot, world, turned(robot, -0.8), turned(robot, 0.8), margin=0.005)
    plain, wide = leeway.plan(problem), leeway.plan(problem, keep=0.04)
    for result in (plain, wide):
        proof = result.certificate
        assert "post" in proof.world.closest and "post" not in proof.self.closest
        assert proof.lower == min(proof.world.lower, proof.self.lower)
        assert 0 <= proof.self.closest_edge < len(proof.edges) and proof.world.point_a.shape == (3,)
        assert leeway.verify(result.problem, result)
    assert plain.certificate.world.upper < 0.04 <= wide.certificate.world.lower
    assert leeway.plan(problem, push=False).times["push"] < 1e-5


def test_many_problems_give_the_same_bytes_for_any_number_of_threads(shelf):
    problems = [shelf.copy() for _ in range(6)]
    for seed, problem in enumerate(problems):
        problem.seed = seed + 1
    one = leeway.plan_many(problems, threads=1)
    three = leeway.plan_many(problems, threads=3)
    assert all(same(a, b) and a.seed == i + 1 for i, (a, b) in enumerate(zip(one, three)))
    assert all(same(leeway.plan(problem), result) for problem, result in zip(problems[:2], one))


def test_threads_share_robots_and_worlds(robot, world):
    results = [None] * 4

    def work(i):
        results[i] = leeway.plan(robot, world, turned(robot, -0.8), turned(robot, 0.8), margin=0.01)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(same(results[0], result) for result in results)


def test_invalid_start_says_what_is_in_the_way(robot, world):
    result = leeway.plan(robot, world, "ready", turned(robot, 0.8), margin=0.01)
    assert not result and result.status == "invalid_start" and "post" in result.offending
    assert result.path.shape == (0, 7)
    with pytest.raises(ValueError, match="invalid_start"):
        result.save("nowhere.json")
    with pytest.raises(ValueError, match="invalid_start"):
        result.trajectory()


def test_stop_progress_and_failing_callbacks():
    sealed = leeway.load("problems/unsolvable/sealed.yaml")
    result = leeway.plan(sealed, time=60, iterations=0, stop=lambda: True)
    assert result.status == "not_compiled"
    phases = []
    leeway.plan(sealed, iterations=200, progress=lambda phase, seconds: phases.append((phase, seconds)))
    assert phases and all(seconds >= 0 for _, seconds in phases)
    with pytest.raises(ZeroDivisionError):
        leeway.plan(sealed, time=60, iterations=0, stop=lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        leeway.plan(sealed, time=60, iterations=0, progress=lambda phase, seconds: 1 / 0)
    better = []
    shelf = leeway.load("problems/shelf/reach.yaml")
    result = leeway.plan(shelf, parameters={"improve": "0.3"}, on_path=lambda path, length: better.append((path, length)))
    assert result and better and all(path.shape[1] == 7 and leeway.verify(shelf, path) for path, _ in better)
    lengths = [length for _, length in better]
    assert lengths == sorted(lengths, reverse=True)
    with pytest.raises(ZeroDivisionError):
        leeway.plan(shelf, parameters={"improve": "0.3"}, on_path=lambda path, length: 1 / 0)
    with pytest.raises(KeyError):
        leeway.plan_many([sealed, sealed], time=60, iterations=0, threads=2, stop=lambda: {}["no"])


def test_trajectory_keeps_the_limits_and_the_path(shelf, tmp_path):
    result = leeway.plan(shelf, accelerations=5)
    trajectory = result.trajectory(period=0.02)
    assert trajectory.times[0] == 0 and trajectory.times[-1] == trajectory.duration
    assert np.array_equal(trajectory.positions[0], result.path[0])
    assert np.array_equal(trajectory.positions[-1], result.path[-1])
    assert trajectory.positions.shape == trajectory.velocities.shape == (len(trajectory.times), 7)
    assert np.all(np.abs(trajectory.accelerations) <= 5 * (1 + 1e-9))
    assert np.array_equal(trajectory.position(trajectory.times), trajectory.positions)
    assert trajectory.position(-1.0).shape == (7,)
    trajectory.save(tmp_path / "timed.json")
    saved = json.loads((tmp_path / "timed.json").read_text())
    assert len(saved["points"]) >= len(trajectory.times)


def test_blends_are_proven_as_they_are_executed(shelf, tmp_path):
    result = leeway.plan(shelf, jerks=60, acceleration_scale=0.8)
    trajectory = result.trajectory(period=0.02)
    assert trajectory.blends > 0
    assert trajectory.duration < leeway.plan(shelf, jerks=60, acceleration_scale=0.8, corners="stop").trajectory().duration
    assert leeway.verify(result.problem, trajectory)
    for name in ("timed.json", "timed.yaml", "timed.csv"):
        trajectory.save(tmp_path / name)
        assert leeway.verify(result.problem, tmp_path / name)
    saved = json.loads((tmp_path / "timed.json").read_text())
    assert saved["certificate"]["interpolation"] == "cubic" and len(saved["certificate"]["blended_corners"]) == trajectory.blends
    times = np.linspace(0, trajectory.duration, 20001)
    q, h = trajectory.position(times), times[1]
    assert np.abs(np.diff(q, 3, axis=0)).max() <= 60 * h**3 * (1 + 1e-6) + 1e-14
    # Elsewhere rows are a path of lines, and a warning says so.
    with pytest.warns(UserWarning, match="lines join its rows"):
        leeway.clearance(result.problem, tmp_path / "timed.json")


def test_attach_and_detach(robot):
    world = leeway.World()
    world.add_box("part", (0.02, 0.02, 0.02), position=robot.pose("hand", robot.state("ready"))[:3, 3] + (0, 0, 0.3))
    problem = leeway.Problem(robot, world, "ready", "tucked")
    held = problem.attach("part", "hand", ["finger_left"])
    assert len(held.world) == 0 and len(problem.world) == 1
    back = held.detach("part")
    assert np.allclose(back.world.pose("part"), world.pose("part"), atol=1e-12)


def test_moveit_and_free_bodies(tmp_path):
    robot = leeway.Robot("robots/arm7/arm7.urdf", "robots/arm7/arm7.srdf")
    problem = leeway.Problem.load_moveit(robot, "problems/moveit/scene0001.yaml", "problems/moveit/request0001.yaml")
    assert leeway.plan(problem)
    body = leeway.Robot.free_body("brick", [leeway.Shape.box((0.2, 0.1, 0.1))], lower=(-2, -2, -2), upper=(2, 2, 2))
    wall = leeway.World()
    wall.add("wall", [(leeway.Shape.box((0.05, 4, 1.5)), (0, 0, 1.25)), (leeway.Shape.box((0.05, 4, 1.5)), (0, 0, -1.25))])
    at = [-1, 0, 0, 0, 0, 0, 1], [1, 0, 0.3, 0, 0, 0, 1]
    result = leeway.plan(body, wall, *at, margin=0.01)
    assert result and leeway.verify(result.problem, result)


def test_replanning_among_obstacles_that_deform(tmp_path):
    problem = leeway.load("problems/deforming/curtain.yaml")
    steps = []
    executed = leeway.replan(problem, on_step=steps.append, steps=5)
    assert executed.status in ("stopped", "reached") and executed.certified
    (tmp_path / "run.jsonl").write_text("\n".join([*(step.log for step in steps), executed.log, ""]))
    assert leeway.verify_log(problem, str(tmp_path / "run.jsonl"))
    assert [step.index for step in steps] == list(range(len(steps)))
    assert all(step.certified and step.lower > 0 for step in steps)
    replanner = leeway.Replanner(problem)
    for other in steps[:2]:
        step = replanner.step()
        assert step.motion.tobytes() == other.motion.tobytes()
    assert replanner.time == steps[1].motion[-1, 0] and np.array_equal(replanner.state, steps[1].motion[-1, 1:])
    assert replanner.scene.check(replanner.state)


def test_replanner_follows_vertices_from_numpy(robot, tmp_path):
    x, y = np.meshgrid(np.linspace(-0.2, 0.2, 5), np.linspace(-0.2, 0.2, 5))
    sheet = np.column_stack([x.ravel(), y.ravel(), np.zeros(25)])
    corner = np.array([i * 5 + j for i in range(4) for j in range(4)])
    triangles = np.concatenate([np.column_stack([corner, corner + 1, corner + 6]), np.column_stack([corner, corner + 6, corner + 5])])
    world = leeway.World()
    world.add_deforming("sheet", sheet, triangles, speed_bound=0.1, position=(0.6, 0, 0.1))
    replanner = leeway.Replanner(robot, world, "ready", turned(robot, 0.8), margin=0.01)
    log = []
    while not replanner.reached:
        replanner.set_vertices("sheet", sheet, speed_bound=0.1)
        sheet[:, 2] += 0.002
        step = replanner.step()
        assert step.certified
        log.append(step.log)
    with pytest.raises(ValueError):
        replanner.set_vertices("sheet", sheet[:-1])
    executed = replanner.executed
    assert executed and executed.status == "reached" and executed.steps == len(log) and executed.trajectory.shape == (0, 8)
    file = tmp_path / "run.jsonl"
    file.write_text("\n".join([*log, executed.log, ""]))
    problem = leeway.Problem(robot, world, "ready", turned(robot, 0.8), margin=0.01)
    proven = leeway.verify_log(problem, file)
    assert proven and proven.lower > 0.01 and proven.line == 0, proven
    assert json.loads(log[0])["observed"][0]["vertices"][3] == [*sheet[3, :2], 0]
    file.write_text("\n".join([*log, ""]))
    cut = leeway.verify_log(problem, file)
    assert cut.status == "undecided" and cut.line == len(log) and "cut" in cut.reason
    file.write_text("\n".join([*log[1:], executed.log, ""]))
    missing = leeway.verify_log(problem, file)
    assert missing.status == "refuted" and missing.line == 1 and missing.edge == -1
    file.write_text("\n".join([log[0], log[1].replace('"certified":true', '"certified":false'), ""]))
    with pytest.raises(leeway.InputError, match="run.jsonl:2: the line was changed"):
        leeway.verify_log(problem, file)


def test_a_guard_passes_polynomials(robot, world):
    start = turned(robot, -0.8)
    guard = leeway.Guard(robot, world, start, margin=0.01, accelerations=2, most_setpoints=200)
    terms = np.zeros((7, 3))
    terms[:, 0] = start
    terms[0, 2] = 0.5  # from rest, 1 rad/s^2
    answer = guard.check(polynomials=terms, duration=0.5)
    assert answer and answer.passed == 25 == answer.on_polynomials
    assert answer.motion[24, 0] == pytest.approx(start[0] + 0.125)
    terms[0] = start[0] + 0.125, 0.5, 0
    answer = guard.check(polynomials=terms, duration=4)
    assert 10 < answer.passed < 200 and answer.certified and "post" in answer.pair and answer.in_stop
    elsewhere = guard.check(polynomials=terms, duration=0.5)
    assert elsewhere.reason == "invalid" and elsewhere.certified
    terms[0, 0] = np.nan
    assert guard.check(polynomials=terms, duration=0.5).reason == "invalid"
    for wrong in (dict(polynomials=terms), dict(duration=1), dict(polynomials=terms[:6], duration=1), dict(polynomials=start, duration=1),
                  dict(setpoints=[start], polynomials=terms, duration=1)):
        with pytest.raises(ValueError, match="polynomials"):
            guard.check(**wrong)


def test_a_guard_passes_what_has_room_to_stop(robot, world):
    start = turned(robot, -0.8)
    guard = leeway.Guard(robot, world, start, margin=0.01, accelerations=2, joint_errors=0.001, most_setpoints=200)
    speed = np.minimum(0.5, 0.03 * np.arange(1, 151))
    chunk = np.tile(start, (150, 1))
    chunk[:, 0] += 0.02 * np.cumsum(speed)
    answer = guard.check(chunk)
    assert 10 < answer.passed < 100 and answer.certified and not answer and answer.in_stop
    assert answer.reason == "not_free" and "post" in answer.pair and answer.joint is None and answer.limit is None
    assert np.array_equal(answer.motion[:answer.passed], chunk[:answer.passed]) and len(answer.motion) > answer.passed
    assert np.array_equal(answer.start, start) and answer.time == 0 and answer.edges > 0 and answer.work > 0
    assert guard.next_time == pytest.approx(0.02 * answer.passed)
    scene = leeway.Scene(robot, world, margin=0.01)
    assert all(scene.check(row) for row in answer.motion)
    again = leeway.Guard(robot, world, start, margin=0.01, accelerations=2, joint_errors=[0.001] * 7, most_setpoints=200).check(chunk)
    assert np.array_equal(again.motion, answer.motion)
    stopping = guard.check()
    assert stopping and stopping.passed == 0 and np.array_equal(stopping.motion, answer.motion[answer.passed:])
    fast = guard.check([turned(robot, 0.8)], time=10)
    assert (fast.reason, fast.limit, fast.joint) == ("limit", "velocity", "joint1") and fast.value > fast.allowed
    for nan in (dict(setpoints=[[np.nan] * 7]), dict(position=[np.inf] * 7), dict(velocity=[np.nan] * 7)):
        stopped = guard.check(**nan)
        assert stopped.reason == "invalid" and stopped.certified
    for wrong in (dict(most_setpoints=2.5), dict(most_setpoints=True), dict(work=1e6), dict(work=-1), dict(joint_errors="0"), dict(joint_errors=[0.1] * 3)):
        with pytest.raises((ValueError, TypeError), match=list(wrong)[0]):
            leeway.Guard(robot, world, start, accelerations=2, **wrong)
    assert leeway.Guard(robot, world, start, accelerations=2, work=np.int64(10**6), joint_errors=np.float32(0.001)).check()
    for wrong in (dict(setpoints=[1] * 6), dict(setpoints=[[1] * 6]), dict(position=[1]), dict(time=float("nan"))):
        with pytest.raises(ValueError):
            guard.check(**wrong)
    assert guard.check(position=start, time=20).start[0] == start[0]


def test_a_guard_follows_vertices_from_numpy(robot):
    sheet = np.array([[-0.2, -0.2, 0], [0.2, -0.2, 0], [-0.2, 0.2, 0], [0.2, 0.2, 0]])
    world = leeway.World()
    world.add_deforming("sheet", sheet, [[0, 1, 3], [0, 3, 2]], speed_bound=0.1, position=(0.9, 0, 0.1))
    guard = leeway.Guard(robot, world, "ready")
    still = np.tile(robot.state("ready"), (5, 1))
    assert guard.set_vertices("sheet", sheet, 0.1, speed_bound=0.1) == "taken"
    guard.look(0.1)
    assert guard.check(still, time=0.1)
    assert guard.set_vertices("sheet", sheet + [0, 0, 0.3], 0.2, speed_bound=0.1) == "jumped"
    guard.look()
    assert guard.check(still, time=0.2).reason == "jumped"
    assert guard.set_vertices("sheet", sheet[:3], 0.3) == "invalid"
    assert guard.set_vertices("sheet", sheet, 0.1) == "late"
    assert guard.set_vertices("sheet", sheet * np.nan, 0.3) == "invalid"
    assert guard.set_vertices("sheet", sheet, np.nan) == "late"
    assert guard.set_vertices("sheet", sheet + [0, 0, 0.3], 0.3, speed_bound=0.1) == "taken"
    guard.look(0.3)
    assert guard.check(still, time=0.3)
    assert guard.check(still, time=3).reason == "stale"
    with pytest.raises(ValueError):
        guard.set_vertices("curtain", sheet, 0.4)


def test_a_guard_and_a_replanner_take_clouds_as_they_are_seen(robot, tmp_path):
    def grid(x, dtype=float):
        y, z = np.meshgrid(np.linspace(-0.1, 0.1, 9), np.linspace(0.05, 0.25, 9))
        return np.column_stack([np.full(y.size, x), y.ravel(), z.ravel()]).astype(dtype)
    world = leeway.World()
    world.add_cloud("seen", grid(0.9), radius=0.01)
    world.set_motion("seen", speed_bound=0.1)  # of its points
    guard = leeway.Guard(robot, world, "ready")
    still = np.tile(robot.state("ready"), (5, 1))
    assert guard.check(still)
    assert guard.set_cloud("seen", grid(0.95, np.float32), 0.01, 0.1, speed_bound=0.1) == "taken"
    assert guard.check(still, time=0.1).reason == "stale"  # balls may be anywhere: look first
    guard.look(0.1)
    assert guard.check(still, time=0.1)
    holes = grid(0.95)
    holes[::2] = np.nan
    assert guard.set_cloud("seen", holes, np.full(81, 0.01), 0.2, 0.1, pose=(0, 0, 0.1), thin=0.05) == "taken"
    assert guard.set_cloud("seen", holes * np.nan, 0.01, 0.3, 0.1) == "invalid"
    assert guard.set_cloud("seen", grid(0.9), 0.01, 0.3, 0.1, pose=(np.nan, 0, 0)) == "invalid"
    assert guard.set_cloud("seen", grid(0.9), 0.01, 0.3, 0.1, pose=(np.nan, 0, 0), carve=["robot"], carve_margin=0.01, state=robot.state("ready")) == "invalid"
    assert guard.set_cloud("seen", grid(0.9), 0.01, 0.1, 0.1) == "late"
    assert guard.set_cloud("seen", grid(0.9), 0.01, float("inf"), 0.1) == "late"
    assert guard.set_cloud("seen", grid(0.9), 0.01, 0.3) == "taken"  # no bound
    guard.look(0.3)
    assert guard.check(still, time=0.3).passed == 0
    for wrong, what in ((dict(name="car"), "car"), (dict(points=np.zeros((3, 2))), "shape"), (dict(radius=0), "radius"), (dict(points=np.full((1, 3), 1e12)), "point 0 has the coordinate"),
                        (dict(carve=["robot"]), "pose"), (dict(carve=["robot"], pose=(0, 0, 0)), "state"), (dict(carve_margin=1), "carve"), (dict(speed_bound=-1), "speed_bound"),
                        (dict(carve=["hnd"], pose=(0, 0, 0), state=robot.state("ready")), "hnd"), (dict(carve=["seen"], pose=(0, 0, 0), state=robot.state("ready")), "is a cloud"), (dict(most_balls=0), "most_balls")):
        with pytest.raises(ValueError, match=what):
            guard.set_cloud(**{**dict(name="seen", points=grid(0.9), radius=0.01, time=0.4), **wrong})
    problem = leeway.Problem(robot, world, "ready", turned(robot, 0.8), margin=0.01)
    replanner = leeway.Replanner(problem)
    lines = []
    while not replanner.reached:
        replanner.set_cloud("seen", grid(0.9 + 0.05 * replanner.time), 0.01, speed_bound=0.1, pose=(0, 0, 0), carve=["robot"], most_balls=30)
        step = replanner.step()
        assert step.certified
        lines.append(step.log)
    lines.append(replanner.executed.log)
    (tmp_path / "run.jsonl").write_text("\n".join(lines) + "\n")
    assert leeway.verify_log(problem, str(tmp_path / "run.jsonl"))
    with pytest.raises(ValueError, match="no ball is left"):
        replanner.set_cloud("seen", grid(0.9) * np.nan, 0.01)
    with pytest.raises(ValueError, match="later than"):
        replanner.set_cloud("seen", grid(0.9), 0.01, time=replanner.time + 1)


def test_a_guard_and_a_replanner_follow_objects_that_move(robot):
    world = leeway.World()
    world.add_box("cart", (0.2, 0.2, 0.2), position=(0.9, 0, 0.1))
    world.set_motion("cart", speed_bound=0.1, turn_bound=0.1)
    assert "cart" in world and world.pose("cart")[0, 3] == 0.9
    guard = leeway.Guard(robot, world, "ready")
    still = np.tile(robot.state("ready"), (5, 1))
    assert guard.check(still)
    assert guard.set_pose("cart", (0.9, 0, 0.1), 0.1, speed_bound=0.1, turn_bound=0) == "taken"
    guard.look(0.1)
    assert guard.check(still, time=0.1)
    assert guard.set_pose("cart", (0.9, 0, 0.4, 0, 0, 0, 1), 0.2, speed_bound=0.1, turn_bound=0) == "jumped"
    assert guard.set_pose("cart", (0.9, 0, 0.4), 0.1, speed_bound=0.1, turn_bound=0) == "late"
    assert guard.set_pose("cart", (0.9, np.nan, 0.4), 0.3) == "invalid"
    assert guard.set_pose("cart", (0.9, 0, 0.4), float("inf")) == "late"
    assert guard.set_pose("cart", (0.9, 0, 0.4), 0.3, speed_bound=0.1) == "taken"  # how it turns is not known
    guard.look(0.3)
    assert guard.check(still, time=0.3).passed == 0
    with pytest.raises(ValueError):
        guard.set_pose("car", (0.9, 0, 0.1), 0.4)
    with pytest.raises(ValueError):
        guard.set_vertices("cart", np.eye(3), 0.4)
    replanner = leeway.Replanner(robot, world, "ready", turned(robot, 0.8), margin=0.01, joint_errors=0.001)
    height = 0.1
    while not replanner.reached:
        replanner.set_pose("cart", (0.9, 0, height), speed_bound=0.1, turn_bound=0.1)
        height += 0.002
        step = replanner.step()
        assert step.certified and not step.exposed
        state = replanner.state
        replanner.state = state + 0.0009
        assert np.array_equal(replanner.state, state)
    with pytest.raises(leeway.InputError, match="Replanner: joint_errors"):
        leeway.Replanner(robot, world, "ready", turned(robot, 0.8), joint_errors=-1)
    world.set_motion("cart", times=[0, 2], poses=[(0.9, 0, 0.1), (0.9, 0.5, 0.1)], start=1)
    assert world.pose("cart")[1, 3] == pytest.approx(0.25)
    assert leeway.Replanner(robot, world, "ready", turned(robot, 0.8), margin=0.01, start_time=1).step().certified
    with pytest.raises(ValueError, match="does not stand where"):
        leeway.Guard(robot, world, "ready")
    with pytest.raises(ValueError, match="set_motion"):
        world.move("cart", (1, 0, 0))
    world.set_motion("cart", velocity=(0, 0.1, 0), turning=(0, 0, 1), start=1)
    assert world.pose("cart")[1, 3] == pytest.approx(0.25)
    for wrong in (dict(times=[0]), dict(poses=[(0, 0, 0)]), dict(times=[0, 1], poses=[(0, 0, 0)]), dict(times=[0], poses=[(0, 0, 0)], velocity=(0, 0, 1)),
                  dict(time=1), dict(velocity=(0, 0, 1), age=1), dict(speed_bound=-1), dict(turn_bound=-1), dict(age=-1), dict(velocity=(0, 1)),
                  dict(times=[1, 1], poses=[(0, 0, 0), (0, 0, 1)])):
        with pytest.raises(ValueError):
            world.set_motion("cart", **wrong)
    with pytest.raises(KeyError):
        world.set_motion("nothing", velocity=(0, 0, 1))
    # A sighting at 0 s is not one at 5 s.
    world.set_motion("cart", speed_bound=0.3, turn_bound=0)
    for of in (leeway.Guard, leeway.Replanner):
        with pytest.raises(ValueError, match="was seen 0 s before 0 s, and execution starts at 5 s"):
            of(robot, world, "ready", turned(robot, 0.8), start_time=5)


def test_a_motion_given_again_goes_on_from_where_the_object_is():
    world = leeway.World()
    world.add_box("cart", (0.1, 0.1, 0.1), position=(0, -3, 0))
    for _ in range(2):
        world.set_motion("cart", velocity=(0, 1, 0), start=3)
        assert world.pose("cart")[1, 3] == 0
    with pytest.raises(ValueError, match="moves already; the time at which it is at its present pose"):
        world.set_motion("cart", velocity=(0, 2, 0))
    world.set_motion("cart", velocity=(0, 2, 0), time=3)
    assert world.pose("cart")[1, 3] == -6


def test_a_world_may_change_while_a_motion_is_read():
    world = leeway.World()
    for i in range(50):
        world.add_box(f"box {i}", (0.1, 0.1, 0.1), position=(i, 0, 0))

    class Age:
        def __float__(self):
            for i in range(50):
                world.remove(f"box {i}")
            return 1.0

    with pytest.raises(KeyError):
        world.set_motion("box 49", speed_bound=1, age=Age())


def test_a_monitor_is_safe_and_looks_at_little(robot, world):
    scene = leeway.Scene(robot, world, margin=0.01)
    monitor = leeway.Monitor(scene, accelerations=[10] * 7)
    q = turned(robot, -0.8)
    first = monitor.look(0.0, q, [0] * 7, horizon=0.001)
    assert first.safe_until > 0 and not first.imminent
    assert first.next is not None
    for i in range(1, 20):
        report = monitor.look(0.001 * i, q, [0] * 7, horizon=0.001)
        assert not report.imminent
    assert monitor.counts["pairs"] < 20 * scene.pairs
    near = monitor.look(100.0, robot.state("ready"), [0.5] * 7)
    assert near.violated > 0 and any("post" in pair for pair in near.imminent)
    with pytest.raises(ValueError, match="is outside .* within the limits is expected"):
        monitor.look(101.0, [100.0] + list(q[1:]), [0] * 7)
    slow = leeway.Monitor(scene, accelerations=[0] * 7, velocities=[0.1] * 7).look(0.0, q, [0.1] * 7)
    fast = leeway.Monitor(scene, accelerations=[0] * 7, velocities=[0.1] * 7).look(0.0, q, [1] * 7)  # beyond its limits
    assert fast.safe_until == pytest.approx(slow.safe_until / 10, rel=1e-3)
    assert leeway.time_to_impact(1.0, 2.0) == pytest.approx(0.5) and leeway.time_to_impact(1.0, float("nan")) == 0


SLIDE = """<robot name="slide"><link name="base"/>
<link name="car"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="car"/><axis xyz="1 0 0"/>{}</joint></robot>"""


def slide_before_a_wall(folder, limit):
    """A car of 10 cm at 0 on a rail of 5 m, 1.9 m from a wall."""
    (folder / "slide.urdf").write_text(SLIDE.format(limit))
    world = leeway.World()
    world.add_box("wall", (0.1, 1, 1), position=(2, 0, 0))
    return leeway.Robot(str(folder / "slide.urdf")), world


@pytest.mark.parametrize("limit", ["", 'velocity="0"', 'velocity="-1"', 'velocity="inf"'])
def test_a_monitor_takes_no_velocity_limit_for_rest(tmp_path, limit):
    robot, world = slide_before_a_wall(tmp_path, f'<limit lower="0" upper="5" effort="1" {limit}/>')
    scene = leeway.Scene(robot, world)
    for rate, truth in ((0, math.sqrt(2 * 1.9 / 10)), (0.1, 0.60653)):  # 10 m/s^2 over 1.9 m
        found = leeway.Monitor(scene, accelerations=[10]).look(0, [0], [rate])
        assert 0.99 * truth < found.safe_until <= truth


def test_a_monitor_looks_anew_where_a_measurement_breaks_its_bounds(tmp_path):
    robot, world = slide_before_a_wall(tmp_path, '<limit lower="0" upper="5" effort="1" velocity="1"/>')
    scene = leeway.Scene(robot, world)
    for later in (0, 0.01):
        monitor = leeway.Monitor(scene, accelerations=[1])
        assert monitor.look(10, [0], [1]).safe_until == pytest.approx(11.9, abs=0.05)
        assert monitor.look(10 + later, [1.5], [1]).safe_until <= 10 + later + 0.4  # it jumped 1.5 m
    with pytest.raises(ValueError, match="10.0 s is before the last look, at 10.01 s"):
        monitor.look(10, [1.5], [1])


def test_an_older_sight_ends_what_newer_ones_proved(robot):
    far = np.array([-0.9, 0, 0.5])
    world = leeway.World()
    world.add_sphere("ball", radius=0.05, position=far)
    world.set_motion("ball", speed_bound=0.2, turn_bound=0)
    replanner = leeway.Replanner(leeway.Problem(robot, world, turned(robot, -1.2), turned(robot, 1.2), margin=0.01, step=0.02))
    for _ in range(30):
        replanner.set_pose("ball", far, time=replanner.time, speed_bound=0.2, turn_bound=0)
        assert replanner.step().certified
    replanner.set_pose("ball", far, time=replanner.time - 20, speed_bound=0.2, turn_bound=0)
    replanner.step()
    replanner.set_pose("ball", robot.pose("hand", replanner.state)[:3, 3], speed_bound=0.2, turn_bound=0)
    assert not replanner.step().certified


def test_accelerations_keep_their_limits_from_one_motion_to_the_next(robot):
    """Regression: a stop that ended with a step was followed by a new motion at once, at 4.853 rad/s^2 of joint 5."""
    rng = np.random.default_rng(200)
    speed, step = rng.uniform(0.05, 0.3), float(rng.choice([0.01, 0.02, 0.05]))
    place = np.array([0.55, rng.uniform(-0.3, 0.3), rng.uniform(0.4, 1)])
    world = leeway.World()
    world.add_sphere("ball", radius=0.08, position=place)
    world.set_motion("ball", speed_bound=speed, turn_bound=0)
    replanner = leeway.Replanner(leeway.Problem(robot, world, turned(robot, -0.9), turned(robot, 0.9), margin=0.01, step=step, seed=200,
                                                look_ahead=0.3, time=1, iterations=2000))
    rows = []
    for k in range(250):
        if k and rng.random() < 0.8:
            replanner.set_pose("ball", place, speed_bound=speed, turn_bound=0)
        taken = replanner.step()
        assert taken.certified
        rows += list(taken.motion if k == 0 else taken.motion[1:])
        away = rng.normal(size=3)
        place = place + away / np.linalg.norm(away) * speed * step * rng.uniform(0.7, 1) * (1 - 1e-9)
    rows = np.array(rows)
    velocity = np.diff(rows[:, 1:], axis=0) / np.diff(rows[:, :1], axis=0)
    acceleration = np.abs(np.diff(velocity, axis=0)) / np.diff(rows[:-1, :1], axis=0)
    assert np.all(acceleration.max(axis=0) <= np.array([2.96706, 2.96706, 2.96706, 2.618, 4.53786, 4.53786, 4.53786]) * (1 + 1e-5))


def test_a_body_measured_twice_in_motion_is_as_lost_as_one_measured_once():
    body = leeway.Robot.free_body("b", [leeway.Shape.box([0.1, 0.1, 0.1])], lower=[-1, -1, -1], upper=[3, 1, 1])
    world = leeway.World()
    world.add_box("wall", (0.1, 1, 1), position=(5, 0, 0))
    for times in (1, 2):
        replanner = leeway.Replanner(body, world, start=[0, 0, 0, 0, 0, 0, 1], goal=[2.5, 0, 0, 0, 0, 0, 1], time=2)
        for _ in range(4):
            step = replanner.step()
        assert step.certified
        before = np.array(replanner.state)
        for k in range(times):
            replanner.state = before + np.array([0, 1e-3 * (k + 1), 0, 0, 0, 0, 0])
        assert not replanner.step().certified


def test_a_state_gives_no_value_to_a_joint_that_others_holds(robot, world):
    problem = leeway.Problem(robot, world, "ready", others={"finger_joint": 0.02})
    state = dict(zip(robot.joint_names, robot.state("ready")))
    assert leeway.check(problem, state=state | {"finger_joint": 0.02}).verdict == leeway.check(problem, state=state).verdict
    scene = leeway.Scene(problem)
    for ask in (lambda s: leeway.check(problem, state=s), scene.check, lambda s: problem.attach("post", "hand", state=s)):
        with pytest.raises(ValueError, match="gives joint 'finger_joint' the value 0.03; it is not planned and stands at 0.02"):
            ask(state | {"finger_joint": 0.03})
    del problem.others["finger_joint"]
    assert problem.copy().others == problem.others == {"finger_joint": 0}


def test_two_wishes_for_the_same_pair_both_count(tmp_path, robot, world):
    both = [(0.2, 3.0), (0.5, 1.0)]
    problem = leeway.Problem(robot, world, "ready", turned(robot, 0.8), wishes={("hand", "post"): both})
    problem.wishes["robot", "post"] = 0.1
    problem.save(tmp_path / "saved.yaml")
    with pytest.raises(ValueError, match="wishes: hand and post is an empty list"):
        problem.wishes = {("hand", "post"): []}
    loaded = leeway.load(tmp_path / "saved.yaml").wishes
    assert loaded["hand", "post"] == problem.wishes["hand", "post"] == both and len(loaded) == 2


def test_no_edit_is_lost_while_another_thread_places_the_start(robot, world):
    problem = leeway.Problem(robot, world, "ready", turned(robot, 0.8))
    x, y, z = robot.pose("hand", turned(robot, -0.8))[:3, 3]

    def start_again():
        for _ in range(20):
            problem.start = leeway.FramePose("hand", (x, y, z))

    thread = threading.Thread(target=start_again)
    thread.start()
    for i in range(1, 200):
        problem.margin = 1e-5 * i
        assert problem.margin == 1e-5 * i
    thread.join()
    assert problem.margin == 1e-5 * 199


def test_a_condition_in_python_restricts_the_search(robot, world, tmp_path):
    """Over the post, not beside it: the first joint keeps away from the middle while the hand is low."""
    problem = leeway.Problem(robot, world, turned(robot, -0.8), turned(robot, 0.8), margin=0.01, time=60)
    asked = []

    def accept(states):
        asked.append(len(states))
        return states[:, 1] < 0.5

    result = leeway.plan_where(problem, accept)
    again = leeway.plan_where(problem, accept)
    assert result and same(result, again) and leeway.verify(problem, result)
    assert result.planner == "Connect" and result.certificate.conditions == "sampled" and "condition sampled" in repr(result)
    assert leeway.plan(problem).certificate.conditions is None and "condition" not in repr(leeway.plan(problem))
    # Regression: the page said "certified", and a saved path forgot what it was planned with.
    result.view(tmp_path / "page.svg")
    assert "certified, condition sampled" in (tmp_path / "page.svg").read_text()
    result.save(tmp_path / "path.json")
    with pytest.warns(UserWarning, match="path.json:[0-9]+: the path was planned with a condition"):
        assert leeway.verify(problem, tmp_path / "path.json")
    assert len(result.path) > 2 and result.trajectory().blends == 0  # a blend would leave what was asked
    for a, b in zip(result.path, result.path[1:]):
        assert np.all(robot.interpolate(a, b, np.linspace(0, 1, 2 + int(robot.distance(a, b) / 0.05)))[:, 1] < 0.5)
    assert 2 < max(asked) <= 256
    refused = leeway.plan_where(problem, lambda states: np.zeros(len(states), bool))
    assert refused.status == "invalid_start" and refused.reason == "the condition does not accept it"
    refused = leeway.plan_where(problem, lambda states: states[:, 0] < 0.7)
    assert refused.status == "invalid_goal" and "the condition does not accept it" in refused.reason
    with pytest.raises(ZeroDivisionError):
        leeway.plan_where(problem, lambda states: 1 / 0)
    for wrong in (lambda states: True, lambda states: [True], lambda states: "x", lambda states: None,
                  lambda states: ["no"] * len(states), lambda states: [1] * len(states), lambda states: np.full(len(states), "")):
        with pytest.raises(TypeError, match="bools"):
            leeway.plan_where(problem, wrong)
    for settings, what in (({"planner": "RRTConnect"}, "planner 'RRTConnect' does not keep"), ({"objective": "clearance"}, "another objective")):
        with pytest.raises(leeway.InputError, match="there is a condition, .*" + what):
            leeway.plan_where(leeway.Problem(problem, **settings), accept)
    for wrong in (0, -1, float("nan"), 1e-300, 1e-9, 9e-5, float("inf")):
        with pytest.raises(ValueError, match="resolution"):
            leeway.plan_where(problem, accept, resolution=wrong)
    stopped = leeway.plan_where(problem, lambda states: (states[:, 0] < -0.7) | (states[:, 0] > 0.7), stop=lambda: True)
    assert not stopped


def test_constraints_in_python(robot, world):
    """Proven by plan(), clearance() and check(), beside a condition, too; a tolerance belongs to something."""
    start, goal = turned(robot, -0.8), turned(robot, 0.8)
    axis = robot.pose("hand", start)[:3, :3].T @ (0, 0, 1)
    level = leeway.Constraint("hand", axis=axis, angle=0.3, name="level")
    problem = leeway.Problem(robot, world, start, goal, margin=0.01, time=60, constraints=[level])
    result = leeway.plan(problem)
    assert result and leeway.verify(problem, result)
    ((name, off, angle),) = result.certificate.constraints
    assert name == "level" and off == 0 and 0 < angle <= 0.3
    measured = leeway.clearance(problem, result)
    assert measured and measured.constraints == result.certificate.constraints
    tilted = start.copy()
    tilted[5] += 0.5
    bent = leeway.clearance(problem, [start, tilted, start])
    assert not bent.certified and bent.constraints == []
    state = leeway.check(problem, state=tilted)
    assert not state and state.limit.startswith("constraint 'level': 'hand' is turned by 0.5")
    assert leeway.check(problem, state=start)
    conditional = leeway.plan_where(problem, lambda states: states[:, 1] < 1.5)
    assert conditional and conditional.certificate.constraints and conditional.certificate.conditions == "sampled"

    for wrong, what in (
        (lambda: leeway.Constraint("hand", axis=axis, angle=0.3, position_tolerance=0.01), "position_tolerance is given without position"),
        (lambda: leeway.Constraint("hand", (0, "any", "any"), angle=0.3), "angle is given without axis, orientation or rpy"),
        (lambda: leeway.Constraint("hand", (0, "any", "any"), direction=(0, 0, 1)), "direction is given without axis"),
        (lambda: leeway.Constraint("hand", axis=axis), "axis is given without angle"),
        (lambda: leeway.FramePose("hand", rpy=(0, 0, 0), position_tolerance=0.01), "position_tolerance is given without position"),
        (lambda: leeway.FramePose("hand", (0, 0, 0), angle_tolerance=0.01), "angle_tolerance is given without orientation or rpy"),
    ):
        with pytest.raises(ValueError, match=what):
            wrong()


ARM = '<link name="arm">{}</link><joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>'
BAR = '<collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.05 0.05"/></geometry></collision>'


def spin(tmp_path, shape=BAR):
    urdf = tmp_path / "spin.urdf"
    urdf.write_text('<robot name="spin"><link name="base"/>' + ARM.format(shape) + "</robot>")
    return leeway.Robot(urdf)


def test_rows_are_straight_lines(tmp_path):
    """A controller that interpolates from 3 to -3 passes 0."""
    robot, world = spin(tmp_path), leeway.World()
    world.add_box("o", size=(0.1, 0.1, 0.1), position=(0.9, 0, 0))
    problem = leeway.Problem(robot, world, [3.0], [-3.0])
    rows = np.array([[3.0], [-3.0]])
    file = tmp_path / "rows.csv"
    file.write_text("3.0\n-3.0\n")
    for path in (rows, file):
        assert leeway.verify(problem, path).status == "refuted"
        assert leeway.verify(problem, path, shortest=True).status == "certified"
        assert leeway.clearance(problem, path).upper < 0
        for parts in (1, 3):
            assert len(leeway.clearance(problem, path, parts=parts).edges) == parts
        assert leeway.clearance(problem, path, shortest=True).lower > 0.1
    result = leeway.plan(problem)
    assert result and result.path[-1][0] == pytest.approx(-3 + 2 * np.pi)
    assert leeway.verify(problem, result) and leeway.verify(problem, result.path)


def test_motions_continue_straight(tmp_path):
    """Regression: places were wrapped to [-pi, pi), so that a controller would turn the long way."""
    robot, world = spin(tmp_path), leeway.World()
    world.add_box("o", size=(0.1, 0.1, 0.1), position=(0.9, 0, 0))
    problem = leeway.Problem(robot, world, [2.5], [-2.5])
    trajectory = leeway.plan(problem).trajectory()
    times = np.linspace(0, trajectory.duration, 200)
    for rows in (trajectory.positions, trajectory.position(times), robot.interpolate([2.5], [-2.5], times / times[-1]),
                 leeway.replan(problem).trajectory[:, 1:]):
        assert np.abs(np.diff(rows, axis=0)).max() < 0.2 and rows[-1] == pytest.approx(2 * np.pi - 2.5)
        assert leeway.verify(problem, rows)


def test_nothing_near_is_said_so(tmp_path):
    robot, world = spin(tmp_path), leeway.World()
    alone = leeway.plan(robot, None, [3.0], [-3.0])
    assert alone and "certified, nothing near" in repr(alone.certificate) and "nothing near" in repr(alone)
    assert repr(leeway.verify(alone.problem, alone)) == "<leeway.Verification: certified, nothing near>"
    assert "at least nothing" not in alone._repr_html_()
    world.add_box("o", size=(0.1, 0.1, 0.1), position=(0.9, 0, 0))
    far = leeway.plan(robot, world, [3.0], [-3.0])
    assert far.certificate.lower < np.inf == far.certificate.upper
    assert "certified, nothing nearer than 0." in repr(far.certificate)


def test_nothing_checked_is_never_certified(tmp_path):
    robot, world = spin(tmp_path, ""), leeway.World()
    assert "neither link" in robot.warnings[0]
    world.add_box("room", size=(10, 10, 10))
    problem = leeway.Problem(robot, world, [0.0], [1.0])
    result = leeway.plan(problem)
    assert result.status == "nothing_checked" and not result and len(result.path) == 0
    assert "no link that moves" in result.reason and "no link that moves" in repr(result)
    verified = leeway.verify(problem, [[0.0], [1.0]])
    assert verified.status == "nothing_checked" and not verified and "no link that moves" in verified.reason
    assert not leeway.clearance(problem, [[0.0], [1.0]])
    state = leeway.check(problem)
    assert not state and state.verdict == "nothing_checked" and "nothing was checked" in repr(state)
    scene = leeway.Scene(problem)
    assert "no link that moves" in scene.nothing_checked
    assert not scene.valid([0.0]) and not scene.valid_edges([0.0], [1.0]) and not scene.certify([0.0], [1.0])
    assert leeway.Scene(spin(tmp_path), None, [0.0], [1.0]).nothing_checked == ""
    executed = leeway.replan(problem)
    assert executed.status == "nothing_checked" and not executed and not executed.certified


def test_pairs_that_are_not_checked_are_counted(robot, world, tmp_path):
    result = leeway.plan(robot, world, turned(robot, -0.8), turned(robot, 0.8), margin=0.01)
    reasons = {reason: count for reason, count, names in result.certificate.unchecked}
    assert reasons["adjacent"] > 0 and sum(reasons.values()) == len(leeway.Scene(result.problem).dropped)
    verified = leeway.verify(result.problem, result)
    assert {reason: count for reason, count, names in verified.unchecked} == reasons
    # An arm that turns on a part of its base, face to face.
    urdf = tmp_path / "rest.urdf"
    shape = '<collision><origin xyz="{}"/><geometry><box size="{}"/></geometry></collision>'
    urdf.write_text('<robot name="r"><link name="base">' + shape.format("0 0 0", "0.2 0.2 0.1") + '</link><link name="rest">' +
                    shape.format("0 0 0", "0.1 0.1 0.1") + '</link><joint name="f" type="fixed"><parent link="base"/><child link="rest"/>'
                    "</joint>" + ARM.format(shape.format("0.4 0 0.1", "0.8 0.05 0.1")) + "</robot>")
    resting = leeway.plan(leeway.Robot(urdf), None, [0.0], [1.0])
    assert ("touching at every sampled configuration", 1, [("rest", "arm")]) in resting.certificate.unchecked


def test_a_monitor_refuses_what_it_does_not_follow(robot):
    sheet = np.array([[-0.2, -0.2, 0], [0.2, -0.2, 0], [-0.2, 0.2, 0]])
    for change in (lambda w: w.set_motion("cart", velocity=(-5, 0, 0)), lambda w: w.set_motion("cart", speed_bound=5),
                   lambda w: w.add_deforming("sheet", sheet, [[0, 1, 2]], position=(2, 0, 0)),
                   lambda w: w.add_deforming("sheet", sheet, [[0, 1, 2]], position=(2, 0, 0), speed_bound=5)):
        world = leeway.World()
        world.add_box("cart", (0.2, 0.2, 0.2), position=(1.5, 0, 0.1))
        change(world)
        with pytest.raises(ValueError, match="Monitor: '(cart|sheet)' (moves|deforms)"):
            leeway.Monitor(leeway.Scene(robot, world), accelerations=[1] * 7)
    world.remove("sheet")
    world.add_deforming("sheet", sheet, [[0, 1, 2]], position=(2, 0, 0), speed_bound=0)
    assert leeway.Monitor(leeway.Scene(robot, world), accelerations=[1] * 7)


def test_a_scene_counts_constraints(robot):
    start = [0, 0.4, 0, -1.6, 0, 1.1416, 0]
    upright = leeway.Constraint("hand", axis=robot.pose("hand", start)[:3, :3].T @ (0, 0, 1), angle=0.2)
    tilted = [0, 0.4, 0, -1.6, 0, 0.5, 0]
    turned = [0.5, 0.4, 0, -1.6, 0, 1.1416, 0]
    scene = leeway.Scene(robot, leeway.World(), start, constraints=[upright])
    plain = leeway.Scene(robot, leeway.World(), start)
    assert plain.valid(tilted) and plain.valid_edges(start, tilted) and plain.certify(start, tilted)
    assert scene.check(start) and not scene.check(tilted)
    assert scene.valid([start, tilted, turned]).tolist() == [True, False, True]
    assert scene.valid_edges([start, start], [tilted, turned]).tolist() == [False, True]
    assert scene.certify(start, turned)
    outside = plain.certify(start, [4, 0.4, 0, -1.6, 0, 1.1416, 0])
    assert outside.verdict == "not_free" and outside.last_valid == 0 and outside.pair is None
    edge = scene.certify(start, tilted)
    assert not edge and edge.verdict == "undecided" and edge.last_valid == 0


def test_clearance_refuses_steps():
    task = leeway.load("problems/pick_place/can.yaml")
    assert task.steps
    with pytest.raises(ValueError, match="the problem has steps"):
        leeway.clearance(task, [task.start, task.start])
