"""Runs the examples of a page (lines that begin with >>>) and of a notebook, and writes their outputs into them.

    PYTHONPATH=build/python python3 tests/python/pages.py docs/python.md docs/first_plan.ipynb
"""

import ast
import contextlib
import io
import json
import pathlib
import sys


def run_example(source, names):
    """What an interpreter prints for one example."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(source, "<example>", "single"), names)
    return out.getvalue()


def run_page(text):
    """The page, with the outputs that its examples have now."""
    names, lines, result, i = {}, text.splitlines(), [], 0
    while i < len(lines):
        if not lines[i].startswith(">>> "):
            result.append(lines[i])
            i += 1
            continue
        source = [lines[i]]
        i += 1
        while i < len(lines) and lines[i].startswith("..."):
            source.append(lines[i])
            i += 1
        while i < len(lines) and not lines[i].startswith((">>> ", "```")):
            i += 1  # what it printed before
        result += source
        result += run_example("\n".join(line[4:] for line in source) + "\n", names).splitlines()
    return "\n".join(result) + "\n"


def run_notebook(text):
    """The notebook, with the outputs that its cells have now."""
    notebook, names = json.loads(text), {}
    for number, cell in enumerate((c for c in notebook["cells"] if c["cell_type"] == "code"), 1):
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(tree, "<cell>", "exec"), names)
            value = eval(compile(ast.Expression(last.value), "<cell>", "eval"), names) if last else None
        cell["execution_count"] = number
        cell["outputs"] = []
        if out.getvalue():
            cell["outputs"].append({"name": "stdout", "output_type": "stream", "text": out.getvalue().splitlines(keepends=True)})
        if value is not None:
            data = {"text/plain": [repr(value)]}
            if hasattr(value, "_repr_html_"):
                data["text/html"] = [value._repr_html_()]
            cell["outputs"].append({"data": data, "execution_count": number, "metadata": {}, "output_type": "execute_result"})
    return json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"


def run(file):
    text = pathlib.Path(file).read_text()
    if not str(file).endswith(".ipynb"):
        return run_page(text)
    with contextlib.chdir(pathlib.Path(file).parent):  # as Jupyter does
        return run_notebook(text)


if __name__ == "__main__":
    for page in sys.argv[1:]:
        pathlib.Path(page).write_text(run(page))
