$about
#include "$stem.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

#if defined(__FAST_MATH__) || defined(_M_FP_FAST)
#error "expected the rules of IEEE 754: compile without -ffast-math or /fp:fast"
#endif
#if FLT_EVAL_METHOD == 2 || FLT_EVAL_METHOD < 0
#error "expected binary64 arithmetic: compile with -msse2 -mfpmath=sse on 32-bit x86"
#endif

enum { TERMS = $terms };

struct maneuver {
    int number, pieces;
    double end, end_lo;        /* the end of the run is their sum */
    const double *breaks;      /* pieces + 1 times; piece p is from breaks[p] to breaks[p + 1] */
    const double (*hi)[TERMS]; /* Chebyshev coefficients of a column on a piece, */
    const double (*lo)[TERMS]; /* hi + lo, at [column * pieces + piece] */
};

$data
static const struct maneuver *find(int number, int column)
{
    for (size_t i = 0; i < sizeof maneuvers / sizeof *maneuvers; i++)
        if (maneuvers[i].number == number && 0 <= column && column < BICYCLE_COLUMNS)
            return &maneuvers[i];
    return NULL;
}

/* Index of the piece with t + t_lo; a break belongs to the piece on its right, the end to the last. */
static int locate(const struct maneuver *m, double t, double t_lo)
{
    int low = 0, high = m->pieces;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (t > m->breaks[middle] || (t == m->breaks[middle] && t_lo >= 0))
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Clenshaw's rule for sum_k c_k T_k(x): b_k = c_k + 2 x b_(k+1) - b_(k+2). */
double bicycle_evaluate(int maneuver, int column, double t)
{
    const struct maneuver *m = find(maneuver, column);
    if (!m || !(t >= 0 && t <= m->end))
        return NAN;
    int piece = locate(m, t, 0);
    double a = m->breaks[piece], b = m->breaks[piece + 1];
    const double *c = m->hi[column * m->pieces + piece];
    double x = ((t - a) - (b - t)) / (b - a), b1 = 0, b2 = 0;
    for (int k = TERMS - 1; k > 0; k--) {
        double next = c[k] + (2 * x * b1 - b2);
        b2 = b1;
        b1 = next;
    }
    return c[0] + (x * b1 - b2);
}

/* Error-free: a + b and a * b are hi + lo exactly. */
struct pair {
    double hi, lo;
};

static struct pair sum(double a, double b)
{
    double s = a + b, v = s - a;
    return (struct pair){s, (a - (s - v)) + (b - v)};
}

static struct pair quick_sum(double a, double b) /* abs(a) >= abs(b) */
{
    double s = a + b;
    return (struct pair){s, b - (s - a)};
}

static struct pair product(double a, double b)
{
    double p = a * b;
    return (struct pair){p, fma(a, b, -p)};
}

/* 2 (t - a) / (b - a) - 1 */
static struct pair argument(struct pair t, double a, double b)
{
    struct pair s = sum(2 * t.hi, -a);
    s = quick_sum(s.hi, s.lo + 2 * t.lo);
    struct pair d = sum(s.hi, -b);
    d = quick_sum(d.hi, d.lo + s.lo);
    double q = d.hi / (b - a);
    struct pair p = product(q, b - a);
    return quick_sum(q, (((d.hi - p.hi) - p.lo) + d.lo) / (b - a));
}

void bicycle_evaluate_pair(int maneuver, int column, double t, double t_lo, double pair[2])
{
    const struct maneuver *m = find(maneuver, column);
    struct pair at = sum(t, t_lo), b1 = {0, 0}, b2 = {0, 0};
    pair[0] = pair[1] = NAN;
    if (!m || !(at.hi >= 0 && (at.hi < m->end || (at.hi == m->end && at.lo <= m->end_lo))))
        return;
    int piece = locate(m, at.hi, at.lo);
    struct pair x = argument(at, m->breaks[piece], m->breaks[piece + 1]);
    const double *hi = m->hi[column * m->pieces + piece];
    const double *lo = m->lo[column * m->pieces + piece];
    for (int k = TERMS - 1; k >= 0; k--) {
        int twice = k > 0 ? 2 : 1;
        struct pair p = product(twice * x.hi, b1.hi);
        struct pair term = sum(hi[k], -b2.hi), total = sum(term.hi, p.hi);
        double rest = p.lo + (twice * x.hi * b1.lo + twice * x.lo * b1.hi);
        rest += term.lo + (lo[k] - b2.lo);
        b2 = b1;
        b1 = quick_sum(total.hi, total.lo + rest);
    }
    pair[0] = b1.hi;
    pair[1] = b1.lo;
}
