// Derivatives by the chain rule, as a number type over another number type.
#pragma once
#include "model.hpp"

// A quantity with its derivatives: the rate along a motion, or partial derivatives. Without any it is a constant.
template <class S>
struct Dual {
    S at;
    std::vector<S> slope;

    Dual() = default;
    Dual(const Interval& constant) : at(constant) {}
    Dual(S x, std::vector<S> d) : at(std::move(x)), slope(std::move(d)) {}

    S rate() const { return slope.empty() ? S() : slope[0]; }
    // f(this), if the values of f and its derivative at this number are known.
    Dual chain(S f, const S& derivative) const {
        Dual r(std::move(f), slope);
        for (S& d : r.slope) d = derivative * d;
        return r;
    }
    friend Dual operator-(const Dual& a) { return a.chain(-a.at, S(Interval(-1))); }
    friend Dual operator+(Dual a, const Dual& b) {
        a.at = a.at + b.at;
        if (a.slope.empty()) a.slope = b.slope;
        else for (std::size_t i = 0; i < b.slope.size(); ++i) a.slope[i] = a.slope[i] + b.slope[i];
        return a;
    }
    friend Dual operator-(const Dual& a, const Dual& b) { return a + (-b); }
    friend Dual operator*(const Dual& a, const Dual& b) { return a.chain(a.at * b.at, b.at) + b.chain(S(), a.at); }
};

template <class S>
Dual<S> inverse(const Dual<S>& a) {
    const S y = inverse(a.at);
    return a.chain(y, -(y * y));
}
template <class S>
Dual<S> inverse_root(const Dual<S>& a) {
    const S y = inverse_root(a.at);
    return a.chain(y, S(Interval(-1) / 2) * (y * y * y));
}
template <class S>
void sine_and_cosine(const Dual<S>& a, Dual<S>& sine, Dual<S>& cosine) {
    S s, c;
    sine_and_cosine(a.at, s, c);
    sine = a.chain(s, c), cosine = a.chain(c, -s);
}
inline void sine_and_cosine(const Interval& a, Interval& s, Interval& c) { s = sin(a), c = cos(a); }
