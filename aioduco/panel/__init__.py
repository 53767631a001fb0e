"""The panel: an arm in the browser, watched by many and commanded by one.

`control_lease` decides who commands and for how long, `page_requests` what a page may ask for, and
`page_state` what pages are told: all three without I/O or a clock. `page_server` serves the page
and carries its messages, `arm_scene` draws the arm by viser, `simulator_port` asks a simulator, and
`panel` puts them together over two robots: one that looks on, and one for the time of a lease.

It uses the package from above, by its public interface alone, and needs the extra `panel`.
"""

from __future__ import annotations

from aioduco.panel.panel import Panel

__all__ = ["Panel"]
