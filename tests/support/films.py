"""Films read by programs that are not ours, and a chain that moves for them."""

import itertools
import re
import subprocess

import imageio_ffmpeg
import numpy as np
from PIL import Image

from nrchain.scene.loading import load_scene
from nrchain.trajectory.trajectory import Trajectory


def read_mp4(path):
    """Frames (F, height, width, 3) and rate of an MP4, by ffmpeg."""
    ffmpeg = imageio_ffmpeg.get_ffmpeg_exe()
    command = [ffmpeg, "-i", str(path), "-f", "image2pipe", "-vcodec", "ppm", "-"]
    read = subprocess.run(command, capture_output=True, check=True)
    width, height = map(int, read.stdout.split(maxsplit=3)[1:3])
    head = len(b"P6\n%d %d\n255\n" % (width, height))
    images = np.frombuffer(read.stdout, np.uint8).reshape(-1, head + 3 * width * height)
    rate = re.search(r"([\d.]+) fps", read.stderr.decode())
    return images[:, head:].reshape(-1, height, width, 3), float(rate[1])


def read_gif(path):
    """Frames (F, height, width, 3) of a GIF, and how long it lasts in ms, by Pillow."""
    frames, lasted = [], 0
    with Image.open(path) as film:
        for number in range(film.n_frames):
            film.seek(number)
            lasted += film.info["duration"]
            frames.append(np.asarray(film.convert("RGB")))
    return np.array(frames), lasted


def assert_film(frames, count):
    """So many frames, each different from the one before, none of them blank."""
    assert len(frames) == count
    for image in frames:
        assert 0.005 < np.mean(image.min(axis=-1) < 200) < 0.5
    for before, after in itertools.pairwise(frames):
        assert np.mean(np.abs(before.astype(int) - after).max(axis=-1) > 40) > 3e-4


def growing(snapshots=6, particles=6, **changes):
    """A chain along x that grows an arc in y, while its frames turn about e₁."""
    u = np.linspace(0.0, 1.0, particles)
    length = 10.0 * (particles - 1)
    grown = np.linspace(0.0, 0.3 * length, snapshots)[:, None]
    positions = np.stack(np.broadcast_arrays(length * u, grown * np.sin(np.pi * u), 0.0), axis=-1)
    frames = np.zeros((snapshots, particles, 3, 3))
    turned = np.linspace(0.0, 2.0, snapshots)[:, None]
    frames[..., 0, 0] = 1.0
    frames[..., 1, 1] = frames[..., 2, 2] = np.cos(turned)
    frames[..., 1, 2], frames[..., 2, 1] = np.sin(turned), -np.sin(turned)
    base = {"chain.particles": particles, "run.end": 10.0, "slip.2s": 100.0}
    scene = load_scene(base, **changes)
    return Trajectory(np.linspace(0.0, 10.0, snapshots), positions, frames, scene)
