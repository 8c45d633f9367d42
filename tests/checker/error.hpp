// The error of a candidate, bounded at all times.
//
// Let p be the candidate, x the exact motion, and F(x, x') = 0 the equations, which are linear in x'. Let F(p, p') = r.
// Then e = x - p satisfies E(p + e) e' = -F_x(p + theta e, p') e - r, where E is the matrix of x' in F. While e stays
// within a tube around p, both matrices are enclosed as functions of time, so e is a solution of one of the enclosed
// linear equations (flow.hpp). The proved bound is below the claim, and the claim is half the radius of the tube, so e
// never leaves the tube.
#pragma once
#include <iostream>
#include "bicycle.hpp"
#include "claims.hpp"
#include "flow.hpp"

constexpr int SPANS = 3;  // number of parts of a segment
constexpr long STEER_PARTS = 32;  // number of parts of the initial steer angle
// Precision [bits] and number of coefficients: first for the defect r, then for the matrices of the error equation.
constexpr int BITS = 320, MATRIX_BITS = 96;
constexpr std::size_t ORDER = 64, MATRIX_ORDER = 18, FLOW_ORDER = 44;

using Rows7 = std::vector<std::vector<Interval>>;  // coefficients by state variable

// The pitch that puts the front wheel's lowest point on the floor. It is the root that is zero at zero steer, followed
// along the steer angle. If Newton's interval iteration maps `around` into itself for a range of steer angles, then
// each of these angles has exactly one root in it, and the root is a continuous function of the angle.
inline Interval pitch_at_start(const Bicycle& k, const Interval& roll, const Interval& steer) {
    auto newton = [&](const Interval& part, const Interval& near, const Interval& around) {
        auto gap = [&](const Interval& pitch) {
            using T = Dual<Interval>;
            const Motion<T> m(k, {roll, {pitch, {1}}, steer * part / STEER_PARTS, T(), T(), T(), T()});
            return dot(m.down, m.front_hub + m.rim_F - m.rim_R);
        };
        return near - gap(near).at / gap(around).rate();
    };
    Interval pitch;
    for (long i = 0; i < STEER_PARTS; ++i) {
        const Interval part = Interval::between(i, i + 1), near = pitch.middle();
        const double away = (newton(part, near, near) - near).size();
        const Interval around = near + Interval::around_zero(2 * away + 0x1p-60);
        expect(pitch.is_within(around) && newton(part, near, around).is_within(around),
               "pitch at the start: it is not proved which root grows from zero steer");
        pitch = around;
        for (int round = 0; round < 9; ++round) pitch = newton(i + 1, pitch.middle(), pitch);
    }
    return pitch;
}

// The exact initial state.
inline std::vector<Interval> start(const Bicycle& k, const Claim& claim) {
    const auto& given = claim.at_start;
    const Interval &roll = given.at("roll"), &steer = given.at("steer"), &p = given.at("roll_rate");
    const Interval pitch = pitch_at_start(k, roll, steer);
    // Roll and steer rate are linear in w1 and w3.
    const Interval spin = given.at("speed") / k.rR;
    auto rates = [&](long w1, long w3) { return Motion<Interval>(k, {roll, pitch, steer, w1, w3, spin, 0}); };
    const auto none = rates(0, 0), one = rates(1, 0), three = rates(0, 1);
    const Interval a = one.steer_rate - none.steer_rate, b = three.steer_rate - none.steer_rate;
    const Interval &c = one.cos_beta, &s = one.sin_beta, d = given.at("steer_rate") - none.steer_rate;
    const Interval determinant = c * b - s * a;
    return {roll, pitch, steer, (p * b - s * d) / determinant, (c * d - a * p) / determinant, spin, 0};
}

// F(x, x'): differences of the rates of the angles, and the Newton-Euler equations at 3, 4 and 5.
template <class S>
std::vector<S> equations(const Bicycle& k, const std::vector<S>& x, const std::vector<S>& slope) {
    std::vector<Dual<S>> moving;
    for (std::size_t i = 0; i < SIZE; ++i) moving.push_back({x[i], {slope[i]}});
    const Motion<Dual<S>> m(k, moving);
    const auto f = missing(k, m);
    return {slope[0] - m.roll_rate.at, slope[1] - m.pitch_rate.at, slope[2] - m.steer_rate.at,
            f[0], f[1], f[2], slope[6] - m.yaw_rate.at};
}

// The matrices h A and h B of e' = A e + B r, from the partial derivatives of F with respect to x (0 to 6) and x' (7 to
// 13).
inline void solve(const std::vector<Dual<Model>>& F, const Interval& h, Models& A, Models& B) {
    // Gaussian elimination of the rows (E, -h F_x, -h), without pivoting because the equations are in the order of the
    // rates.
    Models rows(SIZE, std::vector<Model>(3 * SIZE));
    for (std::size_t i = 0; i < SIZE; ++i) {
        for (std::size_t j = 0; j < SIZE; ++j)
            rows[i][j] = F[i].slope[SIZE + j], rows[i][SIZE + j] = Model(-h) * F[i].slope[j];
        rows[i][2 * SIZE + i] = Model(-h);
    }
    for (std::size_t i = 0; i < SIZE; ++i) {
        const Model pivot = inverse(rows[i][i]);
        for (Model& x : rows[i]) x = pivot * x;
        for (std::size_t l = 0; l < SIZE; ++l) {
            const Model part = rows[l][i];
            for (std::size_t j = i; l != i && j < rows[l].size(); ++j) rows[l][j] += -(part * rows[i][j]);
        }
    }
    for (const auto& row : rows) {
        A.emplace_back(row.begin() + SIZE, row.begin() + 2 * SIZE);
        B.emplace_back(row.begin() + 2 * SIZE, row.end());
    }
}

// The error over one span. p is a function of the span's own time, 0 to 1; the span lasts h seconds.
inline Radii over_span(const Bicycle& k, const Rows7& p, const Interval& h, const Radii& tube, Frame& frame) {
    std::vector<Model> x, slope, b(SIZE);
    for (const auto& row : p) {
        x.emplace_back(row);
        std::vector<Interval> derivative;
        for (std::size_t i = 1; i < row.size(); ++i) derivative.push_back(row[i] * long(i) / h);
        slope.emplace_back(derivative);
    }
    const std::vector<Model> r = equations(k, x, slope);
    const Working low(MATRIX_BITS, MATRIX_ORDER);
    auto unit = [](std::size_t i) {
        std::vector<Model> r(2 * SIZE);
        r[i] = Model(1);
        return r;
    };
    std::vector<Dual<Model>> wide, rate;
    for (std::size_t i = 0; i < SIZE; ++i) {
        Model around = x[i].shortened();
        around.rest += tube[i];
        wide.push_back({around, unit(i)}), rate.push_back({slope[i].shortened(), unit(SIZE + i)});
    }
    Models A, B;
    solve(equations(k, wide, rate), h, A, B);
    // The defect of a truncated series is nearly all in its last powers, so none of them is cut off.
    const Working long_series(MATRIX_BITS, ORDER);
    for (std::size_t i = 0; i < SIZE; ++i)
        for (std::size_t j = 0; j < SIZE; ++j) b[i] += B[i][j] * r[j].shortened();
    return frame.carry(Flow(A, b, FLOW_ORDER));
}

inline void meet(const Radii& found, const Radii& claimed, const std::string& where) {
    for (std::size_t i = 0; i < SIZE; ++i)
        expect(found[i] <= claimed[i],
               STATES[i] + where + ": the error may be " + shown(found[i]) + ", claimed " + shown(claimed[i]));
}

// Bounds of the error over the segments that begin before `until`. Each must be below its claim. `apart` is the exact
// initial state on entry.
inline Radii prove(const Bicycle& k, const Candidate& run, const Claim& claim, Column apart, double until) {
    Radii tube, worst(SIZE, 0.0);
    for (double bound : claim.interval) tube.push_back(2 * bound + 0x1p-200);
    Rows7 p = run.piece(0);
    for (std::size_t i = 0; i < SIZE; ++i) apart[i] = apart[i] - p[i][0];
    Frame frame(apart);
    meet(frame.bound(), claim.interval, " at the start");
    for (std::size_t piece = 0; piece < run.pieces && run.breaks[piece] < until; ++piece) try {
        const Interval h = (Interval::exactly(run.breaks[piece + 1]) - Interval::exactly(run.breaks[piece])) / SPANS;
        for (auto& row : p) {
            Interval scale = 1;
            for (Interval& c : row) c = c * scale, scale = scale / SPANS;
        }
        for (int span = 0; span < SPANS; ++span) {
            const Radii most = over_span(k, p, h, tube, frame);
            meet(most, claim.interval, "");
            for (std::size_t i = 0; i < SIZE; ++i) worst[i] = std::max(worst[i], most[i]);
            // Shift p to p(s + 1), the next span or the end of the segment.
            for (auto& row : p)
                for (std::size_t i = 0; i + 1 < row.size(); ++i)
                    for (std::size_t j = row.size() - 1; j-- > i;) row[j] += row[j + 1];
        }
        if (piece + 1 == run.pieces) break;
        // The candidate jumps between two segments, but the motion does not.
        Rows7 next = run.piece(piece + 1);
        for (std::size_t i = 0; i < SIZE; ++i) apart[i] = p[i][0] - next[i][0];
        const Working low(MATRIX_BITS, MATRIX_ORDER);
        frame.move(apart);
        p.swap(next);
    } catch (const Refusal& e) {
        throw Refusal("piece " + std::to_string(piece) + ", t = " + shown(run.breaks[piece]) + " s: " + e.what());
    }
    if (until > run.breaks.back()) meet(frame.bound(), claim.end, " at the end");
    return worst;
}
