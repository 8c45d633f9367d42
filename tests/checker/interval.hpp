// Real intervals in MPFI: every operation encloses all results for all values of its operands.
#pragma once
#include <cfenv>
#include <cmath>
#include <cstring>
#include <mpfi.h>
#include <mpfi_io.h>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

// Raised if a claim is not proved; the message is one line.
struct Refusal : std::runtime_error {
    using std::runtime_error::runtime_error;
};

inline void expect(bool good, const std::string& message) {
    if (!good) throw Refusal(message);
}

inline std::string shown(double x) {
    std::ostringstream text;
    text.precision(3);
    return text << x, text.str();
}

// Precision and order of the computations until the end of the scope.
struct Working {
    static inline int bits = 320;          // of an interval's ends
    static inline std::size_t order = 64;  // coefficients of a Taylor model
    Working(int b, std::size_t n) : bits_before(bits), order_before(order) { bits = b, order = n; }
    ~Working() { bits = bits_before, order = order_before; }
    Working(const Working&) = delete;

private:
    int bits_before;
    std::size_t order_before;
};

class Interval {
public:
    Interval(long n = 0) { init(); mpfi_set_si(x, n); }
    static Interval of(mpz_srcptr n) { Interval r; mpfi_set_z(r.x, n); return r; }
    Interval(const Interval& o) { init(); mpfi_set(x, o.x); }
    Interval(Interval&& o) noexcept { *x = *o.x; o.owner = false; }
    Interval& operator=(const Interval& o) { if (!owner) init(), owner = true; mpfi_set(x, o.x); return *this; }
    Interval& operator=(Interval&& o) noexcept { std::swap(*x, *o.x); std::swap(owner, o.owner); return *this; }
    ~Interval() { if (owner) mpfi_clear(x); }

    static Interval exactly(double d) { Interval r; mpfi_set_d(r.x, d); return r; }
    static Interval decimal(const std::string& text) {
        Interval r;
        const bool plain = text.find_first_not_of("+-.0123456789e") == std::string::npos;
        expect(plain && mpfi_set_str(r.x, text.c_str(), 10) == 0, "found \"" + text + "\", expected a decimal");
        return r;
    }
    static Interval pi() { Interval r; mpfi_const_pi(r.x); return r; }
    static Interval between(long a, long b) { Interval r; mpfi_interv_si(r.x, a, b); return r; }
    static Interval around_zero(double radius) { Interval r; mpfi_interv_d(r.x, -radius, radius); return r; }

    Interval operator-() const { Interval r; mpfi_neg(r.x, x); return r; }
    Interval& operator+=(const Interval& b) { mpfi_add(x, x, b.x); return *this; }
    friend Interval operator+(Interval a, const Interval& b) { return a += b; }
    friend Interval operator-(Interval a, const Interval& b) { mpfi_sub(a.x, a.x, b.x); return a; }
    friend Interval operator*(Interval a, const Interval& b) { mpfi_mul(a.x, a.x, b.x); return a; }
    friend Interval operator/(Interval a, const Interval& b) {
        expect(!b.holds_zero(), "a divisor may vanish");
        return mpfi_div(a.x, a.x, b.x), a;
    }
    void add_product(const Interval& a, const Interval& b) {
        static Interval product = [] { Working most(512, 0); return Interval(); }();
        mpfi_mul(product.x, a.x, b.x);
        mpfi_add(x, x, product.x);
    }
    Interval scaled_by_power_of_two(long k) const { Interval r; mpfi_mul_2si(r.x, x, k); return r; }

    Interval not_above_1() const { Interval r = between(-1, 1); mpfi_intersect(r.x, r.x, x); return r; }
    // The text to which MPFR's printf rounds both ends, or nothing if they differ.
    std::string written(const char* format) const {
        char low[500], high[500];
        mpfr_snprintf(low, sizeof low, format, &x->left), mpfr_snprintf(high, sizeof high, format, &x->right);
        return std::strcmp(low, high) ? "" : low;
    }

    bool holds_zero() const { return mpfi_has_zero(x) > 0; }
    bool is_within(const Interval& o) const { return mpfi_is_inside(x, o.x) > 0; }
    Interval middle() const {
        Interval r;
        mpfi_mid(&r.x->left, x);
        return mpfr_set(&r.x->right, &r.x->left, MPFR_RNDN), r;
    }
    // Upper bounds: of the absolute value, and of the distance from the middle to either end.
    double size() const {
        const double r = std::max(above(), -below());
        expect(std::isfinite(r), "a bound is not finite");
        return r;
    }
    double radius() const { return (*this - middle()).size(); }
    // Lower and upper bound; binary64 nearest to the lower (-1) or upper (1) end.
    double below() const { return mpfr_get_d(&x->left, MPFR_RNDD); }
    double above() const { return mpfr_get_d(&x->right, MPFR_RNDU); }
    double nearest(int side) const { return mpfr_get_d(side < 0 ? &x->left : &x->right, MPFR_RNDN); }

    friend Interval sin(const Interval& a) { Interval r; mpfi_sin(r.x, a.x); return r; }
    friend Interval cos(const Interval& a) { Interval r; mpfi_cos(r.x, a.x); return r; }
    friend Interval exp(const Interval& a) { Interval r; mpfi_exp(r.x, a.x); return r; }
    friend Interval inverse(const Interval& a) { return Interval(1) / a; }
    friend Interval inverse_root(Interval a) {
        expect(a.below() > 0, "a root may be of nothing positive");
        return mpfi_sqrt(a.x, a.x), inverse(a);
    }

private:
    mpfi_t x;
    bool owner = true;
    void init() { mpfi_init2(x, Working::bits); }
};
