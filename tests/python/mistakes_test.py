"""Programs with one mistake each, refused with the words of tests/data/mistakes.txt: where a problem is made, where it is set, and where what a problem has
handed out is changed. A new check is a new line there, and a row here. And: whatever an object hands out is live, or refuses to be changed."""

import array
import collections
import copy
import json
import pickle

import numpy as np
import pytest

import leeway
from leeway import Constraint, FramePose, TaskStep

NAN = float("nan")
UPRIGHT = Constraint("tool", axis=(0, 0, 1), angle=3)
TUCKED = [0, -0.6, 0, -2.05, 0, 1.6, 0]


def lines():
    """tests/data/mistakes.txt: {name: (who, words)}."""
    rows = [line.rstrip("\n").split(" | ", 2) for line in open("tests/data/mistakes.txt") if line.strip() and line[0] != "#"]
    return {name: (who, words) for name, who, words in rows}


def worlds():
    world = leeway.World()
    world.add_cylinder("post", radius=0.05, length=1, position=(0.5, 0.5, 0.5))
    return world


def good(robot, **settings):
    return leeway.Problem(robot, worlds(), **{"start": "ready", "goal": TUCKED} | ({"goal": None} if "steps" in settings else {}) | settings)


def settings(**given):
    """A mistake in keywords: made with them, and set one by one."""
    def set_all(problem):
        for name, value in given.items():
            setattr(problem, name, value)
    return given, set_all


def edits(change):
    """A mistake in what the problem has handed out."""
    return {}, change


def put(container, key, value):
    container[key] = value


def clothes(world, name):
    world.add_deforming(name, np.eye(3), [[0, 1, 2]], position=(5, 0, 0))


MISTAKES = {
    "frame_like_link": [settings(frames={"hand": ("hand", None)}), edits(lambda p: put(p.frames, "hand", ("hand", None)))],
    "start_outside": [settings(start=[0, 9, 0, 0, 0, 0, 0]), edits(lambda p: put(p.start, 1, 9))],
    "goal_outside": [settings(goal=[0, 9, 0, 0, 0, 0, 0]), edits(lambda p: put(p.goal, 1, 9)), edits(lambda p: put(p.goals, 0, [0, 9, 0, 0, 0, 0, 0]))],
    "goal_partly_outside": [settings(goal=[0, (1, 3), 0, 0, 0, 0, 0]), edits(lambda p: put(p.goals[0], 1, (1, 3)))],
    "margin_of_nothing": [settings(margins={("hand", "psot"): 0.1}), edits(lambda p: put(p.margins, ("hand", "psot"), 0.1))],
    "allowed_of_nothing": [settings(allowed=[("finger_let", "post")]), edits(lambda p: p.allowed.append(("finger_let", "post")))],
    "wish_of_nothing": [settings(wishes={("hand", "psot"): 0.1}), edits(lambda p: put(p.wishes, ("hand", "psot"), 0.1))],
    "margin_of_one": [settings(margins={("post", "post"): 0.1}), edits(lambda p: put(p.margins, ("post", "post"), 0.1))],
    "allowed_of_one": [settings(allowed=[("hand", "hand")]), edits(lambda p: p.allowed.append(("hand", "hand")))],
    "margin_of_world_twice": [settings(margins={("world", "world"): 0.1}), edits(lambda p: put(p.margins, ("world", "world"), 0.1))],
    "margin_of_unknown_and_world": [settings(margins={("hnad", "world"): 0.1}), edits(lambda p: put(p.margins, ("hnad", "world"), 0.1))],
    "allowed_of_world": [settings(allowed=[("hand", "world")]), edits(lambda p: p.allowed.append(("hand", "world")))],
    "checked_of_object": [settings(checked=[("hand", "post")]), edits(lambda p: p.checked.append(("hand", "post")))],
    "checked_and_allowed": [settings(checked=[("link1", "link2")], allowed=[("link2", "link1")])],
    "wish_of_world": [settings(wishes={("hand", "world"): 0.1})],
    "object_like_world": [edits(lambda p: p.world.add_sphere("world", 0.1, position=(5, 0, 0)))],
    "frame_like_world": [settings(frames={"world": ("hand", None)}), edits(lambda p: put(p.frames, "world", ("hand", None)))],
    "frame_like_robot": [settings(frames={"robot": ("hand", None)}), edits(lambda p: put(p.frames, "robot", ("hand", None)))],
    "wish_of_one": [settings(wishes={("post", "post"): 0.1})],
    "object_color": [edits(lambda p: p.world.add_sphere("ball", 0.1, position=(5, 0, 0), color=(0, 1.5, 0))), edits(lambda p: p.world.paint("post", (0, 1.5, 0)))],
    "object_like_robot": [edits(lambda p: p.world.add_sphere("robot", 0.1, position=(5, 0, 0)))],
    "deforming_like_robot": [edits(lambda p: clothes(p.world, "robot"))],
    "object_like_link": [edits(lambda p: p.world.add_sphere("hand", 0.1, position=(5, 0, 0)))],
    "object_twice": [edits(lambda p: p.world.add_sphere("post", 0.1))],
    "deforming_like_object": [edits(lambda p: clothes(p.world, "post"))],
    "wish_of_no_length": [settings(wishes={("hand", "post"): 0}), edits(lambda p: put(p.wishes, ("hand", "post"), 0))],
    "wish_of_no_weight": [settings(wishes={("hand", "post"): (0.1, -1)})],
    "time_negative": [settings(time=-1)],
    "step_of_no_time": [settings(step=0)],
    "duration_below_step": [settings(duration=0.01)],
    "speed_above_1": [settings(speed=2)],
    "buffer_negative": [settings(buffer=-1)],
    "velocity_of_unplanned": [settings(velocities={"finger_joint": 1}), edits(lambda p: put(p.velocities, "finger_joint", 1))],
    "velocity_of_0": [settings(velocities={"joint1": 0}), edits(lambda p: put(p.velocities, "joint1", 0))],
    "nearness_of_no_length": [settings(objective={"integral": {"hinge": 0}})],
    "weighs_nothing": [settings(objective={"weighted": {"length": 0}})],
    "wish_beside_clearance": [settings(wishes={("hand", "post"): 0.1}, objective="clearance")],
    "planner_unknown": [settings(planner="RRTConect")],
    "parameter_unknown": [settings(parameters={"rnge": 1}), edits(lambda p: put(p.parameters, "rnge", "1"))],
    "planner_without_costs": [settings(planner="LBTRRT", objective={"integral": {"hinge": 0.1}})],
    "improve_beside_clearance": [settings(parameters={"improve": 1}, objective="clearance")],
    "deforming_of_another_time": [edits(lambda p: (clothes(p.world, "cloth"), setattr(p, "start_time", 1)))],
    "constraint_of_nothing": [settings(constraints=[Constraint("tol", axis=(0, 0, 1), angle=3)])],
    "constraint_that_keeps_nothing": [settings(constraints=[Constraint("tool")])],
    "constraint_without_room": [settings(constraints=[Constraint("tool", (0, "any", "any"), position_tolerance=0)])],
    "constraint_of_any_angle": [settings(constraints=[Constraint("tool", axis=(0, 0, 1), angle=4)])],
    "constraint_without_axis": [settings(constraints=[Constraint("tool", axis=(0, 0, 0), angle=3)])],
    "constraint_of_one_body": [settings(constraints=[Constraint("tool", axis=(0, 0, 1), angle=3, relative_to="hand")])],
    "constraint_of_the_base": [edits(lambda p: p.constraints.append(Constraint("base", axis=(0, 0, 1), angle=3)))],
    "constraint_beside_steps": [settings(constraints=[UPRIGHT], steps=[TaskStep.line("tool", (0, 0, 1))])],
    "constraint_beside_clearance": [settings(constraints=[UPRIGHT], objective="clearance")],
    "constraint_for_another_planner": [settings(constraints=[UPRIGHT], planner="RRTConnect")],
    "no_share_of_acceleration": [settings(acceleration_scale=0)],
    "more_than_all_jerk": [settings(jerk_scale=1.5)],
    "step_allows_nothing": [settings(steps=[TaskStep.move(TUCKED, allowed=[("hand", "psot")])])],
    "step_takes_nothing": [settings(steps=[TaskStep.attach("psot", "hand")])],
    "step_held_by_nothing": [settings(steps=[TaskStep.attach("post", "hnad")])],
    "step_lets_go_of_nothing": [settings(steps=[TaskStep.detach("post")])],
    "step_takes_twice": [settings(steps=[TaskStep.attach("post", "hand"), TaskStep.attach("post", "hand")])],
    "step_to_nothing": [settings(steps=[TaskStep.move(FramePose("tol", (0, 0, 0)))])],
}

#: Every call that takes a problem.
CALLS = {
    "plan": leeway.plan,
    "plan_many": lambda p: leeway.plan_many([p]),
    "plan_where": lambda p: leeway.plan_where(p, lambda states: np.ones(len(states), bool)),
    "verify": lambda p: leeway.verify(p, [TUCKED, TUCKED]),
    "clearance": lambda p: leeway.clearance(p, [TUCKED, TUCKED]),
    "check": leeway.check,
    "Scene": leeway.Scene,
    "Replanner": leeway.Replanner,
    "Guard": leeway.Guard,
    "replan": leeway.replan,
    "attach": lambda p: p.attach("post", "hand"),
}


def refusal(call):
    try:
        call()
    except ValueError as error:  # an InputError is one
        return str(error)
    return "accepted"


def test_list_and_rows_are_the_same():
    assert set(MISTAKES) == {name for name, (who, _) in lines().items() if "p" in who}


def test_what_the_rows_change_is_a_good_problem(robot):
    assert leeway.plan(good(robot))
    assert leeway.plan(good(robot, steps=[TaskStep.move(TUCKED)]))
    for call in CALLS.values():
        assert call(good(robot)) is not None


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_refused_where_it_is_made_or_used(robot, name):
    words = lines()[name][1]
    for given, change in MISTAKES[name]:
        if given:
            said = refusal(lambda: good(robot, **given))
            assert words in said and "\n" not in said, said
            said = refusal(lambda: leeway.plan(good(robot), **given))
            assert words in said, said
        for call in CALLS:
            problem = good(robot)
            said = refusal(lambda: (change(problem), CALLS[call](problem)))
            assert words in said and "\n" not in said, (call, said)


# ---- What is handed out is live.


def same(a, b):
    return a.path.tobytes() == b.path.tobytes()


LIVE = {
    "world": (lambda p: p.world.add_sphere("ball", 0.1, position=(0.5, 0, 0.5)), lambda p: "ball" in p.world),
    "world moved": (lambda p: p.world.move("post", (0.5, 0, 0.5)), lambda p: p.world.pose("post")[1, 3] == 0),
    "world removed": (lambda p: p.world.remove("post"), lambda p: len(p.world) == 0),
    "margins": (lambda p: put(p.margins, ("hand", "post"), 0.02), lambda p: p.margins == {("hand", "post"): 0.02}),
    "margins updated": (lambda p: p.margins.update({("robot", "post"): 0.02}), lambda p: p.margins.get(("robot", "post")) == 0.02),
    "allowed": (lambda p: p.allowed.append(("hand", "post")), lambda p: p.allowed == [("hand", "post")]),
    "checked": (lambda p: p.checked.append(("link1", "link2")), lambda p: p.checked == [("link1", "link2")]),
    "wishes": (lambda p: put(p.wishes, ("hand", "post"), (0.1, 2.0)), lambda p: p.wishes == {("hand", "post"): (0.1, 2.0)}),
    "start": (lambda p: put(p.start, 0, 0.25), lambda p: p.start[0] == 0.25),
    "start in place": (lambda p: np.add(p.start, 0.01, out=p.start), lambda p: p.start[0] == 0.01),
    "start sliced": (lambda p: p.start[2:4].fill(-0.5), lambda p: list(p.start[2:4]) == [-0.5, -0.5]),
    "goal": (lambda p: put(p.goal, 0, 0.3), lambda p: list(p.goal[0]) == [0.3, 0.3] and list(p.goals[0][0]) == [0.3, 0.3]),
    "goal's range": (lambda p: put(p.goals[0][6], 1, 1), lambda p: list(p.goal[6]) == [0, 1]),
    "goals": (lambda p: p.goals.append("upright"), lambda p: len(p.goals) == 2 and p.goals[1][1, 0] == 0),
    "goals cleared": (lambda p: p.goals.clear(), lambda p: p.goal is None),
    "others": (lambda p: put(p.others, "finger_joint", 0.03), lambda p: p.others == {"finger_joint": 0.03}),
    "frames": (lambda p: put(p.frames, "tip", ("hand", (0, 0, 0.1))), lambda p: "tip" in p.frames and p.frames["tip"][1][2, 3] == 0.1),
    "parameters": (lambda p: put(p.parameters, "range", 0.5), lambda p: p.parameters == {"range": "0.5"}),
    "velocities": (lambda p: put(p.velocities, "joint1", 0.5), lambda p: p.velocities == {"joint1": 0.5}),
    "accelerations": (lambda p: put(p.accelerations, "joint1", 0.5), lambda p: p.accelerations == {"joint1": 0.5}),
    "jerks": (lambda p: put(p.jerks, "joint1", 0.5), lambda p: p.jerks == {"joint1": 0.5}),
}


@pytest.mark.parametrize("name", LIVE)
def test_edits_are_live(robot, name):
    edit, holds = LIVE[name]
    problem = good(robot)
    assert not holds(problem)
    edit(problem)
    assert holds(problem.copy())
    if name != "goals cleared":
        assert holds(leeway.plan(problem, time=1, iterations=20).problem)
    held = leeway.Scene(problem).problem
    assert holds(held)
    problem.seed = 9  # another setting leaves it
    assert holds(problem.copy())


def test_nested_objectives_and_steps_are_live(robot):
    problem = good(robot, objective={"weighted": {"length": 1, "integral": [{"hinge": 0.1}]}})
    problem.objective["weighted"]["integral"][0]["hinge"] = 0.2
    assert problem.copy().objective["weighted"]["integral"][0]["hinge"] == 0.2
    problem.objective["weighted"]["integral"].append({"inverse": 0.3})
    assert len(problem.copy().objective["weighted"]["integral"]) == 2
    task = good(robot, steps=[TaskStep.move(TUCKED)])
    task.steps.append(TaskStep.move("ready", name="back"))
    assert [step.name for step in leeway.plan(task).steps] == ["move", "back"]
    task.goals.append(TUCKED)
    assert "goals beside the steps" in refusal(lambda: leeway.plan(task))
    task.steps.clear()
    assert leeway.plan(task)


def test_an_obstacle_that_is_added_to_the_problems_world_is_avoided(robot):
    """The programs of the issue: each of these was certified without what was asked."""
    problem = good(robot, start=[-0.8, 0.4, 0, -1.6, 0, 1.1416, 0], goal=[0.8, 0.4, 0, -1.6, 0, 1.1416, 0])
    free = leeway.plan(problem)
    problem.world.add_box("wall", (0.1, 0.1, 1), position=(0.5, 0, 0.5))
    around = leeway.plan(problem)
    assert around and not same(free, around) and leeway.verify(problem, around)
    assert leeway.verify(problem, free).status == "refuted"
    problem.margins[("robot", ("wall", "post"))] = 0.03
    wide = leeway.plan(problem)
    assert wide and leeway.verify(problem, wide) and wide.certificate.world.lower >= 0.03
    problem.start[0] = -0.9
    assert leeway.plan(problem).path[0, 0] == -0.9
    problem.allowed.append(("robot", "wall"))
    assert same(leeway.plan(problem, start=free.path[0]), free)


def test_settings_that_change_others_change_what_was_handed_out(robot):
    problem = good(robot)
    others, goals = problem.others, problem.goals
    problem.start = {**dict(zip(robot.joint_names, problem.start)), "joint1": 0.1, "finger_joint": 0.02}
    assert others == {"finger_joint": 0.02} and problem.others is others
    problem.steps = [TaskStep.move(TUCKED)]
    steps = problem.steps
    assert goals == [] and len(steps) == 1
    problem.goal = TUCKED
    assert steps == [] and len(goals) == 1 and problem.goals is goals
    with pytest.raises(ValueError, match="'joint1' is planned; its value belongs to start"):
        problem.others = {"joint1": 0.1}


def test_a_joint_has_its_value_once(robot):
    start = {**dict(zip(robot.joint_names, TUCKED)), "finger_joint": 0}
    with pytest.raises(ValueError, match="start gives joint 'finger_joint', which has a value in others"):
        good(robot, start=start, others={"finger_joint": 0.03})
    with pytest.raises(ValueError, match="start gives joint 'finger_joint', which has a value in others"):
        good(robot, start={"arm": "ready", "hand": "open"}, others={"finger_joint": 0.01})
    assert good(robot, others={"finger_joint": 0.03}).others == {"finger_joint": 0.03}


def elsewhere():
    world = worlds()
    world.move("post", (5, 0, 0.5))
    return world


KEPT = {
    "world": elsewhere(),
    "margins": {("hand", "post"): 0.01},
    "allowed": [("hand", "post")],
    "checked": [("link1", "link2")],
    "start": TUCKED,
    "goals": ["upright"],
    "frames": {},
    "velocities": 0.5,
}


@pytest.mark.parametrize("name", KEPT)
def test_what_was_replaced_can_be_put_back(robot, name):
    """A problem that was given back its world went through its walls, as to replace it had emptied it."""
    problem = good(robot, margins={("robot", "post"): 0.02}, frames={"tip": ("hand", (0, 0, 0.1))}, velocities={"joint1": 0.25})
    before, other = leeway.plan(problem, iterations=20), problem.copy()
    kept = getattr(problem, name)
    setattr(problem, name, KEPT[name])
    setattr(other, name, KEPT[name])
    assert same(leeway.plan(problem, iterations=20), leeway.plan(other, iterations=20))
    setattr(problem, name, kept)
    assert getattr(problem, name) is kept and problem.world.pose("post")[0, 3] == 0.5
    assert same(leeway.plan(problem, iterations=20), before)
    setattr(problem, name, getattr(problem, name))
    assert getattr(problem, name) is kept


def test_all_that_was_replaced_and_kept_is_watched(robot):
    problem = good(robot)
    first = problem.start
    for _ in range(150):
        problem.start = problem.start.copy()
    first[0] += 0.1
    with pytest.raises(ValueError, match="'start' was changed after another had taken its place"):
        leeway.plan(problem)


def test_what_was_replaced_is_not_changed_in_vain(robot):
    problem = good(robot)
    world, margins = problem.world, problem.margins
    problem.margins, problem.world = {("hand", "post"): 0.01}, worlds()
    margins[("link6", "post")] = 0.02
    for _ in range(2):
        with pytest.raises(ValueError, match="'margins' was changed after another had taken its place"):
            leeway.plan(problem)
    problem.margins = problem.margins
    assert leeway.plan(problem).status == "solved"
    world.add_sphere("ball", 0.1, position=(5, 0, 0))
    with pytest.raises(ValueError, match="'world' was changed after another"):
        problem.copy()
    assert problem.margins == {("hand", "post"): 0.01}
    problem.world = world
    world.add_sphere("other", 0.1, position=(5, 0, 0))
    assert problem.copy().world.names == ["post", "ball", "other"]
    old = problem.margins  # changed between, and put back: this counts
    problem.margins = {}
    old["link5", "post"] = 0.03
    problem.margins = old
    assert ("link5", "post") in problem.copy().margins


def test_the_margin_that_was_set_last_holds(robot):
    """A key that was there keeps its place in a dict: a margin of the group that came behind it held instead."""
    problem = good(robot, margins={("hand", "post"): 0.01, ("robot", "world"): 0.02})
    problem.margins["hand", "post"] = 0.5
    problem.margins["link6", "post"] = 0.03
    problem.seed = 2
    assert list(problem.copy().margins.items())[-2:] == [(("hand", "post"), 0.5), (("link6", "post"), 0.03)]
    assert leeway.plan(problem).status == "invalid_start"


def test_a_goal_does_not_stand_beside_goals(robot):
    with pytest.raises(ValueError, match="goal is given beside goals; one of them is expected"):
        good(robot, goals=[TUCKED])


def test_words_are_words(robot):
    for call in (lambda word: FramePose("hand", (0, 0, 0), relative_to=word), lambda word: TaskStep.line(by=(0, 0, 1), relative_to=word),
                 lambda word: good(robot, planner=word), lambda word: good(robot, goal=word), lambda word: leeway.Scene(good(robot)).check(word)):
        for wrong in (5, "\ud800"):
            with pytest.raises((TypeError, ValueError)) as error:
                call(wrong)
            assert "\n" not in str(error.value) and "Unable to cast" not in str(error.value)


def test_margins_of_groups_stay_groups(robot):
    """A margin of 'robot' has no effect on the base, which does not move: no warning, as it has for other links."""
    problem = good(robot, margins={("robot", "post"): 0.02})
    assert leeway.plan(problem).warnings == []
    problem.margins[("hand", "post")] = 0.03
    assert leeway.plan(problem).warnings == []
    problem.margins[("link1", "link2")] = 0.1
    assert leeway.plan(problem).warnings == ["the margin of 'link1' and 'link2' has no effect: the pair is not checked (adjacent)"]


def test_margins_of_the_world_are_for_what_comes_later_too(robot):
    """Without objects none of them is without effect; a link that does not move keeps none."""
    empty = leeway.Problem(robot, leeway.World(), "ready", TUCKED, margins={("robot", "world"): 0.02, ("hand", "world"): 0.03})
    assert leeway.plan(empty).warnings == []
    problem = good(robot, margins={("robot", "world"): 0.02, ("hand", "world"): 0.03})
    assert leeway.plan(problem).warnings == []
    problem.margins[("base", "world")] = 0.1
    assert leeway.plan(problem).warnings == ["the margin of 'base' and 'world' has no effect: the pair is not checked (neither moves)"]


def test_a_problem_copies_what_it_is_given(robot):
    world, q, allowed = worlds(), np.array(TUCKED), []
    problem = leeway.Problem(robot, world, q, q, allowed=allowed)
    world.add_sphere("ball", 0.1)
    q[0] = 1
    allowed.append(("hand", "post"))
    assert problem.world.names == ["post"] and problem.start[0] == 0 and problem.allowed == []
    other = problem.copy()
    other.world.add_sphere("ball", 0.1)
    assert problem.world.names == ["post"]
    for copied in (copy.copy(problem), copy.deepcopy(problem), copy.deepcopy({"one": [problem]})["one"][0]):
        assert list(copied.start) == list(problem.start) and copied.robot.links == robot.links
        copied.margins["hand", "post"] = 0.02
        copied.world.add_sphere("ball", 0.1)
    assert problem.world.names == ["post"] and problem.margins == {}
    for copied in (copy.copy(world), copy.deepcopy(world)):
        copied.remove("ball")
    assert world.names == ["post", "ball"]
    shape, pose, step = leeway.Shape.box((1, 1, 1)), FramePose("hand", (0.5, 0, 0.5), rpy=(0, 0, 0)), TaskStep.detach("post")
    for constant in (robot, shape, pose, step):
        assert copy.copy(constant) is constant and copy.deepcopy([constant])[0] is constant
    for thing in (problem, world, robot):
        with pytest.raises(TypeError, match=f"cannot pickle 'leeway.{type(thing).__name__}' object"):
            pickle.dumps(thing)
    running = leeway.plan(problem)
    problem.world.add_sphere("ball", 0.1)
    assert running.problem.world.names == ["post"]


# ---- What is not live cannot be changed.

DEFORMABLE = leeway.Deformable(np.eye(3), [[0, 1, 2]])


def objects(robot):
    """An object of every class that has attributes, by its class's name."""
    problem = good(robot, start=[-0.8, 0.4, 0, -1.6, 0, 1.1416, 0], wishes={("hand", "post"): 0.05}, time=1)
    result, scene = leeway.plan(problem), leeway.Scene(problem)
    moving = leeway.World()
    moving.add_deforming("cloth", np.eye(3), [[0, 1, 2]], position=(5, 0, 0), speed_bound=0)
    replanner = leeway.Replanner(robot, moving, "ready", TUCKED)
    step = replanner.step()
    guard = leeway.Guard(robot, moving, "ready")
    monitor = leeway.Monitor(scene, accelerations=[10] * 7)
    task = leeway.plan(good(robot, steps=[TaskStep.move(TUCKED)]))
    ball = leeway.Shape.sphere(1)
    return [robot, problem.world, result, result.certificate, result.certificate.world, result.trajectory(), scene, scene.check("start"),
            scene.certify(TUCKED, TUCKED), leeway.verify(problem, result), replanner, step, guard, guard.check(), leeway.replan(robot, moving, "ready", TUCKED, steps=1), monitor,
            monitor.look(0, TUCKED, [0] * 7, horizon=1), task.steps[0], FramePose("hand", (0, 0, 0)), leeway.Waypoint((0, 0, 0)), UPRIGHT, TaskStep.move(TUCKED), ball,
            leeway.Shape.mesh(vertices=np.eye(3), triangles=[[0, 1, 2]]), leeway.distance(ball, None, ball, (3, 0, 0)), leeway.separation(ball, None, ball, None),
            leeway.inverse_kinematics(robot, "hand", robot.pose("hand", TUCKED)), DEFORMABLE, result.problem, scene.problem]


def test_objects_are_made_by_calls_alone(robot):
    classes = [value for value in vars(leeway._leeway).values() if isinstance(value, type) and not issubclass(value, Exception)]
    assert len(classes) > 20
    for made in classes:
        with pytest.raises(TypeError, match="__new__"):
            made.__new__(made)


def attributes(thing):
    return [name for name in dir(type(thing)) if not name.startswith("_") and isinstance(getattr(type(thing), name), property)]


def expect_constant(value, where):
    """Nothing that could be changed is in it."""
    if isinstance(value, np.ndarray):
        assert not value.flags.writeable, where
        with pytest.raises(ValueError):
            value[...] = 0
    elif isinstance(value, list):
        for change in (lambda: value.append(1), lambda: value.clear(), lambda: value.__setitem__(slice(None), []), lambda: value.sort(), lambda: value.pop(),
                       lambda: value.__iadd__([1]), lambda: value.__imul__(2), lambda: value.extend([1]), lambda: value.insert(0, 1),
                       lambda: value.remove(1), lambda: value.reverse(), lambda: value.__delitem__(0)):
            with pytest.raises(TypeError, match="read-only"):
                change()
        for item in value:
            expect_constant(item, where)
    elif isinstance(value, tuple):
        for item in value:
            expect_constant(item, where)
    elif isinstance(value, leeway.World):
        with pytest.raises(TypeError, match="copy"):
            value.add_sphere("new", 1)
        for change in (lambda: value.remove("post"), lambda: value.move("post")):
            with pytest.raises(TypeError, match="copy"):
                change()
    elif hasattr(value, "keys"):
        with pytest.raises(TypeError):
            value["new"] = 1
        for item in value.values():
            expect_constant(item, where)


def test_what_is_not_live_cannot_be_changed(robot):
    seen = set()
    for thing in objects(robot):
        kind = type(thing).__name__
        for name in attributes(thing):
            seen.add((kind, name))
            where = f"{kind}.{name}"
            expect_constant(getattr(thing, name), where)
            if (kind, name) != ("Replanner", "state"):
                with pytest.raises(AttributeError):
                    setattr(thing, name, getattr(thing, name))
        with pytest.raises(AttributeError):
            thing.no_such_attribute = 1
    classes = {name for name in leeway.__all__ if isinstance(getattr(leeway, name), type) and not issubclass(getattr(leeway, name), Exception)}
    with_attributes = {name for name in classes if any(isinstance(value, property) for value in vars(getattr(leeway, name)).values())}
    assert with_attributes <= {kind for kind, _ in seen}, with_attributes - {kind for kind, _ in seen}


def test_copies_of_what_cannot_be_changed_can(robot):
    names = robot.joint_names
    assert names == list(names) and json.dumps(names) and names[:2] == ["joint1", "joint2"]
    for made in (list(names), copy.copy(names), copy.deepcopy(names), pickle.loads(pickle.dumps(names)), names + ["more"]):
        made.append("joint8")
        assert made[-1] == "joint8"
    lower = robot.lower.copy()
    lower[0] = 0
    assert robot.lower[0] < 0
    world = worlds()
    with pytest.raises(ValueError):
        world.pose("post")[0, 3] = 1
    problem = leeway.Scene(good(robot)).problem.copy()
    problem.world.add_sphere("ball", 0.1, position=(5, 0, 0))
    assert "ball" in problem.world


def test_starts_say_something_of_every_planned_joint(robot):
    problem, goal = good(robot), [0.8, 0.4, 0, -1.6, 0, 1.1416, 0]
    for some in ({}, {"joint1": 0.1}, {"finger_joint": 0.02}):
        for use in (lambda: setattr(problem, "start", some), lambda: leeway.plan(robot, worlds(), some, goal), lambda: leeway.check(problem, state=some),
                    lambda: leeway.Guard(robot, worlds(), some), lambda: leeway.Scene(problem).check(some)):
            with pytest.raises(ValueError, match="start says nothing of joint"):
                use()
    for use in (lambda: leeway.plan(robot, worlds(), None, goal), lambda: leeway.plan(robot, worlds(), goal=goal), lambda: leeway.Guard(robot, worlds())):
        with pytest.raises(ValueError, match="no start is given"):
            use()


def test_a_mesh_of_vertices_has_a_scale(robot):
    for scale in (0, (1, 0, 1)):
        with pytest.raises(ValueError, match="scale is 0.0; numbers other than 0 are expected"):
            worlds().add_mesh("new", vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles=[[0, 1, 2]], scale=scale)


def test_what_holds_itself_or_hides_its_changes_is_refused(robot):
    hidden = array.array("d", TUCKED), collections.deque(TUCKED), memoryview(np.array(TUCKED)), collections.UserList(TUCKED)
    edits = [lambda p: p.goals.append(p.goals), lambda p: p.allowed.append(p.allowed), lambda p: put(p.margins, ("hand", "post"), p.margins),
             lambda p: put(p.wishes, ("hand", "post"), p.wishes), lambda p: put(p.frames, "tip", ("hand", p.frames)), lambda p: put(p.others, "finger_joint", p.others),
             lambda p: p.steps.append(p.steps), lambda p: p.constraints.append(p.constraints), *[lambda p, of=of: p.goals.append(of) for of in hidden]]
    for edit in edits:
        problem = good(robot)
        edit(problem)
        for _ in range(2):
            with pytest.raises((TypeError, ValueError), match="holds itself|holds an object of type"):
                leeway.plan(problem)
    problem = good(robot)
    problem.goals.append(problem.goals)
    problem.goals = ["upright"]
    assert problem.copy().goals[0][1, 0] == 0
    given = {}
    given["arm"] = given
    with pytest.raises((TypeError, ValueError)):
        problem.goal = given


def test_a_value_replaces_the_changes_of_the_one_before(robot):
    problem = good(robot)
    old = problem.goals[0]
    old[0] = 0.3
    problem.goals = ["upright"]
    assert problem.copy().goals[0][0, 0] == 0
    for _ in range(130):
        problem.goals = ["upright"]
        assert problem.goals
    old[0] = 0.4
    with pytest.raises(ValueError, match="'goals' was changed after another"):
        leeway.plan(problem)


def test_a_world_that_was_replaced_is_watched_as_well(robot):
    problem = good(robot)
    old = problem.world
    problem.world = leeway.World()
    for _ in range(130):
        problem.goals = ["upright"]
        assert problem.goals
    old.add_sphere("late", 0.1, position=(3, 0, 0))
    with pytest.raises(ValueError, match="'world' was changed after another"):
        leeway.plan(problem)
