"""Slow, obvious twins of the kernels: one chain, plain Python, the formulas as they are printed."""

import math


def spring_force(deformation, limit=20.0, compression=0.2, extension=0.01):
    """F_e(dl) of Sec. III, branch by branch."""
    if deformation < -limit:
        return (
            limit + math.exp(compression * (-deformation - limit)) / compression - 1 / compression
        )
    if deformation <= limit:
        return -deformation
    return -(limit + math.exp(extension * (deformation - limit)) / extension - 1 / extension)


def verlet(
    n_blocks, belt_velocity, n_steps, time_step=0.001, threshold=71.4, ratio=0.45, limit=20.0
):
    """The Appendix in the laboratory frame, without noise.

    Returns positions after every step (n_steps, N) and events (time, block from 1, kind).
    """
    x = [50.0 * (i + 1) for i in range(n_blocks)]
    before = [position - belt_velocity * time_step for position in x]
    v = [belt_velocity] * n_blocks
    a_before = [0.0] * n_blocks
    direction = [0] * n_blocks
    positions, events = [], []
    for step in range(n_steps):
        lengths = [x[i] - (x[i - 1] if i else 0.0) for i in range(n_blocks)]
        springs = [spring_force(length - 50.0, limit) for length in lengths]
        springs.append(0.0)
        after = [0.0] * n_blocks
        for i in range(n_blocks):
            force = springs[i] - springs[i + 1]
            free = int(math.copysign(1, force)) if abs(force) > threshold else 0
            if direction[i] * (v[i] - belt_velocity) <= 0 and free != direction[i]:
                if direction[i]:
                    events.append((step * time_step, i + 1, "stick"))
                if free:
                    events.append((step * time_step, i + 1, "slip"))
                if not direction[i] or not free:
                    before[i] = x[i] - belt_velocity * time_step
                    a_before[i] = 0.0
                direction[i] = free
            if direction[i] == 0:
                after[i] = x[i] + belt_velocity * time_step
                v[i] = belt_velocity
            else:
                a = force - direction[i] * ratio * threshold
                after[i] = 2 * x[i] - before[i] + a * time_step**2
                v[i] = (x[i] - before[i]) / time_step + time_step / 6 * (11 * a - 2 * a_before[i])
                a_before[i] = a
        before, x = x, after
        positions.append(list(x))  # a copy: a block that sticks rewrites its place in `before`
    return positions, events


def normal_deviates(state, count):
    """xoshiro256++ as its authors print it, and Box and Muller's two deviates of each word."""
    mask = (1 << 64) - 1

    def rotated(word, places):
        return ((word << places) | (word >> (64 - places))) & mask

    s, normals = list(state), []
    for _ in range(count // 2):
        word = (rotated((s[0] + s[3]) & mask, 23) + s[0]) & mask
        shifted = (s[1] << 17) & mask
        s[2] ^= s[0]
        s[3] ^= s[1]
        s[1] ^= s[2]
        s[0] ^= s[3]
        s[2] ^= shifted
        s[3] = rotated(s[3], 45)
        radius = 1.0 - (word >> 12) / 2.0**52  # the high 52 bits, 0 excluded
        angle = (word & ((1 << 36) - 1)) / 2.0**36  # the low 36 bits
        length = math.sqrt(-2.0 * math.log(radius))
        normals += [length * math.cos(2 * math.pi * angle), length * math.sin(2 * math.pi * angle)]
    return normals


def slips_and_avalanches(events, initial, belt_velocity, energy, start):
    """Slips as pairs of events of a block; avalanches as slips that overlap or touch, merged.

    events : rows (time, block from 0, slips, force, position, dissipated); energy : of positions.
    Returns rows in the order of the fields of SLIP and AVALANCHE without `chain`, in order of
    their ends.
    """
    slips, going_on = [], {}
    for time, block, begins, _, position, loss in events:
        if begins:
            going_on[block] = (time, position, loss)
        else:
            begin, place, before = going_on.pop(block)
            slips.append((int(block) + 1, begin, time, place, position, loss - before))
    merged = []
    unfinished = min((begin for begin, *_ in going_on.values()), default=math.inf)
    for slip in sorted(slips, key=lambda slip: slip[1]):
        if merged and slip[1] <= max(other[2] for other in merged[-1]):
            merged[-1].append(slip)
        else:
            merged.append([slip])

    def positions(time, done):
        """Of blocks that are all stuck, each carried by the belt since the last of its slips."""
        places = [place + belt_velocity * time for place in initial]
        for block, _, stop, _, place, _ in done:
            places[block - 1] = place + belt_velocity * (time - stop)
        return places

    avalanches = []
    for group in merged:
        begin, end = group[0][1], max(slip[2] for slip in group)
        if begin < start or end >= unfinished:
            continue
        before = positions(begin, [slip for slip in slips if slip[2] < begin])
        after = positions(end, [slip for slip in slips if slip[2] <= end])
        counts = len(group), len({slip[0] for slip in group})
        drop, moved = energy(before) - energy(after), after[-1] - before[-1]
        avalanches.append((begin, end, *counts, sum(slip[5] for slip in group), drop, moved))
    return [slip for slip in slips if slip[1] >= start], avalanches
