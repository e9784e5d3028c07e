"""A view as one self-contained HTML file, by viser's serialised scene; needs the extra ``view``."""

from __future__ import annotations

import contextlib
import io
import webbrowser
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import escape

import numpy as np

from ...common.errors import InputError
from ...common.files import write_text
from ..extras import extra
from ..numbers import quaternion

if TYPE_CHECKING:
    from .moving import View

_LAST = 1.0  # s: how long the last pose stays
_STILL = 1e-9  # m and of a turn: what moves less is not written again


def require_viewer() -> Any:
    """The library of views; where it is not installed, a refusal says what to install."""
    return extra("viser", "--view needs the extra view: pip install 'dynident[view]'")


def open_view(view: View) -> str:
    """Open the view in the browser, as a file in a folder for temporary files; its path."""
    page = Path(mkdtemp(prefix="dynident_")) / "view.html"
    write_text(page, html_of(view))
    if not webbrowser.open(page.as_uri()):
        raise InputError(f"--view -: no browser could be opened: open {page} in one")
    return str(page)


def html_of(view: View) -> str:
    """The view as HTML: made by a server on a free port of this machine alone, which says nothing."""
    viser = require_viewer()
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        try:
            page = _played(server, view)
        finally:
            server.stop()
    mark = '<div><span style="color:rgb{}">&#9632;</span> {}</div>'
    rows = "".join(mark.format(colour, escape(text)) for colour, text in view.legend)
    style = "position:fixed;left:8px;bottom:52px;padding:6px 10px;background:#fffd;color:#222;font:12px sans-serif;"
    summary = f"<summary>{escape(view.title)}</summary>"  # a click closes it on a narrow page
    legend = f'<details open style="{style}border-radius:6px">{summary}{rows}</details>'
    return page.replace("</body>", f"{legend}</body>", 1)


def _played(server: Any, view: View) -> str:
    """The scene at the first time, a node for each frame and below it what is fixed to it; then its movement."""
    scene, frames, meshes = server.scene, [], []
    scene.set_up_direction("+z")
    points = np.array([pose.p for poses in view.frames for pose in poses])
    middle, size = 0.5 * (points.min(axis=0) + points.max(axis=0)), float(np.ptp(points, axis=0).max())
    server.initial_camera.look_at = middle
    server.initial_camera.position = middle + (size + 0.3) * np.array([0.75, -0.85, 0.5])
    ground = (0.0, 0.0, view.ground)
    scene.add_grid(*("/ground", 4.0, 4.0), cell_size=0.1, section_size=1.0, shadow_opacity=0.0, position=ground)
    for number, pose in enumerate(view.frames[0]):
        turn = quaternion(pose.R).tolist()
        frames.append(scene.add_frame(f"/{number}", show_axes=False, wxyz=turn, position=pose.origin))
    for shape in view.shapes:
        name = f"/{shape.frame}/{shape.name.replace('/', ', ')}"
        mesh = scene.add_mesh_simple(
            *(name, shape.mesh.vertices.astype(np.float32), shape.mesh.faces.astype(np.uint32)),
            color=shape.colour,
            opacity=None if shape.opacity >= 1.0 else shape.opacity,
            side="double",
            visible=shape.shown is None or bool(shape.shown[0]),
            cast_shadow=False,
            receive_shadow=False,
        )
        meshes += [(mesh, shape.shown)] if shape.shown is not None else []
    if len(view.path) > 1:
        pieces = np.stack([view.path[:-1], view.path[1:]], axis=1).astype(np.float32)
        colours = np.repeat(view.path_colours[:, None], 2, axis=1)
        scene.add_line_segments("/path of the flange", pieces, colours, thickness=3.0, thickness_units="screen")
    serialiser = server.get_scene_serializer()
    for k in range(1, len(view.times)):
        serialiser.insert_sleep(float(view.times[k] - view.times[k - 1]))
        for frame, before, pose in zip(frames, view.frames[k - 1], view.frames[k], strict=True):
            if np.abs(pose.p - before.p).max() > _STILL:
                frame.position = pose.origin
            if np.abs(pose.R - before.R).max() > _STILL:
                frame.wxyz = quaternion(pose.R).tolist()
        for mesh, shown in meshes:
            if shown[k] != shown[k - 1]:
                mesh.visible = bool(shown[k])
    serialiser.insert_sleep(_LAST)
    return str(serialiser.as_html())
