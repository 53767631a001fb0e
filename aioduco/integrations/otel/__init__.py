"""OpenTelemetry: spans of calls, motions and recoveries, and metrics, for chosen robots.

It needs the extra `otel`, which installs OpenTelemetry's API. The program sets up the SDK, which
decides where spans and metrics go. OpenTelemetry is not loaded before this module is imported.
"""

from aioduco.errors import MissingExtra

with MissingExtra.named("telemetry", "otel"):
    from aioduco.integrations.otel.telemetry import Telemetry

__all__ = ["Telemetry"]
