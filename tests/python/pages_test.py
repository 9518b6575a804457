"""The tutorials print what they say they print; README's Python plans; the wheel holds the package."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

import pytest

import pages


@pytest.mark.parametrize("page", ["docs/python.md", "docs/first_plan.ipynb"])
def test_examples_print_what_the_page_says(page):
    text = pathlib.Path(page).read_text()
    assert pages.run(page) == text


def test_runners_notice_another_output():
    assert pages.run_page("```pycon\n>>> 1 + 1\n3\n```\n") == "```pycon\n>>> 1 + 1\n2\n```\n"


def test_readme_plans_as_its_cpp_program():
    blocks = re.findall(r"```python\n(.*?)```", pathlib.Path("README.md").read_text(), re.DOTALL)
    assert len(blocks) == 1 and len(blocks[0].splitlines()) <= 10
    names = {}
    exec(blocks[0], names)
    twin = subprocess.run([os.environ["LEEWAY_PYTHON_TWIN"]], capture_output=True, text=True, check=True).stdout.split()
    result = names["result"]
    assert [*result.path.ravel(), *result.certificate.edges.ravel(), result.length] == [float(number) for number in twin]


def test_the_wheel_has_the_package_and_works_alone(tmp_path):
    if shutil.which("cmake") is None or subprocess.run([sys.executable, "-c", "import build, wheel, setuptools"], check=False,
                                                       capture_output=True).returncode:
        pytest.skip("python3-build, python3-setuptools or python3-wheel is missing")
    environment = {**os.environ, "LEEWAY_BUILD": os.environ["LEEWAY_BUILD"]}
    subprocess.run([sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", tmp_path, "python"], check=True,
                   capture_output=True, env=environment)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
        names = archive.namelist()
    assert any(re.fullmatch(r"leeway/_leeway.*\.so", name) for name in names)
    assert {"leeway/__init__.py", "leeway/__init__.pyi", "leeway/py.typed"} <= set(names)
    script = "import leeway; print(leeway.__file__, leeway.distance(*[leeway.Shape.sphere(1), None] * 2).upper < 0)"
    printed = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True,
                             env={**os.environ, "PYTHONPATH": str(tmp_path / "site")}).stdout
    assert printed.split() == [str(tmp_path / "site/leeway/__init__.py"), "True"]


def test_a_package_without_its_parts_says_so(tmp_path):
    shutil.copytree("python/leeway", tmp_path / "leeway", ignore=shutil.ignore_patterns("*.so", "__pycache__"))
    for hidden, words in [("leeway._leeway", "compiled part is missing"), ("numpy", "needs numpy")]:
        script = f"import sys; sys.modules[{hidden!r}] = None; import leeway"
        told = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(tmp_path)})
        assert told.returncode == 1 and words in told.stderr.splitlines()[-1], told.stderr
