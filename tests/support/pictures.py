"""Checks of pictures."""


def stick_lines(axes: object) -> list[object]:
    """Lines with joints marked: the stick figures, and not the frames."""
    return [line for line in axes.lines if line.get_marker() == "o"]


def is_png(data: bytes) -> bool:
    """Whether it is a PNG, from its signature to its last chunk."""
    return data.startswith(b"\x89PNG\r\n\x1a\n") and data[-8:-4] == b"IEND"
