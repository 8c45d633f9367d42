/* Runge-Kutta integrators for comparison: adaptive DOPRI5 and DOP853 with their dense output, and
   the classical RK4 at a fixed step.

   The formulas and step laws are those of E. Hairer, S. P. Norsett and G. Wanner, Solving Ordinary
   Differential Equations I, 2nd edition, Springer 1993, and of their programs dopri5.f and
   dop853.f, with the options' default values. equations.h is generated from the model, and contains
   the weighted sums of DOP853's step from ../fast/dop853.toml. */

#include <math.h>

#define N 6
#define STAGES 16
#define DENSE 8
#define BLOCK 128
#define MOST_STEPS 10000000
#define EACH for (int i = 0; i < N; i++)

/* The GNU C library has vectorised sines and cosines, but declares them only under -ffast-math. */
#if defined(__GLIBC__) && defined(__x86_64__) && !defined(__clang__)
extern double sin(double) __attribute__((simd("notinbranch"), const));
extern double cos(double) __attribute__((simd("notinbranch"), const));
#endif

#include "equations.h"

static double larger(double a, double b) { return fmax(fabs(a), fabs(b)); }

/* Dormand and Prince, order 5(4), with the dense output of order 4 of dopri5.f. */
static double dopri5_step(double h, const double *y, double (*k)[N], double *end, double tol)
{
    double s[N], square = 0;
    EACH s[i] = y[i] + h * (
        0.2 * k[0][i]);
    slope(s, k[1]);
    EACH s[i] = y[i] + h * (
        0.075 * k[0][i] + 0.225 * k[1][i]);
    slope(s, k[2]);
    EACH s[i] = y[i] + h * (
        0.9777777777777777 * k[0][i] - 3.7333333333333334 * k[1][i]
        + 3.5555555555555554 * k[2][i]);
    slope(s, k[3]);
    EACH s[i] = y[i] + h * (
        2.9525986892242035 * k[0][i] - 11.595793324188385 * k[1][i]
        + 9.822892851699436 * k[2][i] - 0.2908093278463649 * k[3][i]);
    slope(s, k[4]);
    EACH s[i] = y[i] + h * (
        2.8462752525252526 * k[0][i] - 10.757575757575758 * k[1][i]
        + 8.906422717743473 * k[2][i] + 0.2784090909090909 * k[3][i]
        - 0.2735313036020583 * k[4][i]);
    slope(s, k[5]);
    EACH end[i] = y[i] + h * (
        0.09114583333333333 * k[0][i] + 0.44923629829290207 * k[2][i]
        + 0.6510416666666666 * k[3][i] - 0.322376179245283 * k[4][i]
        + 0.13095238095238096 * k[5][i]);
    slope(end, k[6]);
    EACH {
        const double e = h * (
            -0.0012326388888888888 * k[0][i] + 0.0042527702905061394 * k[2][i]
            - 0.03697916666666667 * k[3][i] + 0.05086379716981132 * k[4][i]
            - 0.0419047619047619 * k[5][i] + 0.025 * k[6][i]);
        const double r = e / (tol + tol * larger(y[i], end[i]));
        square += r * r;
    }
    return sqrt(square / N);
}

static void dopri5_dense(
    double h, const double *y, double (*k)[N], const double *end, double (*c)[N])
{
    EACH {
        const double rise = end[i] - y[i];
        c[0][i] = y[i];
        c[1][i] = rise;
        c[2][i] = h * k[0][i] - rise;
        c[3][i] = 2 * rise - h * (k[6][i] + k[0][i]);
        c[4][i] = h * (-12715105075.0 / 11282082432.0 * k[0][i]
            + 87487479700.0 / 32700410799.0 * k[2][i] - 10690763975.0 / 1880347072.0 * k[3][i]
            + 701980252875.0 / 199316789632.0 * k[4][i] - 1453857185.0 / 822651844.0 * k[5][i]
            + 69997945.0 / 29380423.0 * k[6][i]);
    }
}

/* Dormand, Prince and Hairer, order 8(5,3), with the dense output of order 7 of dop853.f. */
static double dop853_step(double h, const double *y, double (*k)[N], double *end, double tol)
{
    double s[N], fifth = 0, third = 0;
    EACH s[i] = y[i] + h * STAGE_1;
    slope(s, k[1]);
    EACH s[i] = y[i] + h * STAGE_2;
    slope(s, k[2]);
    EACH s[i] = y[i] + h * STAGE_3;
    slope(s, k[3]);
    EACH s[i] = y[i] + h * STAGE_4;
    slope(s, k[4]);
    EACH s[i] = y[i] + h * STAGE_5;
    slope(s, k[5]);
    EACH s[i] = y[i] + h * STAGE_6;
    slope(s, k[6]);
    EACH s[i] = y[i] + h * STAGE_7;
    slope(s, k[7]);
    EACH s[i] = y[i] + h * STAGE_8;
    slope(s, k[8]);
    EACH s[i] = y[i] + h * STAGE_9;
    slope(s, k[9]);
    EACH s[i] = y[i] + h * STAGE_10;
    slope(s, k[10]);
    EACH s[i] = y[i] + h * STAGE_11;
    slope(s, k[11]);
    EACH end[i] = y[i] + h * STEP;
    slope(end, k[12]);
    EACH {
        const double weight = 1 / (tol + tol * larger(y[i], end[i]));
        const double e5 = weight * FIFTH;
        const double e3 = weight * THIRD;
        fifth += e5 * e5;
        third += e3 * e3;
    }
    const double both = fifth + 0.01 * third;
    return both == 0 ? 0 : fabs(h) * fifth / sqrt(N * both);
}

static void dop853_dense(
    double h, const double *y, double (*k)[N], const double *end, double (*c)[N])
{
    double s[N];
    EACH s[i] = y[i] + h * (
        0.056167502283047954 * k[0][i] + 0.25350021021662483 * k[6][i]
        - 0.2462390374708025 * k[7][i] - 0.12419142326381637 * k[8][i]
        + 0.15329179827876568 * k[9][i] + 0.00820105229563469 * k[10][i]
        + 0.007567897660545699 * k[11][i] - 0.008298 * k[12][i]);
    slope(s, k[13]);
    EACH s[i] = y[i] + h * (
        0.03183464816350214 * k[0][i] + 0.028300909672366776 * k[5][i]
        + 0.053541988307438566 * k[6][i] - 0.05492374857139099 * k[7][i]
        - 0.00010834732869724932 * k[10][i] + 0.0003825710908356584 * k[11][i]
        - 0.00034046500868740456 * k[12][i] + 0.1413124436746325 * k[13][i]);
    slope(s, k[14]);
    EACH s[i] = y[i] + h * (
        -0.42889630158379194 * k[0][i] - 4.697621415361164 * k[5][i]
        + 7.683421196062599 * k[6][i] + 4.06898981839711 * k[7][i]
        + 0.3567271874552811 * k[8][i] - 0.0013990241651590145 * k[12][i]
        + 2.9475147891527724 * k[13][i] - 9.15095847217987 * k[14][i]);
    slope(s, k[15]);
    EACH {
        const double rise = end[i] - y[i];
        c[0][i] = y[i];
        c[1][i] = rise;
        c[2][i] = h * k[0][i] - rise;
        c[3][i] = 2 * rise - h * (k[12][i] + k[0][i]);
        c[4][i] = h * (
            -8.428938276109013 * k[0][i] + 0.5667149535193777 * k[5][i]
            - 3.0689499459498917 * k[6][i] + 2.38466765651207 * k[7][i]
            + 2.117034582445028 * k[8][i] - 0.871391583777973 * k[9][i]
            + 2.2404374302607883 * k[10][i] + 0.6315787787694688 * k[11][i]
            - 0.08899033645133331 * k[12][i] + 18.148505520854727 * k[13][i]
            - 9.194632392478356 * k[14][i] - 4.436036387594894 * k[15][i]);
        c[5][i] = h * (
            10.427508642579134 * k[0][i] + 242.28349177525817 * k[5][i]
            + 165.20045171727028 * k[6][i] - 374.5467547226902 * k[7][i]
            - 22.113666853125306 * k[8][i] + 7.733432668472264 * k[9][i]
            - 30.674084731089398 * k[10][i] - 9.332130526430229 * k[11][i]
            + 15.697238121770845 * k[12][i] - 31.139403219565178 * k[13][i]
            - 9.35292435884448 * k[14][i] + 35.81684148639408 * k[15][i]);
        c[6][i] = h * (
            19.985053242002433 * k[0][i] - 387.0373087493518 * k[5][i]
            - 189.17813819516758 * k[6][i] + 527.8081592054236 * k[7][i]
            - 11.57390253995963 * k[8][i] + 6.8812326946963 * k[9][i]
            - 1.0006050966910838 * k[10][i] + 0.7777137798053443 * k[11][i]
            - 2.778205752353508 * k[12][i] - 60.19669523126412 * k[13][i]
            + 84.32040550667716 * k[14][i] + 11.99229113618279 * k[15][i]);
        c[7][i] = h * (
            -25.69393346270375 * k[0][i] - 154.18974869023643 * k[5][i]
            - 231.5293791760455 * k[6][i] + 357.6391179106141 * k[7][i]
            + 93.40532418362432 * k[8][i] - 37.45832313645163 * k[9][i]
            + 104.0996495089623 * k[10][i] + 29.8402934266605 * k[11][i]
            - 43.53345659001114 * k[12][i] + 96.32455395918828 * k[13][i]
            - 39.17726167561544 * k[14][i] - 149.72683625798564 * k[15][i]);
    }
}
struct method {
    double (*step)(double, const double *, double (*)[N], double *, double);
    void (*dense)(double, const double *, double (*)[N], const double *, double (*)[N]);
    int order, last, calls, dense_calls, terms; /* last: stage that is the first of the next step */
    double beta, least, most;                   /* exponent of the step controller; limits of a change of the step */
};

static const struct method METHODS[] = {
    {dopri5_step, dopri5_dense, 5, 6, 6, 0, 5, 0.04, 0.2, 10},
    {dop853_step, dop853_dense, 8, 12, 12, 3, 8, 0, 1.0 / 3, 6},
};

static double norm(const double *x, const double *y, double tol)
{
    double square = 0;
    EACH square += x[i] * x[i] / ((tol + tol * fabs(y[i])) * (tol + tol * fabs(y[i])));
    return sqrt(square / N);
}

/* Returns a first step from the first derivative and an estimate of the second. */
static double first_step(int order, const double *y, const double *f, double tol, double longest)
{
    const double size = norm(y, y, tol), slope_size = norm(f, y, tol);
    double h = size < 1e-5 || slope_size < 1e-5 ? 1e-6 : 0.01 * size / slope_size;
    double ahead[N], g[N];
    h = fmin(h, longest);
    EACH ahead[i] = y[i] + h * f[i];
    slope(ahead, g);
    EACH g[i] -= f[i];
    const double most = fmax(norm(g, y, tol) / h, slope_size);
    const double h1 = most <= 1e-15 ? fmax(1e-6, 1e-3 * h) : pow(0.01 / most, 1.0 / order);
    return fmin(fmin(100 * h, h1), longest);
}

#define UP(j, above) (c[j][i] + (j % 2 ? 1 - s[r] : s[r]) * (above))
#define CUBIC(above) UP(0, UP(1, UP(2, above)))
#define SEVENTH(above) CUBIC(UP(3, UP(4, UP(5, UP(6, above)))))

/* Computes the rows from `row` up to the time t + h; returns the first row beyond. Callers pass
   `terms` (4, 5 or 8) as a constant, so that the compiler vectorises over rows. */
static inline __attribute__((always_inline)) long rows_of_step(
    long row, long n, const double *restrict times, double t, double h, const int terms,
    double (*restrict c)[N], double *restrict y)
{
    double s[BLOCK];
    long stop = row;
    while (stop < n && times[stop] <= t + h) stop++;
    for (; row < stop; row += BLOCK) {
        const long count = stop - row < BLOCK ? stop - row : BLOCK;
        for (long r = 0; r < count; r++) s[r] = (times[row + r] - t) / h;
        EACH {
            double *restrict to = y + i * n + row;
#pragma GCC ivdep
            for (long r = 0; r < count; r++)
                to[r] = terms == 4   ? CUBIC(c[3][i])
                        : terms == 5 ? CUBIC(UP(3, c[4][i]))
                                     : SEVENTH(c[7][i]);
        }
    }
    return stop;
}

static long adaptive(const struct method *m, const double *start, long n, const double *times,
                     double tol, double *rows)
{
    double y[N], end[N], k[STAGES][N], c[DENSE][N], t = times[0], last_error = 1e-4;
    const double finish = times[n - 1], power = 1.0 / m->order - m->beta * 0.75;
    long row = 0, calls = 2;
    int was_rejected = 0;
    EACH y[i] = start[i];
    slope(y, k[0]);
    double h = first_step(m->order, y, k[0], tol, finish - t);
    for (long steps = 0; row < n; steps++) {
        const int is_last = t + 1.01 * h >= finish;
        if (is_last) h = finish - t;
        const double error = m->step(h, y, k, end, tol);
        calls += m->calls;
        if (!(error < HUGE_VAL) || steps >= MOST_STEPS || t + 0.1 * h == t) return -1;
        const double wish = pow(error, power);
        if (error > 1) {
            h /= fmin(1 / m->least, wish / 0.9);
            was_rejected = 1;
            continue;
        }
        double change = wish / pow(last_error, m->beta) / 0.9;
        change = fmax(1 / m->most, fmin(1 / m->least, change));
        last_error = fmax(error, 1e-4);
        if (times[row] <= t + h || is_last) {
            m->dense(h, y, k, end, c);
            calls += m->dense_calls;
            /* The last step ends at the last row, even if rounding makes it slightly shorter. */
            const double reach = is_last ? h * (1 + 1e-15) : h;
            row = m->terms == 5 ? rows_of_step(row, n, times, t, reach, 5, c, rows)
                                : rows_of_step(row, n, times, t, reach, 8, c, rows);
        }
        EACH y[i] = end[i];
        EACH k[0][i] = k[m->last][i];
        t += h;
        h /= was_rejected ? fmax(change, 1) : change;
        was_rejected = 0;
        if (is_last) break;
    }
    return row == n ? calls : -1;
}

/* Integrates by RK4 with equal steps; the rows come from cubic Hermite interpolation. */
static long fixed(const double *start, long n, const double *times, double longest, double *rows)
{
    double y[N], end[N], s[N], k[5][N], c[4][N];
    const double begin = times[0], span = times[n - 1] - begin;
    const long steps = (long)ceil(span / longest);
    const double h = span / steps;
    long row = 0;
    EACH y[i] = start[i];
    slope(y, k[0]);
    for (long step = 0; step < steps; step++) {
        const double t = begin + step * h;
        EACH s[i] = y[i] + h / 2 * k[0][i];
        slope(s, k[1]);
        EACH s[i] = y[i] + h / 2 * k[1][i];
        slope(s, k[2]);
        EACH s[i] = y[i] + h * k[2][i];
        slope(s, k[3]);
        EACH end[i] = y[i] + h / 6 * (k[0][i] + 2 * (k[1][i] + k[2][i]) + k[3][i]);
        slope(end, k[4]);
        EACH {
            const double rise = end[i] - y[i];
            c[0][i] = y[i];
            c[1][i] = rise;
            c[2][i] = h * k[0][i] - rise;
            c[3][i] = 2 * rise - h * (k[4][i] + k[0][i]);
        }
        const double reach = step == steps - 1 ? h * (1 + 1e-12) : h;
        row = rows_of_step(row, n, times, t, reach, 4, c, rows);
        EACH y[i] = end[i];
        EACH k[0][i] = k[4][i];
    }
    return row == n ? 4 * steps + 1 : -1;
}

/* Computes the state and the eight columns at n times, one variable after the other.

   method: 0 DOPRI5, 1 DOP853, with atol = rtol = tol; 2 RK4, with tol as its longest step.
   Returns the number of calls of the right-hand side, or -1 if the run did not reach its end. */
long solve(int method, const double *start, long n, const double *times, double tol, double *y,
           double *out)
{
    const long calls = method == 2 ? fixed(start, n, times, tol, y)
                                   : adaptive(&METHODS[method], start, n, times, tol, y);
    if (calls > 0) columns(n, y, out);
    return calls;
}

/* Evaluates the right-hand side and the columns of one state, for tests. */
void evaluate(const double *y, double *f, double *out)
{
    slope(y, f);
    columns(1, y, out);
}
