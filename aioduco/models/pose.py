"""Poses and joint vectors: `Pose`, `Joints`."""

from __future__ import annotations

import functools
import math
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Self, TypeAlias, TypeVar, Union, get_args, overload

from aioduco.errors import Described, ParameterError
from aioduco.models.numpy_on_use import is_array, is_number, np, number_array, plain
from aioduco.models.rotation import (
    matrix_from_quaternion,
    matrix_from_rotvec,
    matrix_from_rpy,
    quaternion_from_matrix,
    rotvec_from_matrix,
    rpy_from_matrix,
    slerp,
    transform,
    turn_between,
)
from aioduco.models.words import one_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.models.rotation import Array

QuaternionOrder: TypeAlias = Literal["wxyz", "xyzw"]

#: tolerance for a rotation matrix times its transpose: only for digits lost in a file. With six
#: decimals each element is off by up to 5e-7, and the product by up to 2·√3 times as much
_ORTHONORMAL = 2e-6
_EXACT = 1e-12  # the same, by computing alone


class _Six(Sequence[float]):
    """Base class of `Pose` and `Joints`: a frozen sequence of six finite floats."""

    __slots__ = ()

    _expected = "six finite numbers"

    def __post_init__(self) -> None:
        for value in self._values():
            if type(value) is not float or not math.isfinite(value):
                self._convert()
                break

    def _convert(self) -> None:
        """Convert other numbers to floats; raise an error for a value that is not a number."""
        values: tuple[Any, ...] = self._values()
        names: tuple[str, ...] = type(self).__slots__
        for name, given in zip(names, values, strict=True):
            value = plain(given)
            if not is_number(value):
                raise ParameterError(name, given, f"a number, as one of {self._expected}")
            try:
                number = float(value)
            except OverflowError:  # a whole number, or a fraction, beyond all floats
                number = math.inf
            if not math.isfinite(number):
                raise ParameterError(name, given, f"finite, as one of {self._expected}")
            object.__setattr__(self, name, number)

    @classmethod
    def of(cls, values: Sequence[float] | NDArray[Any]) -> Self:
        """Make one from a list, a tuple or an array; an object of this class is returned unchanged.

        Args:
            values: six finite numbers, in the order and the units of the class.

        Raises:
            ParameterError: there are not six, or one is not a finite number.
        """
        if type(values) is cls:
            return values
        name = cls.__name__.lower()
        if is_array(values):
            if values.shape != (6,) or values.dtype.kind not in "fiu":
                found = Described(f"an array of shape {values.shape} and type {values.dtype}")
                raise ParameterError(name, found, cls._expected)
            values = values.tolist()
        elif isinstance(values, _Six):  # a pose is no joint vector, although both have six numbers
            raise ParameterError(name, values, cls._expected)
        elif not isinstance(values, Sequence):
            raise ParameterError(name, values, f"{cls._expected}, as a list, a tuple or an array")
        if len(values) != 6:
            raise ParameterError(name, values, cls._expected)
        return cls(*values)

    @property
    def array(self) -> Array:
        """The six numbers as a new array. Shape (6,)."""
        return np.array(self._values())

    @abstractmethod
    def _values(self) -> tuple[float, ...]:
        """The six numbers."""

    def __array__(
        self, dtype: np.dtype[Any] | None = None, copy: bool | None = None
    ) -> NDArray[Any]:
        if copy is False:
            raise ValueError(
                f"a {type(self).__name__} has no array to share; it can only be copied"
            )
        return np.array(self._values(), dtype=dtype)

    def __len__(self) -> int:
        return 6

    def __iter__(self) -> Iterator[float]:
        return iter(self._values())

    @overload
    def __getitem__(self, index: int) -> float: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[float, ...]: ...
    def __getitem__(self, index: int | slice) -> float | tuple[float, ...]:
        return self._values()[index]


_Kind = TypeVar("_Kind", bound=_Six)


def _counted(kind: type[_Kind]) -> type[_Kind]:
    """Let a class of six numbers tell in its own words that there are more or fewer."""
    init = kind.__init__

    @functools.wraps(init)
    def checked(self: _Kind, *values: Any, **named: Any) -> None:
        if len(values) + len(named) != 6:
            given = (*values, *named.values())
            expected = kind._expected
            if len(given) == 1:
                expected += f", one by one; {kind.__name__}.of takes a list, a tuple or an array"
            raise ParameterError(kind.__name__.lower(), given, expected)
        init(self, *values, **named)

    kind.__init__ = checked  # type: ignore[assignment]  # of the same signature
    return kind


def _short(value: float) -> str:
    # Micrometres and microradians: finer than any arm, and still readable.
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


@_counted
@dataclass(frozen=True, slots=True, repr=False)
class Pose(_Six):
    """A position and an orientation (位姿), in the controller's notation.

    The orientation is R = Rz(rz)·Ry(ry)·Rx(rx). A pose is an immutable sequence of its six numbers.
    It can be converted to and from arrays, matrices, quaternions and rotation vectors.
    Manual section 1.3.5.

    Args:
        x: position along x [m].
        y: position along y [m].
        z: position along z [m].
        rx: rotation about x, applied first [rad].
        ry: rotation about y, applied second [rad].
        rz: rotation about z, applied last [rad].

    Raises:
        ParameterError: there are not six, or one of them is not a finite number.
    """

    x: float
    y: float
    z: float
    rx: float
    ry: float
    rz: float

    _expected = "six finite numbers x, y, z [m], rx, ry, rz [rad]"

    def _values(self) -> tuple[float, ...]:
        return (self.x, self.y, self.z, self.rx, self.ry, self.rz)

    def __repr__(self) -> str:
        x, y, z, rx, ry, rz = map(_short, self._values())
        return f"Pose(x={x}, y={y}, z={z} [m], rx={rx}, ry={ry}, rz={rz} [rad])"

    @property
    def position(self) -> Array:
        """The position [m]. Shape (3,)."""
        return np.array((self.x, self.y, self.z))

    @property
    def rotation(self) -> Array:
        """The orientation as a rotation matrix. Shape (3, 3)."""
        return matrix_from_rpy(np.array((self.rx, self.ry, self.rz)))

    @property
    def matrix(self) -> Array:
        """The homogeneous matrix (齐次变换矩阵). Shape (4, 4)."""
        return transform(self.rotation, np.array((self.x, self.y, self.z)))

    @property
    def rotvec(self) -> Array:
        """The orientation as axis times angle, the angle in [0, π] [rad]. Shape (3,)."""
        return rotvec_from_matrix(self.rotation)

    def quaternion(self, order: QuaternionOrder) -> Array:
        """Return the orientation as a unit quaternion.

        Args:
            order: "wxyz" (MuJoCo, Eigen's constructor) or "xyzw" (ROS, SciPy).

        Returns:
            The quaternion with w not negative. Shape (4,).
        """
        quaternion = quaternion_from_matrix(self.rotation)
        return quaternion if _order(order) == "wxyz" else np.roll(quaternion, -1)

    @classmethod
    def from_rotation(cls, position: Sequence[float] | NDArray[Any], rotation: Array) -> Self:
        """Make a pose from a position [m], shape (3,), and a rotation matrix, shape (3, 3)."""
        point = _finite("position", position, (3,), "three numbers [m]")
        matrix = _finite("rotation", rotation, (3, 3), "a rotation matrix of shape (3, 3)")
        off = np.abs(matrix @ matrix.T - np.eye(3)).max()
        if off > _ORTHONORMAL or np.linalg.det(matrix) < 0:
            raise ParameterError(
                "rotation", matrix.tolist(), "a rotation: orthonormal, with determinant one"
            )
        if off > _EXACT:
            left, _, right = np.linalg.svd(matrix)
            matrix = left @ right  # the nearest rotation
        return cls(*point.tolist(), *rpy_from_matrix(matrix).tolist())

    @classmethod
    def from_matrix(cls, matrix: Sequence[Sequence[float]] | NDArray[Any]) -> Self:
        """Make a pose from a homogeneous matrix.

        Args:
            matrix: rotation and position [m]. Shape (4, 4), last row 0, 0, 0, 1.

        Raises:
            ParameterError: the shape is wrong, or the upper left part is not a rotation.
        """
        full = _finite("matrix", matrix, (4, 4), "a homogeneous matrix of shape (4, 4)")
        if np.abs(full[3] - (0, 0, 0, 1)).max() > _ORTHONORMAL:
            raise ParameterError("matrix", full.tolist(), "a matrix whose last row is 0, 0, 0, 1")
        return cls.from_rotation(full[:3, 3], full[:3, :3])

    @classmethod
    def from_quaternion(
        cls,
        position: Sequence[float] | NDArray[Any],
        quaternion: Sequence[float] | NDArray[Any],
        order: QuaternionOrder,
    ) -> Self:
        """Make a pose from a position and a quaternion.

        Args:
            position: x, y, z [m].
            quaternion: four numbers of any norm except zero; they are normalised.
            order: "wxyz" (MuJoCo, Eigen's constructor) or "xyzw" (ROS, SciPy).

        Raises:
            ParameterError: wrong lengths, values that are not finite, or a quaternion of zeros.
        """
        order = _order(order)
        values = _finite("quaternion", quaternion, (4,), f"four numbers in the order {order}")
        length = math.hypot(*values)
        if not 1e-9 <= length < math.inf:
            raise ParameterError("quaternion", values.tolist(), "of a finite norm above zero")
        if order == "xyzw":
            values = np.roll(values, 1)
        return cls.from_rotation(position, matrix_from_quaternion(values / length))

    @classmethod
    def from_rotvec(
        cls, position: Sequence[float] | NDArray[Any], rotvec: Sequence[float] | NDArray[Any]
    ) -> Self:
        """Make a pose from a position [m] and a rotation vector, axis times angle [rad]."""
        turn = _finite("rotvec", rotvec, (3,), "three numbers [rad]")
        return cls.from_rotation(position, matrix_from_rotvec(turn))

    def __matmul__(self, other: Pose) -> Pose:
        """Transform `other`, given in this frame, to the frame in which this pose is given."""
        if not isinstance(other, Pose):
            # Not NotImplemented: numpy would then multiply by the six numbers as an array.
            raise TypeError("a Pose composes with a Pose; take .matrix to multiply by an array")
        rotation = self.rotation
        position = self.position + rotation @ other.position
        return Pose(*position.tolist(), *rpy_from_matrix(rotation @ other.rotation).tolist())

    def inverse(self) -> Pose:
        """Return the inverse pose: `pose @ pose.inverse()` is the identity."""
        back = self.rotation.T
        return Pose(*(-back @ self.position).tolist(), *rpy_from_matrix(back).tolist())

    def shifted(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Pose:
        """Return this pose shifted along the axes of the frame in which it is given [m]."""
        by = Pose(x, y, z, 0.0, 0.0, 0.0)
        return Pose(self.x + by.x, self.y + by.y, self.z + by.z, self.rx, self.ry, self.rz)

    def interpolate(self, other: PoseLike, t: float) -> Pose:
        """Return a pose between this one and another.

        Args:
            other: the pose at t = 1.
            t: 0 to 1. The position follows a straight line, and the orientation rotates at a
                constant rate the shorter way, as in a linear move.

        Raises:
            ParameterError: the other one is no pose, or t is outside 0 to 1.
        """
        other, t = Pose.of(other), _fraction(t)
        position = (1.0 - t) * self.position + t * other.position
        return Pose.from_rotation(position, slerp(self.rotation, other.rotation, np.array(t)))

    def distance(self, other: PoseLike) -> tuple[float, float]:
        """Return the distance of the positions [m] and the angle between the orientations [rad].

        Raises:
            ParameterError: the other one is no pose.
        """
        other = Pose.of(other)
        return math.dist(self[:3], other[:3]), turn_between(self[3:], other[3:])

    def almost_equal(
        self, other: PoseLike, *, position: float = 1e-6, rotation: float = 1e-6
    ) -> bool:
        """Whether two poses are equal within tolerances.

        Orientations are compared, not angles: rx = π and rx = -π are equal.

        Args:
            other: the pose to compare with.
            position: largest distance [m].
            rotation: largest angle between the orientations [rad].
        """
        apart, turned = self.distance(other)
        return apart <= position and turned <= rotation


@_counted
@dataclass(frozen=True, slots=True, repr=False)
class Joints(_Six):
    """Six joint angles (关节角) [rad], base first: an immutable sequence.

    Args:
        j1: angle of joint 1 [rad].
        j2: angle of joint 2 [rad].
        j3: angle of joint 3 [rad].
        j4: angle of joint 4 [rad].
        j5: angle of joint 5 [rad].
        j6: angle of joint 6 [rad].

    Raises:
        ParameterError: there are not six, or one of them is not a finite number.
    """

    j1: float
    j2: float
    j3: float
    j4: float
    j5: float
    j6: float

    _expected = "six finite numbers, the joint angles [rad]"

    def _values(self) -> tuple[float, ...]:
        return (self.j1, self.j2, self.j3, self.j4, self.j5, self.j6)

    def __repr__(self) -> str:
        return f"Joints({', '.join(map(_short, self._values()))} [rad])"

    @classmethod
    def deg(cls, *angles: float) -> Self:
        """Make a joint vector from six angles in degrees: `Joints.deg(30, -15, 105, 0, -90, 0)`."""
        with suppress(OverflowError):  # a whole number, or a fraction, beyond all floats
            if len(angles) == 6 and all(map(is_number, angles)):
                return cls(*map(math.radians, angles))
        raise ParameterError("angles", angles, "six joint angles in degrees, one by one")

    @property
    def degrees(self) -> tuple[float, ...]:
        """The six angles [deg]."""
        return tuple(map(math.degrees, self._values()))

    def distance(self, other: JointsLike) -> float:
        """Return the largest difference of one joint [rad]. Whole turns count: 2π is not 0."""
        return max(abs(a - b) for a, b in zip(self, Joints.of(other), strict=True))

    def almost_equal(self, other: JointsLike, tolerance: float = 1e-6) -> bool:
        """Whether no joint differs by more than `tolerance` [rad]."""
        return self.distance(other) <= tolerance

    def interpolate(self, other: JointsLike, t: float) -> Joints:
        """Return the vector at fraction t, 0 to 1, of the straight joint-space line to `other`."""
        t = _fraction(t)
        return Joints(*((1 - t) * a + t * b for a, b in zip(self, Joints.of(other), strict=True)))


# a union with a name in it, since a program may write `JointsLike | None`
PoseLike: TypeAlias = Union[Pose, Sequence[float], "NDArray[Any]"]
JointsLike: TypeAlias = Union[Joints, Sequence[float], "NDArray[Any]"]


def _fraction(t: float) -> float:
    given = plain(t)
    if not is_number(given) or not 0.0 <= given <= 1.0:
        raise ParameterError("t", t, "a number from 0 to 1")
    return float(given)


def _order(order: QuaternionOrder) -> QuaternionOrder:
    one_of("order", order, get_args(QuaternionOrder))
    return order


def _finite(name: str, values: object, shape: tuple[int, ...], expected: str) -> Array:
    array = number_array(name, values, expected, finite=False)
    if array.shape != shape or not np.isfinite(array).all():
        raise ParameterError(name, array.tolist(), f"finite, {expected}")
    return array
