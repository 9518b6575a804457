"""Rotations, and the kinematics of one link as its URDF has them; shares no code with Leeway."""

import xml.etree.ElementTree

import numpy as np


def rotations(axis, angles):
    """Turns about a unit axis: (n, 3, 3)."""
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angles)[:, None, None] * K + (1 - np.cos(angles))[:, None, None] * (K @ K)


def turn_of(R):
    """Axis times angle of rotations (n, 3, 3), for angles below a half turn."""
    v = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1) / 2
    sine = np.linalg.norm(v, axis=1)
    angle = np.arctan2(sine, (np.trace(R, axis1=1, axis2=2) - 1) / 2)
    return v * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 1)[:, None]


def quaternion(R):
    """x, y, z, w of a rotation: the eigenvector of Bar-Itzhack's matrix."""
    k = np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0],
                  [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                  [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], 0],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)]])
    return np.linalg.eigh(k)[1][:, -1]  # of the lower triangle


def pose(position, rpy):
    """4 x 4, from a position and roll, pitch, yaw."""
    X = np.eye(4)
    for axis, angle in zip(np.eye(3), rpy):
        X[:3, :3] = rotations(axis, np.array([angle]))[0] @ X[:3, :3]
    X[:3, 3] = position
    return X


class Chain:
    """Revolute and fixed joints from a URDF's root to a link; `names` are the joints of the values."""

    def __init__(self, file, link, names):
        self.count = len(names)
        above = {joint.find("child").get("link"): joint for joint in xml.etree.ElementTree.parse(file).getroot().findall("joint")}
        self.joints = []
        while link in above:
            joint = above[link]
            kind, moves = joint.get("type"), joint.get("type") in ("revolute", "continuous")
            assert moves or kind == "fixed", f"joint '{joint.get('name')}' is {kind}; revolute, continuous or fixed is expected"
            axis = numbers(joint.find("axis"), "xyz", "1 0 0")
            X = pose(numbers(joint.find("origin"), "xyz", "0 0 0"), numbers(joint.find("origin"), "rpy", "0 0 0"))
            self.joints.insert(0, (X, names.index(joint.get("name")) if moves else None, axis / np.linalg.norm(axis)))
            link = joint.find("parent").get("link")

    def poses(self, values, jacobian=False):
        """Of the link in the world for values (n, joints): (n, 4, 4); and the Jacobian (n, 6, joints)."""
        X_WL = np.tile(np.eye(4), (len(values), 1, 1))
        moving = []
        for X, column, axis in self.joints:
            X_WL = X_WL @ X
            if column is not None:
                moving.append((column, X_WL[:, :3, :3] @ axis, X_WL[:, :3, 3]))
                X_WL[:, :3, :3] = X_WL[:, :3, :3] @ rotations(axis, values[:, column])
        if not jacobian:
            return X_WL
        J = np.zeros((len(values), 6, self.count))
        for column, axis, at in moving:
            J[:, :3, column], J[:, 3:, column] = np.cross(axis, X_WL[:, :3, 3] - at), axis
        return X_WL, J


def numbers(element, name, otherwise):
    return np.array([float(word) for word in (otherwise if element is None else element.get(name, otherwise)).split()])
