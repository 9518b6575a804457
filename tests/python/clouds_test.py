"""Point clouds from numpy."""

import numpy as np
import pytest

import leeway


def wall(spacing=0.02, dtype=np.float64):
    """A square grid of points across the arm's way, in front of it."""
    u, v = np.meshgrid(np.arange(-0.3, 0.3, spacing), np.arange(-0.3, 0.3, spacing))
    return np.column_stack([0 * u.ravel(), u.ravel(), v.ravel()]).astype(dtype)


def test_a_cloud_is_planned_among_and_verified(robot):
    start, goal = robot.state("ready"), robot.state("ready")
    start[0], goal[0] = -0.8, 0.8
    answers = []
    for dtype in (np.float64, np.float32):
        world = leeway.World()
        assert world.add_cloud("post", wall(dtype=dtype) * (1, 0.2, 1), 0.015, position=(0.5, 0, 0.5)) == []
        assert "cloud of 900 balls" in world._repr_html_() and "post" in world
        result = leeway.plan(robot, world, start, goal, margin=0.01)
        assert result and result.certificate.lower >= 0.01 and leeway.verify(result.problem, result)
        answers.append(result.certificate.lower)
    assert np.isclose(*answers, atol=1e-4)
    # Every answer says what it does not cover.
    notes = result.problem.notes
    assert list(notes) == ["cloud 'post': space that was not seen counts as free"]
    verified, state = leeway.verify(result.problem, result), leeway.Scene(result.problem).check("start")
    assert result.notes == verified.notes == state.notes == notes
    assert leeway.plan(robot, None, start, goal).notes == notes[:0]


def test_any_strides_and_radii(world):
    records = np.zeros(900, dtype=[("xyz", np.float32, 3), ("rgb", np.uint8, 3)])
    records["xyz"] = wall(dtype=np.float32)
    records["xyz"][:2] = np.nan
    assert world.add_cloud("records", records["xyz"], 0.01) == [("drop", "points that are not numbers", 2)]
    world.add_cloud("reversed", wall()[::-1], np.full(900, 0.01))
    world.add_cloud("columns", np.asfortranarray(wall()), 0.01)
    world.add_cloud("integers", [[1, 2, 3], [4, 5, 6]], 1)
    world.add_cloud("with intensity", np.hstack([wall(), np.ones((900, 1))])[:, :3], 0.01)
    world.add_cloud("one", wall()[:1], 0.01)
    world.add_cloud("the same, many times", np.broadcast_to(np.array([1.0, 2, 3]), (9, 3)), 0.01)
    world.add_cloud("nothing masked", np.ma.masked_invalid(wall()), 0.01)
    assert world.add_cloud("thin", wall(), 0.01, thin=0.1)[0][0] == "thin"


def test_a_cloud_is_added_to_the_world_that_a_problem_hands_out(robot):
    start, goal = robot.state("ready"), robot.state("ready")
    start[0], goal[0] = -0.8, 0.8
    problem = leeway.Problem(robot, leeway.World(), start, goal, margin=0.01)
    free = leeway.plan(problem)
    problem.world.add_cloud("post", wall() * (1, 0.2, 1), 0.015, position=(0.5, 0, 0.5))
    assert "post" in problem.copy().world and leeway.verify(problem, free).status == "refuted"
    with pytest.raises(TypeError, match="compiled or answered"):
        free.problem.world.add_cloud("post", wall(), 0.015)
    assert "post" not in free.problem.world


def test_a_region_is_seen_again(robot):
    start, goal = robot.state("ready"), robot.state("ready")
    start[0], goal[0] = -0.8, 0.8
    world, points = leeway.World(), wall() * (1, 0.2, 1)
    world.add_cloud("post", points, 0.015, position=(0.5, 0, 0.5))
    scene = leeway.Scene(robot, world, margin=0.01)
    low, high = (-1, -1, -1), (1, 1, 0)
    above = points[points[:, 2] > 0]
    gone = scene.with_region("post", low, high, np.zeros((0, 3)), 0.015)
    again = gone.with_region("post", low, high, points[points[:, 2] <= 0] + (0, 0.1, 0), 0.02)
    assert gone.pairs < again.pairs == scene.pairs
    for renewed in (gone, again):
        anew = leeway.Scene(renewed.problem)
        assert renewed.pairs == anew.pairs
        states = start + np.random.default_rng(1).uniform(0, 1, (50, 1)) * (goal - start)
        assert np.allclose(renewed.clearances(states), anew.clearances(states), atol=2e-6)
        result = leeway.plan(renewed.problem, start=start, goal=goal)
        assert result and leeway.verify(result.problem, result)
    for wrong in (("pst", low, high, above), ("post", high, low, above), ("post", (np.nan, 0, 0), high, above), ("post", low, high, above * 1e12)):
        with pytest.raises(ValueError):
            scene.with_region(*wrong, 0.01)
    with pytest.raises(ValueError, match="^low"):
        scene.with_region("post", (-np.nan, -1, -1), high, above, 0.01)
    assert scene.with_region("post", (-np.inf,) * 3, (np.inf, np.inf, 0), above, 0.01).problem.world is not None


def test_unseen_space_is_occupied_and_saved(world, robot, tmp_path):
    depth = np.full((12, 16), 0.5, np.float32)
    depth[3:5, 3:5] = np.nan
    camera = dict(fx=12, fy=12, cx=7.5, cy=5.5, position=(0.6, -0.6, 0.5), orientation=(0, -0.7071067811865476, -0.7071067811865476, 0))
    q = robot.state("ready")
    lowers = []
    for more in ({}, dict(unseen="occupied", range=1.0, parts=20)):
        seen = world.copy()
        seen.add_depth_image("camera", depth, 0.003, **camera, **more)
        problem = leeway.Problem(robot, seen, q, q)
        problem.save(tmp_path / "saved.yaml")
        loaded = leeway.load(tmp_path / "saved.yaml", cache=False)
        checks = [leeway.check(p) for p in (problem, loaded)]
        assert np.isclose(checks[0].lower, checks[1].lower, atol=2e-6) and checks[0].closest == checks[1].closest
        lowers.append(checks[0].lower)
    assert lowers[1] < lowers[0], "behind the surface there may be something"
    for words, arguments in (("range", dict(unseen="occupied")), ("range", dict(range=1.0)), ("parts stands without unseen", dict(parts=20)), ("'occupied'", dict(unseen="maybe")), ("parts", dict(unseen="occupied", range=1.0, parts=0))):
        with pytest.raises(ValueError, match=words):
            world.copy().add_depth_image("camera", depth, 0.003, **camera, **arguments)


def test_carving_leaves_out_what_touches_an_object(world):
    world.add_box("can", (0.1, 0.1, 0.1), position=(0.5, 0, 0.5))
    removed = world.add_cloud("seen", wall(), 0.01, carve=["can"], carve_margin=0.005, position=(0.5, 0, 0.5))
    assert removed == [("carve", "balls within 0.005 m of can", 49)]


@pytest.mark.parametrize("points, radius, more, words", [
    (np.zeros(3), 0.1, {}, "shape (n, 3)"),
    (np.zeros((3, 2)), 0.1, {}, "shape (n, 3)"),
    (np.zeros((3, 50)), 0.1, {}, "has shape (3, 50); shape (n, 3)"),
    (np.zeros((50, 4)), 0.1, {}, "points[:, :3]"),
    ([["a", "b", "c"]], 0.1, {}, "dtype <U1; real numbers"),
    (np.zeros((3, 3), complex), 0.1, {}, "dtype complex128; real numbers"),
    (np.zeros((3, 3), bool), 0.1, {}, "dtype bool; real numbers"),
    (np.ma.masked_equal([[1.0, 2, 3], [4, 5, 6]], 5), 0.1, {}, "points has masked entries"),
    (np.zeros((0, 3)), 0.1, {}, "points: no ball is left"),
    (np.full((9, 3), np.nan), 0.1, {}, "dropped 9 points that are not numbers"),
    (np.zeros((3, 3)), 0.1, {"carve_margin": 0.1}, "carve_margin stands without carve"),
    (np.zeros((3, 3)), 0, {}, "radius 0"),
    (np.zeros((3, 3)), np.nan, {}, "radius"),
    (np.zeros((3, 3)), [0.1, 0.2], {}, "2 radii for 3 points"),
    (np.full((3, 3), 1e10), 0.1, {}, "point 0"),
    (np.zeros((3, 3)), 0.1, {"thin": 0}, "a cell of 0"),
    (np.zeros((3, 3)), 0.1, {"carve": ["cann"]}, "'cann'"),
    (np.zeros((3, 3)), 0.1, {"carve": "can"}, "carve is 'can'; a list of names"),
    (np.zeros((3, 3)), 0.1, {"carve_margin": -1, "carve": ["can"]}, "margin -1"),
])
def test_bad_clouds_are_refused_in_one_line(world, points, radius, more, words):
    world.add_box("can", (0.1, 0.1, 0.1))
    count = len(world)
    with pytest.raises((ValueError, TypeError, KeyError)) as error:
        world.add_cloud("seen", points, radius, **more)
    assert words in str(error.value) and "\n" not in str(error.value)
    assert len(world) == count


ARM = """<robot name="arm"><link name="base"/>
<link name="l1"><collision><origin xyz="0.25 0 0"/><geometry><box size="0.4 0.05 0.05"/></geometry></collision></link>
<link name="l2"><collision><origin xyz="0.15 0 0"/><geometry><box size="0.3 0.05 0.05"/></geometry></collision></link>
<joint name="a" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="2" effort="1"/></joint>
<joint name="ext" type="prismatic"><parent link="l1"/><child link="l2"/><origin xyz="0.4 0 0"/><axis xyz="1 0 0"/><limit lower="0" upper="1" velocity="2" effort="1"/></joint>
</robot>"""
GROUPS = """<robot name="arm"><group name="rot"><joint name="a"/></group>
<group name="both"><joint name="a"/><joint name="ext"/></group></robot>"""


@pytest.fixture
def cropped(tmp_path):
    """The file of a problem whose cloud, a wall that the arm touches when it is longer, is cropped to nothing."""
    (tmp_path / "arm.urdf").write_text(ARM)
    (tmp_path / "arm.srdf").write_text(GROUPS)
    (tmp_path / "wall.xyz").write_text("1.2 0 0\n")
    file = tmp_path / "problem.yaml"
    file.write_text("""leeway: 1
robot: {urdf: arm.urdf, srdf: arm.srdf, group: rot}
start: [-0.5]
goal: [0.5]
objects:
  - {name: wall, cloud: {file: wall.xyz, radius: 0.02, crop: 0.1}}
  - {name: stick, box: {size: [1, 0.03, 0.03]}, position: [1, 0, 0]}
""")
    return file


def with_robot(problem, cropped, **robot):
    robot = leeway.Robot(cropped.with_name("arm.urdf"), cropped.with_name("arm.srdf"), **robot)
    return leeway.Problem(robot, problem.world, np.zeros(len(robot.joint_names)), np.full(len(robot.joint_names), 0.1))


@pytest.mark.parametrize("edit, words", [
    (lambda p, _: p.attach("stick", "l2"), "reaches less far"),
    (lambda p, _: setattr(p, "others", {"ext": 0.7}), "reaches less far"),
    (lambda p, _: p.world.move("wall", (-0.5, 0, 0)), "another pose"),
    (lambda p, _: setattr(p, "margin", 0.5), "a crop of at least that"),
    (lambda p, _: setattr(p, "steps", [leeway.TaskStep.move([0.0]), leeway.TaskStep.attach("stick", "l2")]), "attaches an object"),
    (lambda p, file: with_robot(p, file, group="both"), "reaches less far"),
    (lambda p, file: with_robot(p, file, group="rot", base_pose=(0.55, 0, 0)), "reaches less far"),
])
def test_a_cropped_cloud_holds_for_its_robot_and_place_only(cropped, edit, words):
    problem = leeway.Problem.load(cropped)
    problem.world.move("stick", (1, 0, 2))
    assert leeway.plan(problem)
    with pytest.raises(leeway.InputError) as error:
        leeway.plan(edit(problem, cropped) or problem)
    assert "cloud 'wall'" in str(error.value) and words in str(error.value)


CAMERA = {"fx": 50, "fy": 50, "cx": 31.5, "cy": 23.5}


def test_depth_images_of_all_types(robot):
    millimetres = np.full((48, 64), 1000, np.uint16)
    millimetres[:5] = 0
    removed = [("drop", "pixels without a measurement", 320)]
    worlds = []
    for depth in (millimetres, millimetres.astype(np.float32) / 1000, millimetres / 1000, np.asfortranarray(millimetres)):
        world = leeway.World()
        # The camera looks along the world's x, at the arm's way.
        assert world.add_depth_image("wall", depth, 0.005, **CAMERA, position=(-0.5, 0, 0.5), orientation=(-0.5, 0.5, -0.5, 0.5)) == removed
        worlds.append(world)
    start, goal = robot.state("ready"), robot.state("ready")
    start[0], goal[0] = -0.8, 0.8
    results = [leeway.verify(leeway.Problem(robot, world, start, goal), np.stack([start, goal])) for world in worlds]
    assert len({result.status for result in results}) == 1 and results[0].status == "refuted"


def test_a_path_among_few_balls_of_a_depth_image_is_verified(robot):
    depth = np.full((48, 64), np.nan, np.float32)
    depth[:, 30:34] = 1.0
    mask = np.ones(depth.shape, bool)
    mask[:10] = False
    start, goal = robot.state("ready"), robot.state("ready")
    start[0], goal[0] = -0.8, 0.8
    where = {"position": (-0.5, 0, 0.5), "orientation": (-0.5, 0.5, -0.5, 0.5)}
    all_of_it, thin = leeway.World(), leeway.World()
    removed = all_of_it.add_depth_image("post", depth, 0.005, **CAMERA, mask=mask, **where)
    assert removed == [("drop", "pixels that the mask leaves out", 640), ("drop", "pixels without a measurement", 38 * 60)]
    assert thin.add_depth_image("post", depth, 0.005, **CAMERA, mask=mask, most_balls=40, **where)[-1][::2] == ("thin", 112)
    result = leeway.plan(robot, thin, start, goal, margin=0.01)
    assert result and leeway.verify(leeway.Problem(robot, all_of_it, start, goal, margin=0.01), result)


@pytest.mark.parametrize("depth, radius, more, words", [
    (np.ones(3), 0.1, {}, "shape (rows, columns)"),
    (np.ones((3, 3), np.int32), 0.1, {}, "type int32"),
    (np.ones((3, 3), ">u2"), 0.1, {}, "uint16, float32 or float64"),
    (-np.ones((3, 3)), 0.1, {}, "row 0, column 0 has the depth -1"),
    (np.ones((3, 3)), 0, {}, "radius 0"),
    (np.ones((3, 3)), 0.1, {"fx": 0}, "fx 0"),
    (np.ones((3, 3)), 0.1, {"slant": 1.6}, "slant 1.6"),
    (np.ones((3, 3)), 0.1, {"scale": -1}, "scale -1"),
    (np.ones((3, 3)), 0.1, {"mask": np.ones((2, 3))}, "mask has another shape than depth; (3, 3)"),
    (np.ma.masked_equal(np.ones((3, 3)), 1), 0.1, {}, "depth has masked entries"),
    (np.ones((3, 3)), 0.1, {"carve_margin": 0.1}, "carve_margin stands without carve"),
    (np.ones((3, 3)), 0.1, {"most_balls": 0}, "most_balls is 0"),
    (np.ones((3, 3)), 0.1, {"most_balls": 1.5}, "most_balls is 1.5"),
    (np.ones((3, 3)), 0.1, {"most_balls": True}, "most_balls is True"),
    (np.ones((3, 3)), True, {}, "radius is of type bool"),
])
def test_bad_depth_images_are_refused_in_one_line(world, depth, radius, more, words):
    count = len(world)
    with pytest.raises((ValueError, TypeError)) as error:
        world.add_depth_image("seen", depth, radius, **{**CAMERA, **more})
    assert words in str(error.value) and "\n" not in str(error.value)
    assert len(world) == count


def test_height_fields(robot):
    heights = np.zeros((5, 9))
    heights[2, 4] = 0.3
    shape = leeway.Shape.height_field(heights, 0.1, -0.5)
    assert shape.type == "mesh" and len(shape.triangles) == 2 * 4 * 8 + 3 * 24
    assert np.array_equal(shape.vertices[4 + 9 * 2], (0.4, 0.2, 0.3))
    turned = leeway.Shape.height_field(heights.T[::-1], (0.1, -0.1), -0.5)
    assert np.isclose(shape.bounding_radius, turned.bounding_radius)
    world = leeway.World()
    world.add_height_field("ground", heights, (0.1, 0.1), -0.5, position=(0.1, -0.2, -0.6))
    assert "ground" in world and "mesh" in world._repr_html_()
    for wrong, step, floor, words in [
        (np.zeros(3), 0.1, -1, "shape (rows, columns)"), (np.zeros((1, 3)), 0.1, -1, "at least 2 of each"),
        (heights, 0, -1, "apart in x"), (heights, (1, 2, 3), -1, "step holds 3"), (heights, 0.1, 0, "above the floor"),
        (np.full((3, 3), np.nan), 0.1, -1, "heights")]:
        with pytest.raises(ValueError) as error:
            world.add_height_field("other", wrong, step, floor)
        assert words in str(error.value) and "\n" not in str(error.value)
    assert len(world) == 1


def test_octrees(tmp_path):
    world = leeway.World()
    head = b"# Octomap OcTree binary file\nid OcTree\nsize 2\nres 0.1\ndata\n"
    file = tmp_path / "map.bt"
    file.write_bytes(head + b"\x02\x00")  # the first child of the root is occupied
    world.add_octree("map", file, "free")
    world.add_octree("all", str(file), unseen="occupied", position=(0, 0, 1))
    assert "map" in world and len(world) == 2
    with pytest.raises(ValueError, match="unseen"):
        world.add_octree("other", file, "maybe")
    file.write_bytes(head + b"\x02")
    with pytest.raises(leeway.InputError, match="ends within its nodes"):
        world.add_octree("other", file, "free")
    assert len(world) == 2
