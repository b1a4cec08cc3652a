"""An FMU as a fast stepping object."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import TracebackType
from typing import TYPE_CHECKING, Any, NoReturn, Self

import numpy as np
from numpy.typing import ArrayLike

from ...shaping.pieces import FloatArray
from ...shaping.told import table
from .description import FmuDescription, FmuError, FmuVariable
from .instance import Instance
from .library import Session
from .log import TERMINATED, WARNING, Log
from .ports import Port, shown
from .settings import check_tunable, check_type, recorded_signals, start_settings
from .snapshot import FmuState
from .standing import Standing
from .values import flat_values, one_value, own_shape, read, start_values, write
from .versions import binding_of

if TYPE_CHECKING:
    import control

    from .isolation import RemoteInstance

_DOUBLE = np.dtype(float)


@dataclass(frozen=True)
class Experiment:
    """What an FMU is told of the run, None for nothing, and its communication step."""

    dt: float
    start_time: float = 0.0
    stop_time: float | None = None
    tolerance: float | None = None


class Fmu:
    """An instance of an FMU, stepped from communication point to communication point.

    Made by `load_fmu`. Not to be used from two threads at once.

    Attributes
    ----------
    description : FmuDescription
    input_names, output_names : tuple of str
        What `step` takes and returns, in this order: the inputs and outputs that are numbers,
        arrays spread out as name[1], name[2], …; and behind the outputs `recorded_names`.
    recorded_names : tuple of str
        What `load_fmu` was asked to record and is no input or output.
    dt : float
        Communication step where `step` is given none.
    units : dict of str to str
        Unit of each of these, empty where the FMU names none.
    """

    def __init__(
        self,
        session: Session,
        instantiate: Callable[[Session, Log], Instance | RemoteInstance],
        description: FmuDescription,
        log: Log,
        experiment: Experiment,
        record: Sequence[str] = (),
    ) -> None:
        self.description = description
        self.dt = experiment.dt
        self._session = session
        self._instantiate = instantiate
        self._log = log
        self._dtypes = binding_of(description).DTYPES
        numeric = [v for v in description.variables if v.type in self._dtypes]
        inputs = [v for v in numeric if v.causality == "input"]
        entered = description.of_causality("input")
        self._other_inputs = [v for v in entered if v.type not in self._dtypes]
        taken = [signal for v in inputs for signal in v.signals]
        given = [signal for v in numeric if v.causality == "output" for signal in v.signals]
        known = {signal.label for signal in [*taken, *given]}
        beside = recorded_signals(description, record, self._dtypes, known)
        self._ports = taken, [*given, *beside]
        self._attach()
        self.input_names, self.output_names = self._inputs.labels, self._outputs.labels
        self.recorded_names = tuple(signal.label for signal in beside)
        self.units = {label: v.unit for label, v, _ in [*taken, *given, *beside]}
        starts = [value for variable in inputs for value in start_values(variable)]
        self._start_inputs = np.array(starts, self._inputs.values.dtype)
        self._given: Mapping[str, Any] = {}
        self._experiment = experiment
        finalizer = weakref.finalize(self, session.close)
        self._at = Standing(description, session, log, close=finalizer)

    def _attach(self) -> None:
        """Make a new instance, and keep at hand what every step needs."""
        self._instance = instance = self._instantiate(self._session, self._log)
        inputs, outputs = self._ports
        self._inputs = Port(inputs, self._dtypes, instance.input_setter, writes=True)
        self._outputs = Port(outputs, self._dtypes, instance.output_getter, writes=False)
        self._values, self._shape = self._inputs.values, self._inputs.shape
        self._found = self._outputs.values
        exact = self._found.dtype == object
        self._show = partial(shown, self._found) if exact else self._found.copy
        self._put, self._fetch = self._inputs.move, self._outputs.move
        self._do_step = self._instance.do_step
        self._states = self._session.states

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            f"{self.description.model_name}: an Fmu cannot be copied or pickled; load it again, "
            "with load_fmu, for another instance"
        )

    def _repr_html_(self) -> str:
        """Return the FMU as a table: time, and each input and output with its unit."""
        rows = [("FMI", self.description.fmi_version)]
        rows += [("input", self._labelled(name)) for name in self.input_names]
        rows += [("output", self._labelled(name)) for name in self.output_names]
        rows.append(("state", f"at time {self._at.time:g}" if self._at.is_open else "closed"))
        return table(self.description.model_name, rows)

    def _labelled(self, name: str) -> str:
        return f"{name} [{self.units[name]}]" if self.units[name] else name

    def __repr__(self) -> str:
        state = f"at time {self._at.time:g}" if self._at.is_open else "closed"
        return (
            f"<Fmu {self.description.model_name}: {', '.join(self.input_names) or 'no inputs'} → "
            f"{', '.join(self.output_names) or 'no outputs'}, {state}>"
        )

    @property
    def time(self) -> float:
        """Communication point at which the FMU stands."""
        return self._at.time

    @property
    def outputs(self) -> FloatArray:
        """Outputs at the present communication point, (number of outputs,)."""
        self._at.check_ready(reading=True)
        self._at.check(self._fetch(), "show its outputs")
        return shown(self._found)

    @property
    def inputs(self) -> FloatArray:
        """Inputs as they were last given, (number of inputs,)."""
        return shown(self._values)

    @property
    def parameters(self) -> dict[str, object]:
        """Present values of all the parameters, by name."""
        chosen = self.description.of_causality("parameter", "structuralParameter")
        known = (*self._dtypes, "String", "Binary")
        return {v.name: self.get(v.name) for v in chosen if v.type in known}

    @property
    def messages(self) -> tuple[str, ...]:
        """Last warnings and errors that the FMU logged and no exception has told.

        With log=True of `load_fmu` the last 10 000 messages of any kind.
        """
        return self._log.messages

    def step(
        self, inputs: Mapping[str, float] | ArrayLike | None = None, dt: float | None = None
    ) -> FloatArray:
        """Set inputs, go on by one communication step, and return the outputs at its end.

        Parameters
        ----------
        inputs : (number of inputs,) array or mapping of str to float, optional
            In the order of `input_names`, or by name, an array in its own shape or by element;
            an enumeration as a number or an item's name. Held over the step; what is not given
            stays as it was.
        dt : float, optional
            Length of this step, if not `Fmu.dt`.

        Returns
        -------
        (number of outputs,) array
            In the order of `output_names`; a new one each time. Of doubles, but where one of them
            does not hold an integer of 64 bits, of objects: floats, and exact ints.

        Raises
        ------
        FmuError
            For unknown names or another number of values, a step of another length than the FMU
            can take, or an error that the FMU reports, with what it logged. The inputs are
            then as they were before. After an error of the FMU itself it is to be reset.
        FmuTerminated
            An FmuError: where the FMU ends the simulation, in this step or before.
        TypeError
            For an input that is no number.
        """
        at = self._at
        if at.refusal is not None:
            at.check_ready()
        length = self.dt if dt is None else at.checked_length(dt)
        before = self._values.copy()
        try:
            if inputs is not None:
                self._take(inputs)
            after = at.clock_after(length)
            status, reached = self._do_step(at.time, length, not self._states)
            if status > WARNING and status != TERMINATED:
                if not self._instance.took_inputs:
                    self._refused_inputs(status)
                at.fail(status, f"step from time {at.time!r} by {length!r}", stopped=True)
        except BaseException as error:
            self._values[:] = before
            if not isinstance(error, Exception):
                at.stop(f"after a step that was interrupted at time {at.time:g}")
            elif inputs is not None and at.refusal is None:
                self._put()
            raise
        at.at_start = False
        if status == TERMINATED:
            ended = at.end(reached, at.time + length, length)
            ended.outputs = self.outputs
            raise ended
        at.go_to(after)
        status = self._fetch()
        if status > WARNING:
            at.fail(status, "show its outputs", stopped=True)
        return self._show()

    def _take(self, inputs: Mapping[str, float] | ArrayLike) -> None:
        if type(inputs) is np.ndarray and inputs.dtype is _DOUBLE and inputs.shape == self._shape:
            self._values[:] = inputs
        else:
            named = set(inputs) if isinstance(inputs, Mapping) else ()
            for variable in self._other_inputs:
                if variable.name in named:
                    raise FmuError(
                        f"input {variable.name!r} is of type {variable.type}, and `step` takes "
                        "numbers: give it to `set`, before the step"
                    )
            self._inputs.take(inputs)
        status = self._put()
        if status > WARNING:
            self._refused_inputs(status)

    def _refused_inputs(self, status: int) -> NoReturn:
        self._at.fail(status, f"take the inputs {self._values.tolist()}", stopped=False)

    def reset(self, parameters: Mapping[str, Any] | None = None) -> None:
        """Go back to the start time, with the start values and the parameters of `load_fmu`.

        `parameters`, if given, take the place of those. What `set` has changed is undone.
        """
        self._at.check_open()
        self._session.stepping = False
        ended = self._at.terminated and not self._states
        self._at.stop("before it is initialised again")
        if ended:  # some FMUs forget to reset that they have ended
            self._renew()
        else:
            self._at.check(self._instance.reset(), "be reset")
        self.initialize(self._given if parameters is None else parameters)

    def restart(self) -> None:
        """Go back to the start by a new instance, as some FMUs reset themselves in part only."""
        self._at.check_open()
        self._renew()
        self.initialize(self._given)

    def twin(self) -> Fmu:
        """Return another instance of the FMU, at its start, in memory of its own."""
        self._at.check_open()
        session = Session(self._session.folder, twin=True)
        try:
            made = Fmu(
                session,
                self._instantiate,
                self.description,
                Log(),
                self._experiment,
                self.recorded_names,
            )
            made.initialize(self._given)
        except BaseException:
            session.close()
            raise
        return made

    @property
    def at_start(self) -> bool:
        """Whether nothing has been done to it since its initialisation."""
        return self._at.at_start

    def _renew(self) -> None:
        self._session.free_instance()
        self._attach()

    def get_state(self) -> FmuState:
        """Return a snapshot of all that the FMU is, to go back to with `set_state`.

        As long as it is alive, the FMU is told in each step that it may have to go back; without
        any, that it will not, so that it may keep less and give out results once and for all.
        """
        self._at.check_ready()
        self.check_rollback("take snapshots")
        status, pointer = self._instance.get_state()
        self._at.check(status, "give its state")
        return FmuState(self._session, pointer, self._at.clock, self._values.copy())

    def set_state(self, state: FmuState) -> None:
        """Go back, or forward, to a snapshot of this instance: time, inputs and all."""
        self._at.check_open()
        if not isinstance(state, FmuState):
            raise TypeError(f"state = {state!r}: expected an FmuState, of this Fmu's get_state")
        if state._session is not self._session:
            raise FmuError("a state of another FMU: expected one of this instance's get_state")
        self._at.check(self._instance.set_state(state._pointer), "go back to a state")
        self._values[:] = state._inputs
        self._at.recover(state._clock)

    def check_rollback(self, purpose: str) -> None:
        """Refuse `purpose` where the FMU cannot get and set its state."""
        if not self.description.capabilities.can_get_and_set_state:
            raise FmuError(
                f"{self.description.model_name} cannot {purpose}: it declares no "
                "canGetAndSetFMUState; use a plain loop of `step`, or `cosimulate`, or export it "
                "with this capability"
            )

    def get(self, name: str) -> object:
        """Return the present value of any variable, by its name, an alias, or that of an element.

        Of the variable's own type and shape: an array of its shape, or one of its values by
        "A[1,2]", counted from 1; bytes for a binary; an int for an enumeration, whose
        `FmuVariable.items` name it.
        """
        self._at.check_ready(reading=True)
        variable, place = self.description.element(name)
        values = self._read(variable)
        if place is None:
            return own_shape(variable, values, self._dtypes)
        return own_shape(replace(variable, shape=()), [values[place]], self._dtypes)

    def set(self, name: str, value: object) -> None:
        """Set a tunable parameter, or an input that is no number, from the next step on.

        By name, as `get` knows it: an array in its own shape, or one of its elements; an
        enumeration as a number or an item's name. Fixed parameters are given to `load_fmu` or
        `reset`, inputs that are numbers to `step`.
        """
        self._at.check_ready()
        variable, place = self.description.element(name)
        check_tunable(self.description, name, self._dtypes)
        self._at.at_start = False
        if place is None:
            values = flat_values(variable, value)
        else:
            values = self._read(variable)
            values[place] = one_value(variable, value)
        self._write(variable, values)

    def system(self, dt: float | None = None, *, snapshots: int = 64) -> control.NonlinearIOSystem:
        """Return a discrete python-control system; see `io_system`."""
        from .io_system import io_system

        return io_system(self, dt, snapshots=snapshots)

    def close(self) -> None:
        """Free the instance, unload its library, remove the temporary folder."""
        self._at.close()

    def directional(self, unknowns: list[FmuVariable], knowns: list[FmuVariable]) -> FloatArray:
        """Return ∂unknown/∂known at the present point, (number of unknowns, of knowns)."""
        self._at.check_ready()
        columns = []
        for i in range(len(knowns)):
            seed = np.zeros(len(knowns))
            seed[i] = 1.0
            status, column = self._instance.directional(
                [v.value_reference for v in unknowns], [v.value_reference for v in knowns], seed
            )
            self._at.check(status, "give directional derivatives")
            columns.append(column)
        return np.array(columns).T.reshape(len(unknowns), len(knowns))

    def initialize(self, parameters: Mapping[str, Any]) -> None:
        """Go through the initialisation; `load_fmu` and `reset` do."""
        given = dict(parameters)
        self._values[:] = self._start_inputs
        for variable, values in start_settings(self.description, given):
            self._write(variable, values)
            if variable.causality == "input" and variable.type in self._dtypes:
                self._values[self._inputs.places(variable.name)] = values
        asked = self._experiment
        start = asked.start_time
        status = self._instance.enter_initialization(start, asked.stop_time, asked.tolerance)
        what = f"be initialised{self.description.tool_hint}"
        self._at.check(status, what)
        self._at.check(self._instance.exit_initialization(), what)
        self._given = given
        self._at.recover((start, 0, 0.0), at_start=True)

    def _read(self, variable: FmuVariable) -> list[Any]:
        check_type(variable, self._dtypes)
        status, values = read(self._instance, variable, self._dtypes)
        self._at.check(status, f"show {variable.name!r}")
        return values

    def _write(self, variable: FmuVariable, values: list[Any]) -> None:
        check_type(variable, self._dtypes)
        told = values if variable.shape else values[0]
        status = write(self._instance, variable, values, self._dtypes)
        self._at.check(status, f"take {variable.name} = {told!r}")
