"""What the tests of the Python module share. They run in the project's folder, where robots/ and problems/ are."""

import os
import pathlib
import subprocess
import sys

import pytest

import leeway

ROOT = pathlib.Path(__file__).parents[2]
os.chdir(ROOT)
os.environ["LEEWAY_CACHE_DIR"] = ""  # tests keep nothing


@pytest.fixture(scope="session")
def robot():
    return leeway.Robot("robots/arm7/arm7.urdf", "robots/arm7/arm7.srdf", group="arm")


@pytest.fixture
def world():
    made = leeway.World()
    made.add_cylinder("post", radius=0.05, length=1, position=(0.5, 0, 0.5))
    return made


@pytest.fixture(scope="session")
def shelf():
    return leeway.load("problems/shelf/reach.yaml")


@pytest.fixture
def run():
    """Runs a script in an interpreter of its own: what it prints. Fails unless it ends with `status`."""

    def run_script(script, status=0, timeout=60):
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=timeout, cwd=ROOT)
        assert done.returncode == status, f"status {done.returncode}\n{done.stdout}{done.stderr}"
        return done.stdout

    return run_script
