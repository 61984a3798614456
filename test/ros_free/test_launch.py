"""The launch file, read without ``launch``, which no wheel brings: what it names is what there is."""

from __future__ import annotations

import ast
from pathlib import Path

from cloth_sim_ros import operator
from cloth_sim_ros.parameters import parameter_names

CHECKOUT = Path(__file__).parents[2]
FILE = ast.parse((CHECKOUT / "launch" / "cloth_sim.launch.py").read_text())


def calls(name: str) -> list[ast.Call]:
    return [node for node in ast.walk(FILE) if isinstance(node, ast.Call) and ast.unparse(node.func) == name]


def texts(node: ast.AST) -> list[str]:
    return [part.value for part in ast.walk(node) if isinstance(part, ast.Constant) and isinstance(part.value, str)]


def assigned(tree: ast.Module, name: str) -> ast.expr:
    """What a module assigns to a name."""
    return next(n.value for n in tree.body if isinstance(n, ast.Assign) and ast.unparse(n.targets[0]) == name)


def nodes() -> dict[str, dict[str, ast.expr]]:
    """The keywords of every node that is described, by its executable."""
    described = [{keyword.arg: keyword.value for keyword in call.keywords} for call in calls("Node")]
    return {ast.literal_eval(keywords["executable"]): keywords for keywords in described}


def test_the_executables_are_those_that_are_installed_and_rviz():
    installed = ast.literal_eval(assigned(ast.parse((CHECKOUT / "setup.py").read_text()), "COMMANDS"))
    packages = {executable: ast.literal_eval(keywords["package"]) for executable, keywords in nodes().items()}
    assert packages.pop("rviz2") == "rviz2"
    assert set(packages) == {"cloth_node", "cloth_operator"} <= set(installed)
    assert set(packages.values()) == {"cloth_sim_ros"}


def test_every_argument_is_declared_described_and_used():
    declared = ast.literal_eval(assigned(FILE, "ARGUMENTS"))
    asked = {text for call in calls("LaunchConfiguration") for text in texts(call)}
    in_loop = {text for node in ast.walk(FILE) if isinstance(node, ast.comprehension) for text in texts(node.iter)}
    assert asked | in_loop == set(declared)
    assert all(isinstance(default, str) and text for default, text in declared.values())


def test_what_it_sets_are_parameters_of_the_node():
    function = next(n for n in FILE.body if isinstance(n, ast.FunctionDef) and n.name == "cloth_node")
    loops = [node for node in ast.walk(function) if isinstance(node, ast.comprehension)]
    given = {text for loop in loops for text in texts(loop.iter)}
    keys = {ast.literal_eval(node.slice) for node in ast.walk(function) if isinstance(node, ast.Subscript)
            and isinstance(node.slice, ast.Constant)}  # fmt: skip
    assert given == {"scene", "record"} <= set(parameter_names())
    assert keys == {"use_sim_time"}


def test_the_options_of_the_operator_are_those_that_it_has():
    options = [text for text in texts(nodes()["cloth_operator"]["arguments"]) if text.startswith("--")]
    values = operator._parser().parse_args([word for option in options for word in (option, "x")])
    assert (values.scene, values.namespace) == ("x", "x")


def test_the_layout_of_rviz_is_where_it_says():
    share, *parts = calls("PathJoinSubstitution")[0].args[0].elts
    assert texts(share) == ["cloth_sim_ros"]  # the package's share folder, into which setup.py puts config/
    assert CHECKOUT.joinpath(*map(ast.literal_eval, parts)).is_file()
