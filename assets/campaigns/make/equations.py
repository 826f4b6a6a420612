"""Accelerations of a leg and its actuators in one linear system, written from the equations (numba).

MuJoCo gives the bodies: poses, joint axes, mass matrix M and bias (Coriolis and weight). Everything between the current and
the links, and between foot and ground, is here. With u the axis from link 1 (spring side) to link 2 (screw side), L the
length, y the screw's extension, s the deflection of a compliance between screw and link 2 (0 without one), compression
positive, the Lagrangian of spring, rotor and sprung mass gives

    F_k = spring law of delta = y - s - (L - L_rest)
    rotor     (m_J + m_p) y'' - m_p s'' - m_p (B q'' + c)  =  F_m - b y' + friction - F_k
    screw end (m_p + m_u)(s'' + B q'' + c) - m_p y''       =  F_k - k_j s              (only with a compliance)
    bodies    M q'' + bias + B^T ((m_p + m_u) s'' - m_p y'') + [linkages: below]  =  F_k dL/dq + contact + stops
    load cells  F_1 = F_k       F_2 = F_k + m_p (y'' - B q'' - c), or k_j s

B q'' + c is the acceleration less gravity of what carries the sprung mass, along the axis. Rods: the attachment in link 2,
where M has the point mass m_p. Linkages: the mount in link 1, which has the point mass, plus the tracer's L''; the part
with L'' is not in M and is added. Unlike a time-stepped coupling nothing is lagged: q'', y'' and s'' are solved together.

Dry friction has three modes: slipping up, slipping down, stuck. A stuck rotor has y'' = 0 as a constraint, and the friction
that this takes is compared with the bound. Elements that yield and then slip (bristles, clamp slip) are states held in bounds.
"""

import math

import numpy as np
from numba import njit

# Columns of the actuators' parameters.
(STIFFNESS, INERTIA, DAMPING, SPRUNG, COULOMB, STATIC, STRIBECK_SPEED, LOAD_FRICTION, ASYMMETRY, DRAG, RIPPLE, RIPPLE_PER_M,
 RIPPLE_PHASE, CUBIC, SPRING_DAMPING, SLIP_STIFFNESS, SLIP_FORCE, PRESLIDING_FORCE, PRESLIDING_STIFFNESS, GAP, SERIES,
 UNSPRUNG, BUS_V, RESISTANCE, FORCE_CONSTANT, MAIN_LENGTH) = range(26)
COLUMNS = 26
ROD, LINKAGE, LEVER = 0, 1, 2


@njit(cache=True)
def tracer(bars, angle):
    """Travel (m), moment arm (m/rad) of an inverted Hoekens linkage at a crank angle; 0 is the middle of its straight.

    bars: crank (m), then ground, coupler, rocker and tracer arm in cranks. Crank about the origin at pi + angle, rocker about
    (ground, 0); the coupler prolonged by tracer/coupler carries the tracer, whose travel counts along -x.
    """
    ground, coupler, rocker, arm = bars[1], bars[2], bars[3], bars[4]
    px, py = -math.cos(angle), -math.sin(angle)
    dx, dy = ground - px, -py
    d = math.hypot(dx, dy)
    # Law of cosines at the crank pin between the ground pivot's direction and the coupler's.
    at = math.atan2(dy, dx) + math.acos((coupler * coupler + d * d - rocker * rocker) / (2.0 * coupler * d))
    x = px + arm * math.cos(at)
    # Loop closure differentiated: pin' + coupler at' perpendicular to the rocker stays a rotation of the rocker.
    jx, jy = px + coupler * math.cos(at) - ground, py + coupler * math.sin(at)
    pdx, pdy = math.sin(angle), -math.cos(angle)
    rate = -(jx * pdx + jy * pdy) / (coupler * (-jx * math.sin(at) + jy * math.cos(at)))
    x_rate = pdx - arm * math.sin(at) * rate
    return -bars[0] * x, -bars[0] * x_rate


@njit(cache=True)
def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True)
def moving_point(body, local, xpos, xmat, xaxis, xanchor, slides, moves, v, jac, point, velocity, bias):
    """A body's point: Jacobian (3 x n), place, velocity, and its acceleration for q'' = 0."""
    for i in range(3):
        point[i] = xpos[body, i]
        for j in range(3):
            point[i] += xmat[body, 3 * i + j] * local[j]
        velocity[i] = 0.0
        bias[i] = 0.0
    # Joint by joint from the world, w the angular velocity so far. A joint's column a x r turns with all joints before it and
    # with itself, and those before it see it once more as a motion: q_j' (2 w x (a x r) + q_j' a x (a x r)).
    w = (0.0, 0.0, 0.0)
    for j in range(v.shape[0]):
        if not moves[body, j]:
            for i in range(3):
                jac[i, j] = 0.0
            continue
        a = (xaxis[j, 0], xaxis[j, 1], xaxis[j, 2])
        if slides[j]:
            column, turned = a, cross(w, a)
            column_rate = (2.0 * turned[0], 2.0 * turned[1], 2.0 * turned[2])
        else:
            r = (point[0] - xanchor[j, 0], point[1] - xanchor[j, 1], point[2] - xanchor[j, 2])
            column = cross(a, r)
            first, own = cross(w, column), cross(a, column)
            column_rate = (2.0 * first[0] + v[j] * own[0], 2.0 * first[1] + v[j] * own[1], 2.0 * first[2] + v[j] * own[2])
            w = (w[0] + v[j] * a[0], w[1] + v[j] * a[1], w[2] + v[j] * a[2])
        for i in range(3):
            jac[i, j] = column[i]
            velocity[i] += v[j] * column[i]
            bias[i] += v[j] * column_rate[i]


@njit(cache=True)
def reach(i, kind, ends, local, axis, dof, bars, q, v, xpos, xmat, xaxis, xanchor, slides, moves, gravity, grad, carrier, extra):
    """Length, rate, and rows dL/dq (grad) and B (carrier); returns (L, L', c, c of the linkage's part alone)."""
    n = v.shape[0]
    j1, j2 = np.zeros((3, n)), np.zeros((3, n))
    p1, p2, v1, v2, b1, b2 = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    if kind[i] == ROD:
        moving_point(ends[i, 0], local[i, 0], xpos, xmat, xaxis, xanchor, slides, moves, v, j1, p1, v1, b1)
        moving_point(ends[i, 1], local[i, 1], xpos, xmat, xaxis, xanchor, slides, moves, v, j2, p2, v2, b2)
        between = p2 - p1
        length = math.sqrt(between[0] ** 2 + between[1] ** 2 + between[2] ** 2)
        u = between / length
        rate, c = 0.0, 0.0
        for k in range(3):
            rate += u[k] * (v2[k] - v1[k])
            c += u[k] * b2[k]
        c += u[2] * gravity
        for j in range(n):
            grad[j], carrier[j], extra[j] = 0.0, 0.0, 0.0
            for k in range(3):
                grad[j] += u[k] * (j2[k, j] - j1[k, j])
                carrier[j] += u[k] * j2[k, j]
        return length, rate, c, 0.0
    grad[:], carrier[:], extra[:] = 0.0, 0.0, 0.0
    d = dof[i]
    if kind[i] == LEVER:
        grad[d] = bars[i, 0]
        carrier[d] = bars[i, 0]
        return bars[i, 0] * q[d], bars[i, 0] * v[d], 0.0, 0.0
    # bars: 0..4 the linkage, 5 crank angle at zero, 6 sign, 7 length in the middle
    sign, angle = bars[i, 6], bars[i, 5] + bars[i, 6] * q[d]
    travel, arm = tracer(bars[i], angle)
    middle, _ = tracer(bars[i], 0.0)
    e = 1e-4
    slope = (tracer(bars[i], angle + e)[1] - tracer(bars[i], angle - e)[1]) / (2.0 * e)
    moving_point(ends[i, 0], local[i, 0], xpos, xmat, xaxis, xanchor, slides, moves, v, j1, p1, v1, b1)
    grad[d] = sign * arm
    turning = slope * v[d] * v[d]
    mount = 0.0
    for k in range(3):
        u = 0.0
        for j in range(3):
            u += xmat[ends[i, 0], 3 * k + j] * axis[i, j]
        mount += u * (b1[k] + (gravity if k == 2 else 0.0))
        for j in range(n):
            extra[j] += u * j1[k, j]
    carrier[:] = grad + extra
    return bars[i, 7] + travel - middle, grad[d] * v[d], mount + turning, mount


@njit(cache=True)
def solve(a, b):
    """a x = b in place by Cholesky's factors; a is symmetric and positive."""
    n = b.shape[0]
    for j in range(n):
        for k in range(j):
            a[j, j] -= a[j, k] * a[j, k]
        a[j, j] = math.sqrt(a[j, j])
        for i in range(j + 1, n):
            for k in range(j):
                a[i, j] -= a[i, k] * a[j, k]
            a[i, j] /= a[j, j]
    for i in range(n):
        for k in range(i):
            b[i] -= a[i, k] * b[k]
        b[i] /= a[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= a[k, i] * b[k]
        b[i] /= a[i, i]


@njit(cache=True)
def spring(p, delta, rate):
    """Force of the spring beside its slipping element, N."""
    left = delta - min(max(delta, -0.5 * p[GAP]), 0.5 * p[GAP])
    if p[GAP] > 0.0 and left == 0.0:
        return 0.0
    return p[STIFFNESS] * left + p[CUBIC] * left ** 3 + p[SPRING_DAMPING] * rate


@njit(cache=True)
def bound(p, speed, direction, load):
    """Of dry friction, N."""
    static = 0.0
    if p[STATIC] > p[COULOMB]:
        static = (p[STATIC] - p[COULOMB]) * math.exp(-((speed / p[STRIBECK_SPEED]) ** 2))
    return p[COULOMB] * (1.0 + p[ASYMMETRY] * direction) + static + p[LOAD_FRICTION] * abs(load)


@njit(cache=True)
def ground_forces(x, at, g, sole_body, sole, xpos, xmat, xaxis, xanchor, slides, moves, v, force, dx):
    """Hunt-Crossley normal force and bristle friction of the sole points, into force; returns the normal force, N."""
    n = v.shape[0]
    total = 0.0
    jac, point, velocity, bias = np.zeros((3, n)), np.zeros(3), np.zeros(3), np.zeros(3)
    for i in range(sole.shape[0]):
        z = at + 2 * i
        moving_point(sole_body, sole[i], xpos, xmat, xaxis, xanchor, slides, moves, v, jac, point, velocity, bias)
        depth = g[0] - point[2]
        dx[z], dx[z + 1] = 0.0, 0.0
        if depth <= 0.0:
            x[z], x[z + 1] = 0.0, 0.0
            continue
        normal = max(g[2] * depth ** g[3] * (1.0 - g[4] * velocity[2]), 0.0)
        tx, ty = -g[5] * x[z] - g[6] * velocity[0], -g[5] * x[z + 1] - g[6] * velocity[1]
        size, most = math.hypot(tx, ty), g[1] * normal
        if size > most:
            tx, ty = tx * most / size, ty * most / size
            x[z], x[z + 1] = -(tx + g[6] * velocity[0]) / g[5], -(ty + g[6] * velocity[1]) / g[5]
        dx[z], dx[z + 1] = velocity[0], velocity[1]
        for j in range(n):
            force[j] += tx * jac[0, j] + ty * jac[1, j] + normal * jac[2, j]
        total += normal
    return total


@njit(cache=True)
def rhs(x, dx, out, mode, load, may_break, current, params, kind, ends, local, axis, dof, bars, rest, stops, ground, sole_body, sole,
        gravity, mass, bias, xpos, xmat, xaxis, xanchor, slides, moves):
    """dx of the state x = q, q', y, y', s, s', clamp slip, presliding, bristles; out = F_1, F_2, ground force.

    mode: -1, 0, +1 for each rotor (0: stuck, where there is dry friction). With may_break a stuck rotor that its bound cannot
    hold gets its new mode here.
    """
    n, m = bias.shape[0], kind.shape[0]
    q, v = x[:n], x[n:2 * n]
    at = 2 * n
    y, w, s, ds = x[at:at + m], x[at + m:at + 2 * m], x[at + 2 * m:at + 3 * m], x[at + 3 * m:at + 4 * m]
    slip, presliding = x[at + 4 * m:at + 5 * m], x[at + 5 * m:at + 6 * m]
    size = n + 2 * m
    a, b = np.zeros((size, size)), np.zeros(size)
    carriers, carried, forces = np.zeros((m, n)), np.zeros(m), np.zeros(m)
    grad, carrier, extra = np.zeros(n), np.zeros(n), np.zeros(n)
    for i in range(n):
        b[i] = -bias[i]
        for j in range(n):
            a[i, j] = mass[i, j]
        past = q[i] - min(max(q[i], stops[i, 0]), stops[i, 1])
        if past != 0.0:
            push = -stops[i, 2] * past - stops[i, 3] * v[i]
            b[i] += min(push, 0.0) if past > 0.0 else max(push, 0.0)
    total = ground_forces(x, at + 6 * m, ground, sole_body, sole, xpos, xmat, xaxis, xanchor, slides, moves, v, b[:n], dx)
    for i in range(m):
        p = params[i]
        length, rate, c, c_mount = reach(i, kind, ends, local, axis, dof, bars, q, v, xpos, xmat, xaxis, xanchor, slides, moves,
                                         gravity, grad, carrier, extra)
        delta, delta_rate = y[i] - s[i] - (length - rest[i]), w[i] - ds[i] - rate
        slip[i] = min(max(slip[i], -p[SLIP_FORCE]), p[SLIP_FORCE])
        presliding[i] = min(max(presliding[i], -p[PRESLIDING_FORCE]), p[PRESLIDING_FORCE])
        f_k = spring(p, delta, delta_rate) + slip[i]
        amps = current[i]
        if p[RESISTANCE] > 0.0:
            back = p[FORCE_CONSTANT] * w[i]
            amps = min(max(amps, (-p[BUS_V] - back) / p[RESISTANCE]), (p[BUS_V] - back) / p[RESISTANCE])
        push = p[FORCE_CONSTANT] * amps - p[DAMPING] * w[i] - p[DRAG] * w[i] * abs(w[i]) + presliding[i]
        push += p[RIPPLE] * math.sin(p[RIPPLE_PER_M] * y[i] + p[RIPPLE_PHASE])
        m_p = p[SPRUNG]
        for j in range(n):
            b[j] += f_k * grad[j]
            a[n + i, j] = -m_p * carrier[j]
            if kind[i] != ROD:
                # The linkage's part of the carrier: not in the mass matrix of the bodies.
                b[j] -= m_p * (carrier[j] * c - extra[j] * c_mount)
                for k in range(n):
                    a[j, k] += m_p * (carrier[j] * carrier[k] - extra[j] * extra[k])
        a[n + i, n + i] = p[INERTIA] + m_p
        b[n + i] = push - f_k + m_p * c
        if mode[i] != 0:
            b[n + i] -= mode[i] * bound(p, w[i], mode[i], load[i])
        e = n + m + i
        a[e, e] = 1.0
        if p[SERIES] > 0.0:
            moving = m_p + p[UNSPRUNG]
            a[e, e] = moving
            a[e, n + i] = -m_p
            for j in range(n):
                a[e, j] = moving * carrier[j]
                if kind[i] == LEVER:
                    # The unsprung mass of a leg's actuator is a part of its link 2; a bench's pendulum is without it.
                    for k in range(n):
                        a[j, k] += p[UNSPRUNG] * carrier[j] * carrier[k]
            b[e] = f_k - p[SERIES] * s[i] - moving * c
        carriers[i], carried[i], forces[i] = carrier, c, f_k
        dx[at + 4 * m + i] = p[SLIP_STIFFNESS] * delta_rate
        dx[at + 5 * m + i] = -p[PRESLIDING_STIFFNESS] * w[i]
    held = np.zeros(m)
    for attempt in range(2):
        lhs, r = a.copy(), b.copy()
        for i in range(m):
            p = params[i]
            if mode[i] == 0 and dry(p):
                # y'' = 0: its column never counts, its row says what it takes.
                lhs[n + i, :] = 0.0
                lhs[:, n + i] = 0.0
                lhs[n + i, n + i] = 1.0
                r[n + i] = 0.0
        solve(lhs, r)
        broke = False
        for i in range(m):
            p = params[i]
            if mode[i] == 0 and dry(p) and may_break:
                held[i] = -b[n + i]
                for j in range(n):
                    held[i] += a[n + i, j] * r[j]
                held[i] += a[n + m + i, n + i] * r[n + m + i]
                way = -1 if held[i] > 0.0 else 1
                most = bound(p, 0.0, way, load[i])
                if abs(held[i]) > most:
                    mode[i] = way
                    b[n + i] -= way * most
                    broke = True
        if not broke:
            break
    for j in range(n):
        dx[j], dx[n + j] = v[j], r[j]
    for i in range(m):
        p = params[i]
        felt = carried[i]
        for j in range(n):
            felt += carriers[i, j] * r[j]
        dx[at + i], dx[at + m + i] = w[i], r[n + i]
        dx[at + 2 * m + i], dx[at + 3 * m + i] = ds[i], r[n + m + i] if p[SERIES] > 0.0 else 0.0
        out[i] = forces[i]
        out[m + i] = p[SERIES] * s[i] if p[SERIES] > 0.0 else forces[i] + p[SPRUNG] * (r[n + i] - felt)
        load[i] = out[m + i]
    out[2 * m] = total


@njit(cache=True)
def dry(p):
    """Whether an actuator has dry friction."""
    return p[COULOMB] > 0.0 or p[STATIC] > 0.0 or p[LOAD_FRICTION] > 0.0


@njit(cache=True)
def finish(x, n, m, mode, params):
    """A rotor whose speed has changed its sign under dry friction stops there."""
    at = 2 * n + m
    for i in range(m):
        if dry(params[i]) and mode[i] != 0 and x[at + i] * mode[i] <= 0.0:
            x[at + i] = 0.0
            mode[i] = 0
