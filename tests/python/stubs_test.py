"""The stubs name what the module has, with the same parameters; everything public is documented."""

import ast
import inspect
import pathlib

import leeway

STUBS = pathlib.Path(leeway.__file__).parent / "__init__.pyi"


def stub_parameters(function):
    arguments = function.args
    positional = [*arguments.posonlyargs, *arguments.args]
    bare = len(positional) - len(arguments.defaults)
    parameters = [(p.arg, "positional", i >= bare) for i, p in enumerate(positional)]
    if arguments.vararg:
        parameters.append((arguments.vararg.arg, "*", False))
    parameters += [(p.arg, "keyword", d is not None) for p, d in zip(arguments.kwonlyargs, arguments.kw_defaults)]
    if arguments.kwarg:
        parameters.append((arguments.kwarg.arg, "**", False))
    static = any(isinstance(d, ast.Name) and d.id == "staticmethod" for d in function.decorator_list)
    return parameters, static


def module_parameters(function):
    kinds = {inspect.Parameter.KEYWORD_ONLY: "keyword", inspect.Parameter.VAR_KEYWORD: "**", inspect.Parameter.VAR_POSITIONAL: "*"}
    return [(p.name, kinds.get(p.kind, "positional"), p.default is not p.empty) for p in inspect.signature(function).parameters.values()]


def stub_names(body):
    """Functions by name, properties that are read, and those that are set."""
    functions, read, written = {}, set(), set()
    for node in body:
        if isinstance(node, ast.FunctionDef):
            decorators = [ast.unparse(d) for d in node.decorator_list]
            if "property" in decorators:
                read.add(node.name)
            elif f"{node.name}.setter" in decorators:
                written.add(node.name)
            else:
                functions[node.name] = node
        elif isinstance(node, ast.AnnAssign):
            read.add(node.target.id)
            written.add(node.target.id)
    return functions, read, written


def check_function(name, stub, function):
    expected, static = stub_parameters(stub)
    assert module_parameters(function) == expected, name
    assert function.__doc__ and function.__doc__.strip(), f"{name} has no docstring"


def test_stubs_and_module_agree():
    tree = ast.parse(STUBS.read_text())
    functions = {n.name: n for n in tree.body if isinstance(n, ast.FunctionDef)}
    classes = {n.name: n for n in tree.body if isinstance(n, ast.ClassDef)}
    public = {name: getattr(leeway, name) for name in leeway.__all__}
    assert set(functions) | set(classes) == set(public)
    for name, stub in functions.items():
        check_function(name, stub, public[name])
    for name, stub in classes.items():
        check_class(name, stub, public[name])


def check_class(name, stub, value):
    assert inspect.isclass(value) and value.__doc__ and value.__module__ == "leeway", name
    methods, read, written = stub_names(stub.body)
    if name == "InputError":
        assert read == {"file", "line"}
        return
    members = {k: v for k, v in vars(value).items() if not k.startswith("_")}
    properties = {k: v for k, v in members.items() if isinstance(v, property)}
    assert set(properties) == read, name
    assert {k for k, v in properties.items() if v.fset} == written, name
    assert set(members) - set(properties) == {k for k in methods if not k.startswith("_")}, name
    for key, property_ in properties.items():
        assert property_.__doc__, f"{name}.{key} has no docstring"
    for key, method in methods.items():
        if key == "__init__":
            expected, _ = stub_parameters(method)
            assert module_parameters(value) == expected[1:], name
        elif not key.startswith("_"):
            check_function(f"{name}.{key}", method, getattr(value, key))
        else:
            assert key in vars(value), f"{name}.{key}"
    made = not isinstance(value.__init__, type(object.__init__))  # else only the module makes them
    assert ("__init__" in methods) == made, name
