/* Extrapolation in binary128, for comparison: the explicit midpoint rule with 2, 4, 6, ... steps,
   extrapolated by Aitken and Neville's scheme, with a fixed number of columns.

   W. B. Gragg, On extrapolation algorithms for ordinary initial value problems, SIAM Journal
   on Numerical Analysis 2, 384-403 (1965); E. Hairer, S. P. Norsett and G. Wanner, Solving Ordinary Differential
   Equations I, 2nd edition, Springer 1993, section II.9. equations.h is generated from the model. */

#include <quadmath.h>
#include <stdio.h>

#define N 6
#define MOST 24
#define MOST_STEPS 10000
#define EACH for (int i = 0; i < N; i++)

typedef __float128 real;
#define sin sinq
#define cos cosq
#define sqrt sqrtq

#include "equations.h"

/* Computes one step of length h; returns its error, estimated by the difference of the last two results. */
static real step(int columns, real h, const real *y, const real *first, real *end)
{
    static const real two = 2;
    real t[MOST][N], error = 0;
    for (int j = 0; j < columns; j++) {
        const int n = 2 * (j + 1);
        const real d = h / n;
        real before[N], here[N], f[N];
        EACH { before[i] = y[i]; here[i] = y[i] + d * first[i]; }
        for (int m = 1; m < n; m++) {
            slope(here, f);
            EACH { const real next = before[i] + two * d * f[i]; before[i] = here[i]; here[i] = next; }
        }
        /* t[j - k] becomes the entry of column k, starting with the first column. */
        EACH t[j][i] = here[i];
        for (int k = 1; k <= j; k++) {
            const real q = (real)(j + 1) / (j + 1 - k), w = 1 / (q * q - 1);
            EACH t[j - k][i] = t[j - k + 1][i] + (t[j - k + 1][i] - t[j - k][i]) * w;
        }
    }
    EACH {
        const real e = fabsq(t[0][i] - t[1][i]) / (1 + fabsq(y[i]));
        error = fmaxq(error, e);
        end[i] = t[0][i];
    }
    return error;
}

/* Integrates from time 0 to `duration`, with numbers as text. Returns the number of calls of the
   right-hand side, or -1 if the run does not reach its end. */
long extrapolate(
    int columns, const char *const *start, const char *duration, double tolerance, char (*found)[64])
{
    const real stop = strtoflt128(duration, 0);
    const int order = 2 * columns - 1;
    real y[N], f[N], end[N], t = 0, h = stop / 64;
    long calls = 0;
    EACH y[i] = strtoflt128(start[i], 0);
    for (long steps = 0; steps < MOST_STEPS && t < stop; steps++) {
        if (t + h > stop) h = stop - t;
        slope(y, f);
        const real error = step(columns, h, y, f, end);
        calls += 1 + (long)columns * columns;
        if (!finiteq(error)) { h /= 4; continue; }
        const real change = 0.9Q * powq(tolerance / fmaxq(error, 1e-60Q), 1 / (real)order);
        if (error <= tolerance) {
            t += h;
            EACH y[i] = end[i];
        }
        h *= fminq(4, fmaxq(0.2Q, change));
    }
    EACH quadmath_snprintf(found[i], 64, "%.36Qe", y[i]);
    return t < stop ? -1 : calls;
}
