"""Random layouts with random requests, and what the cheapest way costs by NetworkX: a JSON line for each.

    route_costs.py COUNT SEED

The rules (LIF 1.0 8, 10) are written down a second time here: a graph whose vertices are edges of the layout, each
once per number of stops that lie behind it, and Dijkstra's algorithm by others.
"""
import cmath
import json
import math
import random
import sys

import networkx

TURNINGS = ["BOTH", "BOTH", "NONE", "NONE", "CW", "CCW"]
QUARTERS = [0.0, math.pi / 2, -math.pi / 2, 3.14159]


def random_layout(rng):
    count = rng.randint(3, 8)
    spots = rng.sample([(x, y) for x in range(5) for y in range(5)], count)
    nodes = []
    for i, (x, y) in enumerate(spots):
        kinds = [{"vehicleTypeId": "T"}] if rng.random() < 0.95 else [{"vehicleTypeId": "U"}]
        if rng.random() < 0.1:
            kinds[0]["theta"] = rng.choice(QUARTERS)
        nodes.append({"nodeId": f"n{i}", "mapId": "m" if rng.random() < 0.9 else "up",
                      "nodePosition": {"x": x, "y": y}, "vehicleTypeNodeProperties": kinds})
    edges = [random_edge(rng, i, nodes) for i in range(rng.randint(count, 3 * count))]
    return {"layouts": [{"layoutId": "l", "layoutVersion": "1", "nodes": nodes, "edges": edges}]}


def random_edge(rng, index, nodes):
    start, end = rng.sample(nodes, 2)
    kind = {"vehicleTypeId": "T" if rng.random() < 0.95 else "U", "rotationAllowed": rng.random() < 0.2}
    if rng.random() < 0.8:
        kind["vehicleOrientation"] = rng.choice(QUARTERS)
    if rng.random() < 0.5:
        kind["orientationType"] = rng.choice(["TANGENTIAL", "GLOBAL"])
    for name in ("rotationAtStartNodeAllowed", "rotationAtEndNodeAllowed"):
        if rng.random() < 0.6:
            kind[name] = rng.choice(TURNINGS)
    if rng.random() < 0.4:
        kind["maxSpeed"] = rng.choice([0.5, 1, 2])
    if rng.random() < 0.2:
        kind["loadRestriction"] = {"loaded": rng.random() < 0.7, "unloaded": rng.random() < 0.7}
        if rng.random() < 0.5:
            kind["loadRestriction"]["loadSetNames"] = rng.choice([["A"], ["B"], ["A", "B"], []])
    if rng.random() < 0.2:
        kind["trajectory"] = random_trajectory(rng, start["nodePosition"], end["nodePosition"])
    return {"edgeId": f"e{index}", "startNodeId": start["nodeId"], "endNodeId": end["nodeId"],
            "vehicleTypeEdgeProperties": [kind]}


def random_trajectory(rng, start, end):
    middle = {"x": rng.uniform(0, 5), "y": rng.uniform(0, 5)}
    degree = rng.choice([1, 2])
    knots = [0, 0, 0.5, 1, 1] if degree == 1 else [0, 0, 0, 1, 1, 1]
    return {"degree": degree, "knotVector": knots, "controlPoints": [dict(start), middle, dict(end)]}


def point(value):
    return complex(value["x"], value["y"])


def curve_length(trajectory):
    a, b, c = map(point, trajectory["controlPoints"])
    if trajectory["degree"] == 1:
        return abs(b - a) + abs(c - b)
    steps = 200  # Simpson's rule over the speed of a Bézier curve
    total = 0.0
    for i in range(steps + 1):
        t = i / steps
        weight = 1 if i in (0, steps) else 4 if i % 2 else 2
        total += weight * abs(2 * (1 - t) * (b - a) + 2 * t * (c - b))
    return total / steps / 3


class Graph:
    def __init__(self, layout, request):
        self.request = request
        self.nodes = {n["nodeId"]: n for n in layout["layouts"][0]["nodes"]}
        self.edges = {}
        for edge in layout["layouts"][0]["edges"]:
            kind = next((k for k in edge["vehicleTypeEdgeProperties"] if k["vehicleTypeId"] == "T"), None)
            ends = [self.kind(edge["startNodeId"]), self.kind(edge["endNodeId"])]
            if kind and all(e is not None for e in ends) and self.admits(kind.get("loadRestriction")):
                self.edges[edge["edgeId"]] = self.describe(edge, kind)

    def kind(self, node):
        return next((k for k in self.nodes[node]["vehicleTypeNodeProperties"] if k["vehicleTypeId"] == "T"), None)

    def admits(self, load):
        if load is None:
            return True
        if not self.request["loaded"]:
            return load["unloaded"]
        names = load.get("loadSetNames") or []
        return load["loaded"] and (not names or self.request["loadSet"] in names)

    def describe(self, edge, kind):
        start, end = self.nodes[edge["startNodeId"]], self.nodes[edge["endNodeId"]]
        a, b = point(start["nodePosition"]), point(end["nodePosition"])
        same_map = start["mapId"] == end["mapId"]
        length = abs(b - a)
        first, last = (b - a, b - a) if same_map else (None, None)
        if "trajectory" in kind:
            p, q, r = map(point, kind["trajectory"]["controlPoints"])
            first, last, length = q - p, r - q, curve_length(kind["trajectory"])
        orientation = kind.get("vehicleOrientation")

        def heading(direction):
            if orientation is None:
                return None
            if kind.get("orientationType", "TANGENTIAL") == "GLOBAL":
                return cmath.rect(1, orientation)
            return None if direction is None else direction / abs(direction) * cmath.rect(1, orientation)

        theta = self.kind(edge["endNodeId"]).get("theta")
        cost = length if same_map else 0.0
        if self.request["time"]:
            cost /= min(kind.get("maxSpeed", 1.5), 1.5)
        return {"start": edge["startNodeId"], "end": edge["endNodeId"], "cost": cost,
                "in": heading(first), "out": heading(last), "theta": None if theta is None else cmath.rect(1, theta),
                "rotates": kind["rotationAllowed"], "at_start": kind.get("rotationAtStartNodeAllowed", "BOTH"),
                "at_end": kind.get("rotationAtEndNodeAllowed", "BOTH")}

    @staticmethod
    def alike(a, b):
        return a is None or b is None or abs(cmath.phase(a / b)) < math.radians(2)

    def may_end(self, e):
        return e["at_end"] != "NONE" or self.alike(e["out"], e["theta"])

    def may_follow(self, e, f):
        allowed = {"BOTH": {"CW", "CCW"}, "NONE": set(), "CW": {"CW"}, "CCW": {"CCW"}}
        if allowed[e["at_end"]] & allowed[f["at_start"]]:
            return True
        stands = e["out"] if e["theta"] is None else e["theta"]
        return self.alike(e["out"], e["theta"]) and (f["rotates"] or self.alike(stands, f["in"]))

    def cost(self):
        stops = self.request["stops"]

        def passed(done, node):
            while done < len(stops) and node in stops[done]:
                done += 1
            return done

        if self.kind(self.request["from"]) is None:
            return None
        graph = networkx.DiGraph()
        begin = passed(0, self.request["from"])
        graph.add_node("end")
        graph.add_node("begin")
        if begin == len(stops):
            return 0.0
        usable = {name: e for name, e in self.edges.items() if self.may_end(e)}
        for name, e in usable.items():
            if e["start"] == self.request["from"]:
                graph.add_edge("begin", (name, begin), weight=e["cost"])
            following = [(n, f) for n, f in usable.items() if f["start"] == e["end"] and self.may_follow(e, f)]
            for done in range(begin, len(stops)):
                after = passed(done, e["end"])
                if after == len(stops):
                    graph.add_edge((name, done), "end", weight=0.0)
                    continue
                for other, f in following:
                    graph.add_edge((name, done), (other, after), weight=f["cost"])
        try:
            return networkx.dijkstra_path_length(graph, "begin", "end")
        except networkx.NetworkXNoPath:
            return None


def main():
    count, seed = int(sys.argv[1]), int(sys.argv[2])
    rng = random.Random(seed)
    for _ in range(count):
        layout = random_layout(rng)
        names = [n["nodeId"] for n in layout["layouts"][0]["nodes"]]
        stops = [rng.sample(names, rng.choice([1, 1, 2])) for _ in range(rng.choice([1, 1, 1, 2, 3]))]
        request = {"from": rng.choice(names), "stops": stops, "loaded": rng.random() < 0.4,
                   "loadSet": rng.choice(["", "A", "B"]), "time": rng.random() < 0.3}
        print(json.dumps({"layout": json.dumps(layout), "request": request, "cost": Graph(layout, request).cost()}))


main()
