"""This module has the page's colours, for plots and pictures."""
import json
import os

with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "page", "palette.json")) as _file:
    PALETTE = json.load(_file)


def spread(colours, count):
    """Returns `count` colours at equal distances along a list of colours."""
    stops = [[int(colour[at : at + 2], 16) for at in (1, 3, 5)] for colour in colours]
    places = [k * (len(stops) - 1) / max(1, count - 1) for k in range(count)]
    pairs = [(stops[int(place)], stops[min(int(place) + 1, len(stops) - 1)], place % 1) for place in places]
    return ["#" + "".join(f"{round(a + share * (b - a)):02x}" for a, b in zip(low, high)) for low, high, share in pairs]
