"""The stub names what the module has, with the same arguments, and nothing else."""

import ast
import pathlib
import re

import gelight

STUB = pathlib.Path(gelight.__file__).with_name("__init__.pyi")
DUNDER = {"__init__", "__call__", "__len__", "__getitem__"}


# What the module has only where it was built with Embree.
WITH_EMBREE = {"InnerLayer", "beneath", "LightBalance", "TracedLight", "LightTracer"}
# And with stb's headers.
WITH_STB = {"read_png", "read_depth_png", "write_png", "read_presses"}


def is_public(name):
    return not name.startswith("_") or name in DUNDER


def arguments_of(text):
    """Names of arguments in pybind11's signature, `name(self: type, a: type = value) -> type`."""
    inside, depth, names = "", 0, []
    for letter in text[text.index("("):]:
        depth += letter in "([{<"
        depth -= letter in ")]}>"
        if depth == 0:
            break
        inside += letter if depth == 1 and letter not in "(" else " "
    for part in inside.split(","):
        name = re.split("[:=]", part.strip())[0].strip()
        if name and name != "self" and not name.startswith("*"):
            names.append(name)
    return names


def signature(function):
    first = (function.__doc__ or "").splitlines()[0]
    return arguments_of(first.replace("->", ""))


def module_members(owner):
    found = {}
    for name, value in vars(owner).items():
        if not is_public(name) or isinstance(value, type(ast)):
            continue
        if isinstance(value, type):
            found[name] = module_members(value)
        elif isinstance(value, staticmethod):
            found[name] = signature(value.__func__)
        elif type(value).__name__ in ("instancemethod", "builtin_function_or_method"):
            found[name] = signature(value)
        elif callable(value):
            continue  # object's own
        else:
            found[name] = None  # a property or a value of an enumeration
    return found


def stub_members(body):
    found = {}
    for node in body:
        if isinstance(node, ast.ClassDef):
            found[node.name] = stub_members(node.body)
        elif isinstance(node, ast.FunctionDef):
            kinds = [d.id if isinstance(d, ast.Name) else d.attr for d in node.decorator_list]
            names = [a.arg for a in node.args.posonlyargs + node.args.args + node.args.kwonlyargs]
            is_value = "property" in kinds or "setter" in kinds
            if is_public(node.name):
                found[node.name] = None if is_value else [n for n in names if n != "self"]
        elif isinstance(node, ast.AnnAssign) and is_public(node.target.id):
            found[node.target.id] = None
    return found


def plain(members):
    """Without what every class has."""
    return {k: v for k, v in members.items() if k != "__init__" or v is not None}


def test_stub_and_module_name_the_same():
    module = module_members(gelight)
    stub = stub_members(ast.parse(STUB.read_text()).body)
    module.pop("annotations", None)
    if "LightTracer" not in module:
        stub = {name: members for name, members in stub.items() if name not in WITH_EMBREE}
    if "read_png" not in module:
        stub = {name: members for name, members in stub.items() if name not in WITH_STB}
    assert set(module) == set(stub)
    for name, members in stub.items():
        if not isinstance(members, dict):
            assert module[name] == members, name
            continue
        theirs = plain(module[name])
        if "__members__" in vars(getattr(gelight, name)):
            assert set(getattr(gelight, name).__members__) == set(members), name
            continue
        if issubclass(getattr(gelight, name), Exception):
            continue
        assert set(theirs) == set(members), name
        for member, arguments in members.items():
            assert theirs[member] == arguments, f"{name}.{member}"


def test_everything_is_documented():
    for name, value in vars(gelight).items():
        if name.startswith("_") or type(value) is type(ast):
            continue
        assert value.__doc__ and len(value.__doc__) > 20, name
        for member, inner in vars(value).items() if isinstance(value, type) else ():
            if member.startswith("_") or "__members__" in vars(value):
                continue
            if issubclass(value, Exception):
                continue
            assert inner.__doc__ and len(inner.__doc__) > 1, f"{name}.{member}"


def test_typed():
    assert STUB.with_name("py.typed").exists()
