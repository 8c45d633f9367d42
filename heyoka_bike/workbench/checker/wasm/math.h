/* What the header needs of <math.h>, for WebAssembly without a C library: the elementary functions are
   those of the page's language. */
#ifndef CHECKER_MATH_H
#define CHECKER_MATH_H

#define NAN __builtin_nan("")
#define INFINITY __builtin_inf()

double sin(double), cos(double), atan2(double, double), log(double), log10(double);
double pow(double, double);

static inline double fabs(double x) { return __builtin_fabs(x); }
static inline double floor(double x) { return __builtin_floor(x); }
static inline double sqrt(double x) { return __builtin_sqrt(x); }
/* Of a number and none, the number. */
static inline double fmax(double x, double y) { return x != x || x < y ? (y == y ? y : x) : x; }
static inline double fmin(double x, double y) { return x != x || y < x ? (y == y ? y : x) : x; }

static inline double ldexp(double x, int n)
{
    for (; n > 0; n--)
        x *= 2;
    for (; n < 0; n++)
        x /= 2;
    return x;
}

/* Of a normal number: a half or more and less than one, times two to the power of n. */
static inline double frexp(double x, int *n)
{
    union { double x; unsigned long long bits; } u = {x};
    *n = (int)(u.bits >> 52 & 0x7ff) - 1022;
    u.bits = (u.bits & ~(0x7ffULL << 52)) | 0x3feULL << 52;
    return u.x;
}

#endif
