"""What is written from the table of settings is up to date, and each setting is a keyword and an attribute."""

import importlib.machinery
import importlib.util
import inspect
import pathlib

import numpy as np
import pytest

import leeway

SETTINGS = leeway.settings()
KEYWORDS = [setting["name"] for setting in SETTINGS if setting["given"]]


def script():
    """tools/scripts/write_settings as a module."""
    path = str(pathlib.Path("tools/scripts/write_settings").resolve())
    loader = importlib.machinery.SourceFileLoader("write_settings", path)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("write_settings", loader))
    loader.exec_module(module)
    return module


WRITER = script()


@pytest.mark.parametrize("file", WRITER.FILES)
def test_what_is_written_from_the_table_is_up_to_date(file):
    new, old = WRITER.written(file)
    assert new == old, f"{file}: PYTHONPATH=build/python tools/scripts/write_settings"


def test_a_setting_that_is_new_is_written_into_every_file(monkeypatch):
    extra = {**next(s for s in SETTINGS if s["name"] == "look_ahead"), "name": "brisk", "key": "execution.brisk", "option": "--brisk"}
    at = [s["name"] for s in SETTINGS].index("look_ahead")
    monkeypatch.setattr(leeway, "settings", lambda: SETTINGS[:at] + [extra] + SETTINGS[at:])
    for file, word in (("problems/schema.json", '"brisk": {"type": "number"'), ("python/leeway/__init__.pyi", "brisk: float = ..., "),
                       ("problems/README.md", "`--brisk`")):
        new, old = WRITER.written(file)
        assert word in new and word not in old
        assert len(new.splitlines()) <= len(old.splitlines()) + 10


def test_each_setting_is_an_attribute_with_a_docstring(shelf):
    for name in KEYWORDS:
        assert getattr(leeway.Problem, name).__doc__, name
        getattr(shelf, name)


def test_signatures_have_every_keyword():
    for call in (leeway.Problem, leeway.Scene, leeway.Replanner, leeway.Guard, leeway.plan, leeway.plan_many, leeway.check, leeway.replan):
        parameters = inspect.signature(call).parameters
        assert set(KEYWORDS) <= set(parameters), call
        assert not any(p.kind is p.VAR_KEYWORD for p in parameters.values()), call


def test_words_are_not_taken_for_true(shelf):
    names = [s["name"] for s in SETTINGS if s["kind"] == "boolean"]
    assert len(names) > 1
    problem = shelf.copy()
    for name in names:
        for wrong in ("false", 0, None):
            with pytest.raises(TypeError, match=f"{name} is .*; True or False is expected"):
                setattr(problem, name, wrong)
        for right in (np.bool_(False), True):
            setattr(problem, name, right)
            assert getattr(problem, name) is bool(right)


def test_a_seed_is_any_that_files_accept(shelf):
    problem = shelf.copy()
    problem.seed = 2**64 - 1
    assert leeway.Problem(shelf, seed=problem.seed).seed == 2**64 - 1
    for wrong in (2**64, -1, 1.5):
        with pytest.raises(ValueError, match="at least 0 and at most 18446744073709551615 is expected"):
            problem.seed = wrong


def test_numbers_out_of_range_are_refused(shelf):
    refused = 0
    for setting in SETTINGS:
        if setting["kind"] == "number" and setting["lower"] >= 0:
            refused += 1
            problem = shelf.copy()
            if setting["key"].startswith("objective.clearance"):
                problem.objective = "clearance"
            with pytest.raises(ValueError, match="is expected"):
                setattr(problem, setting["name"], -1)
    assert refused > 5
