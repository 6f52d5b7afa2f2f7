# SPDX-License-Identifier: Apache-2.0
"""Scores of the scenes, by the definitions of GaussianBench 0.6.0 (SPEC.md and the pass criteria of scenes/).

Each scorer returns figures and a verdict. PASS: all tolerances are kept. FAIL: one is not. INVALID: the run left the
regime of the reference, so no judgement is possible.
"""
import math
from dataclasses import dataclass

import algebra
import pictures
import scenes
from runs import Failure, Run


@dataclass
class Figure:
    quantity: str
    measured: float
    reference: float
    error: float  # compared with the tolerance
    tolerance: float
    kept: bool


@dataclass
class Score:
    verdict: str
    figures: list
    run: Run


def within(quantity, measured, reference, tolerance):
    """A relative error below the tolerance."""
    error = abs(measured - reference) / abs(reference)
    return Figure(quantity, measured, reference, error, tolerance, error < tolerance)


def at_most(quantity, measured, tolerance, reference=0.0):
    return Figure(quantity, measured, reference, abs(measured - reference), tolerance, measured <= tolerance)


def at_least(quantity, measured, bar):
    return Figure(quantity, measured, bar, measured, bar, measured >= bar)


def judged(run, figures):
    return Score("PASS" if all(f.kept for f in figures) else "FAIL", figures, run)


def simulate(case, program, folder, wanted, kernels_wanted=None):
    """Runs a case; checks the start, the frames and the rate as SPEC.md asks (sections 2.1 and 3)."""
    def kept(frame, index):
        return frame == 0 or wanted(frame, index)

    run = Run(case, program, folder, kept, kernels_wanted)
    frames, times_s = run.particles.frames, run.particles.times_s
    count = round(case.seconds * case.rate_hz) + 1
    if len(frames) != count:
        raise Failure(f"{case.name}: {len(frames)} frames instead of {count}; see {run.folder}")
    start = [row for _, _, row in frames[0]]
    if case.name != "m1":
        if len(start) != len(case.points):
            raise Failure(f"{case.name}: {len(start)} particles instead of {len(case.points)}; see {run.folder}")
        off = max(abs(a - b) for row, point in zip(start, case.points) for a, b in zip(row, point))
        if off > 1e-6:
            raise Failure(f"{case.name}: starts {off:.3g} m off the published positions; see {run.folder}")
    step = algebra.median([times_s[i + 1] - times_s[i] for i in range(count - 1)])
    if abs(1.0 / step - case.rate_hz) > 0.01 * case.rate_hz:
        raise Failure(f"{case.name}: frames at {1.0 / step:g} Hz instead of {case.rate_hz:g}; see {run.folder}")
    for rows in frames.values():
        if not all(math.isfinite(v) for _, _, row in rows for v in row):
            raise Failure(f"{case.name}: the motion is not finite; see {run.folder}")
    return run


def series(run):
    """Frames in order: lists of (id, numbers)."""
    return [[(index, row) for _, index, row in run.particles.frames[i]] for i in sorted(run.particles.frames)]


def conservation(case, program, folder):
    run = simulate(case, program, folder, lambda frame, index: True)
    momenta, spins, energies, content = [], [], [], 0.0
    for rows in series(run):
        mass = math.fsum(row[6] for _, row in rows)
        momentum = [math.fsum(row[6] * row[3 + i] for _, row in rows) for i in range(3)]
        centre = [math.fsum(row[6] * row[i] for _, row in rows) / mass for i in range(3)]
        parts = []
        for _, row in rows:
            arm = [row[i] - centre[i] for i in range(3)]
            speed = [row[3 + i] - momentum[i] / mass for i in range(3)]
            parts.append([row[6] * v for v in algebra.cross(arm, speed)])
        spins.append([math.fsum(p[i] for p in parts) for i in range(3)])
        momenta.append(momentum)
        energies.append(0.5 * math.fsum(row[6] * sum(v * v for v in row[3:6]) for _, row in rows))
        if not content:
            content = math.fsum(row[6] * algebra.norm(row[3:6]) for _, row in rows)
    # A body that does not travel has no momentum to compare with: then the sum of m |v| is the scale.
    scale = algebra.norm(momenta[0])
    if scale <= 1e-12 * max(content, 1.0):
        scale = content
    drift = max(algebra.norm(algebra.minus(p, momenta[0])) for p in momenta) / scale
    turn = max(algebra.norm(algebra.minus(s, spins[0])) for s in spins) / algebra.norm(spins[0])
    growth = energies[-1] / energies[0] - 1.0
    tight = case.name == "a1a"
    figures = [
        at_most("linear momentum drift", drift, 1e-6 if tight else 1e-3),
        at_most("angular momentum drift", turn, 1e-3 if tight else 1e-2),
    ]
    rises = all(b - a >= -1e-12 * energies[0] for a, b in zip(energies, energies[1:]))
    figures.append(Figure("kinetic energy growth", growth, 0.0, abs(growth), 0.01,
                          not (tight and rises and growth > 0.01)))
    return judged(run, figures)


def plucked(case, program, folder, tolerance):
    rest = case.points
    low = min(p[0] for p in rest)
    extent = max(p[0] for p in rest) - low
    if case.size_m:
        length, ratio = case.size_m[0], case.size_m[2] ** 2 / 12.0  # I / A of a rectangle
    else:
        length, ratio = extent, section_ratio(rest, 20)
    tip = {i for i, p in enumerate(rest) if p[0] - low > 0.95 * length}
    run = simulate(case, program, folder, lambda frame, index: index in tip)
    shifts = [
        math.fsum(row[1] - rest[i][1] for i, row in rows if i in tip) / len(tip) for rows in series(run)
    ]
    modulus, density = case.material["youngs_modulus_pa"], case.material["density_kg_m3"]
    reference = scenes.BETA_1**2 / (2.0 * math.pi * length**2) * math.sqrt(modulus * ratio / density)
    deepest = max(abs(v) for v in shifts)
    deflection = at_most("tip deflection over length", deepest / length, 0.05)
    times_s = [run.particles.times_s[i] for i in range(len(shifts))]
    slope, at_0 = algebra.line_fit(times_s, shifts)
    rate_hz = 1.0 / algebra.median([b - a for a, b in zip(times_s, times_s[1:])])
    straight = [v - slope * t - at_0 for v, t in zip(shifts, times_s)]
    frequency = algebra.dominant_frequency_hz(straight, rate_hz)
    score = judged(run, [within("frequency Hz", frequency, reference, tolerance), deflection])
    if not deflection.kept:
        score.verdict = "INVALID"
    return score


def section_ratio(points, bins):
    """I / A: mean square of y from the middle of each of `bins` slices along x."""
    low, high = min(p[0] for p in points), max(p[0] for p in points) + 1e-12
    slices = [[] for _ in range(bins)]
    for p in points:
        slices[min(bins - 1, int((p[0] - low) / (high - low) * bins))].append(p[1])
    total = count = 0
    for heights in slices:
        if len(heights) < 4:
            continue
        middle = math.fsum(heights) / len(heights)
        total += math.fsum((y - middle) ** 2 for y in heights)
        count += len(heights)
    return total / count


def a2(case, program, folder):
    return plucked(case, program, folder, 0.10)


def c4(case, program, folder):
    return plucked(case, program, folder, 0.20)


def a3(case, program, folder):
    rest = case.points
    low = min(p[0] for p in rest)
    length = max(p[0] for p in rest) - low
    far = {i for i, p in enumerate(rest) if p[0] - low > 0.98 * length}
    run = simulate(case, program, folder, lambda frame, index: index in far)
    speed = math.sqrt(case.material["youngs_modulus_pa"] / case.material["density_kg_m3"])
    way = math.fsum(rest[i][0] for i in far) / len(far) - low
    measured = 0.0  # no arrival
    for frame, rows in enumerate(series(run)):
        moved = math.fsum(algebra.norm(algebra.minus(row[:3], rest[i])) for i, row in rows if i in far)
        if moved / len(far) > 1e-5:
            measured = way / run.particles.times_s[frame] if frame else 0.0
            break
    return judged(run, [within("wave speed m/s", measured, speed, 0.15)])


def ends(case, run, first_kept):
    """Mean ways along x of the outermost particles at both ends, over the last frames."""
    rest = case.points
    low, high = min(p[0] for p in rest), max(p[0] for p in rest)
    reach = 0.75 * case.spacing_m
    means = []
    for at_end in (lambda x: x - low < reach, lambda x: high - x < reach):
        ways = [
            row[0] - rest[i][0] for rows in series(run)[first_kept:] for i, row in rows if at_end(rest[i][0])
        ]
        means.append(math.fsum(ways) / len(ways))
    return means


def held_frames(case):
    """First of the last quarter of the frames."""
    count = round(case.seconds * case.rate_hz) + 1
    return count - max(1, round(0.25 * count))


def moved_as_told(case, way):
    return within("way of the face m", way, case.drive["displacement_m"], 0.05)


def a5(case, program, folder):
    rest, first = case.points, held_frames(case)
    run = simulate(case, program, folder, lambda frame, index: frame >= first)
    fixed_way, face_way = ends(case, run, first)
    face = moved_as_told(case, face_way)
    low = min(p[0] for p in rest)
    axial = (face_way - fixed_way) / (max(p[0] for p in rest) - low)
    core = [i for i, p in enumerate(rest) if 0.3 * case.size_m[0] < p[0] - low < 0.7 * case.size_m[0]]
    inside = set(core)

    def extent(points):
        middle = math.fsum(points) / len(points)
        return math.fsum(abs(v - middle) for v in points)

    across = []
    for axis in (1, 2):
        before = extent([rest[i][axis] for i in core])
        now = [extent([row[axis] for i, row in rows if i in inside]) for rows in series(run)[first:]]
        across.append(math.fsum(now) / len(now) / before - 1.0)
    reference = -case.material["poisson_ratio"] * axial
    score = judged(run, [within("lateral strain", sum(across) / 2.0, reference, 0.10), face])
    if not face.kept:
        score.verdict = "INVALID"
    return score


def a6(case, program, folder):
    gravity = case.scene["gravity_m_s2"][2]
    run = simulate(case, program, folder, lambda frame, index: True)
    rows = series(run)
    mass = math.fsum(row[6] for _, row in rows[0])
    places = [math.fsum(row[6] * row[2] for _, row in each) / mass for each in rows]
    speeds = [math.fsum(row[6] * row[5] for _, row in each) / mass for each in rows]
    times_s = [run.particles.times_s[i] for i in range(len(rows))]
    falls = [0.5 * gravity * t * t for t in times_s]
    place = max(abs(z - places[0] - fall) / abs(fall) for z, fall in zip(places[1:], falls[1:]))
    speed = max(abs(v - gravity * t) / abs(gravity * t) for v, t in zip(speeds[1:], times_s[1:]))
    boxes = [
        math.prod(max(r[i] for _, r in each) - min(r[i] for _, r in each) for i in range(3)) for each in rows
    ]
    swelling = max(abs(box / boxes[0] - 1.0) for box in boxes)
    gradients = [row[7:16] for each in rows[1:] for _, row in each]
    share = sum(1 for g in gradients if not algebra.determinant(g) > 0.0) / len(gradients)
    return judged(run, [
        at_most("position error", place, 0.10),
        at_most("velocity error", speed, 0.10),
        at_most("bounding volume drift", swelling, 0.01),
        at_most("share of det F <= 0", share, 1e-6),
    ])


def b1(case, program, folder):
    rest, first = case.points, held_frames(case)
    run = simulate(case, program, folder, lambda frame, index: frame >= first)
    fixed_way, face_way = ends(case, run, first)
    way = face_way - fixed_way
    face = moved_as_told(case, way)
    low, high = min(p[0] for p in rest), max(p[0] for p in rest)
    border, moduli = case.drive["interface_x_m"], case.drive["youngs_moduli_pa"]
    # The gauge ends are the outermost particles.
    stress = way / ((border - low) / moduli[0] + (high - border) / moduli[1])
    figures, tractions = [], []
    for name, modulus, start, end in (("left", moduli[0], 0.125, 0.375), ("right", moduli[1], 0.625, 0.875)):
        core = {i for i, p in enumerate(rest) if low + start * (high - low) < p[0] < low + end * (high - low)}
        slopes = []
        for rows in series(run)[first:]:
            pairs = [(rest[i][0], row[0]) for i, row in rows if i in core]
            slopes.append(algebra.line_fit(*zip(*pairs))[0])
        strain = math.fsum(slopes) / len(slopes) - 1.0
        figures.append(within(f"{name} strain", strain, stress / modulus, 0.15))
        tractions.append(modulus * strain)
    jump = abs(tractions[0] - tractions[1]) / abs(sum(tractions) / 2.0)
    score = judged(run, [*figures, at_most("traction jump", jump, 0.15), face])
    if not face.kept:
        score.verdict = "INVALID"
    return score


def interior(case):
    """Ids of particles more than two spacings from every face, and their 26 neighbours on the lattice."""
    rest, reach = case.points, 2.0 * case.spacing_m
    low = [min(p[i] for p in rest) + reach for i in range(3)]
    high = [max(p[i] for p in rest) - reach for i in range(3)]
    chosen = [i for i, p in enumerate(rest) if all(low[k] < p[k] < high[k] for k in range(3))]
    counts = [round(edge / case.spacing_m) for edge in case.size_m]
    around = [
        (a * counts[1] + b) * counts[2] + c
        for a in (-1, 0, 1) for b in (-1, 0, 1) for c in (-1, 0, 1) if (a, b, c) != (0, 0, 0)
    ]
    return chosen, around


def transport(case, program, folder, frame, limits, wanted):
    """Fitted and exported deformation gradients and covariances in one frame; limits of the kinematic error."""
    rest, target = case.points, [float(v) for v in case.drive["target"]]
    run = simulate(case, program, folder, lambda at, index: at == frame, wanted)
    now = [row for _, row in series(run)[frame]]
    chosen, around = interior(case)
    kinematic, pushed = [], []
    first = [row for _, _, row in run.kernels.frames[0]]
    last = [row for _, _, row in run.kernels.frames[frame]]
    for i in chosen:
        before = [algebra.minus(rest[i + k], rest[i]) for k in around]
        after = [algebra.minus(now[i + k][:3], now[i][:3]) for k in around]
        fitted = algebra.fitted_gradient(before, after)
        kinematic.append(algebra.norm(algebra.minus(fitted, target)) / algebra.norm(target))
        expected = algebra.pushed_forward(last[i][6:15], algebra.symmetric(first[i][:6]))
        found = algebra.symmetric(last[i][:6])
        pushed.append(algebra.norm(algebra.minus(found, expected)) / algebra.norm(expected))
    return run, [
        at_most("median kinematic error", algebra.median(kinematic), limits[0]),
        at_most("p95 kinematic error", algebra.percentile(kinematic, 0.95), limits[1]),
        at_most("median transport error", algebra.median(pushed), 1e-3),
        at_most("p95 transport error", algebra.percentile(pushed, 0.95), 1e-2),
    ]


def c1(case, program, folder):
    last = round(case.seconds * case.rate_hz)
    run, figures = transport(case, program, folder, last, (0.05, 0.10), lambda frame, index: frame in (0, last))
    return judged(run, figures)


def c2(case, program, folder):
    peak = case.drive["peak_frame"]
    run, figures = transport(case, program, folder, peak, (0.05, 0.10), lambda frame, index: True)
    spectra = [
        algebra.eigenvalues(algebra.symmetric(row[:6])) for rows in run.kernels.frames.values() for _, _, row in rows
    ]
    start = [
        v for _, _, row in run.kernels.frames[0] for v in algebra.eigenvalues(algebra.symmetric(row[:6]))
    ]
    thinnest = min(s[0] for s in spectra) / algebra.median(start)
    needles = sum(1 for s in spectra if not s[0] > 0.0 or s[2] / s[0] > 1e4) / len(spectra)
    figures += [at_least("least eigenvalue ratio", thinnest, 1e-3), at_most("share of needles", needles, 1e-3)]
    score = judged(run, figures)
    if not (figures[0].kept and figures[1].kept):
        score.verdict = "INVALID"
    return score


def c3(case, program, folder):
    run = simulate(case, program, folder, lambda frame, index: True)
    heights = [max(row[1] for _, row in rows) - min(row[1] for _, row in rows) for rows in series(run)]
    squash = at_most("least height over the first", min(heights) / heights[0], 0.82)
    first, last = (
        pictures.read_png(run.folder / f"frame_{frame:04d}.png")
        for frame in (0, round(case.seconds * case.rate_hz))
    )
    score = judged(run, [
        at_least("PSNR dB", min(100.0, pictures.psnr_db(first, last)), 35.0),
        at_least("SSIM", pictures.ssim(first, last), 0.97),
        squash,
    ])
    if not squash.kept:
        score.verdict = "INVALID"
    return score


def m1(case, program, folder):
    """Stretch and section of the middle third of each bar at the end; Cauchy stress: the pull over that section."""
    last = round(case.seconds * case.rate_hz)
    rest = case.points
    middle = [i for i, p in enumerate(rest) if case.size_m[0] / 3.0 < p[0] < case.size_m[0] * 2.0 / 3.0]
    run = simulate(case, program, folder, lambda frame, index: frame >= last - 24)
    figures, errors = [], []
    for name, load in case.drive["loads_pa"].items():
        along, section = [], []
        for frame in range(last - 24, last + 1):
            rows = {i: row for n, i, row in run.particles.frames[frame] if n.decode() == name}

            def slope(now, before):
                return algebra.line_fit([rest[i][before] for i in middle], [rows[i][now] for i in middle])[0]

            along.append(slope(0, 0))
            section.append(slope(1, 1) * slope(2, 2) - slope(1, 2) * slope(2, 1))  # also if the bar is twisted
        stretch = sum(along) / len(along)
        stress, reference = load / (sum(section) / len(section)), scenes.rubber_stress_pa(stretch)
        error = abs(stress - reference) / reference
        if 1.001 < stretch <= 2.5:
            errors.append(error)
        figures.append(Figure(f"stress Pa at stretch {stretch:.3f}", stress, reference, error, math.inf, True))
    if len(errors) < 5:
        raise Failure(f"m1: {len(errors)} stretches up to 2.5 instead of 5; choose other loads")
    return judged(run, [at_most("median stress error", algebra.median(errors), 0.15), *figures])


SCORERS = {name: globals().get(name, conservation) for name in scenes.PUBLISHED}
