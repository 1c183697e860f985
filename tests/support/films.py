"""Films for tests: moving pictures; files that are complete, cut off or continued; their packets."""

from __future__ import annotations

import av
import numpy as np

from motes._film import growing
from motes._film.movie import Movie, writer_of
from motes._picture.frame import Frame


def moving(count, *, height=48, width=64, first=0):
    """Return frames of which no two are equal: a gradient with points that move across it."""
    for k in range(first, first + count):
        random = np.random.default_rng(5)
        at = (random.random((60, 2)) + k * random.normal(0, 0.02, (60, 2))) % 1
        pixels = np.zeros((height, width, 3), np.uint8)
        pixels[:] = np.linspace(20, 120, height, dtype=np.uint8)[:, None, None]
        pixels[(at[:, 0] * height).astype(int), (at[:, 1] * width).astype(int)] = (250, 200, 90)
        yield Frame(k, k / 24, pixels)


def packets(path):
    """Return all packets of a film, and the frames that it shows, in the order of time."""
    with av.open(str(path)) as film:
        stream = film.streams.video[0]
        found = [
            (packet.pts, packet.is_keyframe, bytes(packet)) for packet in film.demux(stream) if packet.size
        ]
        return found, bytes(stream.codec_context.extradata), stream.average_rate


def decoded(path):
    """Return the pictures of a film, as floats of 0..255."""
    with av.open(str(path)) as film:
        return [frame.to_ndarray(format="rgb24").astype(float) for frame in film.decode(video=0)]


def shown(path):
    """Return how many frames a player shows, and the time of each in seconds."""
    with av.open(str(path)) as film:
        return [frame.time for frame in film.decode(video=0)]


def partial(path):
    return growing.partial_path(path)


def cut_off(path, count, *, secure, fps=24, size=(48, 64), more=3):
    """Write a film, secured after each number of frames in `secure`, and leave it like a killed process."""
    movie = Movie(path, fps=fps)
    for frame in moving(count, height=size[0], width=size[1]):
        movie.write(frame)
        if movie.written in secure:
            assert writer_of(movie).secure() == movie.written
    writer_of(movie).abandon()
    writer_of(movie)._thread.join()
    assert len(packets(partial(path))[0]) == count


def go_on(path, at, count, *, secure=(), fps=24, size=(48, 64), close=True):
    movie = Movie(path, fps=fps)
    writer_of(movie).continue_at(at)
    for frame in moving(count - at, height=size[0], width=size[1], first=at):
        movie.write(frame)
        if movie.written in secure:
            writer_of(movie).secure()
    movie.close()
    return movie


def whole(path, count, *, secure=(), fps=24, size=(48, 64)):
    with Movie(path, fps=fps) as movie:
        for frame in moving(count, height=size[0], width=size[1]):
            movie.write(frame)
            if movie.written in secure:
                writer_of(movie).secure()
    return packets(path)
