"""Colours of branches that people with colour blindness can tell apart."""

import colorsys

Colour = tuple[float, float, float]

# Okabe and Ito, "Color Universal Design", 2008; dark grey and dark red for their black, which is the pictures' own, and
# their yellow, which is too light for lines on white.
_EIGHT = ("0072b2", "d55e00", "009e73", "cc79a7", "e69f00", "56b4e9", "444444", "7a0019")
_DARKER = 0.5
# On black: light grey and their yellow in the places of those two, and the same eight lighter.
_ON_BLACK = {"444444": "c0c0c0", "7a0019": "f0e442"}


def colours(count: int, dark: bool = False) -> tuple[Colour, ...]:
    """``count`` colours, red, green and blue from 0 to 1: eight hues, then the same darker, then round the circle.

    ``dark``: for a black background; instead of darker the second eight are lighter.
    """
    codes = [_ON_BLACK.get(code, code) if dark else code for code in _EIGHT]
    eight = [tuple(part / 255.0 for part in bytes.fromhex(code)) for code in codes]
    white = 1.0 - _DARKER if dark else 0.0
    many = [(r, g, b) for r, g, b in eight]
    many += [(white + _DARKER * r, white + _DARKER * g, white + _DARKER * b) for r, g, b in eight]
    if count <= len(many):
        return tuple(many[:count])
    # Neighbours differ in lightness, and all are dark enough for letters; on black, light enough to be seen.
    lightness = (0.5, 0.7) if dark else (0.3, 0.5)
    return tuple(colorsys.hls_to_rgb(k / count, lightness[k % 2], 0.8) for k in range(count))
