"""Pages and pictures from Python: what `leeway view` writes."""
import base64
import os
import re
import subprocess
import zlib

import numpy as np
import pytest

import leeway


@pytest.fixture(scope="module")
def short(shelf):
    return leeway.plan(shelf, iterations=3000, time=0)


@pytest.fixture
def page(tmp_path, short):
    """A file for a page; skips where the module was built without node."""
    file = tmp_path / "plan.html"
    try:
        short.view(file)
    except leeway.InputError as error:
        if "without node" in str(error):
            pytest.skip("the module was built without the page")
        raise
    return file


def test_a_page_from_another_working_folder(page, monkeypatch):
    problem = leeway.load("problems/shelf/reach.yaml", cache=False)
    monkeypatch.chdir(page.parent)
    leeway.plan(problem).view(page, visual=True)
    assert "leeway-data" in page.read_text()


def test_a_result_as_a_page_without_network(page):
    text = page.read_text()
    assert text.startswith("<!doctype html>") and "default-src 'none'" in text
    assert "leeway-data" in text and "@LEEWAY-DATA@" not in text


def test_a_picture_needs_no_node_and_is_that_of_the_command(short, tmp_path):
    short.view(tmp_path / "plan.svg")
    short.save(tmp_path / "path.json")
    command = os.environ.get("LEEWAY_COMMAND", "")
    if not os.path.exists(command):
        pytest.skip("the command is not built")
    subprocess.run([command, "view", "problems/shelf/reach.yaml", tmp_path / "path.json", "--svg", tmp_path / "command.svg"], check=True, capture_output=True)
    assert (tmp_path / "plan.svg").read_text() == (tmp_path / "command.svg").read_text()
    leeway.view(short.problem, short.path, tmp_path / "rows.svg")
    assert (tmp_path / "rows.svg").read_text() == (tmp_path / "plan.svg").read_text()


def test_visual_shapes_in_a_page(page, short, tmp_path):
    plain = page.stat().st_size
    with pytest.warns(UserWarning, match="has no visual shapes"):
        short.view(page, visual=True)
    assert page.stat().st_size >= plain
    with pytest.warns(UserWarning, match="has no visual shapes"):
        leeway.view(short.problem, short.path, page, visual=True)
    with pytest.raises(ValueError, match="in a page"):
        short.view(tmp_path / "dressed.svg", visual=True)
    assert not (tmp_path / "dressed.svg").exists()


def test_large_clouds_are_drawn_with_fewer_balls(page, shelf, tmp_path):
    """Regression: a cloud of a million balls made a page of 12 MB."""
    problem = leeway.Problem(shelf.robot, start=shelf.start, goal=shelf.start)
    x, z = np.meshgrid(np.arange(225) / 100, np.arange(225) / 100)
    problem.world.add_cloud("scan", np.column_stack([x.ravel(), np.full(x.size, 5), z.ravel()]), 0.01)
    leeway.plan(problem).view(page)
    data = re.search('octet-stream">([^<]*)', page.read_text())[1]
    note = re.search(rb"'scan' is drawn as (\d+) larger balls, which contain its 50625", zlib.decompress(base64.b64decode(data)))
    assert note and int(note[1]) <= 50000
    assert page.stat().st_size < 1.5e6


def test_two_paths_in_a_page(page, shelf, short, tmp_path):
    wide = leeway.plan(shelf, iterations=3000, time=0, seed=7)
    sizes = {}
    wide.save(tmp_path / "wide.json")
    for name, compare in {"result": wide, "rows": wide.path, "file": tmp_path / "wide.json"}.items():
        short.view(page, compare=compare)
        sizes[name] = page.stat().st_size
    short.view(page)
    assert min(sizes.values()) > page.stat().st_size
    leeway.view(shelf, short, page, compare=wide)
    assert page.stat().st_size > 0
    with pytest.raises(ValueError, match="compared in a page"):
        short.view(tmp_path / "both.svg", compare=wide)
    assert not (tmp_path / "both.svg").exists()


def test_failures_and_executions(robot, world, tmp_path):
    failed = leeway.plan(robot, world, "ready", "upright", margin=0.5)
    assert failed.status == "invalid_start"
    failed.view(tmp_path / "failed.svg")
    assert "start not valid" in (tmp_path / "failed.svg").read_text()
    problem = leeway.load("problems/deforming/curtain.yaml")
    executed = leeway.replan(problem, steps=3)
    executed.view(tmp_path / "executed.svg")
    assert "<svg" in (tmp_path / "executed.svg").read_text()


@pytest.mark.parametrize("file, message", [("plan.gif", "unknown ending '.gif'; .html, .svg can be written"), ("plan", "unknown ending"),
                                           ("nowhere/plan.svg", "there is no folder")])
def test_files_that_cannot_be_written(short, tmp_path, file, message):
    with pytest.raises(leeway.InputError, match=message):
        short.view(tmp_path / file)
    with pytest.raises(leeway.InputError, match=message):
        leeway.view(short.problem, short, tmp_path / file)
    assert list(tmp_path.iterdir()) == []


def test_wrong_paths_and_stops(robot, short, tmp_path):
    file = tmp_path / "plan.svg"
    with pytest.raises(ValueError):
        leeway.view(short.problem, np.zeros((2, 3)), file)
    with pytest.raises(TypeError):
        short.view(3)
    with pytest.raises(RuntimeError, match="stopped"):
        short.view(file, stop=lambda: True)

    def fails():
        raise KeyError("mine")

    with pytest.raises(KeyError):
        short.view(file, stop=fails)
    assert not file.exists()
