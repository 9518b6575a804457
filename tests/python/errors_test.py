"""Wrong input is an exception of one line, never a crash, and nothing is half-changed."""

import threading

import numpy as np
import pytest

import leeway

NAN, INF = float("nan"), float("inf")


class Hostile:
    """Fails at whatever is asked of it."""

    def __array__(self, *args, **kwargs):
        raise RuntimeError("no array")

    def __float__(self):
        raise RuntimeError("no number")

    def __len__(self):
        raise RuntimeError("no length")

    def __getitem__(self, index):
        raise RuntimeError("no items")


WRONG = [None, True, 3, -1, 1.5, NAN, INF, "", "ready", "x" * 1000, b"bytes", [], [1, 2], [[1, 2], [3]], ["a"] * 7, [NAN] * 7, [INF] * 7,
         [None] * 7, (), {}, {"joint1": 1}, {1: 2}, {"joint1": NAN}, set(), object(), Hostile(), int, len, 1j, [1j] * 7, 10**400,
         np.zeros(0), np.zeros(6), np.zeros(7, complex), np.zeros(7, object), np.array(["1"] * 7), np.zeros((7, 7, 0)), np.zeros((2, 3, 7)),
         np.full(7, NAN), np.zeros(7, dtype="M8[s]"), np.zeros((4, 4)), np.full((4, 4), NAN), np.zeros((3, 3), int), np.zeros((0, 3)),
         np.array([[0, 1, 2**40]]), np.array([[-1, 0, 1]]), np.zeros(()), memoryview(b"1234567"), leeway.World(), leeway.Shape.sphere(1),
         np.broadcast_to(1e300, (7,)), np.zeros(14)[::2], np.zeros(7, ">f8"), np.zeros(7, np.float16)]


def one_line(call):
    """Calls; what goes wrong must be an ordinary exception of one line."""
    try:
        call()
    except (TypeError, ValueError, KeyError, OverflowError, RuntimeError, AttributeError) as error:
        assert "\n" not in str(error), error
        return error
    return None


def calls(robot, world, problem, scene):
    """Calls with places for a wrong value, by name."""
    body = leeway.Deformable(np.eye(3), np.array([[0, 1, 2]]))
    monitor = leeway.Monitor(scene, accelerations=[1] * 7)
    replanner = leeway.Replanner(problem)
    result = leeway.plan(problem, iterations=1)
    ball = leeway.Shape.sphere(1)
    q = robot.state("ready")
    yield from {
        "Robot": lambda v: leeway.Robot(v),
        "Robot srdf": lambda v: leeway.Robot("robots/arm7/arm7.urdf", v),
        "Robot group": lambda v: leeway.Robot("robots/arm7/arm7.urdf", group=v),
        "Robot packages": lambda v: leeway.Robot("robots/arm7/arm7.urdf", packages=v),
        "Robot xacro": lambda v: leeway.Robot("robots/arm7/arm7.urdf", xacro=v),
        "Robot kinematics_only": lambda v: leeway.Robot("robots/arm7/arm7.urdf", kinematics_only=v),
        "Robot visual_as_collision": lambda v: leeway.Robot("robots/arm7/arm7.urdf", visual_as_collision=v),
        "free_body": lambda v: leeway.Robot.free_body("b", v, lower=(0, 0, 0), upper=(1, 1, 1)),
        "free_body lower": lambda v: leeway.Robot.free_body("b", [ball], lower=v, upper=(1, 1, 1)),
        "state": robot.state, "poses": robot.poses, "pose": lambda v: robot.pose("hand", v), "link": lambda v: robot.pose(v, q),
        "with_group": robot.with_group, "interpolate": lambda v: robot.interpolate(q, v, 0.5), "t": lambda v: robot.interpolate(q, q, v),
        "distance of states": lambda v: robot.distance(v, q),
        "sphere": leeway.Shape.sphere, "box": leeway.Shape.box, "capsule": lambda v: leeway.Shape.capsule(1, v),
        "ellipsoid": leeway.Shape.ellipsoid, "hull": leeway.Shape.convex_hull, "mesh": leeway.Shape.mesh,
        "mesh vertices": lambda v: leeway.Shape.mesh(vertices=v, triangles=[[0, 1, 2]]),
        "mesh triangles": lambda v: leeway.Shape.mesh(vertices=np.eye(3), triangles=v),
        "mesh scale": lambda v: leeway.Shape.mesh("problems/mesh/meshes/tote.obj", scale=v),
        "add": lambda v: world.copy().add("new", v), "add name": lambda v: world.copy().add_sphere(v, 1),
        "position": lambda v: world.copy().add_sphere("new", 1, position=v),
        "orientation": lambda v: world.copy().add_sphere("new", 1, orientation=v),
        "rpy": lambda v: world.copy().add_sphere("new", 1, rpy=v),
        "remove": lambda v: world.copy().remove(v), "contains": lambda v: v in world,
        "deforming": lambda v: world.copy().add_deforming("new", v, [[0, 1, 2]]),
        "deforming triangles": lambda v: world.copy().add_deforming("new", np.eye(3), v),
        "deforming motion": lambda v: world.copy().add_deforming("new", np.eye(3), [[0, 1, 2]], motion=v),
        "deforming bound": lambda v: world.copy().add_deforming("new", np.eye(3), [[0, 1, 2]], speed_bound=v),
        "distance": lambda v: leeway.distance(v, None, ball, None), "X_WA": lambda v: leeway.distance(ball, v, ball, None),
        "tolerance": lambda v: leeway.distance(ball, None, ball, None, tolerance=v),
        "threshold": lambda v: leeway.distance(ball, None, ball, None, threshold=v),
        "distances": lambda v: leeway.distances(ball, v, ball, v),
        "separation": lambda v: leeway.separation(ball, v, ball, None),
        "separation clearance": lambda v: leeway.separation(ball, None, ball, None, clearance=v),
        "plan": leeway.plan, "plan world": lambda v: leeway.plan(robot, v, q, q),
        "plan start": lambda v: leeway.plan(robot, world, v, q, iterations=1, time=0.1),
        "plan goal": lambda v: leeway.plan(robot, world, q, v, iterations=1, time=0.1),
        "plan goals": lambda v: leeway.plan(robot, world, q, goals=v, iterations=1, time=0.1),
        "plan stop": lambda v: leeway.plan(problem, stop=v, iterations=1), "plan progress": lambda v: leeway.plan(problem, progress=v, iterations=1),
        "certificate": lambda v: leeway.plan(problem, certificate=v, iterations=1),
        "plan_many": lambda v: leeway.plan_many(v, iterations=1), "threads": lambda v: leeway.plan_many([], threads=v),
        "load": leeway.load, "load_moveit": lambda v: leeway.Problem.load_moveit(robot, v, v),
        "verify": lambda v: leeway.verify(problem, v), "verify problem": lambda v: leeway.verify(v, result),
        "clearance": lambda v: leeway.clearance(problem, v), "parts": lambda v: leeway.clearance(problem, [q, q], parts=v),
        "Scene": leeway.Scene, "valid": scene.valid, "clearances": scene.clearances, "check": scene.check,
        "valid_edges": lambda v: scene.valid_edges(v, v), "edge_clearances": lambda v: scene.edge_clearances(q, v),
        "certify": lambda v: scene.certify(v, q), "scene tolerance": lambda v: scene.clearances(q, tolerance=v),
        "update": body.update, "follow": body.follow, "update time": lambda v: body.update(np.eye(3), v),
        "Deformable strategy": lambda v: leeway.Deformable(np.eye(3), [[0, 1, 2]], strategy=v),
        "cache": lambda v: leeway.Motion.cache(v, v), "morph": lambda v: leeway.Motion.morph(v, [0], v),
        "lattice": lambda v: leeway.Motion.lattice(np.eye(3), (0, 0, 0), (1, 1, 1), [0], v),
        "waves": lambda v: leeway.Motion.waves(np.eye(3), v, v, [1], [1]), "pinned": lambda v: leeway.Motion.waves(np.eye(3), [(1, 0, 0)], [(0, 0, 1)], [1], [1], pinned=v),
        "skinned": lambda v: leeway.Motion.skinned(np.eye(3), [-1], [[0] * 6 + [1]], np.ones((3, 1)), [0], v),
        "parents": lambda v: leeway.Motion.skinned(np.eye(3), v, [[0] * 6 + [1]], np.ones((3, 1)), [0], [[[0] * 6 + [1]]]),
        "skin weights": lambda v: leeway.Motion.skinned(np.eye(3), [-1], [[0] * 6 + [1]], v, [0], [[[0] * 6 + [1]]]),
        "modes": lambda v: leeway.Motion.reduced(np.eye(3), v, frequencies=[1]), "coordinates": lambda v: leeway.Motion.reduced(np.eye(3), [np.eye(3)], times=[0], coordinates=v),
        "FramePose": leeway.FramePose, "FramePose position": lambda v: leeway.FramePose("hand", v), "FramePose rpy": lambda v: leeway.FramePose("hand", rpy=v),
        "FramePose turn": lambda v: leeway.FramePose("hand", orientation=v), "relative_to": lambda v: leeway.FramePose("hand", (0, 0, 0), relative_to=v),
        "pose tolerance": lambda v: leeway.FramePose("hand", (0, 0, 0), position_tolerance=v),
        "move": lambda v: leeway.Problem(robot, world, q, steps=[leeway.TaskStep.move(v)]),
        "move name": lambda v: leeway.TaskStep.move("ready", name=v), "move allowed": lambda v: leeway.Problem(robot, world, q, steps=[leeway.TaskStep.move(q, allowed=v)]),
        "line": lambda v: leeway.TaskStep.line("hand", v), "line frame": lambda v: leeway.TaskStep.line(v, (0, 0, 1)),
        "attach": lambda v: leeway.TaskStep.attach("post", v, v), "detach": leeway.TaskStep.detach,
        "wave": lambda v: leeway.Motion.wave(v, (1, 0, 0), (0, 0, 1), 1, 1),
        "monitor q": lambda v: monitor.look(0, v, [0] * 7), "monitor time": lambda v: monitor.look(v, q, [0] * 7),
        "monitor limits": lambda v: leeway.Monitor(scene, accelerations=v), "Monitor": lambda v: leeway.Monitor(v, accelerations=[1] * 7),
        "Replanner": leeway.Replanner, "set_vertices": lambda v: replanner.set_vertices("x", v), "set_pose": lambda v: replanner.set_pose("x", v),
        "set_cloud": lambda v: replanner.set_cloud("x", v, 0.01), "set_cloud radius": lambda v: replanner.set_cloud("x", np.zeros((1, 3)), v),
        "set_cloud carve": lambda v: replanner.set_cloud("x", np.zeros((1, 3)), 0.01, pose=(0, 0, 0), carve=v),
        "set_motion": lambda v: world.copy().set_motion(v, velocity=(0, 0, 1)), "set_motion velocity": lambda v: world.copy().set_motion("post", velocity=v),
        "set_motion times": lambda v: world.copy().set_motion("post", times=v, poses=v), "set_motion poses": lambda v: world.copy().set_motion("post", times=[0], poses=v),
        "set_state": lambda v: setattr(replanner, "state", v), "replan": lambda v: leeway.replan(problem, on_step=v, steps=1, iterations=1),
        "verify_log": lambda v: leeway.verify_log(problem, v), "verify_log problem": lambda v: leeway.verify_log(v, "x.jsonl"),
        "save": result.save, "trajectory": lambda v: leeway.plan(robot, None, q, q + 0.1).trajectory(v),
        "planner_parameters": leeway.planner_parameters,
        "self": lambda v: leeway.World.add_sphere(v, "new", 1), "unbound": lambda v: leeway.Scene.valid(v, q),
        "result": lambda v: leeway.Result.save(v, "x"),
    }.items()
    for name in ("margin", "margins", "allowed", "objective", "planner", "parameters", "time", "iterations", "seed", "start", "goal",
                 "goals", "others", "world", "velocities", "corners", "speed", "step", "name", "simplify", "push", "keep", "clearance_of", "at_most_longer", "wishes", "frames", "steps"):
        yield "set " + name, lambda v, name=name: setattr(problem.copy(), name, v)
        yield "with " + name, lambda v, name=name: leeway.Problem(robot, world, q, q, **{name: v})


def test_wrong_values_are_errors_of_one_line(robot, world):
    problem = leeway.Problem(robot, world, [-0.8, 0.4, 0, -1.6, 0, 1.1416, 0], "tucked", time=1)
    scene = leeway.Scene(problem)
    robot_before, world_before = repr(robot), world.names
    refused = asked = 0
    for name, call in calls(robot, world, problem, scene):
        for value in WRONG:
            asked += 1
            refused += one_line(lambda: call(value)) is not None
    assert refused > 0.8 * asked, (refused, asked)
    assert repr(robot) == robot_before and world.names == world_before
    assert scene.valid(robot.state("ready")) in (True, False)


@pytest.mark.parametrize("bad, message", [
    (lambda r: leeway.plan(r, None, [0] * 6, "ready"), "start has shape (6,); (7,) is expected"),
    (lambda r: leeway.plan(r, None, [0] * 6 + [NAN], "ready"), "start[6] is nan; a finite number is expected"),
    (lambda r: leeway.plan(r, None, "redy", "ready"), "no group state 'redy'; did you mean 'ready'?"),
    (lambda r: leeway.plan(r, None, {"joint8": 0}, "ready"), "no joint 'joint8'; did you mean 'joint1'?"),
    (lambda r: leeway.plan(r, None, "ready", "tucked", marginn=1), "plan(): unknown keyword 'marginn'; did you mean 'margin'?"),
    (lambda r: leeway.plan(r, None, "ready"), "no goal is given; a group state, numbers, a dict by joint, a FramePose or steps are expected"),
    (lambda r: leeway.Robot("robots/arm7/arm7.urdf", group="amr"), "no group 'amr'"),
    (lambda r: leeway.Shape.sphere(-1), "radius"),
    (lambda r: leeway.World().add_sphere("a", "b"), "radius is of type str; a number is expected"),
    (lambda r: r.state(3), "state(self, name) is expected; given: leeway.Robot, int"),
    (lambda r: leeway.Scene(r).valid(np.zeros((2, 6))), "states has shape (2, 6); (..., 7) is expected"),
])
def test_messages_say_what_is_expected(robot, bad, message):
    error = one_line(lambda: bad(robot))
    assert error is not None and message in str(error), error


def test_files_are_named_with_their_line(tmp_path):
    file = tmp_path / "bad.yaml"
    file.write_text("leeway: 1\nrobot: {urdf: x.urdf}\nstart: [0]\ngoal: [0]\nmargn: 0.01\n")
    with pytest.raises(leeway.InputError) as caught:
        leeway.load(file)
    assert caught.value.file == str(file) and caught.value.line == 5
    assert str(caught.value).startswith(f"{file}:5: ") and "margin" in str(caught.value)
    with pytest.raises(leeway.InputError, match="nowhere.urdf"):
        leeway.Robot("nowhere.urdf")
    assert issubclass(leeway.InputError, ValueError)


def one_joint_robot(shape, kind="collision"):
    return (f'<robot name="r"><link name="a"/><link name="b"><{kind}>\n<geometry>{shape}</geometry></{kind}></link>'
            '<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>')


def test_kinematics_need_no_meshes(tmp_path):
    urdf = tmp_path / "r.urdf"
    urdf.write_text(one_joint_robot('<mesh filename="package://gone/b.stl"/>'))
    with pytest.raises(leeway.InputError, match='r.urdf:2: the mesh "package://gone/b.stl" was not found'):
        leeway.Robot(urdf)
    robot = leeway.Robot(urdf, kinematics_only=True)
    assert robot.pose("b", [0.5])[1, 0] == pytest.approx(np.sin(0.5))
    with pytest.raises(leeway.InputError, match="without its meshes"):
        leeway.Scene(leeway.Problem(robot, start=[0], goal=[1]))


def test_visual_shapes_stand_in_where_asked_for(tmp_path):
    urdf = tmp_path / "r.urdf"
    urdf.write_text(one_joint_robot('<sphere radius="1"/>', "visual"))
    world = leeway.World()
    world.add("ball", leeway.Shape.sphere(1))

    def scene(robot):
        return leeway.Scene(leeway.Problem(robot, world, [0], [1]))

    assert scene(leeway.Robot(urdf)).nothing_checked
    assert not scene(leeway.Robot(urdf, visual_as_collision=True)).nothing_checked


def test_what_is_left_out_of_an_srdf_is_refused_by_name(tmp_path):
    urdf, srdf = tmp_path / "r.urdf", tmp_path / "r.srdf"
    urdf.write_text(one_joint_robot('<sphere radius="1"/>'))
    srdf.write_text('<robot name="r"><group name="g"><joint name="j"/></group>\n<group name="h"><joint name="k"/></group>'
                    '\n<group_state name="up" group="g"><joint name="k" value="1"/></group_state></robot>')
    robot = leeway.Robot(urdf, srdf, group="g")
    assert len([w for w in robot.warnings if "is left out" in w]) == 2
    with pytest.raises(ValueError, match="'up'; it is left out: .*r.srdf:3: "):
        robot.state("up")
    with pytest.raises(ValueError, match="'h'; it is left out: .*r.srdf:2: "):
        leeway.Robot(urdf, srdf, group="h")


def test_xacro_gets_arguments(tmp_path, monkeypatch):
    program = tmp_path / "xacro"
    urdf = one_joint_robot('<sphere radius="1"/>').replace('name="j"', 'name="$2 $3"')
    program.write_text(f"#!/bin/sh\ncat << END\n{urdf}\nEND\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin")
    (tmp_path / "r.urdf.xacro").write_text("<robot/>")
    assert leeway.Robot(tmp_path / "r.urdf.xacro", xacro={"length": 0.5, "on": "a b"}).joint_names == ["length:=0.5 on:=a b"]


def test_arrays_may_change_while_a_call_runs(robot, shelf):
    """Another thread writes to the array and resizes it: answers are those of the array as it was."""
    scene = leeway.Scene(shelf)
    rng = np.random.default_rng(3)
    points = rng.uniform(robot.lower, robot.upper, (5000, 7))
    expected = scene.valid(points)
    working = points.copy()
    done = threading.Event()

    def disturb():
        while not done.is_set():
            working.resize((10, 7), refcheck=False)
            working.resize((5000, 7), refcheck=False)

    answers = []
    thread = threading.Thread(target=lambda: answers.append(scene.valid(points)))
    thread.start()
    disturber = threading.Thread(target=disturb)
    disturber.start()
    for _ in range(8):
        one_line(lambda: scene.valid(working))
        one_line(lambda: leeway.verify(shelf, working[:2]))
    done.set()
    thread.join()
    disturber.join()
    assert np.array_equal(answers[0], expected)


def test_one_user_at_a_time_where_that_is_said(shelf):
    replanner = leeway.Replanner(shelf)
    errors = []
    looked = leeway.Replanner(shelf, stop=lambda: errors.append(one_line(lambda: looked.step())))
    looked.step()
    assert all(isinstance(error, RuntimeError) for error in errors)
    assert replanner.step().certified


def test_a_result_keeps_what_it_needs(robot):
    path = leeway.plan(robot, leeway.World(), "ready", "tucked").path
    certificate = leeway.plan(robot, leeway.World(), "ready", "tucked").certificate
    with pytest.raises(ValueError):
        path[:] = 0
    assert certificate.edges.shape[1] == 2


def test_classes_cannot_be_changed_or_derived_from(robot, world):
    """`leeway.Problem.margin = 0.1` replaced the property: later problems reported a margin that nothing kept."""
    for name in leeway.__all__:
        value = getattr(leeway, name)
        if not isinstance(value, type):
            continue
        for attribute in ("margin", "__doc__", *[a for a in vars(value) if not a.startswith("_")]):
            for change in (lambda: setattr(value, attribute, 0.1), lambda: delattr(value, attribute)):
                with pytest.raises(TypeError, match=f"(leeway.|immutable type '){name}"):
                    change()
        if not issubclass(value, Exception):
            with pytest.raises(TypeError, match=f"leeway.{name}"):
                type("Derived", (value,), {"margin": 0.1})
    with pytest.raises(TypeError) as error:
        leeway.Problem.margin = 0.1
    assert str(error.value) == "'margin' is set on the class leeway.Problem; an object of it is expected, as in problem.margin = ..."
    with pytest.raises(TypeError, match="^'\\ud800' of the class leeway.World cannot be set or deleted; it is fixed$"):
        setattr(leeway.World, "\ud800", 1)
    problem = leeway.Problem(robot, world, margin=0.01)
    problem.margin = 0.02
    assert problem.margin == 0.02 and leeway.Problem(robot, world).margin == 0


def test_what_is_nowhere_is_not_at_the_origin(robot, world):
    scene = leeway.Scene(robot, world, "ready")
    moving = world.copy()
    for call in (lambda: scene.with_object_at("post", None), lambda: moving.set_motion("post", times=[0, 1], poses=[(0, 0, 0), None]),
                 lambda: leeway.inverse_kinematics(robot, "hand", None)):
        with pytest.raises(ValueError, match="is None; a position"):
            call()


def test_moving_keeps_what_is_not_given():
    world = leeway.World()
    world.add_box("box", size=(1, 2, 3), position=(1, 2, 3), rpy=(0, 0, 1))
    before = world.pose("box")
    world.move("box")
    assert np.array_equal(world.pose("box"), before)
    world.move("box", (4, 5, 6))
    assert np.array_equal(world.pose("box")[:3, :3], before[:3, :3]) and list(world.pose("box")[:3, 3]) == [4, 5, 6]
    world.move("box", rpy=(0, 0, 0))
    assert np.array_equal(world.pose("box"), [[1, 0, 0, 4], [0, 1, 0, 5], [0, 0, 1, 6], [0, 0, 0, 1]])


def test_a_position_alone_leaves_what_is_turned_turned(robot):
    world = leeway.World()
    world.add_box("box", size=(0.1, 0.2, 0.3), position=(2, 0, 1), rpy=(0, 0, 1))
    world.add_sphere("ball", 0.1, position=(2, 1, 1))
    turned = world.pose("box")[:3, :3]
    scene = leeway.Scene(robot, world, "ready").with_object_at("box", (2, 0, 2))
    assert np.array_equal(scene.problem.world.pose("box")[:3, :3], turned)
    assert np.array_equal(scene.with_object_at("box", (2, 0, 2, 0, 0, 0, 1)).with_object_at("box", (2, 0, 1)).problem.world.pose("box")[:3, :3], np.eye(3))
    with pytest.raises(ValueError, match="poses has a position alone, and 'box' is turned"):
        world.set_motion("box", times=[0, 1], poses=[(2, 0, 1), (2, 1, 1)])
    with pytest.raises(ValueError, match="poses has a position alone, and 'ball' is turned"):
        world.set_motion("ball", times=[0, 1], poses=[(2, 0, 1, 0, 0, 0.6, 0.8), (2, 1, 1)])
    with pytest.raises(ValueError, match="position is None"):
        leeway.World().add_sphere("s", 0.1, position=None)
    world.copy().set_motion("ball", times=[0, 1], poses=[(2, 0, 1), (2, 1, 1)])
    for name in ("box", "ball"):
        world.set_motion(name, speed_bound=0.1, turn_bound=0)
    problem = leeway.Problem(robot, world, "ready", "ready")
    for seen in (leeway.Replanner(problem), leeway.Guard(problem)):
        seen.set_pose("ball", (2, 1, 1), 0.0)
        seen.set_pose("box", world.pose("box"), 0.0)
        seen.set_pose("ball", (2, 1, 1, 0, 0, 1, 0), 0.0)
        for name in ("box", "ball"):
            with pytest.raises(ValueError, match=f"pose is a position alone, and '{name}' was turned; a position and quaternion"):
                seen.set_pose(name, (2, 1, 1), 0.0)
    assert leeway.Guard(problem).set_pose("ball", None, 0.0) == "invalid"  # as what is not finite
    with pytest.raises(ValueError, match="pose is None"):
        leeway.Replanner(problem).set_pose("ball", None)
    # Regression: what was refused counted as seen, too.
    guard, replanner = leeway.Guard(problem), leeway.Replanner(problem)
    assert guard.set_pose("ball", (2, 1, 1), 1.0, 0.1, 0) == "taken"
    assert guard.set_pose("ball", (2, 1, 1, 0, 0, 1, 0), 0.5) == "late"
    assert guard.set_pose("ball", (2, 1, 1), 1.1, 0.1, 0) == "taken"
    with pytest.raises(ValueError, match="later than the present"):
        replanner.set_pose("ball", (2, 1, 1, 0, 0, 1, 0), 9.0)
    replanner.set_pose("ball", (2, 1, 1), 0.0)
    assert guard.set_pose("ball", (2, 1, 1, 0, 0, 1, 0), 1.2) == "jumped"  # and taken
    with pytest.raises(ValueError, match="'ball' was turned"):
        guard.set_pose("ball", (2, 1, 1), 1.3)
    points = np.array([[2.0, 2, 1]])
    for rpy, is_turned in (((0, 0, 1), True), ((0, 0, 0), False)):
        around = leeway.World()
        around.add_cloud("scan", points, radius=0.01, position=(0, 0, 0.5), rpy=rpy)
        around.set_motion("scan", speed_bound=0.1)
        guard = leeway.Guard(robot, around, "ready")
        if is_turned:
            with pytest.raises(ValueError, match="pose is a position alone, and 'scan' was turned"):
                guard.set_cloud("scan", points, 0.01, time=0.1, speed_bound=0.1, pose=(0, 0, 0.5))
        else:
            assert guard.set_cloud("scan", points, 0.01, time=0.1, speed_bound=0.1, pose=(0, 0, 0.5)) == "taken"


def test_wrong_numbers_of_pairs_and_joints_name_them(robot, world):
    where = ("hand", "post")
    for settings, message in [
            ({"margins": {where: NAN}}, "margins: hand and post is nan; a finite number is expected"),
            ({"margins": {where: "0.1"}}, "margins: hand and post is of type str; a number is expected"),
            ({"margins": {where: None}}, "margins: hand and post is of type NoneType; a number is expected"),
            ({"margins": {where: 10**400}}, "margins: hand and post is beyond 1.8e308; a finite number is expected"),
            ({"margin": 10**400}, "margin is beyond 1.8e308; a finite number is expected"),
            ({"wishes": {where: NAN}}, "wishes: hand and post: the clearance is nan; a finite number is expected"),
            ({"wishes": {where: (0.1, None)}}, "wishes: hand and post: the weight is of type NoneType; a number is expected"),
            ({"velocities": {"joint1": NAN}}, "velocities: joint1 is nan; a finite number is expected"),
            ({"iterations": 10**5000}, "iterations is of type int; a whole number")]:
        with pytest.raises((TypeError, ValueError)) as error:
            leeway.Problem(robot, world, **settings)
        assert str(error.value).startswith(message), error.value


def test_meshes_that_are_not_closed_are_named(robot, tmp_path):
    world = leeway.World()
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    given = {"vertices": corners, "triangles": [[0, 1, 2], [0, 1, 3], [1, 2, 3]]}
    with pytest.warns(UserWarning) as told:
        for i in range(3):
            world.add_mesh(f"m{i}", **given, position=(5 * i, 5, 5))
        world.add("both", [leeway.Shape.mesh(**given), leeway.Shape.sphere(1)], position=(-5, 0, 0))
    assert [str(w.message).split(" is not closed, it has 3 open edges: ")[0] for w in told] == ["'m0'", "'m1'", "'m2'", "the mesh", "'both'"]
    problem = leeway.Problem(robot, world, "ready", [0.2, -0.6, 0, -2.05, 0, 1.6, 0])
    result = leeway.plan(problem)
    names = "meshes are not closed: " + ", ".join(f"{name} (3 open edges)" for name in ("m0", "m1", "m2", "both"))
    for warnings in (problem.warnings, result.warnings, leeway.verify(problem, result).warnings, result.problem.warnings):
        assert [w for w in warnings if "not closed" in w] == [warnings[0]] and warnings[0].startswith(names), warnings
        assert "In Python, solid='hull' takes the convex hull" in warnings[0] and "key" not in warnings[0]
    problem.save(tmp_path / "open.yaml")
    loaded = leeway.load(tmp_path / "open.yaml")
    told = [w for w in leeway.plan(loaded).warnings if "not closed" in w]
    assert told == list(loaded.warnings) and len(told) == 1 and f"open.yaml: {names}" in told[0]
    # Regression: what had been removed was named all the same.
    loaded.world.remove("m1")
    assert len(loaded.warnings) == 1 and "open.yaml: " + names.replace("m1 (3 open edges), ", "") in loaded.warnings[0]
    for name in ("m0", "m2", "both"):
        loaded.world.remove(name)
    assert not loaded.warnings and not loaded.copy().warnings


def test_goals_of_odd_types_are_refused_in_plain_words(robot):
    for odd in (range(7), frozenset([1]), object()):
        problem = leeway.Problem(robot, None, "ready", "ready")
        problem.goals[0] = odd
        with pytest.raises(TypeError) as error:
            problem.copy()
        assert str(error.value) == (f"goals holds an object of type {type(odd).__name__}; "
                                    "a list, a tuple, a dict, an array of numpy, a text or a number is expected")


def test_a_step_keeps_the_goal_that_it_was_made_with(robot):
    ready = robot.state("ready")
    goal = ready + (0.1, 0, 0, 0, 0, 0, 0)
    given = list(goal)
    problem = leeway.Problem(robot, leeway.World(), "ready", steps=[leeway.TaskStep.move("ready")])
    problem.steps.append(leeway.TaskStep.move(given))
    problem.copy()  # reads the steps
    given[0] += 0.2
    problem.steps.append(leeway.TaskStep.move("ready"))
    path = leeway.plan(problem).path
    assert np.abs(path - goal).max(axis=1).min() == 0 and np.abs(path[:, 0] - ready[0]).max() == pytest.approx(0.1)
