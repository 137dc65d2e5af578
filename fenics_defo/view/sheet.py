"""One picture from many drawings, with titles and a legend."""

import math
from collections.abc import Sequence

import numpy as np

from fenics_defo.view.offscreen import Image, ImageDraw, ImageFont
from fenics_defo.view.panels import palette

_GAP = 24  # pixels between drawings and around them
_TITLE, _FOOT = 46, 34  # heights of the line above a drawing and of one of the legend
_BAR, _SPACE = (200, 14), 12
_TITLE_SIZE, _FOOT_SIZE = 25, 20
_INK, _SOFT = "#1c2126", "#5c666f"
_LANDSCAPE = 1.45


def compose(
    drawings: Sequence[Image.Image],
    titles: Sequence[str],
    *,
    note: str,
    columns: int | None = None,
) -> Image.Image:
    """Put drawings of one size in rows, each under its title, above a legend.

    Args:
        drawings: one or more.
        titles: as many.
        note: what the reader should know, at the lower right.
        columns: drawings in a row; by default what comes nearest to a landscape page.
    """
    width, height = drawings[0].width + _GAP, drawings[0].height + _TITLE + _GAP
    columns = min(columns or _good_columns(len(drawings), width / height), len(drawings))
    rows = math.ceil(len(drawings) / columns)
    used = columns * width - _GAP
    legend = _legend(note, used)
    inner = max(used, legend.width)
    size = (inner + 2 * _GAP, rows * height + legend.height + 2 * _GAP)
    sheet = Image.new("RGB", size, "white")
    pen = ImageDraw.Draw(sheet)
    margin = _GAP + (inner - used) // 2
    for index, (drawing, title) in enumerate(zip(drawings, titles, strict=True)):
        left = margin + index % columns * width
        top = _GAP + index // columns * height
        font = _fitting(title, _TITLE_SIZE, drawing.width)
        middle = (left + drawing.width // 2, top + _TITLE // 2)
        pen.text(middle, title, fill=_INK, font=font, anchor="mm")
        sheet.paste(drawing, (left, top + _TITLE))
    sheet.paste(legend, (_GAP, _GAP + rows * height))
    return sheet


def _good_columns(count: int, ratio: float) -> int:
    """Return the number of columns that gives a landscape page with few gaps."""

    def badness(columns: int) -> float:
        rows = math.ceil(count / columns)
        return abs(math.log(columns * ratio / rows / _LANDSCAPE)) + 1.5 * (
            columns * rows / count - 1.0
        )

    return min(range(1, count + 1), key=badness)


def _legend(note: str, width: int) -> Image.Image:
    """Draw the colour bar with ``note`` to its right, or below where ``width`` is too small."""
    font = _font(_FOOT_SIZE)
    bar = Image.fromarray(np.tile(palette()[None, :, :3], (_BAR[1], 1, 1))).resize(_BAR)
    words = "largest displacement of the mode"
    start = int(font.getlength("0")) + _SPACE
    end = start + _BAR[0] + _SPACE + math.ceil(font.getlength(words))
    length = math.ceil(font.getlength(note))
    below = bool(note) and end + 4 * _SPACE + length > width
    size = (max(width, end, length), _FOOT * (2 if below else 1))
    legend = Image.new("RGB", size, "white")
    pen = ImageDraw.Draw(legend)
    middle = _FOOT // 2
    pen.text((0, middle), "0", fill=_SOFT, font=font, anchor="lm")
    legend.paste(bar, (start, middle - _BAR[1] // 2))
    pen.text((start + _BAR[0] + _SPACE, middle), words, fill=_SOFT, font=font, anchor="lm")
    if below:
        pen.text((0, _FOOT + middle), note, fill=_SOFT, font=font, anchor="lm")
    else:
        pen.text((width, middle), note, fill=_SOFT, font=font, anchor="rm")
    return legend


def _fitting(text: str, size: int, width: int) -> ImageFont.FreeTypeFont:
    """Return the font at ``size`` or as much smaller as ``text`` needs."""
    font = _font(size)
    length = font.getlength(text)
    return font if length <= width else _font(max(10, int(size * width / length)))


def _font(size: int) -> ImageFont.FreeTypeFont:
    font = ImageFont.load_default(size)
    assert isinstance(font, ImageFont.FreeTypeFont)  # every Pillow wheel has FreeType
    return font
