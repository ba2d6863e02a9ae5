# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Small line charts as SVG, for documents: a few series over one axis."""
from xml.sax.saxutils import escape

WIDTH, HEIGHT = 480, 280
LEFT, RIGHT, TOP, BOTTOM = 52, 96, 34, 44
COLOURS = ("#1f6f8b", "#c8553d", "#588157", "#6d597a", "#b08900")


def nice_step(span, steps=5):
    """The smallest of 1, 2, 5 times a power of ten that divides a span into at most so many steps."""
    power = 1e-9
    while True:
        for factor in (1, 2, 5):
            if span <= factor * power * steps * (1 + 1e-9):
                return factor * power
        power *= 10


def ticks(largest):
    """From 0 to the first tick that is not below the largest value."""
    step = nice_step(largest if largest > 0 else 1)
    count = 0
    while count * step < largest * (1 - 1e-9):
        count += 1
    return [round(i * step, 9) for i in range(max(count, 1) + 1)]


def text(x, y, words, anchor="middle", size=11, more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}"{more}>{escape(words)}</text>'


def line_chart(title, x_label, y_label, series):
    """series: {name: [(x, y), ...]}; both axes begin at 0. Raises ValueError if there is nothing to draw."""
    points = [p for line in series.values() for p in line]
    if not points:
        raise ValueError(f"chart '{title}' has no points")
    x_ticks, y_ticks = ticks(max(x for x, _ in points)), ticks(max(y for _, y in points))
    plot_w, plot_h = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM

    def place(x, y):
        return LEFT + plot_w * x / x_ticks[-1], TOP + plot_h * (1 - y / y_ticks[-1])

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>', text(LEFT, 18, title, "start", 13)]
    for y in y_ticks:
        _, at = place(0, y)
        out.append(f'<path d="M{LEFT} {at:.1f}H{LEFT + plot_w}" stroke="#dddddd"/>')
        out.append(text(LEFT - 6, at + 4, f"{y:g}", "end"))
    for x in x_ticks:
        at, _ = place(x, 0)
        out.append(text(at, TOP + plot_h + 16, f"{x:g}"))
    out.append(text(LEFT + plot_w / 2, HEIGHT - 8, x_label))
    out.append(text(14, TOP + plot_h / 2, y_label, more=f' transform="rotate(-90 14 {TOP + plot_h / 2:.1f})"'))
    out += lines(series, place)
    return "\n".join(out + ["</svg>"]) + "\n"


def lines(series, place):
    out, label_ys = [], []
    for number, (name, line) in enumerate(series.items()):
        colour = COLOURS[number % len(COLOURS)]
        places = [place(x, y) for x, y in sorted(line)]
        path = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
        out.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
        out += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>' for x, y in places]
        label_y = places[-1][1] + 4
        while any(abs(label_y - other) < 13 for other in label_ys):  # names must not lie on each other
            label_y += 1
        label_ys.append(label_y)
        out.append(text(places[-1][0] + 8, label_y, name, "start", more=f' fill="{colour}"'))
    return out
