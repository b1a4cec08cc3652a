"""Blocks: what is refused, and a structure that tells the truth."""

import zipfile
from xml.etree import ElementTree

import control
import numpy as np
import pytest
from every_block import BLOCKS, makers
from fmus import VERSIONS, Host, fmu_of, needs_compiler
from tiers import some

from jounce.fmu import export_fmu
from jounce.fmu.exporting.blocks import Block
from jounce.fmu.exporting.dispatch import block_of
from jounce.fmu.exporting.ssp import export_ssp_of
from jounce.plant import Inertia
from jounce.shaping import JerkFilter, Limits


@pytest.mark.parametrize(
    "name", ["", "1st", "a b", "a-b", "é", "../x", "x" * 62, "NUL", "com1", "int"]
)
def test_a_name_that_is_no_identifier_is_refused(name):
    with pytest.raises(ValueError, match="name = "):
        block_of(Inertia(1.0), name=name)


@pytest.mark.parametrize("number", [5, b"axis"], ids=["number", "bytes"])
def test_a_name_that_is_no_text_is_refused(number):
    with pytest.raises(TypeError, match=r"name = .*: expected text, a C identifier"):
        block_of(Inertia(1.0), name=number)


WITHOUT_PLACE = ["\ufffe", "\uffff", "\ud800", "\x00", "\n"]


@pytest.mark.parametrize(
    "label",
    [*(f"a{character}" for character in WITHOUT_PLACE), "\u2028", "  "],
    ids=["U+FFFE", "U+FFFF", "surrogate", "zero", "line", "U+2028 alone", "blanks"],
)
def test_a_signal_that_xml_cannot_name_is_refused(label):
    system = control.ss([[-1.0]], [[1.0]], [[1.0]], [[0.0]], inputs=[label], outputs=["y"])
    with pytest.raises(ValueError, match="expected a name of letters") as refused:
        block_of(system)
    assert repr(label) in str(refused.value)
    assert "not of blanks alone" in str(refused.value)
    with pytest.raises(ValueError, match=r"system .*expected a name of letters"):
        export_ssp_of("a.ssp", {"axis": system}, [], dt=1.0, duration=1.0, name=label)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(
    "label", ["torque \u2028 (1)", "\x7f\x85", 'µ <&">', "\U0001f600"], ids=ascii
)
def test_other_signs_in_names_arrive(label, version, tmp_path):
    system = control.ss([[-1.0]], [[1.0]], [[1.0]], [[0.0]], inputs=[label], outputs=["y"])
    made = export_fmu(system, tmp_path / "a.fmu", fmi_version=version, platforms=[])
    with zipfile.ZipFile(made.path) as file:
        root = ElementTree.fromstring(file.read("modelDescription.xml"))
    assert label in {element.get("name") for element in root.iter()}


def test_other_objects_and_units_are_refused():
    with pytest.raises(TypeError, match="got Limits: expected one of Trajectory, CommandFollower"):
        block_of(Limits(velocity=1.0))
    with pytest.raises(ValueError, match="unit = 'furlong': expected a unit of position"):
        block_of(Inertia(1.0), unit="furlong")
    with pytest.raises(TypeError, match="expected the unit of position"):
        block_of(Inertia(1.0), unit={"y": "rad"})
    system = Inertia(1.0).system()
    with pytest.raises(TypeError, match="expected a mapping from the names"):
        block_of(system, unit="rad")
    with pytest.raises(ValueError, match="unit of z: expected names of u, y, y_rate"):
        block_of(system, unit={"z": "rad"})
    units = {v.name: v.unit for v in block_of(system, unit={"u": "N.m", "y": "rad"}).variables}
    assert units["u"] == "N.m"
    assert units["der(state.y)"] == "rad/s"


@pytest.mark.parametrize("tiny", [Inertia(1e-310), JerkFilter(5e-324, 2)], ids=["J", "corner_hz"])
def test_numbers_below_what_the_binary_accepts_are_refused(tiny):
    with pytest.raises(ValueError, match=r"an FMU accepts .* choose other units"):
        block_of(tiny)


def test_names_follow_the_kind_or_the_system():
    assert block_of(JerkFilter(1.0, 2)).name == "jerk_filter"
    system = Inertia(1.0).system()
    assert block_of(system).name == "plant"
    system.name = "sys[12]"
    assert block_of(system).name == "linear_system"
    system.name = "2nd stage"
    assert block_of(system).name == "nd_stage"
    assert block_of(system, name="mine").name == "mine"


@pytest.mark.parametrize("name", BLOCKS)
def test_every_variable_is_described(name):
    block = block_of(BLOCKS[name]())
    assert isinstance(block, Block)
    assert all(variable.description and variable.unit for variable in block.variables)
    known = {*block.reference, "time"}
    for variable in block.variables:
        assert {*variable.dependencies, *variable.initial_dependencies} <= known


@needs_compiler
@pytest.mark.parametrize("version", some(VERSIONS[::-1], 1))
@pytest.mark.parametrize("make", makers(), ids=lambda make: make.__name__)
def test_what_depends_on_what_at_the_start(make, version):
    """Change each start value: what changes with it depends on it, by the description."""
    block = block_of(make())
    unknowns = [variable.name for variable in block.initial_unknowns]
    if not unknowns:
        pytest.skip("nothing is calculated at the start")
    host = Host(fmu_of(make, version), start=0.5 * (block.start_time + block.stop_time))
    found = {unknown: set() for unknown in unknowns}
    rng = np.random.default_rng(0)
    settable = [v for v in block.variables if v.has_start and v.variability != "constant"]
    settable = [v for v in settable if abs(v.start) < 1e300]  # the others stand for no limit
    random = {v.name: v.start * 1.3 or rng.random() for v in settable}
    host.set(**random)
    before = np.array(host.get(*unknowns))
    for name, value in random.items():
        host.set(**{name: 1.25 * value})
        for unknown, changed in zip(unknowns, host.get(*unknowns) != before, strict=True):
            found[unknown] |= {name} if changed else set()
        host.set(**{name: value})
    host.close()
    for unknown in unknowns:
        told = set(block.variables[block.reference[unknown] - 1].initial_dependencies)
        assert found[unknown] <= told, f"{unknown} changes with {found[unknown] - told}"


@needs_compiler
@pytest.mark.parametrize("make", makers(), ids=lambda make: make.__name__)
def test_partial_derivatives_are_nonzero_where_a_dependency_is_told(make):
    block = block_of(make())
    host = Host(fmu_of(make, "3.0")).run()
    knowns = [v.name for v in block.variables if v.causality == "input" or v.state]
    unknowns = [*block.outputs, *block.derivatives]
    partial = host.fmu.getDirectionalDerivative
    if not block.partials:
        message = host.refused(partial, [1], [1], [1.0])
        assert "provides no partial derivatives" in message
        host.close()
        return
    for unknown in unknowns:
        of = [block.reference[unknown.name]]
        found = {k for k in knowns if partial(of, [block.reference[k]], [1.0]) != [0.0]}
        assert found == set(unknown.dependencies), unknown.name
    host.close()
