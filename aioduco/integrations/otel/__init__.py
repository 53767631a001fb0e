"""OpenTelemetry: spans of calls, motions and recoveries, and metrics, of robots that ask for it.

Needs the extra `otel`, which has OpenTelemetry's interface. Where spans and metrics go is decided
by the program, by the SDK that it sets up. Nothing of it is loaded before this is imported.
"""

from aioduco.integrations.otel.telemetry import Telemetry

__all__ = ["Telemetry"]
