"""Motions of vertices from numpy, each against its formula."""

import numpy as np
import pytest

import leeway
from leeway import Motion

X, Y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 2, 4))
REST = np.column_stack([X.ravel(), Y.ravel(), 0.5 + 0 * X.ravel()])


def turn(axis, angle):
    return np.array([*(np.sin(angle / 2) * np.eye(3)[axis]), np.cos(angle / 2)])


def test_waves_add_up_and_a_pinned_edge_stands():
    directions, amplitudes = np.array([(1, 0, 0), (0, 1, 0)]), np.array([(0, 0, 0.1), (0, 0, 0.05)])
    motion = Motion.waves(REST, directions, amplitudes, [0.5, 2], [1, -0.5], [0.1, 0.2], pinned=((0, 0, 0), (1, 0, 0), 0.5))
    for t in (0, 0.3, 2):
        phase = 2 * np.pi * (REST @ directions.T / [0.5, 2] - np.multiply([1, -0.5], t)) + [0.1, 0.2]
        expected = REST + np.clip(REST[:, :1] / 0.5, 0, 1) * (np.sin(phase) @ amplitudes)
        assert np.allclose(motion.at(t), expected, atol=1e-12)
    one = Motion.wave(REST, (1, 0, 0), (0, 0, 0.1), 0.5, 1, 0.1)
    assert np.array_equal(one.at(0.7), Motion.waves(REST, directions[:1], amplitudes[:1], [0.5], [1], [0.1]).at(0.7))


def test_a_lattice_is_a_bezier_volume():
    lower, upper = np.zeros(3), np.array([1, 2, 1])
    grid = np.stack(np.meshgrid([0, 0.5, 1], [0, 2], [0, 1], indexing="ij"), -1)
    moved = grid.copy()
    moved[1, :, :, 2] += 0.4
    motion = Motion.lattice(REST, lower, upper, [0, 2], [grid, moved])
    assert np.allclose(motion.at(0), REST, atol=1e-12)
    u = REST[:, 0]
    assert np.allclose(motion.at(1), REST + np.outer(2 * u * (1 - u), (0, 0, 0.2)), atol=1e-12)
    with pytest.raises(ValueError, match="axis 1"):
        Motion.lattice(REST, lower, upper, [0], [grid[:, :1]])


def test_skin_follows_its_bones():
    rest_poses = [[0, 0, 0, 0, 0, 0, 1], [0.5, 0, 0, 0, 0, 0, 1]]
    weights = np.column_stack([REST[:, 0] < 0.5, REST[:, 0] >= 0.5]).astype(float)
    bent = [[0, 0, 0, 0, 0, 0, 1], [0.5, 0, 0, *turn(1, -np.pi / 2)]]
    motion = Motion.skinned(REST, [-1, 0], rest_poses, weights, [0, 1], [rest_poses, bent])
    assert np.allclose(motion.at(0), REST, atol=1e-12)
    expected = np.where(weights[:, 1:] > 0, np.column_stack([0.5 - REST[:, 2], REST[:, 1], REST[:, 0] - 0.5]), REST)
    assert np.allclose(motion.at(1), expected, atol=1e-12)
    with pytest.raises(ValueError, match="parents"):
        Motion.skinned(REST, [1, 0], rest_poses, weights, [0], [bent])


def test_modes_swing_or_follow_keys():
    modes = np.stack([0.1 * np.roll(REST, 1, axis=1), np.broadcast_to((0, 0, 1.0), REST.shape)])
    swing = Motion.reduced(REST, modes, frequencies=[1, 2], amplitudes=[0.5, 0.1], phases=[0, 1])
    c = 0.5 * np.sin(2 * np.pi * 0.3), 0.1 * np.sin(2 * np.pi * 2 * 0.3 + 1)
    assert np.allclose(swing.at(0.3), REST + np.tensordot(c, modes, 1), atol=1e-12)
    keyed = Motion.reduced(REST, modes, times=[0, 1], coordinates=[[0, 0], [1, 0.2]], smooth=True)
    s = 0.25**2 * (3 - 0.5)
    assert np.allclose(keyed.at(0.25), REST + np.tensordot((s, 0.2 * s), modes, 1), atol=1e-12)
    with pytest.raises(ValueError, match="frequencies"):
        Motion.reduced(REST, modes)


def test_a_mesh_from_numpy_deforms_by_any_motion(robot):
    corner = np.array([i * 5 + j for i in range(3) for j in range(4)])
    triangles = np.concatenate([np.column_stack([corner, corner + 1, corner + 6]), np.column_stack([corner, corner + 6, corner + 5])])
    sway = Motion.reduced(REST, [np.broadcast_to((0, 0, 1.0), REST.shape)], frequencies=[0.5], amplitudes=[0.05])
    body = leeway.Deformable(REST, triangles, motion=sway)
    body.follow(0.5)
    assert np.allclose(body.vertices, sway.at(0.5), atol=1e-12)
    world = leeway.World()
    world.add_deforming("sheet", REST, triangles, motion=sway, position=(0.2, -1, -0.7))
    executed = leeway.replan(robot, world, "ready", "tucked", margin=0.01, steps=4)
    assert executed.certified
