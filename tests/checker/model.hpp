// Taylor models: functions on 0 <= u <= 1 that are known up to a radius. They need no complex analysis and no
// derivative of a remainder: omitted terms are bounded where they are omitted, and inverses and sines afterwards.
#pragma once
#include "interval.hpp"

// All functions g with abs(g(u) - sum_k c_k u^k) <= rest for some c_k in their intervals. Radii are doubles, rounded
// upward (main sets the processor's rounding direction). Without coefficients and rest the function is exactly zero.
struct Model {
    std::vector<Interval> c;
    double rest = 0;

    Model() = default;
    Model(const Interval& constant) { if (constant.size() > 0) c.push_back(constant); }
    // A polynomial, truncated to the working order.
    explicit Model(std::vector<Interval> coefficients) : c(std::move(coefficients)) {
        for (std::size_t k = Working::order; k < c.size(); ++k) rest += c[k].size();
        if (c.size() > Working::order) c.resize(Working::order);
    }

    bool is_zero() const { return c.empty() && rest == 0; }
    double size() const {
        double sum = rest;
        for (const Interval& x : c) sum += x.size();
        expect(std::isfinite(sum), "a bound is not finite");
        return sum;
    }
    // Upper bound.
    double above() const {
        double sum = rest + (c.empty() ? 0 : c[0].above());
        for (std::size_t k = 1; k < c.size(); ++k) sum += c[k].size();
        return sum;
    }
    // The derivative of the polynomial; nothing is known about the derivative of the rest.
    Model slope() const {
        Model r;
        for (std::size_t k = 1; k < c.size(); ++k) r.c.push_back(c[k] * long(k));
        return r;
    }
    // A copy in the working precision and order, rounded outward.
    Model shortened() const { Model r(c); r.rest += rest; return r; }
    Interval at_end() const {
        Interval sum = Interval::around_zero(rest);
        for (const Interval& x : c) sum += x;
        return sum;
    }
};

inline Model& operator+=(Model& a, const Model& b) {
    for (std::size_t k = 0; k < b.c.size(); ++k)
        if (k < a.c.size()) a.c[k] += b.c[k];
        else a.c.push_back(b.c[k]);
    a.rest += b.rest;
    return a;
}
inline Model operator-(Model a) {
    for (Interval& x : a.c) x = -x;
    return a;
}
inline Model operator+(Model a, const Model& b) { return a += b; }
inline Model operator-(Model a, const Model& b) { return a += -b; }

inline Model operator*(const Model& a, const Model& b) {
    Model r;
    const std::size_t m = a.c.size(), n = b.c.size();
    if (a.is_zero() || b.is_zero()) return r;
    if (m && n) r.c.resize(std::min(m + n - 1, Working::order));
    // Sums of the sizes of b's coefficients from j on: products with these are beyond the working order.
    std::vector<double> from(n + 1, 0.0);
    for (std::size_t j = n; j-- > 0;) from[j] = from[j + 1] + b.c[j].size();
    double size_a = 0;
    for (std::size_t i = 0; i < m; ++i) {
        for (std::size_t j = 0; j < n && i + j < r.c.size(); ++j) r.c[i + j].add_product(a.c[i], b.c[j]);
        const double size = a.c[i].size();
        size_a += size;
        if (i + n > r.c.size()) r.rest += size * from[r.c.size() > i ? r.c.size() - i : 0];
    }
    r.rest += size_a * b.rest + from[0] * a.rest + a.rest * b.rest;
    return r;
}

// g^alpha for alpha = -1 or -1/2: y is a polynomial from the recursion for powers. Then g y (or g y^2) = 1 - e shows
// that g has no zero, and abs(g^alpha - y) <= abs(y) (1 / (1 - abs(e)) - 1) <= 2 abs(y) abs(e).
inline Model power(const Model& g, bool root) {
    const char* refusal = root ? "a root may be of nothing positive" : "a divisor may vanish";
    expect(!g.c.empty(), refusal);
    const Interval alpha = root ? Interval(-1) / 2 : Interval(-1);
    const Interval g0 = g.c[0].middle(), first = inverse(g0);
    Model y((root ? inverse_root(g0) : first).middle());
    for (std::size_t k = 1; k < Working::order && g.c.size() > 1; ++k) {
        Interval sum;
        for (std::size_t i = 1; i <= k && i < g.c.size(); ++i)
            sum.add_product((alpha + 1) * long(i) - long(k), g.c[i] * y.c[k - i]);
        y.c.push_back((sum * first / long(k)).middle());
    }
    const Model gy = root ? g * y * y : g * y;
    const double e = (Model(1) - gy).size();
    expect(e <= 0.5, refusal);
    y.rest = 2 * y.size() * e;
    return y;
}
inline Model inverse(const Model& g) { return power(g, false); }
inline Model inverse_root(const Model& g) { return power(g, true); }

// Sine and cosine of x = P + rest: polynomials s and c that nearly satisfy s' = c P' and c' = -s P'. Without these
// defects the vector (s, c) would rotate with the angle P, so the defects and the initial values bound its error.
inline void sine_and_cosine(const Model& x, Model& s, Model& c) {
    const Interval angle = x.c.empty() ? Interval(0) : x.c[0];
    const Interval s0 = sin(angle), c0 = cos(angle);
    const Model slope = x.slope();
    s = c = Model();
    s.c.push_back(s0.middle()), c.c.push_back(c0.middle());
    for (std::size_t k = 1; k < Working::order && !slope.c.empty(); ++k) {
        Interval up, down;
        for (std::size_t i = 0; i < k && i < slope.c.size(); ++i) {
            up.add_product(slope.c[i], c.c[k - 1 - i]);
            down.add_product(slope.c[i], s.c[k - 1 - i]);
        }
        s.c.push_back((up / long(k)).middle());
        c.c.push_back((-down / long(k)).middle());
    }
    const double defect = (s.slope() - c * slope).size() + (c.slope() + s * slope).size();
    s.rest = c.rest = defect + (s0 - s.c[0]).size() + (c0 - c.c[0]).size() + x.rest;
}
