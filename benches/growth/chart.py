"""Curves in logarithmic axes as SVG, readable on light and on dark pages."""

from html import escape
from math import ceil, floor, log10

# Colours that stand out on white and on black; curves also differ by their marks.
COLOURS = ["#2f81f7", "#d9730d", "#2da44e", "#bf4b8a", "#8a63d2", "#9a6700"]
STYLE = """
  text { font: 12px sans-serif; fill: #1f2328 }
  .title { font-weight: bold; font-size: 13px }
  .grid { stroke: #1f2328; stroke-opacity: 0.15 }
  .frame { fill: none; stroke: #1f2328; stroke-opacity: 0.5 }
  .guide { stroke: #1f2328; stroke-opacity: 0.45; stroke-dasharray: 2 4 }
  @media (prefers-color-scheme: dark) {
    text { fill: #e6edf3 }
    .grid, .frame, .guide { stroke: #e6edf3 }
  }
"""
WIDTH, HEIGHT, LEFT, TOP = 330, 230, 56, 34


class Panel:
    """A chart: curves of points (x, y), all positive."""

    def __init__(self, title, x_label, y_label, curves):
        self.title, self.x_label, self.y_label = title, x_label, y_label
        self.curves = [(name, points) for name, points in curves if points]

    def svg(self):
        xs = [x for _, points in self.curves for x, _ in points]
        ys = [y for _, points in self.curves for _, y in points]
        low = [log10(min(xs)) - 0.05, floor(log10(min(ys)))]
        high = [log10(max(xs)) + 0.05, ceil(log10(max(ys)))]

        def place(x, y):
            across = (log10(x) - low[0]) / (high[0] - low[0])
            up = (log10(y) - low[1]) / max(high[1] - low[1], 1)
            return LEFT + WIDTH * across, TOP + HEIGHT * (1 - up)

        parts = [f'<text class="title" x="{LEFT}" y="{TOP - 14}">{escape(self.title)}</text>']
        for power in range(low[1], high[1] + 1):
            y = place(10 ** low[0], 10.0**power)[1]
            parts.append(f'<line class="grid" x1="{LEFT}" y1="{y:.1f}" x2="{LEFT + WIDTH}" y2="{y:.1f}"/>')
            parts.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{number(10.0**power)}</text>')
        for x in ticks(min(xs), max(xs)):
            at = place(x, 10.0 ** low[1])[0]
            parts.append(f'<line class="grid" x1="{at:.1f}" y1="{TOP}" x2="{at:.1f}" y2="{TOP + HEIGHT}"/>')
            parts.append(f'<text x="{at:.1f}" y="{TOP + HEIGHT + 16}" text-anchor="middle">{number(x)}</text>')
        parts.append(f'<rect class="frame" x="{LEFT}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}"/>')
        parts.append(self.guide(place, min(xs), max(xs), min(ys)))
        middle = TOP + HEIGHT / 2
        parts.append(f'<text x="{LEFT + WIDTH / 2}" y="{TOP + HEIGHT + 34}" text-anchor="middle">{escape(self.x_label)}</text>')
        parts.append(f'<text transform="translate(12 {middle}) rotate(-90)" text-anchor="middle">{escape(self.y_label)}</text>')
        for index, (name, points) in enumerate(self.curves):
            parts.append(curve(name, [place(*point) for point in points], index))
        return "\n".join(parts)

    def guide(self, place, left, right, bottom):
        """A dotted line that grows as x does, to compare with."""
        (x1, y1), (x2, y2) = place(left, bottom), place(right, bottom * right / left)
        if y2 < TOP:
            x2, y2 = x1 + (x2 - x1) * (y1 - TOP) / (y1 - y2), TOP
        return f'<line class="guide" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"><title>in proportion</title></line>'


def curve(name, places, index):
    """A curve with its entry in the legend."""
    colour, y = COLOURS[index % len(COLOURS)], TOP + HEIGHT + 54 + 17 * index
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    marks = "".join(mark(x, y, index, colour) for x, y in places)
    return (
        f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>{marks}'
        f'<line x1="{LEFT}" y1="{y - 4}" x2="{LEFT + 22}" y2="{y - 4}" stroke="{colour}" stroke-width="2"/>'
        f'{mark(LEFT + 11, y - 4, index, colour)}<text x="{LEFT + 30}" y="{y}">{escape(name)}</text>'
    )


def mark(x, y, index, colour):
    """A disk, a square or a diamond."""
    if index % 3 == 0:
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{colour}"/>'
    turn = f' transform="rotate(45 {x:.1f} {y:.1f})"' if index % 3 == 2 else ""
    return f'<rect x="{x - 3:.1f}" y="{y - 3:.1f}" width="6" height="6" fill="{colour}"{turn}/>'


def ticks(low, high):
    """1, 3, 10, 30 … within the range."""
    steps = (factor * 10**power for power in range(floor(log10(low)), ceil(log10(high)) + 1) for factor in (1, 3))
    return [step for step in steps if low * 0.89 <= step <= high * 1.12]


def number(value):
    for unit, letter in ((1e6, "M"), (1e3, "k")):
        if value >= unit:
            return f"{value / unit:g}{letter}"
    return f"{value:g}"


def page(panels):
    """The panels side by side."""
    across = WIDTH + LEFT + 24
    most = max(len(panel.curves) for panel in panels)
    width, height = across * len(panels), TOP + HEIGHT + 50 + 17 * most
    drawn = (f'<g transform="translate({k * across} 0)">\n{panel.svg()}\n</g>' for k, panel in enumerate(panels))
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">'
    return "\n".join([head, f"<style>{STYLE}</style>", *drawn, "</svg>", ""])
