"""The types of the binding: binding.pyi names what binding.c shows, and nothing else."""

import ast
from pathlib import Path

import pytest

from jounce import core
from jounce.core import Pieces, binding
from jounce.shaping import Limits, Transfer, min_time_transfer

STUB = ast.parse((Path(core.__file__).parent / "binding.pyi").read_text(encoding="utf-8"))


def named(nodes, kind):
    return {node.name: node for node in nodes if isinstance(node, kind)}


CLASSES = named(STUB.body, ast.ClassDef)
METHODS = {
    f"{own}.{name}": (getattr(getattr(binding, own), name), node)
    for own, body in CLASSES.items()
    for name, node in named(body.body, ast.FunctionDef).items()
    if not name.startswith("_") and not node.decorator_list
}
FUNCTIONS = {
    name: (getattr(binding, name, None), node)
    for name, node in named(STUB.body, ast.FunctionDef).items()
}


def parameters(node):
    """Return the names of a function's parameters; none may be given by name."""
    arguments = node.args
    assert [one.arg for one in arguments.args] in ([], ["self"])
    assert not arguments.kwonlyargs
    plain = [one.arg for one in arguments.posonlyargs if one.arg not in ("self", "cls")]
    return plain + [f"*{one.arg}" for one in [arguments.vararg] if one is not None]


def told(function):
    """Return the names that a function tells, those in brackets, which may be left out, too."""
    return [name.strip("[ ]") for name in function.__text_signature__[1:-1].split(",") if name]


def test_the_module_shows_what_its_types_name():
    constants = {node.target.id for node in STUB.body if isinstance(node, ast.AnnAssign)}
    shown = {name for name in dir(binding) if not name.startswith("__")}
    assert shown == constants | set(CLASSES) | set(FUNCTIONS)
    assert shown == set(core.__all__)
    assert all(type(getattr(binding, name)) is int for name in constants)


@pytest.mark.parametrize("name", CLASSES)
def test_a_type_shows_what_is_named_of_it(name):
    kind, stub = getattr(binding, name), named(CLASSES[name].body, ast.FunctionDef)
    assert {own for own in dir(kind) if not own.startswith("_")} == set(stub) - {"__new__"}
    if "__new__" in stub:
        assert parameters(stub["__new__"]) == told(kind)
    else:
        with pytest.raises(TypeError, match="cannot create"):
            kind()
    with pytest.raises(TypeError, match="not an acceptable base type"):
        type("Mine", (kind,), {})
    for own, node in stub.items():
        if node.decorator_list:
            assert not callable(getattr(kind, own))


@pytest.mark.parametrize("name", FUNCTIONS | METHODS)
def test_parameters_are_those_that_are_named(name):
    function, node = (FUNCTIONS | METHODS)[name]
    assert told(function) == parameters(node)
    assert function.__doc__.endswith(".")


def test_what_is_returned_has_the_type_that_is_named():
    limits = (-1.0, 1.0, -2.0, 2.0, -9.0, 9.0)
    motion = binding.transfer((0.0, 0.3, 0.1), (1.0,), limits)
    assert isinstance(motion, binding.Motion)
    assert binding.transfer((0.0,), (1.0, 5.0), limits) == binding.UNREACHABLE
    assert [type(getattr(motion, name)) for name in ("duration", "inside_after")] == [float] * 2
    assert [type(getattr(motion, name)) for name in ("count", "order")] == [int] * 2
    assert isinstance(motion.pieces(), Pieces)
    assert [array.ndim for array in motion.arrays()] == [1, 2, 1, 1]
    assert isinstance(binding.possible_durations((0.0,), (1.0,), limits)[0], tuple)
    transfer = min_time_transfer((0.0, 0.3, 0.1), (1.0,), Limits(1.0, 2.0, 9.0))
    [[together], [kept]] = binding.together((transfer,), Transfer)
    assert isinstance(together, Transfer)
    assert kept is transfer.limits
    follower = binding.Follower(limits, 0.01, float("inf"), 0.0, 0)
    state = follower.step((0.0, 0.0, 0.0, 0.0), 1.0, 0.0)
    assert [type(x) for x in state] == [float] * len(state)
    assert isinstance(follower.pieces((0.0, 0.0, 0.0, 0.0), 1.0, 0.0), list)
    assert binding.bounds(1.0, (-2.0, 3.0)) == ((-1.0, -2.0), (1.0, 3.0), (-1.0, 1.0, -2.0, 3.0))
    assert binding.bounds("1") is None
