"""Time integration of modes and fluid, strongly coupled, for a batch of cases.

Modal equation (Reade & Jankauski 2020, Eq. 11, with the damping that Table 1 gives):

    qdd_k + 2 zeta_k w_k qd_k + (w_k^2 - thd^2) q_k = -lambda_k Zdd cos(th) - psi_k thdd + Q_k

Every time derivative, of the modes and of the fluid alike, is the second-order backward difference (BDF2): the fluid
and the modes then see exactly the same added mass, at any mass ratio. For a given geometry the modal force is linear in
the modal acceleration, `Q = load + response qdd`, so that each step needs one small linear solve and no iteration. The
geometry is extrapolated to second order.

The march works with any fluid model of `taichiflap.fluids.interface`.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..case.case import Case
from ..kernels import linear, runtime
from ..kernels.arrays import Spare
from ..kernels.runtime import LANE, Floats3, Floats4, Ints1, View, passes, tasks, ti, view
from ..motion.sampling import PITCH_ACCEL, PITCH_RATE
from ..structure import beam
from . import divergence
from . import state as bodies
from .outputs import Outputs, output_type
from .state import (
    ACCEL,
    AMPLITUDE,
    BEFORE,
    BETA,
    C0,
    C1,
    C2,
    DAMPING,
    EVERY,
    LAMBDA,
    PSI,
    RATE,
    RUNAWAY,
    STEPS,
    STIFFNESS,
    Body,
)

Track = ti.types.argpack(modes=Floats4, force=Floats3)
"""History of every case: modal state and modal force, shape (case, 4, mode, step); and forces, shape (case, 4, step).
"""

MODAL_FORCE = 3
"""Row of the modal force in `Track.modes`, after those of the modal state."""


FIRST, LAST, OPENING, CASES, LANES = range(5)
"""Entries of a launch: first step, last step + 1, first step of the block, number of cases and number of lanes. They
share one array because Taichi allows only 64 kernel arguments.
"""


@ti.func
def differencing(n, dt):
    """Backward differences of order 0, 1 and then 2, since a case starts from rest without a history."""
    rule = ti.Vector([0.0, 0.0, 0.0, 0.0])
    if n == 1:
        rule = ti.Vector([1.0 / dt, -1.0 / dt, 0.0, dt])
    elif n > 1:
        rule = ti.Vector([1.5 / dt, -2.0 / dt, 0.5 / dt, dt / 1.5])
    return rule


@ti.func
def predict(body: View, b, n, rule, known: View):
    """Next amplitudes and rates without acceleration (`q_free`), and extrapolated to second order (`q_predicted`)."""
    dt = body.dt[b]
    modes = bodies.modes_of(body, b, known)
    for k in range(modes):
        body.load[b, k] = 0.0
        for j in range(modes):
            body.response[b, j, k] = 0.0
        if n == 0:
            for row in range(2):
                body.q_free[b, row, k] = body.q[b, row, k]
                body.q_predicted[b, row, k] = body.q[b, row, k]
        else:
            accel = body.q[b, ACCEL, k]
            rate = body.q[b, RATE, k]
            body.q_predicted[b, AMPLITUDE, k] = body.q[b, AMPLITUDE, k] + dt * (rate + 0.5 * dt * accel)
            body.q_predicted[b, RATE, k] = rate + dt * accel
            for row in range(2):
                now = body.q[b, row, k]
                body.q_free[b, row, k] = -(rule[C1] * now + rule[C2] * body.q[b, BEFORE + row, k]) / rule[C0]
                body.q[b, BEFORE + row, k] = now


@ti.func
def accelerate(body: View, b, n, rule, known: View):
    """Solve the modal equation (Eq. 11, with the modal force of Eqs 14-16) and update amplitudes and rates."""
    modes = bodies.modes_of(body, b, known)
    beta = rule[BETA]
    heave = bodies.pivot_heave(body, b, n)
    theta_rate = body.motion[b, n, PITCH_RATE]
    theta_accel = body.motion[b, n, PITCH_ACCEL]
    for j in range(modes):
        stiffness = body.constant[b, STIFFNESS, j] - theta_rate * theta_rate
        damping = body.constant[b, DAMPING, j]
        rate_known = body.q_free[b, RATE, j]
        own = beta * (damping + beta * stiffness)
        forcing = (
            body.load[b, j]
            - body.constant[b, LAMBDA, j] * heave
            - body.constant[b, PSI, j] * theta_accel
            - damping * rate_known
            - stiffness * (body.q_free[b, AMPLITUDE, j] + beta * rate_known)
        )
        if ti.static(known == 1):
            body.q[b, ACCEL, j] = forcing / (-body.response[b, j, j] + 1.0 + own)
        else:
            for k in range(modes):
                body.system[b, j, k] = -body.response[b, j, k]
            body.system[b, j, j] = body.system[b, j, j] + 1.0 + own
            body.system[b, j, modes] = forcing
    if ti.static(known < 0):
        linear.solve_few(body.system, b, modes)
        for k in range(modes):
            body.q[b, ACCEL, k] = body.system[b, k, modes]
    for k in range(modes):
        rate = body.q_free[b, RATE, k] + beta * body.q[b, ACCEL, k]
        body.q[b, RATE, k] = rate
        body.q[b, AMPLITUDE, k] = body.q_free[b, AMPLITUDE, k] + beta * rate


@ti.func
def has_diverged(body: View, b, known: View):
    """Whether a value is not finite or a mode exceeds its limit."""
    total = 0.0
    runaway = False
    for k in range(bodies.modes_of(body, b, known)):
        total += body.q[b, ACCEL, k]
        runaway = runaway or ti.abs(body.q[b, AMPLITUDE, k]) > body.constant[b, RUNAWAY, k]
    for c in range(4):
        total += body.force[b, c]
    return runaway or ti.math.isnan(total) or ti.math.isinf(total)


@ti.func
def track_step(body: View, track: View, b, row, known: View):
    modes = bodies.modes_of(body, b, known)
    for j in range(modes):
        force = body.load[b, j]
        for k in range(modes):
            force += body.response[b, j, k] * body.q[b, ACCEL, k]
        for k in range(3):
            track.modes[b, k, j, row] = body.q[b, k, j]
        track.modes[b, MODAL_FORCE, j, row] = force
    for c in range(4):
        track.force[b, c, row] = body.force[b, c]


_kernels: dict[Any, Any] = {}
"""Compiled kernels of this process, by kernel key."""


_launched: set[Any] = set()
"""Those of them that have been compiled."""


def kernel(flow: Any, outputs: tuple[Any, ...] | None, known: int) -> Any:
    """Kernel that marches a batch, with many steps of many cases per launch, and its argpack.

    Args:
        flow: the batch, a `taichiflap.fluids.interface.Flow`.
        outputs: outputs of the model; None if they are not stored.
        known: see `state.common_modes`.
    """
    key = flow.kernel_key, outputs, known
    if key not in _kernels:
        _kernels[key] = _build(flow, outputs, known)
    return _kernels[key]


def _build(flow: Any, outputs: tuple[Any, ...] | None, known: int) -> Any:
    output = {} if outputs is None else {"output": output_type(outputs)}
    Batch = ti.types.argpack(body=Body, track=Track, **output, **flow.types)
    needs = () if flow.uses is None else (flow.uses,)
    storing, counting = outputs is not None, flow.record_step is not None
    prepare, settle, record, record_step = flow.prepare, flow.settle, flow.record, flow.record_step

    @ti.func
    def march_case(batch: View, b, first, last, opening):
        body = ti.static(bodies.held_body(batch.body, known))
        steps = batch.body.plan[b, STEPS]
        every = batch.body.plan[b, EVERY]
        for n in range(first, ti.min(last, steps + 1)):
            if batch.body.failed[b] < 0:
                rule = differencing(n, batch.body.dt[b])
                predict(body, b, n, rule, known)
                prepare(batch, b, n, rule, *needs)
                accelerate(body, b, n, rule, known)
                settle(batch, b, n, rule, *needs)
                if has_diverged(body, b, known):
                    batch.body.failed[b] = n
                track_step(body, batch.track, b, n - opening, known)
                if ti.static(storing and counting):
                    record_step(batch, b, n - opening)
                if ti.static(storing):
                    if n % every == 0 or n == steps:
                        record(batch, b, (n + every - 1) // every - (opening + every - 1) // every)

    @ti.kernel
    def march(batch: Batch, launch: Ints1):  # type: ignore[valid-type]
        for i in range(launch[LANES] * LANE):
            if i % LANE == 0:
                for m in range((launch[CASES] - i // LANE + launch[LANES] - 1) // launch[LANES]):
                    march_case(batch, i // LANE + m * launch[LANES], launch[FIRST], launch[LAST], launch[OPENING])

    return Batch, march


class March:
    """A batch of cases with one fluid model, marched together.

    Args:
        cases: cases with the same solver; all else may differ.
        fluid: the fluid model, a `taichiflap.fluids.interface.Model`.
        threads: number of threads; None for all. It does not affect results.
        store_outputs: keep the outputs of the fluid model too; studies of many cases leave them out to save memory.
        room: the steps that the first `advance` takes, if known: memory is then allocated once.
        spare: arrays of an earlier march, and of this one once it has ended, see `end`.
    """

    @runtime.exclusive
    def __init__(
        self,
        cases: Sequence[Case],
        fluid: Any,
        threads: int | None = None,
        store_outputs: bool = True,
        room: int = 1,
        spare: Spare | None = None,
    ) -> None:
        self._runtime = runtime.start()
        self.cases = list(cases)
        self.fluid = fluid
        self.sections = [beam.modes(case.wing) for case in self.cases]
        self._spare = spare or Spare()
        motions, self.columns = bodies.sample_motions(self.cases, self._spare)
        self.motion = view(motions)
        self.body = bodies.allocate(self.cases, self.sections, motions)
        self.flow = fluid.flow(self.cases, self.sections, self.body, threads)
        self.groups = {"body": self.body, **self.flow.groups}
        self.steps = max(case.steps for case in self.cases)
        self.next_step = 0
        self._stores = store_outputs
        self._lanes = tasks(len(self.cases), threads)
        self._room = 0, 0
        room = min(room, self.steps + 1)
        self._make_room(room, max(case.frames(room) for case in self.cases) if store_outputs else 1)

    @property
    def done(self) -> bool:
        """Whether every case has reached its last step."""
        return self.next_step > self.steps

    @runtime.exclusive
    def advance(self, steps: int) -> list[dict[str, np.ndarray]]:
        """March every case by `steps` steps and return the stored arrays.

        The first step is step 0, the state at t = 0. A case that has reached its end, or has failed, rests.
        Zero steps compile the kernels, or fetch them from Taichi's cache, if this process has not yet.

        Returns:
            For each case `step`, `q` (amplitude, rate and acceleration of every mode), `modal_force`, `force` and the
            series of the fluid model, with the step as leading axis; `field_step`, the steps of its frames; and the
            fields, with the frame as leading axis. Ragged fields are concatenated over frames.
        """
        return self._collect(*self._advance(steps))

    @runtime.exclusive
    def advance_study(self, steps: int) -> tuple[np.ndarray, np.ndarray]:
        """March as `advance` does, without outputs of the fluid model, for a study.

        Returns:
            Modal state and modal force of all cases, shape (4, modes, cases, steps), and forces, shape (4, cases,
            steps). Modes that a case has not, and steps after it has ended or failed, may hold anything. Those of the
            last steps are the march's own memory.
        """
        first, last = self._advance(steps)
        taken = np.asarray if self.done else np.copy
        modes, force = (view(one)[..., : last - first] for one in (self._track.modes, self._track.force))
        return taken(modes.transpose(1, 2, 0, 3)), taken(force.transpose(1, 0, 2))

    def _advance(self, steps: int) -> tuple[int, int]:
        """First step and last step + 1 that were taken."""
        runtime.check(self._runtime)
        first, last = self.next_step, min(self.next_step + steps, self.steps + 1)
        frames = [case.frames(last) - case.frames(first) for case in self.cases] if self._stores else []
        self._make_room(max(1, last - first), max(1, *frames, 1))
        if first < last or self._kernel not in _launched:
            self._march(first, last)
            _launched.add(self._kernel)
        self.next_step = last
        return first, last

    def state(self, b: int) -> dict[str, np.ndarray]:
        """State of a case, arrays with a case axis of length one, valid until the next `advance`."""
        return {
            f"{group}.{name}": view(values)[b : b + 1]
            for group, arrays in self.groups.items()
            for name, values in arrays.items
            if name not in bodies.GIVEN
        }

    def restore(self, states: Sequence[Mapping[str, np.ndarray]], next_step: int) -> None:
        """Continue from the states, one per case, that a march had before `next_step`, in this or another batch.

        Raises:
            ValueError: if a state does not belong to such a case.
        """
        for b, state in enumerate(states):
            self._check(b, state, next_step)
        for b, state in enumerate(states):
            for name, values in self.state(b).items():
                # The padding differs between batches.
                shared = tuple(map(slice, np.minimum(values.shape, state[name].shape)))
                values[shared] = state[name][shared]
        self.next_step = next_step

    def _check(self, b: int, state: Mapping[str, np.ndarray], next_step: int) -> None:
        """Raise an error for an impossible state, since kernels use its integers as indices."""
        ours = self.state(b)
        if ours.keys() != state.keys():
            raise ValueError("not a state of this model")
        if not 0 < next_step <= self.steps + 1:
            raise ValueError(f"its next step is {next_step}")
        counters = {"body.failed": (-1, next_step - 1), **self.fluid.counters(self.cases[b], next_step)}
        for name, values in ours.items():
            theirs = state[name]
            if theirs.ndim != values.ndim or theirs.dtype != values.dtype or theirs.shape[0] != 1:
                raise ValueError(f"its {name} has another shape")
            # A batch of one has no padding, so its state can be no shorter.
            if len(self.cases) == 1 and np.any(np.less(theirs.shape, values.shape)):
                raise ValueError(f"its {name} is too short")
            shared = tuple(map(slice, np.minimum(values.shape, theirs.shape)))
            if values.dtype.kind == "i":
                low, high = counters.get(name, (values[shared], values[shared]))
                if not np.all((theirs[shared] >= low) & (theirs[shared] <= high)):
                    raise ValueError(f"its {name} is out of range")
            elif not np.isfinite(theirs).all() and state["body.failed"][0] < 0:
                raise ValueError(f"its {name} is not finite")

    def _march(self, first: int, last: int) -> None:
        """Take many steps per launch, except where the fluid model has work for all threads before each step."""
        before = self.flow.before_step
        alone = max(first, min(last, self.flow.first)) if before else last
        self._launch(first, alone, first)
        for n in range(alone, last):
            if before:
                before(n)
            self._launch(n, n + 1, first)

    def _launch(self, first: int, last: int, opening: int) -> None:
        with passes(self.flow.passes):
            self._kernel(self._batch, np.array([first, last, opening, len(self.cases), self._lanes], dtype=np.int32))

    def end(self) -> None:
        """Leave the largest arrays to another march. What `advance` and `motion` gave is no longer valid."""
        self._spare.leave(self.body.motion, self._track.modes, self._track.force)

    def failures(self) -> np.ndarray:
        """Step at which each case diverged, or -1."""
        return view(self.body.failed).copy()

    def reason(self, b: int, finer_helps: Callable[[Case, int], bool | None] | None = None) -> str:
        """Why a case diverged; empty if it did not.

        Args:
            finer_helps: function of a case and the step of divergence that returns whether a trial with twice the steps
                runs further.
        """
        step, count = int(self.failures()[b]), self.sections[b].count
        if step < 0:
            return ""
        known = self.flow.reason(b, step) if self.flow.reason else ""
        if known:
            return known
        # The failed step has moved the previous state to the rows from BEFORE on.
        now, before = (view(self.body.q)[b, row, :count] for row in (AMPLITUDE, BEFORE))
        now, before = now.copy(), before.copy()
        case = self.cases[b]
        helps = finer_helps(case, step) if finer_helps else None
        return divergence.reason(case, self.sections[b], step, now, before, self.fluid.cures(case), helps)

    def _make_room(self, steps: int, frames: int) -> None:
        if steps <= self._room[0] and frames <= self._room[1]:
            return
        self._room = steps, frames = max(steps, self._room[0]), max(frames, self._room[1])
        count, _, most = self.body.q.shape
        self._track = Track(
            modes=self._spare.take(count, 4, most, steps),
            force=self._spare.take(count, 4, steps),
        )
        output: dict[str, Any] = {}
        if self._stores:
            sizes = [self.fluid.sizes(case) for case in self.cases]
            self._outputs = Outputs(self.fluid.outputs, sizes, steps, frames)
            output = {"output": self._outputs.pack}
        outputs, known = self.fluid.outputs if self._stores else None, bodies.common_modes(self.sections)
        group, self._kernel = kernel(self.flow, outputs, known)
        self._batch = group(track=self._track, **output, **self.groups)

    def _collect(self, first: int, last: int) -> list[dict[str, np.ndarray]]:
        modes, force = view(self._track.modes), view(self._track.force)
        failed = self.failures()
        collected = []
        for b, (case, section) in enumerate(zip(self.cases, self.sections, strict=True)):
            end = max(first, min(last, case.steps + 1, failed[b] if failed[b] >= 0 else last))
            steps, frames = end - first, np.arange(case.frames(first), case.frames(end))
            # The steps of a number remain together in memory.
            own = np.moveaxis(modes[b, :, : section.count, :steps], -1, 0)
            found = {
                "step": np.arange(first, end),
                "q": np.copy(own[:, :MODAL_FORCE]),
                "modal_force": np.copy(own[:, MODAL_FORCE]),
                "force": np.copy(force[b, :, :steps].T),
            }
            if self._stores:
                found["field_step"] = case.step_of(frames)
                found |= self._outputs.share(b, self.fluid.stored(case), steps, len(frames))
            collected.append(found)
        return collected
