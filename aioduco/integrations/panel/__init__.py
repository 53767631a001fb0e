"""The panel: an arm in the browser, watched by many pages and commanded by one.

`control_lease` decides which page commands and for how long, `page_requests` checks the messages
from pages, `page_state` makes the messages to pages: all three without I/O or a clock.
`page_server` serves the page and transports its messages, `arm_scene` draws the arm with viser,
`simulator_port` sends commands to a simulator. `panel` combines them with two robots: one that
observes, and one that exists for the duration of a lease.

It uses only the public interface of the package, and needs the extra `panel`.
"""

from __future__ import annotations

from aioduco.errors import MissingExtra

with MissingExtra.named("the panel", "panel"):
    from aioduco.integrations.panel.panel import Panel

__all__ = ["Panel"]
