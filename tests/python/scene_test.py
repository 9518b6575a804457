"""Shapes, kinematics, and states and edges in batches: each against one at a time."""

import numpy as np
import pytest

import leeway

RANDOM = np.random.default_rng(20260501)


def states(robot, *shape):
    return RANDOM.uniform(robot.lower, robot.upper, (*shape, 7))


def test_batches_agree_with_single_calls(robot, shelf):
    scene = leeway.Scene(shelf)
    points = states(robot, 4, 50)
    valid, clearances = scene.valid(points), scene.clearances(points)
    assert valid.shape == (4, 50) and valid.dtype == bool and clearances.shape == (4, 50, 2)
    assert 10 < valid.sum() < 190
    margin = shelf.margin
    for i in np.ndindex(4, 50):
        one = scene.check(points[i])
        assert scene.valid(points[i]) is bool(valid[i]) is one.valid
        lower, upper = clearances[i]
        assert lower <= one.upper and one.lower <= upper
        assert not valid[i] or upper > margin
        assert valid[i] or lower <= margin
    a, b = points[0], points[0] + RANDOM.uniform(-0.2, 0.2, (50, 7))
    edges, bounds = scene.valid_edges(a, b), scene.edge_clearances(a, b)
    assert edges.any() and not edges.all()
    for i in range(50):
        edge = scene.certify(a[i], b[i])
        inside = np.all((robot.lower <= b[i]) & (b[i] <= robot.upper))
        assert not edges[i] or (edge.verdict == "free" and edge.last_valid == 1)
        assert not edges[i] or (valid[0, i] and bounds[i, 1] > margin and inside)
        on_edge = robot.interpolate(a[i], b[i], np.linspace(0, 1, 20))
        assert not edges[i] or scene.valid(on_edge).all()
        assert bounds[i, 0] <= scene.clearances(on_edge)[:, 1].min()
        assert edge.last_valid == 0 or scene.clearances(robot.interpolate(a[i], b[i], 0.999 * edge.last_valid))[1] > margin


def test_states_outside_the_limits_are_not_valid(robot):
    scene = leeway.Scene(robot)
    q = robot.state("ready")
    assert scene.valid(q)
    q[0] = robot.upper[0] + 1e-9
    assert not scene.valid(q)
    check = scene.check(q)
    assert not check and "joint1" in check.limit and check.verdict == "free"


def test_poses(robot):
    points = states(robot, 2, 3)
    poses = robot.poses(points)
    assert poses.shape == (2, 3, len(robot.links), 4, 4)
    assert np.array_equal(robot.pose("hand", points), poses[:, :, robot.links.index("hand")])
    rotations = poses[..., :3, :3]
    assert np.allclose(rotations @ np.swapaxes(rotations, -1, -2), np.eye(3), atol=1e-12)


def test_distances_of_shapes():
    ball, box = leeway.Shape.sphere(0.1), leeway.Shape.box((0.2, 0.4, 0.6))
    d = leeway.distance(ball, (1, 0, 0), box, None)
    assert d.lower <= 0.8 <= d.upper and d.upper - d.lower < 1e-8
    assert np.allclose(d.point_a, (0.9, 0, 0)) and np.allclose(d.point_b, (0.1, 0, 0)) and np.allclose(d.normal, (-1, 0, 0))
    turn = np.sqrt(0.5)
    turned = leeway.distance(ball, (1, 0, 0), box, (0, 0, 0, 0, 0, turn, turn))
    matrix = np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    assert turned.lower <= 0.7 <= turned.upper
    assert abs(leeway.distance(ball, (1, 0, 0), box, matrix).lower - turned.lower) < 1e-8
    assert leeway.distance(ball, None, box, None).upper < 0
    assert leeway.distance(ball, (1, 0, 0), box, None, threshold=0.5).lower > 0.5
    many = leeway.distances(ball, np.array([(x, 0, 0) for x in (1, 2)]), box, np.zeros((2, 3)))
    assert np.allclose(many, [(0.8, 0.8), (1.8, 1.8)], atol=1e-8)
    out = leeway.separation(box, None, ball, (0.15, 0, 0), clearance=0.01)
    assert out.status == "separated" and out.clearance > 0.01
    moved = np.array((0.15, 0, 0)) + out.translation
    assert leeway.distance(ball, moved, box, None).lower > 0.01


@pytest.mark.parametrize("shape", [leeway.Shape.sphere(1), leeway.Shape.capsule(1, 2), leeway.Shape.cylinder(1, 2),
                                   leeway.Shape.cone(1, 2), leeway.Shape.ellipsoid((1, 1, 1)), leeway.Shape.half_space(),
                                   leeway.Shape.convex_hull(np.vstack([np.eye(3), -np.eye(3)]))])
def test_shapes_reach_as_far_as_they_say(shape):
    """A point above each: at z = 3 on the axis."""
    top = {"sphere": 1, "capsule": 2, "cylinder": 1, "cone": 1, "ellipsoid": 1, "half-space": 0, "hull": 1}[shape.type]
    d = leeway.distance(leeway.Shape.sphere(0), (0, 0, 3), shape, None)
    assert d.lower <= 3 - top <= d.upper and d.upper - d.lower < 1e-6
    assert shape.type in repr(shape)


def test_meshes_from_numpy_and_from_files():
    tote = leeway.Shape.mesh("problems/mesh/meshes/tote.obj")
    again = leeway.Shape.mesh(vertices=tote.vertices, triangles=tote.triangles)
    assert np.array_equal(again.vertices, tote.vertices)
    assert not tote.vertices.flags.writeable and tote.vertices.base is not None
    double = leeway.Shape.mesh(vertices=tote.vertices, triangles=tote.triangles, scale=2)
    assert double.bounding_radius == pytest.approx(2 * tote.bounding_radius)
    vertices = leeway.Shape.mesh("problems/mesh/meshes/arch.stl").vertices  # outlives its shape
    assert np.isfinite(vertices).all()


def test_what_a_mesh_file_leaves_out_is_told(tmp_path):
    file = tmp_path / "m.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n")
    with pytest.warns(UserWarning, match="m.obj:5: left out, as they have no area: 1 line"):
        leeway.Shape.mesh(file)
    file.write_text("v 0 0 0\nv 1 0\n")
    with pytest.raises(leeway.InputError, match="^mesh .*m.obj:2: ends where a coordinate is expected"):
        leeway.Shape.mesh(file)


def test_motions_of_programs_keep_doubles():
    far = np.array([[4000000.04, 0.1, 0], [4000000.04, 1.1, 0], [4000000.04, 0.1, 1 / 3]])
    motion = leeway.Motion.cache([0, 1.3], np.stack([far, far + 0.1]))
    np.testing.assert_array_equal(motion.at(0), far)
    np.testing.assert_array_equal(motion.at(1.3), far + 0.1)


def test_deforming_meshes():
    x, y = np.meshgrid(np.linspace(0, 1, 11), np.linspace(0, 1, 11))
    rest = np.column_stack([x.ravel(), y.ravel(), np.zeros(121)])
    corner = np.array([i * 11 + j for i in range(10) for j in range(10)])
    triangles = np.concatenate([np.column_stack([corner, corner + 1, corner + 12]), np.column_stack([corner, corner + 12, corner + 11])])
    ball = leeway.Shape.sphere(0.1)
    for strategy in ("auto", "refit", "hybrid", "rebuild", "lazy"):
        cloth = leeway.Deformable(rest, triangles, strategy=strategy)
        before = cloth.shape, cloth.vertices
        cloth.update(rest + (0, 0, 0.25), time=1.0)
        assert cloth.time == 1.0 and np.array_equal(cloth.vertices, rest + (0, 0, 0.25))
        assert np.array_equal(before[1], rest)  # snapshots are constant
        d = leeway.distance(ball, (0.5, 0.5, 1), cloth.shape, None)
        assert d.lower <= 0.65 <= d.upper and d.upper - d.lower < 1e-6
        assert leeway.distance(ball, (0.5, 0.5, 1), before[0], None).lower == pytest.approx(0.9)
        bad = rest.copy()
        bad[7, 1] = np.nan
        with pytest.raises(ValueError, match="vertex 7"):
            cloth.update(bad, time=2.0)
        assert cloth.time == 1.0
    motion = leeway.Motion.cache([0, 1], np.stack([rest, rest + (0, 0, 1)]))
    moving = leeway.Deformable(rest, triangles, motion=motion)
    moving.follow(0.5)
    assert np.allclose(moving.vertices, rest + (0, 0, 0.5)) and np.allclose(motion.at(0.5), moving.vertices)
    morph = leeway.Motion.morph(np.stack([rest, rest + (0, 0, 1)]), [0, 2], [[1, 0], [0, 1]])
    assert np.allclose(morph.at(1.0), rest + (0, 0, 0.5))
    wave = leeway.Motion.wave(rest, (1, 0, 0), (0, 0, 0.1), wavelength=1, frequency=1)
    assert np.allclose(wave.at(0.0)[:, 2], 0.1 * np.sin(2 * np.pi * rest[:, 0]))
    assert moving.self_distance().lower > 0


def test_worlds(robot):
    world = leeway.World()
    world.add_half_space("floor")
    world.add_box("box", (1, 2, 3), position=(0, 0, 5), rpy=(0, 0, np.pi / 2))
    world.add_mesh("tote", "problems/mesh/meshes/tote.obj", position=(3, 0, 0))
    for name, args in {"sphere": (0.1,), "capsule": (0.1, 1), "cone": (0.1, 1), "ellipsoid": ((1, 2, 3),),
                       "convex_hull": (np.eye(3),), "cylinder": (0.1, 1)}.items():
        getattr(world, "add_" + name)(name, *args, position=(0, 9, 9))
    assert len(world) == 9 and "box" in world and list(world) == world.names
    assert np.allclose(world.pose("box")[:3, :3], [[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    other = world.copy()
    other.remove("box")
    world.move("box", (1, 1, 1), orientation=(0, 0, 0, 1))
    assert np.allclose(world.pose("box"), [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1], [0, 0, 0, 1]])
    assert "box" not in other and "box" in world
    with pytest.raises(KeyError):
        world.remove("nothing")
    with pytest.raises(ValueError, match="box"):
        world.add_sphere("box", 1)


def test_objects_show_themselves(robot, world, shelf):
    result = leeway.plan(shelf)
    for thing in (robot, world, shelf, result):
        assert "leeway." in repr(thing) and "\n" not in repr(thing)
        assert thing._repr_html_().startswith("<table>")
    world.add_sphere("<b>", 1)
    assert "&lt;b&gt;" in world._repr_html_()
    for thing in (leeway.Scene(shelf), result.certificate, result.trajectory(), leeway.check(shelf), leeway.verify(shelf, result)):
        assert "leeway." in repr(thing)


def test_inverse_kinematics(robot):
    target = robot.pose("hand", robot.state("tucked"))
    found = leeway.inverse_kinematics(robot, "hand", target, start=robot.state("ready"), solutions=4)
    assert found and found.status == "found" and 1 <= len(found.solutions) <= 4
    assert np.allclose(robot.pose("hand", found.solutions), target, atol=1e-8)
    assert np.array_equal(found.nearest, found.solutions[0])
    assert np.all((robot.lower <= found.solutions) & (found.solutions <= robot.upper))
    again = leeway.inverse_kinematics(robot, "hand", target, start=robot.state("ready"), solutions=4)
    assert again.solutions.tobytes() == found.solutions.tobytes()
    turned = leeway.inverse_kinematics(robot, "hand", target[:3, 3], start=robot.state("ready"), solutions=4)  # with any turn
    assert turned and np.allclose(robot.pose("hand", turned.solutions)[:, :3, 3], target[:3, 3], atol=1e-8)
    assert not np.allclose(robot.pose("hand", turned.solutions)[:, :3, :3], target[:3, :3], atol=1e-3)
    with pytest.raises(ValueError, match="pose is None"):
        leeway.inverse_kinematics(robot, "hand", None)
    far = leeway.inverse_kinematics(robot, "hand", (5, 0, 0))
    assert not far and far.status == "unreachable" and far.solutions.shape == (0, 7) and far.nearest.shape == (7,)


def test_a_scene_with_an_object_elsewhere_is_the_scene_compiled_so(robot, shelf):
    world = leeway.World()
    world.add_box("cart", (0.3, 0.3, 0.3), position=(0.6, 0, 0.3))
    world.add_sphere("ball", 0.1, position=(-0.5, 0.4, 0.5))
    scene = leeway.Scene(robot, world, margin=0.01)
    points = states(robot, 60)
    before = scene.clearances(points)
    moving = scene
    for i in range(50):
        place = np.eye(4)
        place[:3, 3] = 0.4 + 0.01 * i, -0.2, 0.4
        moving = moving.with_object_at("cart", place)
    moving = moving.with_object_at("ball", (-0.4, 0.4, 0.5))
    world.move("cart", (0.89, -0.2, 0.4))
    world.move("ball", (-0.4, 0.4, 0.5))
    compiled = leeway.Scene(robot, world, margin=0.01)
    assert np.allclose(moving.clearances(points), compiled.clearances(points), atol=2e-6)
    assert np.allclose(scene.clearances(points), before, atol=2e-6) and np.array_equal(scene.problem.world.pose("cart")[:3, 3], (0.6, 0, 0.3))
    assert np.array_equal(moving.problem.world.pose("cart"), compiled.problem.world.pose("cart"))
    for name, pose in (("nothing", None), ("hand", None), ("cart", (np.nan, 0, 0)), ("cart", (1, 2))):
        with pytest.raises(ValueError):
            scene.with_object_at(name, pose)
