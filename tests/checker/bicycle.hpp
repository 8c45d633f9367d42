// The bicycle by the Newton-Euler equations: four rigid bodies, three bearings, two wheels that roll on the floor.
//
// The right-handed axes of the rear frame are called e: e3 is down the steer axis, e2 along the rear axle to the right,
// and e1 = e2 x e3. The origin is the rear hub. All vectors are in these axes, so accelerations are da/dt + omega x a.
// Bodies: R rear wheel, B rear frame with rider, H fork and handlebar, F front wheel.
#pragma once
#include <map>
#include "derivatives.hpp"

template <class T>
struct Vector {
    T x, y, z;
    friend Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Vector operator*(const T& k, const Vector& a) { return {k * a.x, k * a.y, k * a.z}; }
    friend Vector cross(const Vector& a, const Vector& b) {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
    friend T dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
};
template <class T>
Vector<T> constant(const Vector<Interval>& a) { return {T(a.x), T(a.y), T(a.z)}; }
template <class S>
Vector<S> value(const Vector<Dual<S>>& a) { return {a.x.at, a.y.at, a.z.at}; }
// The rate of change of a vector whose components are in axes that rotate with omega.
template <class S>
Vector<S> rate(const Vector<Dual<S>>& a, const Vector<Dual<S>>& omega) {
    return Vector<S>{a.x.rate(), a.y.rate(), a.z.rate()} + cross(value(omega), value(a));
}

// Matrix elements of an inertia tensor about the centre of mass, symmetric in the plane y = 0.
struct Inertia {
    Interval xx, yy, zz, xz;
    template <class T>
    Vector<T> operator*(const Vector<T>& w) const {
        return {T(xx) * w.x + T(xz) * w.z, T(yy) * w.y, T(xz) * w.x + T(zz) * w.z};
    }
};

struct Bicycle {
    Interval tilt, g, rR, rF, mR, mB, mH, mF;
    Inertia R, B, H, F;
    Vector<Interval> b, s, h;  // from the rear hub: B's centre, a point on the steer axis; H's centre from it
    Interval offset;           // front hub from the same point, perpendicular to the axis

    explicit Bicycle(const std::map<std::string, Interval>& p)
        : tilt(p.at("lam")), g(p.at("g")), rR(p.at("rR")), rF(p.at("rF")), mR(p.at("mR")), mB(p.at("mB")),
          mH(p.at("mH")), mF(p.at("mF")), R{p.at("IRxx"), p.at("IRyy"), p.at("IRxx"), 0},
          F{p.at("IFxx"), p.at("IFyy"), p.at("IFxx"), 0} {
        // In the upright position x is forward, z is down, and the origin is below the rear hub. The steer axis meets
        // the floor at w + c and is tilted backward by lam: e1 and e3 are x and z rotated by lam.
        const Interval cl = cos(tilt), sl = sin(tilt);
        auto turned = [&](const Interval& x, const Interval& z) {
            return Vector<Interval>{x * cl - z * sl, 0, x * sl + z * cl};
        };
        auto inertia = [&](const std::string& name) {
            const Interval xx = p.at(name + "xx"), zz = p.at(name + "zz"), xz = p.at(name + "xz"), d = cl * sl;
            return Inertia{cl * cl * xx - d * xz * 2 + sl * sl * zz, p.at(name + "yy"),
                           sl * sl * xx + d * xz * 2 + cl * cl * zz, d * (xx - zz) + (cl * cl - sl * sl) * xz};
        };
        b = turned(p.at("xB"), p.at("zB") + rR);
        B = inertia("IB"), H = inertia("IH");
        const auto ground = turned(p.at("w") + p.at("c"), rR), hub = turned(p.at("w"), rR - rF);
        s = {ground.x, 0, hub.z};
        offset = hub.x - ground.x;
        h = turned(p.at("xH"), p.at("zH") + rR) - s;
    }
};

// Positions and velocities of all parts, from roll, pitch, steer, w1, w3, spin (and yaw, which affects nothing).
template <class T>
struct Motion {
    T sin_roll, cos_roll, sin_beta, cos_beta, sin_steer, cos_steer;
    Vector<T> down, heading;                    // the vertical; the line where the rear wheel's plane meets the floor
    Vector<T> f1, f2, f3;                       // axes of the front frame
    Vector<T> rim_R, rim_F;                     // from the hubs to the lowest points of the wheels
    Vector<T> fork, front_hub;                  // H's centre and the front hub
    T spin, roll_rate, yaw_rate, pitch_rate, steer_rate, spin_F;  // spin_F is the front wheel's rate about its axle
    Vector<T> omega, omega_F;                   // angular velocities of rear frame and front frame
    Vector<T> v_R, v_B, v_H, v_F;               // velocities of the centres of mass
    Vector<T> L_R, L_B, L_H, L_F;               // angular momenta about the centres of mass

    Motion(const Bicycle& k, const std::vector<T>& x) : spin(x[5]) {
        const T &w1 = x[3], &w3 = x[4];
        sine_and_cosine(x[0], sin_roll, cos_roll);
        sine_and_cosine(x[1] + T(k.tilt), sin_beta, cos_beta);
        sine_and_cosine(x[2], sin_steer, cos_steer);
        const T none, one(Interval(1));
        heading = {cos_beta, none, sin_beta};
        const Vector<T> across = {-sin_beta, none, cos_beta};  // heading x axle: down in the wheel's plane
        down = {cos_roll * across.x, sin_roll, cos_roll * across.z};
        f1 = {cos_steer, sin_steer, none}, f2 = {-sin_steer, cos_steer, none}, f3 = {none, none, one};
        rim_R = T(k.rR) * across;
        const T lean = dot(down, f2);
        rim_F = (T(k.rF) * inverse_root(one - lean * lean)) * (down - lean * f2);
        front_hub = constant<T>(k.s) + T(k.offset) * f1;
        fork = constant<T>(k.s) + T(k.h.x) * f1 + T(k.h.z) * f3;

        // The rear wheel turns with (w1, -spin, w3) about its lowest point.
        v_R = cross(rim_R, {w1, -spin, w3});
        // The wheel keeps the front hub at its height: the hub's velocity has no component along the spoke to the
        // contact point. The steer rate has no effect on it, so this gives the rear frame's rate q about its axle.
        const Vector<T> arm = cross(front_hub, rim_F);
        const T q = -(dot(v_R, rim_F) + w1 * arm.x + w3 * arm.z) * inverse(arm.y);
        omega = {w1, q, w3};
        // The front wheel does not slip sideways at its lowest point.
        const T aside = dot(v_R + cross(omega, front_hub + rim_F), f2);
        steer_rate = -aside * inverse(T(k.offset) + dot(rim_F, f1));
        omega_F = {w1, q, w3 + steer_rate};
        v_B = v_R + cross(omega, constant<T>(k.b));
        const Vector<T> v_S = v_R + cross(omega, constant<T>(k.s));
        v_H = v_S + cross(omega_F, fork - constant<T>(k.s));
        v_F = v_S + cross(omega_F, front_hub - constant<T>(k.s));
        // The front wheel does not slip forward either.
        spin_F = -(dot(v_F, cross(f2, rim_F)) * T(inverse(k.rF * k.rF)));

        // omega = yaw' down + roll' heading + pitch' e2.
        roll_rate = dot(omega, heading);
        yaw_rate = (cos_beta * w3 - sin_beta * w1) * inverse(cos_roll);
        pitch_rate = q - yaw_rate * sin_roll;

        L_B = k.B * omega;
        L_R = k.R * Vector<T>{w1, -spin, w3};
        const T turn = dot(omega_F, f1);
        auto out = [&](const Vector<T>& a) { return a.x * f1 + a.y * f2 + a.z * f3; };
        L_H = out(k.H * Vector<T>{turn, dot(omega_F, f2), omega_F.z});
        L_F = out(k.F * Vector<T>{turn, spin_F, omega_F.z});
    }
};

// Forces and moments that the motion requires beyond the acting ones; they are all zero if Newton's and Euler's
// equations are satisfied.
//
// Of the 24 equations of the four bodies, only those without a bearing reaction are used: forces on the whole, and
// moments about the rear hub, of the front about the steer axis, and of each wheel about its axle. These are nine
// equations; their remaining unknowns are the two contact forces.
template <class S>
std::vector<S> missing(const Bicycle& k, const Motion<Dual<S>>& m) {
    const auto down = value(m.down);
    auto force = [&](const Interval& mass, const Vector<Dual<S>>& v) {
        return S(mass) * (rate(v, m.omega) - S(k.g) * down);
    };
    const auto force_B = force(k.mB, m.v_B), force_H = force(k.mH, m.v_H), force_F = force(k.mF, m.v_F);
    const auto whole = force(k.mR, m.v_R) + force_B + force_H + force_F;
    const auto at_H = value(m.fork), at_F = value(m.front_hub), at_S = constant<S>(k.s);
    const auto turning_F = rate(m.L_H + m.L_F, m.omega);
    const auto moment = rate(m.L_R + m.L_B, m.omega) + turning_F + cross(constant<S>(k.b), force_B)
                        + cross(at_H, force_H) + cross(at_F, force_F);
    const auto front = turning_F + cross(at_H - at_S, force_H) + cross(at_F - at_S, force_F);

    // About the rear contact: moment_C = base x contact_F, where base leads from contact to contact. So the front
    // contact force is (moment_C x base) / base^2 + part base; the spin of the front wheel determines `part`.
    const auto rim_R = value(m.rim_R), rim_F = value(m.rim_F), axle_F = value(m.f2);
    const auto moment_C = moment - cross(rim_R, whole);
    const auto base = at_F + rim_F - rim_R;
    const auto level = cross(axle_F, rim_F);
    const auto aside = inverse(dot(base, base)) * cross(moment_C, base);
    const S wheel_F = S(k.F.yy) * m.spin_F.rate();
    const S part = (wheel_F - dot(aside, level)) * inverse(dot(base, level));
    const auto contact_F = aside + part * base;
    return {dot(moment_C, base), front.z - cross(at_F - at_S + rim_F, contact_F).z,
            S(k.rR) * dot(value(m.heading), whole - contact_F) + S(k.R.yy) * m.spin.rate()};
}
