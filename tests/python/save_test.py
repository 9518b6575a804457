"""Problems of Python programs as files: what is saved and loaded again is the same problem."""
import pathlib

import numpy as np
import pytest

import leeway

ROOT = pathlib.Path(__file__).resolve().parents[2]


def again(problem, folder):
    problem.save(folder / "saved.yaml")
    loaded = leeway.load(folder / "saved.yaml", cache=False)
    for setting in leeway.settings():
        name = setting["name"]
        if name in ("world", "goal", "goals", "steps", "wishes", "constraints", "start", "frames") or not hasattr(problem, name):
            continue
        assert getattr(loaded, name) == getattr(problem, name), name
    assert np.array_equal(loaded.start, problem.start)
    assert list(loaded.world) == list(problem.world)
    for name in problem.world:
        assert np.allclose(loaded.world.pose(name), problem.world.pose(name), rtol=0, atol=1e-14)
        assert loaded.world.color(name) == problem.world.color(name)
    return loaded


def test_a_world_of_everything_comes_back(robot, tmp_path):
    world = leeway.World()
    world.add_box("box", (0.1, 0.2, 0.3), position=(0.7, 0, 0.1), rpy=(0.1, 0.2, 0.3), color=(1, 0.5, 0))
    world.add_mesh("tetrahedron", vertices=np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 1 / 3]]), triangles=[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
                   position=(2, 0, 0))
    world.add_cloud("cloud", np.random.default_rng(1).uniform(1, 2, (50, 3)), 0.01, thin=0.2)
    world.add_half_space("floor", position=(0, 0, -0.5), color=(0.2, 0.2, 0.2))
    world.add_height_field("ground", np.array([[0, 0.1], [0.2, 0.1]]), 0.5, -0.1, position=(3, 0, 0))
    rest = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], float)
    world.add_deforming("cloth", rest, [[0, 1, 2], [1, 3, 2]], motion=leeway.Motion.waves(rest, [(1, 0, 0)], [(0, 0, 0.1)], [0.7], [0.3]), position=(3, 3, 0),
                        color=(0, 0, 1))
    problem = leeway.Problem(robot, world, "upright", "ready", margin=0.003, margins={("robot", "box"): 0.01, (("box", "cloud"), "hand"): 0.02},
                             wishes={("robot", "box"): (0.05, 2)}, allowed=[("base", "floor")], time=2, seed=7, velocities={"joint1": 0.3},
                             others={"finger_joint": 0.03}, frames={"grip": ("hand", (0, 0, 0.09))})
    loaded = again(problem, tmp_path)
    a, b = leeway.plan(problem, iterations=3000, time=0), leeway.plan(loaded, iterations=3000, time=0)
    assert a.status == b.status == "solved"
    # Rotations agree to 1e-14, so that searches take the same way.
    assert np.allclose(a.path, b.path, atol=1e-6)
    assert leeway.Problem(loaded, goal=leeway.FramePose("grip", position=(0.5, 0, 0.5), rpy=(np.pi, 0, "any"), relative_to="box")).goals


def test_poses_steps_and_held_objects_come_back(robot, tmp_path):
    world = leeway.World()
    world.add_cylinder("can", 0.03, 0.1, position=(0.5, 0.3, 0.4))
    world.add_box("tray", (0.2, 0.2, 0.02), position=(0.6, -0.2, 0.3), rpy=(0, 0, 0.4))
    goal = leeway.FramePose("grip", position=(0, (0, 0.05), 0.2), rpy=(np.pi, 0, "any"), relative_to="tray")
    problem = leeway.Problem(robot, world, "ready", goal, frames={"grip": ("hand", (0, 0, 0.09))})
    loaded = again(problem, tmp_path)
    assert str(loaded.goal) == str(problem.goal)
    again(problem.attach("can", "hand", ["finger_left"]), tmp_path)
    for name in ("pick_place/can", "pick_place/carton", "constrained/glass"):
        again(leeway.load(ROOT / f"problems/{name}.yaml", cache=False), tmp_path)


def test_files_stay_the_same_in_another_working_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    problem = leeway.load("problems/shelf/reach.yaml", cache=False)
    monkeypatch.chdir(tmp_path)
    again(problem, tmp_path)


def test_what_files_cannot_say_is_refused(robot, tmp_path):
    world = leeway.World()
    world.add_box("tray", (0.2, 0.2, 0.02), position=(0.6, -0.2, 0.3))
    problem = leeway.Problem(robot, world, "ready", leeway.FramePose("hand", position=(0, 0, 0.2), relative_to="tray"))
    # The goal stays where it was, where nothing stands now.
    problem.world.move("tray", position=(0.6, -0.3, 0.3))
    (tmp_path / "kept.yaml").write_text("as it was")
    with pytest.raises(leeway.InputError, match="no object and no link at rest stands"):
        problem.save(tmp_path / "kept.yaml")
    assert (tmp_path / "kept.yaml").read_text() == "as it was"
    with pytest.raises(leeway.InputError, match=r"\.yaml"):
        problem.save(tmp_path / "problem.json")
    with pytest.raises(leeway.InputError, match="folder"):
        leeway.Problem(robot, leeway.World(), "ready", "upright").save(tmp_path / "none/problem.yaml")


def test_colors(robot):
    world = leeway.World()
    world.add_sphere("ball", 0.1, color=(0.1, 0.2, 0.3))
    assert world.color("ball") == (0.1, 0.2, 0.3)
    world.paint("ball", None)
    assert world.color("ball") is None
    for wrong in ((1, 2, 0), (0, 0), "red", (float("nan"), 0, 0)):
        with pytest.raises((ValueError, TypeError)):
            world.paint("ball", wrong)
    with pytest.raises(KeyError):
        world.paint("bal", (0, 0, 0))
    with pytest.raises(KeyError):
        world.color("bal")
    assert world.color("ball") is None
