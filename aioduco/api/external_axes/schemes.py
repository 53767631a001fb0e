"""Schemes of external axes: read, activate and configure them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco._wire import newer
from aioduco._wire.rpc import calls
from aioduco.api.section import Section
from aioduco.models import ranges
from aioduco.models.external_axis import (
    ExternalAxis,
    ExternalAxisScheme,
    ExternalAxisState,
    checked,
)

if TYPE_CHECKING:
    from aioduco._wire import rpc

__all__ = ["Schemes"]

#: time-out of calls that the controller answers only after it has switched drives [s]
_SWITCHING = 10.0


class Schemes(Section):
    """Schemes of external axes."""

    __slots__ = ()

    async def enable_eaxis_scheme(self, scheme_name: str, *, timeout: float = _SWITCHING) -> None:
        """Activate a scheme of external axes (启动外部轴方案).

        Args:
            scheme_name: name of the scheme.
            timeout: seconds within which the controller must have finished.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            TaskError, Refused: it was not activated.
            OutcomeUnknown: the controller did not answer within `timeout`.

        Manual section 1.3.14.
        """
        name = ranges.LONG_NAME("scheme_name", scheme_name)
        await self._finish_within(calls.enable_eaxis_scheme(name), timeout)

    async def disable_eaxis_scheme(self, scheme_name: str, *, timeout: float = _SWITCHING) -> None:
        """Deactivate a scheme of external axes (结束外部轴方案).

        Args:
            scheme_name: name of the scheme.
            timeout: seconds within which the controller must have finished.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            TaskError, Refused: it was not deactivated.
            OutcomeUnknown: the controller did not answer within `timeout`.

        Manual section 1.3.14.
        """
        name = ranges.LONG_NAME("scheme_name", scheme_name)
        await self._finish_within(calls.disable_eaxis_scheme(name), timeout)

    async def get_eaxis_info(self) -> tuple[ExternalAxisState, ...]:
        """Read the state of each scheme of external axes (外部轴反馈信息).

        The wire of 3.8 has this function, and manual 4.3 describes it. Section 1.2 of manual 3.8
        describes the struct. Controllers of manual 4.3 also send speed and acceleration.
        """
        schemes = await self._rpc.get_eaxis_info()
        return tuple(
            ExternalAxisState(one.scheme_name, one.status, one.pos, *_rates(one)) for one in schemes
        )

    async def set_eaxis_param(self, num: int, param: ExternalAxis) -> None:
        """Set the parameters of an external axis.

        Args:
            num: number of the axis, from 0.
            param: its parameters.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: they were not set.

        Not in the manual, only on the wire. Check what the controller's own page shows before and
        after the call.
        """
        num_ = ranges.EAXIS_NUMBER("num", num)
        checked("param", param, ExternalAxis)
        await self._finish(calls.set_eaxis_param(num_, param.wire(), True))

    async def set_eaxiss_scheme_param(self, num: int, param: ExternalAxisScheme) -> None:
        """Set the parameters of a scheme of external axes.

        Args:
            num: number of the scheme, from 0.
            param: its parameters.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: they were not set.

        Not in the manual, only on the wire. Check what the controller's own page shows before and
        after the call.
        """
        num_ = ranges.EAXIS_NUMBER("num", num)
        checked("param", param, ExternalAxisScheme)
        await self._finish(calls.set_eaxiss_scheme_param(num_, param.wire(), True))

    async def add_eaxis_scheme(self, num: int) -> None:
        """Add a scheme of external axes.

        Args:
            num: number of the scheme, from 0.

        Raises:
            ParameterError: the number is out of range; nothing was sent.
            TaskError, Refused: it was not added.

        Not in the manual, only on the wire.
        """
        num_ = ranges.EAXIS_NUMBER("num", num)
        await self._finish(calls.add_eaxis_scheme(num_, True))

    async def delete_eaxis_scheme(self, num: int) -> None:
        """Delete a scheme of external axes.

        Args:
            num: number of the scheme, from 0.

        Raises:
            ParameterError: the number is out of range; nothing was sent.
            TaskError, Refused: it was not deleted.

        Not in the manual, only on the wire.
        """
        num_ = ranges.EAXIS_NUMBER("num", num)
        await self._finish(calls.delete_eaxis_scheme(num_, True))


def _rates(scheme: rpc.EAxissInfo) -> tuple[float, float]:
    """Speed and acceleration of a scheme; NaN for one that was not sent."""
    if not isinstance(scheme, newer.EAxissInfo):
        return math.nan, math.nan
    vel, acc = (math.nan if rate is None else rate for rate in (scheme.vel, scheme.acc))
    return vel, acc
