"""Colours of branches that people with colour blindness can tell apart."""

import colorsys

Colour = tuple[float, float, float]

# Okabe and Ito, "Color Universal Design", 2008; dark grey and dark red for their black, which is the pictures' own, and
# their yellow, which is too light for lines on white.
_EIGHT = ("0072b2", "d55e00", "009e73", "cc79a7", "e69f00", "56b4e9", "444444", "7a0019")
_DARKER = 0.5


def colours(count: int) -> tuple[Colour, ...]:
    """``count`` colours, red, green and blue from 0 to 1: eight hues, then the same darker, then round the circle."""
    eight = [tuple(part / 255.0 for part in bytes.fromhex(code)) for code in _EIGHT]
    many = [(share * r, share * g, share * b) for share in (1.0, _DARKER) for r, g, b in eight]
    if count <= len(many):
        return tuple(many[:count])
    # Neighbours differ in lightness, and all are dark enough for letters.
    return tuple(colorsys.hls_to_rgb(k / count, (0.3, 0.5)[k % 2], 0.8) for k in range(count))
