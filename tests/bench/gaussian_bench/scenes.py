# SPDX-License-Identifier: Apache-2.0
"""The scenes of GaussianBench, as scene files of LiveGS.

Geometry, materials, motions, durations, rates and tolerances are those of GaussianBench 0.6.0
(github.com/Dalu1234/GaussianBench at 576e5bc: SPEC.md, scenes/, variants/generate.py). Cell widths, substeps and loss
factors are ours and free by its rules. SI units.
"""
import csv
import json
import math
from dataclasses import dataclass, field
from pathlib import Path

from numpy_random import Generator

SHAPE_SEED = 20260602  # of the jittered shapes c3 (and c4, plus 1)
FAR = 10.0  # metres; beyond every body
EDGE = 0.02  # spacings by which a region's box includes the centres of its particles
BETA_1 = 1.875104068711961  # first root of cosh(x) cos(x) = -1

VARIED = ("a2", "a3", "a5")  # scenes that the benchmark's generator of variants supports


@dataclass
class Case:
    """One scene to run and to score."""

    name: str  # the benchmark's id of the scene
    points: list  # published rest positions, in the order of the particle ids
    scene: dict  # LiveGS scene; the points are written next to it
    seconds: float
    rate_hz: float
    velocities: list = None
    seed: int = 0  # of a variant; 0: as published
    material: dict = field(default_factory=dict)
    size_m: tuple = ()
    spacing_m: float = 0.0
    drive: dict = field(default_factory=dict)  # numbers of the prescribed motion that the scorer needs
    kernels: bool = False  # the scorer reads covariances
    camera: dict = None  # the scorer reads pictures of the first and the last frame

    def write(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        if self.points:
            with open(folder / "points.csv", "w", newline="") as file:
                rows = csv.writer(file, lineterminator="\n")
                rows.writerow("x y z vx vy vz".split() if self.velocities else "x y z".split())
                for i, point in enumerate(self.points):
                    rows.writerow([repr(v) for v in (*point, *(self.velocities[i] if self.velocities else ()))])
        if self.camera:
            (folder / "camera.json").write_text(json.dumps(self.camera))
        path = folder / "bench.scene.json"
        path.write_text(json.dumps(self.scene, indent=1) + "\n")
        return path


def lattice(size, spacing, centre=(0.0, 0.0, 0.0)):
    """Centres of the cells that fill a box; z varies fastest."""
    counts = [max(1, round(edge / spacing)) for edge in size]
    axes = [
        [(i + 0.5) * edge / count - edge / 2.0 for i in range(count)] for edge, count in zip(size, counts)
    ]
    return [
        (x + centre[0], y + centre[1], z + centre[2]) for x in axes[0] for y in axes[1] for z in axes[2]
    ]


def ball(radius, spacing):
    return [p for p in lattice([2 * radius] * 3, spacing) if math.sqrt(p[0] ** 2 + p[1] ** 2 + p[2] ** 2) <= radius]


def body(material, spacing, cell_width_m, substeps, loss_factor=0.0, regions=()):
    return {
        "name": "body",
        "points": "points.csv",
        "spacing_m": spacing,
        "physics": {"behavior": "ELASTIC", "damping": loss_factor, **material},
        "regions": list(regions),
        "resolution": {"cell_width_m": cell_width_m, "substeps": substeps},
    }


def world(rate_hz, objects, gravity=(0, 0, 0), events=()):
    return {
        "gravity_m_s2": list(gravity),
        "rate_hz": rate_hz,
        "substeps": 1,
        "objects": objects,
        "events": list(events),
    }


def material(youngs, poisson=0.3, density=1000.0):
    return {"youngs_modulus_pa": youngs, "poisson_ratio": poisson, "density_kg_m3": density}


def slab(axis, low, high):
    """Box of everything between two planes."""
    least, most = [-FAR] * 3, [FAR] * 3
    least[axis], most[axis] = low, high
    return {"min_m": least, "max_m": most}


def below(points, axis, plane, spacing):
    """Box of the particles below a plane. It ends at their centres: a region of the benchmark selects particles."""
    return slab(axis, -FAR, max(p[axis] for p in points if p[axis] < plane) + EDGE * spacing)


def above(points, axis, plane, spacing):
    return slab(axis, min(p[axis] for p in points if p[axis] > plane) - EDGE * spacing, FAR)


def mode_1(s):
    """First bending mode of a cantilever at s = x / L, 1 at the tip."""

    def shape(s):
        b = BETA_1
        ratio = (math.cosh(b) - math.cos(b)) / (math.sinh(b) + math.sin(b))
        return math.cosh(b * s) - math.cos(b * s) - ratio * (math.sinh(b * s) - math.sin(b * s))

    return shape(s) / shape(1.0)


def spinning_ball(name, drift):
    points = ball(0.05, 0.01)
    centre = [math.fsum(p[i] for p in points) / len(points) for i in range(3)]
    spin = 4.0  # rad/s about z
    velocities = [
        (drift[0] - spin * (y - centre[1]), drift[1] + spin * (x - centre[0]), drift[2]) for x, y, _ in points
    ]
    stuff = material(1e5)
    scene = world(120, [body(stuff, 0.01, 0.01, 32)])
    return Case(name, points, scene, 10.0, 120, velocities, material=stuff, spacing_m=0.01)


def a1a():
    return spinning_ball("a1a", (0.0, 0.0, 0.0))


def a1b():
    return spinning_ball("a1b", (1.0, 0.5, 0.25))


def scales(seed):
    """Factors of modulus, density and length of a variant."""
    if seed == 0:
        return 1.0, 1.0, 1.0
    generator = Generator(seed)
    return generator.uniform(0.5, 2.0), generator.uniform(0.8, 1.25), generator.uniform(0.8, 1.2)


def plane(x, seed, length_scale):
    """A plane of a region; the generator of variants writes it with six digits."""
    return float(f"{x * length_scale:.6g}") if seed else x


def pluck(points, tip_speed):
    low = min(p[0] for p in points)
    length = max(p[0] for p in points) - low
    return [(0.0, tip_speed * mode_1((p[0] - low) / length), 0.0) for p in points]


def cantilever(name, points, stuff, spacing, clamp_x, seed):
    clamp = {"name": "clamp", "box": below(points, 0, clamp_x, spacing), "fixed": True}
    scene = world(240, [body(stuff, spacing, spacing, 64, regions=[clamp])])
    return Case(name, points, scene, 4.0, 240, pluck(points, 0.05), seed, stuff, spacing_m=spacing)


def a2(seed=0):
    modulus, density, length = scales(seed)
    size = (0.4 * length, 0.05, 0.05)
    points = lattice(size, 0.005, (size[0] / 2.0, 0.0, 0.0))
    stuff = material(5e5 * modulus, 0.3, 1000.0 * density)
    case = cantilever("a2", points, stuff, 0.005, plane(0.01, seed, length), seed)
    case.size_m = size
    return case


def a3(seed=0):
    modulus, density, length = scales(seed)
    size = (1.0 * length, 0.02, 0.02)
    points = lattice(size, 0.005, (size[0] / 2.0, 0.0, 0.0))
    stuff = material(5e5 * modulus, 0.3, 1000.0 * density)
    push = {
        "name": "pulse",
        "box": below(points, 0, plane(0.005, seed, length), 0.005),
        "motion": {"half_sine_pulse": {"displacement_m": [0.001, 0, 0], "start_s": 0.0, "width_s": 0.002}},
    }
    scene = world(2000, [body(stuff, 0.005, 0.005, 16, regions=[push])])
    return Case("a3", points, scene, 0.1, 2000, None, seed, stuff, size, 0.005)


def stretched(points, left, right, displacement, spacing):
    return [
        {"name": "fixed face", "box": below(points, 0, left, spacing), "fixed": True},
        {
            "name": "moved face",
            "box": above(points, 0, right, spacing),
            "motion": {"displacement_ramp": {"displacement_m": [displacement, 0, 0], "start_s": 0.0, "end_s": 0.5}},
        },
    ]


def a5(seed=0):
    modulus, density, length = scales(seed)
    size = (0.1 * length, 0.1, 0.1)
    points = lattice(size, 0.005, (size[0] / 2.0, 0.0, 0.0))
    stuff = material(1e5 * modulus, 0.3, 1000.0 * density)
    regions = stretched(points, plane(0.005, seed, length), plane(0.095, seed, length), 0.002, 0.005)
    scene = world(120, [body(stuff, 0.005, 0.005, 64, regions=regions)])
    return Case("a5", points, scene, 1.5, 120, None, seed, stuff, size, 0.005, {"displacement_m": 0.002})


def a6():
    """A native body: the ball of a1."""
    points = ball(0.05, 0.01)
    stuff = material(1e5)
    scene = world(25, [body(stuff, 0.01, 0.01, 160)], (0, 0, -9.8))
    return Case("a6", points, scene, 0.16, 25, None, material=stuff, spacing_m=0.01)


def b1():
    size = (0.1, 0.04, 0.04)
    points = lattice(size, 0.005, (0.05, 0.0, 0.0))
    stuff = material(5e4)
    stiff = {"name": "stiff half", "box": slab(0, 0.05, FAR), "material": {"youngs_modulus_pa": 2e5}}
    regions = [stiff, *stretched(points, 0.005, 0.095, 0.001, 0.005)]
    scene = world(60, [body(stuff, 0.005, 0.005, 128, regions=regions)])
    drive = {"displacement_m": 0.001, "interface_x_m": 0.05, "youngs_moduli_pa": (5e4, 2e5)}
    return Case("b1", points, scene, 1.0, 60, None, 0, stuff, size, 0.005, drive)


def c1():
    size = (0.1, 0.1, 0.1)
    points = lattice(size, 0.005)
    stuff = material(1e5)
    target = [1.5, 0, 0, 0, 1, 0, 0, 0, 0.8]
    ramp = {"matrix": target, "about_m": [0, 0, 0], "start_s": 0.0, "end_s": 1.0}
    regions = [{"name": "faces", "boundary": True, "motion": {"affine_ramp": ramp}}]
    scene = world(60, [body(stuff, 0.005, 0.005, 128, regions=regions)])
    return Case("c1", points, scene, 1.0, 60, None, 0, stuff, size, 0.005, {"target": target}, kernels=True)


def c2():
    size = (0.1, 0.1, 0.1)
    points = lattice(size, 0.01, (0.0, 0.05, 0.0))
    stuff = material(5e4)
    target = [1, 1, 0, 0, 1, 0, 0, 0, 1]  # x += gamma y with gamma = 1 at the peak
    ramp = {"matrix": target, "about_m": [0, 0, 0], "start_s": 0.0, "end_s": 1.0, "return_end_s": 2.0}
    regions = [
        {"name": "bottom", "box": below(points, 1, 0.01, 0.01), "motion": {"affine_ramp": ramp}},
        {"name": "top", "box": above(points, 1, 0.09, 0.01), "motion": {"affine_ramp": ramp}},
    ]
    scene = world(60, [body(stuff, 0.01, 0.01, 128, regions=regions)])
    drive = {"target": target, "peak_frame": 60}
    return Case("c2", points, scene, 2.0, 60, None, 0, stuff, size, 0.01, drive, kernels=True)


def c3_points():
    generator = Generator(SHAPE_SEED)
    points = [(x * 1.0, y * 0.8, z * 1.3) for x, y, z in ball(0.06, 0.008)]
    points = [tuple(v + generator.normal(0.0008) for v in p) for p in points]
    floor = min(p[1] for p in points)
    return [(x, y - floor, z) for x, y, z in points]


def c3():
    """The plate: the cap that it would touch moves down with it, until it is released."""
    points = c3_points()
    stuff = material(5e4)
    height = max(p[1] for p in points)
    travel = -0.2 * height
    press = {"displacement_m": [0, travel, 0], "start_s": 0.0, "end_s": 1.0}
    regions = [
        {"name": "floor", "box": below(points, 1, 0.004, 0.008), "fixed": True},
        {"name": "plate", "box": above(points, 1, 0.9 * height, 0.008), "motion": {"displacement_ramp": press}},
    ]
    blob = body(stuff, 0.0081, 0.0081, 64, 0.1, regions)
    blob["kernel_per_point"] = True
    scene = world(60, [blob], events=[{"time_s": 1.5, "release_region": {"object": "body", "region": "plate"}}])
    camera = {
        "position_m": [0.22, 0.1, 0.22],
        "look_at_m": [0, 0.045, 0],
        "vertical_fov_deg": 30,
        "width": 320,
        "height": 240,
    }
    return Case("c3", points, scene, 4.0, 60, None, 0, stuff, (), 0.008, camera=camera)


def c4():
    generator = Generator(SHAPE_SEED + 1)
    points = lattice((0.4, 0.04, 0.04), 0.005, (0.2, 0.0, 0.0))
    points = [(x, y + 0.015 * math.sin(math.pi * x / 0.4), z) for x, y, z in points]
    points = [tuple(v + generator.normal(0.0006) for v in p) for p in points]
    return cantilever("c4", points, material(5e5), 0.005, 0.01, 0)


RUBBER = (708663.01, 19707.6, -149.15)  # Yeoh's coefficients, pascals: Azarniya and Rahimi 2022, table 2
RUBBER_STRETCHES = (1.1, 1.3, 1.5, 1.7, 1.9, 2.1, 2.3, 2.5, 2.7)


def rubber_stress_pa(stretch):
    """Measured Cauchy stress of the rubber in incompressible uniaxial tension."""
    over = stretch**2 + 2.0 / stretch - 3.0
    slope = RUBBER[0] + 2.0 * RUBBER[1] * over + 3.0 * RUBBER[2] * over**2
    return 2.0 * (stretch**2 - 1.0 / stretch) * slope


def m1():
    """Bars, each pulled at its end by the measured force of one stretch."""
    size = (0.1, 0.02, 0.02)
    points = lattice(size, 0.005, (0.05, 0.0, 0.0))
    stuff = material(4251978.0, 0.49, 1100.0)
    bars, loads = [], {}
    for i, stretch in enumerate(RUBBER_STRETCHES):
        load = rubber_stress_pa(stretch) / stretch  # force over rest area
        name = f"bar {i + 1}"
        regions = [
            {"name": "clamp", "box": slab(0, -FAR, 0.005), "fixed": True},
            {"name": "load", "box": {"min_m": [0.095, -0.01, -0.01], "max_m": [0.1, 0.01, 0.01]},
             "traction_pa": [load, 0, 0]},
        ]
        bar = body(stuff, 0.005, 0.005, 512, 1.0, regions)
        bars.append({**bar, "name": name, "pose": {"position_m": [0, 0, 0.1 * i]}})
        loads[name] = load
    scene = world(240, bars)
    return Case("m1", points, scene, 0.5, 240, None, 0, stuff, size, 0.005, {"loads_pa": loads})


PUBLISHED = {case.__name__: case for case in (a1a, a1b, a2, a3, a5, a6, b1, c1, c2, c3, c4, m1)}
# Scenes that LiveGS does not enter: heat, and records of triangle soups.
NOT_ENTERED = {
    "a4": "no heat transport",
    "c2 melt": "no heat transport",
    "c5": "no triangle soup",
    "c6": "no triangle soup",
    "c7": "no triangle soup",
    "c8": "no triangle soup",
}
