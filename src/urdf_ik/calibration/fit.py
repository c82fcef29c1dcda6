"""The fit of a URDF's numbers to measurements by robust least squares, and the poses to measure next."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.arm import Arm
from urdf_ik.calibration.equations import Equations, equations
from urdf_ik.calibration.measurements import Measurements
from urdf_ik.calibration.measurements import measured as checked
from urdf_ik.calibration.report import Calibration, Change, Errors
from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics.derivatives import Parameter, written
from urdf_ik.support import inputs
from urdf_ik.support.watch import Progress, TimeIsUp, Watch
from urdf_ik.typing import Array

LOSSES = ("soft_l1", "huber", "cauchy", "linear")
FITS = ("origins", "offsets", "everything")
# Parameter directions with a singular value below this fraction of the largest are unobservable.
_OBSERVABLE = 1e-7
# A measurement is an outlier if its residual's norm exceeds the root of its number of components by this many standard
# deviations; of good ones fewer than one in fifty million do.
_OUTLYING = 4.5
_FOLDS, _ROUNDS = 5, 3
_LEAST = 1e-9  # m and rad: smaller residuals are rounding
_CANDIDATES = 500
_NO_LIMIT = np.pi  # rad: an angle without limits is drawn from one turn
_OTHER_ORDER = 5.0  # joints in another order that explain the measurements this much better are suspected


def calibrate(
    arm: Arm,
    q: ArrayLike | Measurements,
    measured: Any = None,
    *,
    fit: str | Sequence[Any] = "origins",
    base: bool = False,
    marker: bool = False,
    loss: str = "soft_l1",
    seed: int = 0,
    time_limit: float | None = None,
    progress: Progress | None = None,
) -> Calibration:
    """Fit the numbers of an arm's URDF to measurements.

    The fit minimises a robust loss of the residuals by SciPy's least squares with exact derivatives, in the observable
    parameter directions; along the others the parameters keep their values. Residuals are divided by their standard
    deviations, which are estimated. Outliers are listed, and the last fit leaves them out.

    Args:
        arm: the arm that was measured.
        q: (m, n) rad or m; or :class:`Measurements`.
        measured: (m, 4, 4) poses of the tip in the base [m], or (m, 3) positions [m].
        fit: 'origins': xyz and rpy of every moving joint's origin; 'offsets': what is added to every joint's value;
            'everything': the origins of fixed joints too; or a list of (joint, field, part).
        base: whether the base's pose in the measuring frame is fitted too, as for a laser tracker.
        marker: whether the pose of the measured marker or probe in the tip is fitted too.
        loss: 'soft_l1', 'huber', 'cauchy', or 'linear' for plain least squares that keeps outliers.
        seed: of the folds of the cross-validation.
        time_limit: s after which the fit ends with the best numbers so far; ``unlooked`` says what was left out.
        progress: called with the number of finished fits, and of all.

    Returns:
        The changes, the unobservable parameters, the errors before and after; ``arm`` and ``urdf()`` are the new arm.

    Raises:
        ArgumentError: measurements do not fit, are too few, or look mixed up; there is no such parameter.
        ArgumentError: ``time_limit`` is no number of seconds, or ``progress`` no function.

    Example:
        >>> import numpy as np
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> other = urdf_ik.load(arm.model.xml.decode().replace('origin xyz="0 0 1"', 'origin xyz="0 0 1.002"'))
        >>> q = np.random.default_rng(0).uniform(-1.5, 1.5, (40, 6))
        >>> fitted = urdf_ik.calibrate(arm, q, other.fk(q))
        >>> bool(fitted.before.position > 1e-4), bool(abs(fitted.arm.fk(q) - other.fk(q)).max() < 1e-8)
        (True, True)
    """
    given = q if isinstance(q, Measurements) else checked(arm, q, measured)
    inputs.choice(loss, "loss", LOSSES)
    watch = Watch(time_limit, progress)
    chosen = _chosen(arm, fit)
    frames = equations(arm.chain, given, [], base=base, marker=marker)
    whole = equations(arm.chain, given, chosen, base=base, marker=marker)
    _require_enough(given, whole)
    _require_order(arm, given, base, marker)
    nominal = _fitted(frames, given, loss, watch).x if frames.parameters else frames.start
    watch.step(1, 2 + _FOLDS)
    best = _fitted(whole, given, loss, watch)
    watch.step(2, 2 + _FOLDS)
    unlooked = watch.ended("in the midst of the fit: its last rounds were") if watch.is_over else ""
    kept = given.part(~best.outliers)
    before = _errors(frames.residuals(nominal, kept), given.kind)
    after = _errors(whole.residuals(best.x, kept), given.kind)
    validated = _cross_validated(whole, kept, best, np.random.default_rng(seed), watch)
    if watch.is_over and not unlooked:
        unlooked = watch.ended("after the fit: measurements that it did not see were")
    return Calibration(
        nominal=arm,
        given=given,
        equations=whole,
        x=best.x,
        changes=_changes(whole, best),
        unobservable=_unobservable(whole, best),
        singular_values=best.singular_values,
        before=before,
        after=after,
        validated=None if unlooked else validated,
        noise=tuple(best.noise),
        outliers=tuple(np.flatnonzero(best.outliers).tolist()),
        residuals_before=frames.residuals(nominal, given),
        residuals_after=whole.residuals(best.x, given),
        covariance=best.covariance,
        unlooked=unlooked,
    )


@dataclass(frozen=True, eq=False)
class _Fit:
    """A fit: parameters, noise of the residuals, outliers, observable directions, and the parameters' covariance."""

    x: Array
    noise: list[float]
    outliers: NDArray[np.bool_]
    singular_values: Array
    directions: Array
    covariance: Array


def _fitted(eq: Equations, given: Measurements, loss: str, watch: Watch) -> _Fit:
    """The fit of the parameters of ``eq``, from their initial values; after the time limit, the best so far."""
    x = eq.start
    scale = _scales(eq.residuals(x, given), eq.kind)
    outliers = np.zeros(len(given), np.bool_)
    if loss != "linear":
        for _ in range(_ROUNDS):
            x = _solved(eq, given, x, scale, loss, watch)
            scale = _scales(eq.residuals(x, given), eq.kind)
        apart = np.linalg.norm(eq.residuals(x, given) / scale, axis=1)
        outliers = apart > np.sqrt(given.numbers) + _OUTLYING
    kept = given.part(~outliers)
    for _ in range(2):
        x = _solved(eq, kept, x, scale, "linear", watch)
        directions, _ = _directions(eq, kept, x, scale)
        scale = _deviations(eq.residuals(x, kept), eq.kind, directions.shape[1])
    directions, values = _directions(eq, kept, x, scale)
    J = _whitened(eq, kept, x, scale) @ directions
    covariance = (
        directions @ np.linalg.inv(J.T @ J) @ directions.T if directions.shape[1] else np.zeros((len(x), len(x)))
    )
    noise = [float(scale[0]), float(scale[-1])] if eq.kind == "pose" else [float(scale[0])]
    return _Fit(x, noise, outliers, values, directions, covariance)


def _solved(eq: Equations, given: Measurements, x: Array, scale: Array, loss: str, watch: Watch) -> Array:
    """Least squares from ``x`` in the observable directions; after the time limit, the best parameters so far."""
    from scipy.optimize import least_squares

    if not len(x) or watch.is_over:
        return x
    directions, _ = _directions(eq, given, x, scale)
    best = np.zeros(directions.shape[1])

    def residuals(y: Array) -> Array:
        watch.check()
        return np.asarray((eq.residuals(x + directions @ y, given) / scale).ravel())

    def derivatives(y: Array) -> Array:
        best[:] = y  # derivatives are asked for where a step was taken, that is where the loss has fallen
        return np.asarray(_whitened(eq, given, x + directions @ y, scale) @ directions)

    with suppress(TimeIsUp):
        best = least_squares(
            residuals,
            best.copy(),
            jac=derivatives,
            method="trf",
            x_scale="jac",
            loss=loss,
            f_scale=2.0,
            ftol=1e-12,
            xtol=1e-12,
            gtol=1e-12,
            max_nfev=40,
        ).x
    return np.asarray(x + directions @ best)


def _whitened(eq: Equations, given: Measurements, x: Array, scale: Array) -> Array:
    """The derivatives of the residuals in standard deviations, (numbers, k)."""
    return np.asarray((eq.derivatives(x, given) / scale[:, None]).reshape(-1, len(x)))


def _directions(eq: Equations, given: Measurements, x: Array, scale: Array) -> tuple[Array, Array]:
    """Orthonormal basis (k, r) of the observable parameter directions, and all singular values."""
    if not len(x):
        return np.zeros((0, 0)), np.zeros(0)
    J = _whitened(eq, given, x, scale)
    _, s, Vt = np.linalg.svd(np.linalg.qr(J, mode="r"), full_matrices=True)
    values = np.zeros(len(x))
    values[: len(s)] = s
    return np.asarray(Vt[: int((values > _OBSERVABLE * values.max(initial=0.0)).sum())].T), values


def _scales(r: Array, kind: str) -> Array:
    """1.4826 medians of the absolute residuals: one of all position columns, one of all rotation columns."""
    return _by_part(r, kind, lambda part: 1.4826 * np.median(np.abs(part)))


def _deviations(r: Array, kind: str, fitted: int) -> Array:
    """Standard deviations by the mean square; the fitted parameters reduce the degrees of freedom."""
    free = max(r.size - fitted, 1) / r.size
    return _by_part(r, kind, lambda part: np.sqrt((part**2).mean() / free))


def _by_part(r: Array, kind: str, spread: Callable[[Array], Any]) -> Array:
    """A measure of the positions and of the rotations, one number a column."""
    parts = (r[:, :3], r[:, 3:]) if kind == "pose" else (r,)
    return np.repeat([max(float(spread(part)), _LEAST) for part in parts], [part.shape[1] for part in parts])


def _errors(r: Array, kind: str) -> Errors:
    """Root mean square and greatest errors of measurements, as lengths and angles."""
    position = np.linalg.norm(r[:, :3], axis=1)
    rotation = np.linalg.norm(r[:, 3:], axis=1) if kind == "pose" else np.full(1, np.nan)

    def rms(values: Array) -> float:
        return float(np.sqrt((values**2).mean()))

    return Errors(rms(position), float(position.max()), rms(rotation), float(rotation.max()))


def _cross_validated(
    eq: Equations, given: Measurements, best: _Fit, rng: np.random.Generator, watch: Watch
) -> Errors | None:
    """Errors of held-out measurements by five-fold cross-validation; None for too few measurements."""
    order = rng.permutation(len(given))
    scale = np.repeat(best.noise, [3, 3] if eq.kind == "pose" else [given.numbers])
    seen = len(given) - -(-len(given) // _FOLDS)
    if seen * given.numbers < best.directions.shape[1] + given.numbers:
        return None
    held = np.zeros((len(given), given.numbers))
    for k in range(_FOLDS):
        out = order[k::_FOLDS]
        rest = np.setdiff1d(order, out)
        x = _solved(eq, given.part(rest), best.x, scale, "linear", watch)
        held[out] = eq.residuals(x, given.part(out))
        watch.step(3 + k, 2 + _FOLDS)
    return _errors(held, eq.kind)


def _chosen(arm: Arm, fit: str | Sequence[Any]) -> list[Parameter]:
    """The URDF's numbers that are fitted."""
    geometry = written(arm.chain)
    if not isinstance(fit, str):
        return [geometry.parameters[k] for k in geometry.columns(fit)]
    inputs.choice(fit, "fit", FITS)
    moving = {joint.name for joint in geometry.joints if joint.driver}
    if fit == "offsets":
        return [each for each in geometry.parameters if each.field == "offset"]
    return [
        each
        for each in geometry.parameters
        if each.field in ("xyz", "rpy") and (fit == "everything" or each.joint in moving)
    ]


def _require_enough(given: Measurements, eq: Equations) -> None:
    numbers = len(given) * given.numbers
    fitted = _directions(eq, given, eq.start, np.ones(given.numbers))[0].shape[1]
    if numbers <= fitted or len(given) < 3:
        least = max(3, fitted // given.numbers + 1)
        raise ArgumentError(
            f"{len(given)} measurements give {numbers} numbers, and {fitted} are to be fitted; at least {least} "
            f"measurements are needed, better {3 * least}, or fewer parameters: fit='offsets', or a list of them"
        )


def _require_order(arm: Arm, given: Measurements, base: bool, marker: bool) -> None:
    """Refuse measurements that another common order of the joints explains far better than the URDF's."""
    if arm.dof < 2:
        return

    def error(columns: list[int]) -> float:
        part = Measurements(given.kind, given.q[:, columns], given.values)
        eq = equations(arm.chain, part, [], base=base, marker=marker)
        return float(np.median(np.linalg.norm(eq.residuals(eq.start, part)[:, :3], axis=1)))

    every = list(range(arm.dof))
    own = error(every)
    by_name = sorted(every, key=lambda k: arm.joint_names[k])
    unsorted = [by_name.index(k) for k in every]
    swapped = [2, 1, 0, *every[3:]] if arm.dof > 2 else every
    for columns, called in ((unsorted, "by name"), (every[::-1], "from tip to base"), (swapped, "3, 2, 1, 4, ...")):
        if columns != every and error(columns) * _OTHER_ORDER < own:
            raise ArgumentError(
                f"the measurements fit {own / error(columns):.0f} times as well if the joints stand in the order "
                f"{called!r}; are they in another order than {', '.join(arm.joint_names)}?"
            )


def _changes(eq: Equations, best: _Fit) -> tuple[Change, ...]:
    deviation = np.sqrt(np.maximum(np.diag(best.covariance), 0.0))
    hidden = 1.0 - (best.directions**2).sum(axis=1)
    return tuple(
        Change(parameter, float(start), float(value), float(spread), bool(lost < 1e-6))
        for parameter, start, value, spread, lost in zip(
            eq.parameters, eq.start, best.x, deviation, hidden, strict=True
        )
    )


def _unobservable(eq: Equations, best: _Fit) -> tuple[tuple[str, ...], ...]:
    """Groups of parameters of which the measurements determine only combinations."""
    from scipy.linalg import qr

    lost = np.eye(len(best.x)) - best.directions @ best.directions.T
    rank = len(best.x) - best.directions.shape[1]
    if not rank:
        return ()
    # Of columns equal to rounding the first is taken, on every processor.
    _, R, order = qr(lost * (1.0 - 1e-6 * np.arange(len(lost))), pivoting=True)
    # Each row: one parameter, and those that can compensate its change.
    rows = np.linalg.solve(R[:rank, :rank], R[:rank])
    groups = []
    for row in rows:
        there = order[np.flatnonzero(np.abs(row) > 0.02 * np.abs(row).max())]
        groups.append(tuple(str(eq.parameters[k]) for k in sorted(there)))
    return tuple(sorted(set(groups)))


def best_poses(calibration: Calibration, count: int = 10, *, seed: int = 0) -> tuple[Array, Array, str]:
    """The joint vectors whose measurement would determine the fitted numbers best, in the sense of D-optimality.

    Each is the one that raises the determinant of the information matrix most when the earlier ones are measured
    (Fedorov, Theory of Optimal Experiments, 1972), along the observable directions.

    Args:
        calibration: the fit so far.
        count: how many.
        seed: of the 500 joint vectors to choose from, within the limits, free of contact where the shapes can be read.

    Returns:
        (k, n) rad or m, the most useful one first; (k,) by how much each raises the logarithm of the determinant; and
        why contacts were not checked, '' where they were.

    Raises:
        ArgumentError: fewer than asked for are free of contact.

    Example:
        >>> import numpy as np
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> q = np.random.default_rng(0).uniform(-0.3, 0.3, (20, 6))
        >>> q, gains, _ = best_poses(urdf_ik.calibrate(arm, q, arm.fk(q)), 3)
        >>> q.shape, bool((np.diff(gains) <= 1e-9).all())
        ((3, 6), True)
    """
    wanted = inputs.whole(count, "count", low=1, high=10_000)
    given = calibration.given
    q, unchecked = _drawn(calibration, max(_CANDIDATES, 2 * wanted), np.random.default_rng(seed))
    if len(q) < wanted:
        raise ArgumentError(f"{len(q)} joint vectors are free of contact; {wanted} are needed")
    eq, x = calibration.equations, calibration.x
    noise = np.repeat(calibration.noise, [3, 3] if given.kind == "pose" else [given.numbers])
    variances, vectors = np.linalg.eigh(calibration.covariance)
    directions = vectors[:, variances > 1e-14 * variances.max(initial=0.0)]
    poses = eq.chain.fk(q, eq.values(x))
    values = poses if given.kind == "pose" else poses[:, :3, 3]
    G = (eq.derivatives(x, Measurements(given.kind, q, values)) / noise[:, None]) @ directions
    P = directions.T @ calibration.covariance @ directions
    chosen: list[int] = []
    gains: list[float] = []
    for _ in range(wanted):
        S = np.eye(given.numbers) + G @ P @ np.swapaxes(G, 1, 2)
        gain = np.linalg.slogdet(S)[1]
        gain[chosen] = -np.inf
        best = int(np.argmax(gain))
        chosen.append(best)
        gains.append(float(gain[best]))
        K = P @ G[best].T
        P = P - K @ np.linalg.solve(S[best], K.T)
    return q[chosen], np.array(gains), unchecked


def _drawn(calibration: Calibration, count: int, rng: np.random.Generator) -> tuple[Array, str]:
    """Joint vectors within the limits, free of contact where that can be checked."""
    arm = calibration.arm
    low, high = (
        np.where(np.isfinite(side), side, sign * _NO_LIMIT) for sign, side in zip((-1, 1), arm.limits.T, strict=True)
    )
    q = rng.uniform(low, high, (count, arm.dof))
    bodies = arm.cell.in_world(None)
    if bodies.unchecked or not bodies.has_geometry:
        return q, bodies.unchecked or "the URDF has no collision shapes"
    free = ~np.asarray(bodies.in_collision(q), dtype=np.bool_)
    return q[free], ""
