"""One chain on a stage of PyVista: its meshes follow the snapshots; the camera stays or follows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

from nrchain.scene.derived import modes_text
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.shown import FRAME_LENGTH
from nrchain.view.space.camera import ANGLE, Camera, View, Window, fit
from nrchain.view.space.colouring import Colouring
from nrchain.view.space.shapes import HEAD, Template, Tube, arrow, dot, sphere
from nrchain.view.space.tracers import Tracers
from nrchain.view.units import time_name

LIGHT, DARK, NEUTRAL, INK = "#d4e6f4", "#2a6499", "#b9bec4", "#262626"
ARROWS = ("#111111", "#d55e00")
"""Colours of e₁ and e₂."""
RIM = 0.25
"""By which the heads of e₁ stand out of the centreline, in radii of the spheres."""
TUBES = 0.3, 0.55
"""Radii of the centreline, in radii of the spheres: plain, and with the colours of links."""
TRACER, TRAIL = "#4d4d4d", "#9a9a9a"
"""Colours of tracers and of the paths behind them."""
TRACER_RADIUS = 0.22
"""In radii of the spheres."""
ONE_SIGN, TWO_SIGNS = "viridis", "coolwarm"
"""Maps of colours for quantities of one sign and of both."""
WORDS_ROOM, BAR_ROOM = 0.1, 0.16
"""Fractions of the height of a picture for words above, and for the bar of colours below."""
SMOOTHED = 4
"""Samples of a pixel, which smooth the edges."""


@dataclass(frozen=True)
class Look:
    """What a picture shows, and from where.

    Attributes
    ----------
    size
        Width and height, in pixels.
    view
        See :func:`~nrchain.view.space.camera.direction`.
    follow
        Whether the camera moves with the middle of the chain.
    frames
        Whether e₁ (dark) and e₂ (orange) of every sphere are drawn.
    tube
        Whether the centreline is drawn.
    """

    size: tuple[int, int]
    view: View = "slant"
    follow: bool = False
    frames: bool = True
    tube: bool = True


class Stage:
    """The chain of a trajectory, of which :meth:`show` draws one snapshot after the other.

    ``positions`` (F, N, 3) are those of the trajectory, in radii, with the chain unwrapped. Paths
    of tracers are in the units of the trajectory.
    """

    def __init__(
        self,
        pyvista: Any,
        trajectory: Trajectory,
        positions: np.ndarray,
        look: Look,
        colouring: Colouring | None,
        tracers: Tracers | None,
        off_screen: bool,
    ) -> None:
        self._pyvista, self._look, self._colouring = pyvista, look, colouring
        self._time, self._frames, self._positions = trajectory.time, trajectory.frames, positions
        chain = trajectory.scene.chain
        self._font = str(Path(matplotlib.get_data_path(), "fonts", "ttf", "DejaVuSans.ttf"))
        self._radius, self._unit = chain.radius, time_name(trajectory.scene)
        # a theme of its own: that of the process is not read
        self.plotter = pyvista.Plotter(
            off_screen=off_screen,
            window_size=list(look.size),
            theme=pyvista.themes.DocumentTheme(),
            notebook=False,
        )
        self.plotter.enable_anti_aliasing("msaa", multi_samples=SMOOTHED)
        self._placed: list[tuple[Any, Template]] = []
        self._draw_spheres(chain.particles)
        length = max(2.0, FRAME_LENGTH * chain.spacing / chain.radius)
        tube = TUBES[colouring is not None and colouring.of == "links"]
        thickness = ((tube + RIM) / HEAD, 0.035 * length)
        if look.frames:
            for axis, colour in enumerate(ARROWS):
                # e₁ lies in the tube
                template = arrow(pyvista, axis, length, thickness[axis])
                self._add(self._copies(template), color=colour)
        self._tube = Tube(chain.particles, tube) if look.tube and chain.particles > 1 else None
        if self._tube is not None:
            self._draw_tube(self._tube)
        self._paths = None if tracers is None else tracers.paths / chain.radius
        if tracers is not None:
            self._draw_tracers(tracers)
        if colouring is not None:
            self._draw_bar(colouring.label)
        self._write(trajectory, "" if tracers is None else tracers.words)
        self._camera = self._fit_camera(length if look.frames else 1.0)
        self.show(len(self._time) - 1)

    def show(self, index: int) -> None:
        """Show a snapshot of the trajectory from the place of the camera."""
        self._set(index)
        place = self._camera
        if self._look.follow:
            place = place.moved(self._positions[index].mean(axis=0))
        camera = self.plotter.camera
        camera.position, camera.focal_point = tuple(place.position), tuple(place.focus)
        camera.up, camera.view_angle = tuple(place.up), ANGLE
        self.plotter.renderer.ResetCameraClippingRange()

    def _set(self, index: int) -> None:
        """Give all meshes the poses and colours of a snapshot."""
        positions, frames = self._positions[index], self._frames[index]
        for mesh, template in self._placed:
            _move(mesh, template.place(positions, frames))
        if self._tube is not None:
            _move(self._tube_mesh, self._tube.place(positions))
        if self._paths is not None:
            paths = self._paths[index]
            self._trails.points = paths.reshape(-1, 3)
            _move(self._heads, self._head.place(paths[:, -1], self._upright))
        if self._colouring is not None:
            values = self._colouring.values[index]
            if self._colouring.of == "spheres":
                self._spheres.point_data["values"] = np.repeat(values, self._each)
            if self._tube is not None:
                self._tube_mesh.point_data["values"] = self._tube.spread(values)
        self._clock.input = f"t = {self._time[index]:.4g} {self._unit}".rstrip()

    def image(self) -> np.ndarray:
        """What the camera sees: bytes (height, width, 3)."""
        self.plotter.render()
        return np.asarray(self.plotter.screenshot(return_img=True))[..., :3]

    def open_window(self) -> None:
        """Open a window with a slider over the snapshots; return when it is closed."""
        last = len(self._time) - 1
        if last:
            self.plotter.add_slider_widget(
                lambda place: self._turn_to(round(place)),
                [0, last],
                value=last,
                title="snapshot",
                color=INK,
                fmt="%.0f",
                pointa=(0.75, 0.08),
                pointb=(0.97, 0.08),
                title_height=0.02,
                slider_width=0.015,
                tube_width=0.003,
            )
        self.plotter.show(auto_close=False)

    def _turn_to(self, index: int) -> None:
        """Show a snapshot, seen from where the user has turned the camera."""
        self._set(index)
        self.plotter.renderer.ResetCameraClippingRange()

    def _copies(self, template: Template) -> Any:
        """A mesh with one copy of a template for every sphere, which follows the snapshots."""
        placed = template.place(self._positions[-1], self._frames[-1])
        mesh = self._mesh(placed, template.copies(self._positions.shape[1]))
        self._placed.append((mesh, template))
        return mesh

    def _mesh(self, placed: tuple[np.ndarray, np.ndarray], faces: np.ndarray) -> Any:
        mesh = self._pyvista.PolyData(placed[0], faces=faces.ravel())
        mesh.point_data["Normals"] = placed[1]
        mesh.point_data.active_normals_name = "Normals"
        return mesh

    def _add(self, mesh: Any, **looks: Any) -> None:
        shine = {"ambient": 0.15, "specular": 0.25, "specular_power": 20, "show_scalar_bar": False}
        actor = self.plotter.add_mesh(mesh, reset_camera=False, render=False, **shine, **looks)
        actor.prop.interpolation = "Phong"
        if "scalars" in looks:
            self._mapper = actor.mapper

    def _draw_spheres(self, count: int) -> None:
        template = sphere(self._pyvista, count)
        self._each = len(template.points)
        mesh = self._copies(template)
        if self._colouring is None:
            # the point of the surface along e₁ and e₂ picks its colour, so that edges are sharp
            along = 0.5 + 0.5 * template.normals[:, :2]
            mesh.active_texture_coordinates = np.tile(along, (count, 1))
            self._add(mesh, texture=self._pyvista.numpy_to_texture(_halves()))
        elif self._colouring.of == "spheres":
            self._spheres = mesh
            mesh.point_data["values"] = np.zeros(mesh.n_points)
            self._add(mesh, scalars="values", **self._map())
        else:
            self._add(mesh, color=NEUTRAL)

    def _draw_tube(self, tube: Tube) -> None:
        self._tube_mesh = mesh = self._mesh(tube.place(self._positions[-1]), tube.faces)
        if self._colouring is None:
            self._add(mesh, color=NEUTRAL)
        else:
            mesh.point_data["values"] = np.zeros(mesh.n_points)
            self._add(mesh, scalars="values", **self._map())

    def _draw_tracers(self, tracers: Tracers) -> None:
        count, places = tracers.paths.shape[1:3]
        paths = tracers.paths[-1] / self._radius
        lines = np.arange(count * places).reshape(count, places)
        lines = np.column_stack([np.full(count, places), lines])
        self._trails = self._pyvista.PolyData(paths.reshape(-1, 3), lines=lines.ravel())
        look = {"color": TRAIL, "line_width": max(1.0, 1.6 * self._scale), "lighting": False}
        self.plotter.add_mesh(self._trails, reset_camera=False, render=False, **look)
        self._head = dot(self._pyvista, TRACER_RADIUS)
        self._upright = np.broadcast_to(np.eye(3), (count, 3, 3))
        placed = self._head.place(paths[:, -1], self._upright)
        self._heads = self._mesh(placed, self._head.copies(count))
        self._add(self._heads, color=TRACER)

    def _map(self) -> dict[str, Any]:
        assert self._colouring is not None
        colours = TWO_SIGNS if self._colouring.signed else ONE_SIGN
        looks = {"clim": self._colouring.limits, "cmap": colours}
        return looks | {"log_scale": self._colouring.logarithmic}

    def _draw_bar(self, label: str) -> None:
        scale = self._scale
        self.plotter.add_scalar_bar(
            # its own title would run into its numbers
            " ",
            mapper=self._mapper,
            color=INK,
            vertical=False,
            n_labels=5,
            fmt="%.3g",
            label_font_size=round(14 * scale),
            title_font_size=round(4 * scale) or 1,
            unconstrained_font_size=True,
            width=0.4,
            height=0.06,
            position_x=0.3,
            position_y=0.015,
        )
        self._add_text(label, (0.5, 0.085), 14 * scale).prop.justification_horizontal = "center"

    @property
    def _scale(self) -> float:
        return self._look.size[1] / 720

    def _write(self, trajectory: Trajectory, remark: str) -> None:
        """Write the title of the scene, its facts and a remark, the time, and the axes of space."""
        scene, scale = trajectory.scene, self._scale
        facts = f"{modes_text(scene.slip)},  {scene.chain.ends} ends,  N = {scene.chain.particles}"
        facts += f",  {remark}" * bool(remark)
        # between dollars, VTK would read mathematics
        title = scene.title.replace("$", r"\$")
        for text, height, size in ((title, 0.955, 14), (facts, 0.92, 12)):
            self._add_text(text, (0.012, height), size * scale)
        self._clock = self._add_text("t", (0.988, 0.955), 14 * scale)
        self._clock.prop.justification_horizontal = "right"
        self.plotter.add_axes(
            color=INK, line_width=2, label_size=(0.35, 0.13), viewport=(0.0, 0.0, 0.13, 0.2)
        )

    def _add_text(self, text: str, place: tuple[float, float], size: float) -> Any:
        """Write a line at a place in fractions of the picture, ``size`` pixels high."""
        added = self.plotter.add_text(
            text,
            position=place,
            viewport=True,
            color=INK,
            font_size=8,
            name=str(place),
            render=False,
        )
        # the letters of VTK have no Greek
        added.prop.set_font_file(self._font)
        added.prop.font_size = max(7, round(size))
        return added

    def _fit_camera(self, margin: float) -> Camera:
        points = self._positions
        if self._look.follow:
            points = points - points.mean(axis=1, keepdims=True)
        width, height = self._look.size
        below = BAR_ROOM if self._colouring is not None else 0.04
        window = Window.within(width / height, 0.02, WORDS_ROOM, below)
        return fit(points, margin, self._look.view, window)


def _move(mesh: Any, placed: tuple[np.ndarray, np.ndarray]) -> None:
    mesh.points = placed[0]
    mesh.point_data["Normals"] = placed[1]


def _halves(fine: int = 512) -> np.ndarray:
    """Colours over (e₂, e₁) of a sphere: its half along e₁ is dark."""
    light, dark = (np.array([int(c[k : k + 2], 16) for k in (1, 3, 5)]) for c in (LIGHT, DARK))
    image = np.empty((fine, fine, 3), np.uint8)
    image[:, : fine // 2], image[:, fine // 2 :] = light, dark
    return image
