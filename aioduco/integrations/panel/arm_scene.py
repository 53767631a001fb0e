"""The arm and its surroundings in 3D, drawn by viser for pages of the panel's own port.

Pages only view it: it has no controls, and no message of a page reaches it.
"""

from __future__ import annotations

import contextlib
import io
import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import viser

from aioduco.envelope import Envelope, Zone
from aioduco.integrations.panel.picture_door import portless
from aioduco.kinematics.bodies import bodies, flange_on_link6
from aioduco.kinematics.looks import COLOURS, looks, merged
from aioduco.models.rotation import quaternion_from_matrix

if TYPE_CHECKING:
    from collections.abc import Sequence
    from xml.etree import ElementTree as ET

    from numpy.typing import NDArray
    from websockets.asyncio.server import ServerConnection

    from aioduco.kinematics import Arm
    from aioduco.planning import Scene

    Array = NDArray[np.float64]
    Colour = tuple[int, int, int]


_TOLD: Final = (255, 170, 40)
_AIM: Final = (60, 190, 120)
_TWIN: Final = (170, 120, 245)
_KEEP_OUT: Final = (215, 60, 60)
_KEEP_IN: Final = (70, 150, 230)
#: difference of joints below which two arms are drawn as one [rad]
_SAME: Final = 0.01


class _SilentViser(viser.ViserServer):
    """Viser without a port, that prints nothing, and opens no tunnel from the internet."""

    def __init__(self) -> None:
        # it prints a banner, whatever `verbose` says
        with contextlib.redirect_stdout(io.StringIO()), portless() as self.door:
            super().__init__(host="127.0.0.1", port=0, verbose=False)
        if self.door.handler is None:
            self.stop()
            raise RuntimeError(f"viser {viser.__version__} opened a port of its own: it is closed")

    def request_share_url(self, verbose: bool = True) -> str | None:  # noqa: ARG002 - viser's
        """Refuse it: any page could ask for a tunnel through viser's servers."""
        return None

    def stop(self) -> None:
        with contextlib.redirect_stdout(io.StringIO()):
            super().stop()


class ArmScene:
    """Draws one arm for all pages.

    Args:
        arm: the arm.
        scene: objects around the arm; None for nothing.
        envelope: envelope whose zones are drawn; None for none.
        twin: whether to draw the arm's twin, too.
    """

    def __init__(
        self,
        arm: Arm,
        scene: Scene | None,
        envelope: Envelope | None,
        *,
        twin: bool = False,
    ) -> None:
        self._server = _SilentViser()
        draw = self._server.scene
        self._server.gui.configure_theme(
            dark_mode=True, show_logo=False, show_share_button=False, control_width="small"
        )
        self._server.initial_camera.position = (1.15, -1.0, 0.85)
        self._server.initial_camera.look_at = (0.12, 0.0, 0.36)
        draw.configure_default_lights(cast_shadow=True)
        draw.add_grid(
            "/floor", width=4.0, height=4.0, cell_size=0.1, section_size=0.5,
            cell_color=(52, 62, 76), section_color=(84, 97, 116), plane_color=(24, 30, 39),
            plane_opacity=1.0, shadow_opacity=0.35, position=(0.0, 0.0, -0.001),
        )  # fmt: skip
        mounting = np.eye(4) if scene is None else np.asarray(scene.mounting.matrix)
        draw.add_frame(
            "/base", axes_length=0.16, axes_radius=0.004,
            wxyz=quaternion_from_matrix(mounting[:3, :3]), position=mounting[:3, 3],
        )  # fmt: skip
        self._turns = [np.asarray(body.rotation) for body in bodies(arm)[1:]]
        self._arms = {
            "is": self._add_arm(arm, "is", None, None),
            "told": self._add_arm(arm, "told", _TOLD, 0.35),
            "aim": self._add_arm(arm, "aim", _AIM, 0.45),
        }
        if twin:
            self._arms["twin"] = self._add_arm(arm, "twin", _TWIN, 0.45)
        on = flange_on_link6(arm)
        draw.add_frame(
            "/base/is/1/2/3/4/5/6/flange", axes_length=0.12, axes_radius=0.004,
            wxyz=quaternion_from_matrix(on[:3, :3]), position=on[:3, 3],
        )  # fmt: skip
        for number, thing in enumerate(scene or ()):
            # not by its name, which may begin as that of another one and a slash
            self._add_body(f"/things/{number}", thing.mjcf(free=False))
        for number, limit in enumerate(() if envelope is None else envelope.limits):
            if isinstance(limit, Zone):
                self._add_zone(f"/base/zones/{number}", limit)

    async def serve(self, page: ServerConnection) -> None:
        """Transport the picture to a page until it is closed."""
        await self._server.door.serve(page)

    def show(
        self,
        joints: Sequence[float],
        told: Sequence[float],
        aim: Sequence[float] | None,
        twin: Sequence[float] | None = None,
    ) -> None:
        """Draw the arm.

        Args:
            joints: actual joints [rad], six.
            told: commanded joints [rad], six; drawn if they differ from the actual ones.
            aim: joints of the sliders [rad], six; None to draw none.
            twin: joints of the twin [rad], six; drawn if they differ from the actual ones.
        """
        with self._server.atomic():
            self._turn("is", joints)
            self._turn("told", None if _near(joints, told) else told)
            self._turn("aim", None if aim is None or _near(joints, aim) else aim)
            if "twin" in self._arms:
                self._turn("twin", None if twin is None or _near(joints, twin) else twin)

    def close(self) -> None:
        """Stop the server: pages no longer show the scene."""
        self._server.stop()

    # -- drawing ---------------------------------------------------------------------------------

    def _turn(self, which: str, joints: Sequence[float] | None) -> None:
        root, links = self._arms[which]
        shown = joints is not None and all(map(math.isfinite, joints))
        if root.visible != shown:
            root.visible = shown
        if joints is None or not shown:
            return
        for link, turn, angle in zip(links, self._turns, joints, strict=True):
            link.wxyz = quaternion_from_matrix(turn @ _about_z(angle))

    def _add_arm(
        self, arm: Arm, which: str, colour: Colour | None, opacity: float | None
    ) -> tuple[Any, list[Any]]:
        """Add a frame for each link in that of the previous link, and the link's looks in it."""
        draw = self._server.scene
        path = f"/base/{which}"
        root = draw.add_frame(path, show_axes=False, visible=colour is None)
        links = []
        shown = looks(arm)
        for number, body in enumerate(bodies(arm)):
            if number:
                path = f"{path}/{number}"
                links.append(
                    draw.add_frame(
                        path,
                        show_axes=False,
                        position=body.position,
                        wxyz=quaternion_from_matrix(np.asarray(body.rotation)),
                    )
                )
            for name, (points, faces) in merged(shown[number]).items():
                draw.add_mesh_simple(
                    f"{path}/{name}", points, faces, opacity=opacity, color=colour or COLOURS[name],
                    cast_shadow=colour is None, receive_shadow=False,
                )  # fmt: skip
        return root, links

    def _add_body(self, path: str, body: ET.Element) -> None:
        """Add an object from MJCF: nested bodies with simple shapes."""
        draw = self._server.scene
        draw.add_frame(path, show_axes=False, **_placed(body))
        for number, child in enumerate(body):
            name = f"{path}/{number}"
            if child.tag == "body":
                self._add_body(name, child)
            elif child.tag == "geom":
                size = _floats(child, "size")
                red, green, blue = (int(255 * part) for part in _floats(child, "rgba")[:3])
                look: dict[str, Any] = {"color": (red, green, blue), **_placed(child)}
                kind = child.get("type")
                if kind == "box":
                    draw.add_box(name, dimensions=2.0 * np.array(size), **look)
                elif kind == "sphere":
                    draw.add_icosphere(name, radius=size[0], **look)
                elif kind == "cylinder":
                    draw.add_cylinder(name, radius=size[0], height=2 * size[1], **look)

    def _add_zone(self, path: str, zone: Zone) -> None:
        draw = self._server.scene
        colour = _KEEP_IN if zone.keep == "in" else _KEEP_OUT
        # double-sided: the camera may be inside a zone to keep in
        look: dict[str, Any] = {"color": colour, "opacity": 0.14, "side": "double",
                                "cast_shadow": False, "receive_shadow": False}  # fmt: skip
        if zone.shape == "sphere":
            draw.add_icosphere(path, radius=zone.size[0], position=np.array(zone.at), **look)
            return
        size: tuple[float, ...] = zone.size
        turn = np.array(zone.turn).reshape(3, 3)
        if zone.shape == "plane":
            size, turn = (2.4, 2.4, 0.002), _towards(np.array(zone.size))
        where: dict[str, Any] = {"position": zone.at, "wxyz": quaternion_from_matrix(turn)}
        draw.add_box(path, dimensions=np.array(size), **look, **where)
        edge: dict[str, Any] = {"color": colour, "wireframe": True, "cast_shadow": False}
        draw.add_box(f"{path}/edges", dimensions=np.array(size), **edge)


def _near(one: Sequence[float], other: Sequence[float]) -> bool:
    return all(abs(a - b) < _SAME for a, b in zip(one, other, strict=True))


def _floats(element: ET.Element, name: str) -> list[float]:
    return [float(word) for word in element.get(name, "").split()]


def _placed(element: ET.Element) -> dict[str, Any]:
    """Pose of an MJCF element, in viser's arguments."""
    position, quaternion = _floats(element, "pos"), _floats(element, "quat")
    return {"position": position or (0.0, 0.0, 0.0), "wxyz": quaternion or (1.0, 0.0, 0.0, 0.0)}


def _about_z(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _towards(axis: Array) -> Array:
    """A rotation whose z axis points along `axis`. Shape (3, 3)."""
    z = axis / np.linalg.norm(axis)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])
