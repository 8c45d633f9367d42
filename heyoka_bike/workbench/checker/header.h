$about
#ifndef UNCONTROLLED_BICYCLE_H
#define UNCONTROLLED_BICYCLE_H

/* For instance, of arrays t and roll of n numbers each, in maneuver 2:
       static bicycle_check check;
       char line[160];
       bicycle_begin(&check);
       bicycle_give(&check, 2, BICYCLE_ROLL_ANGLE, n, t, 1, roll, 1);
       bicycle_judge(&check);
       puts(bicycle_line(&check, line, sizeof line));
       assert(check.result[2 - 1][BICYCLE_ROLL_ANGLE].digits >= 6); */

#include <float.h>
#include <math.h>
#include <stddef.h>

#if defined(__FAST_MATH__) || defined(_M_FP_FAST)
#error "expected the rules of IEEE 754: compile without -ffast-math or /fp:fast"
#endif
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error "expected NaN and infinity: compile without -ffinite-math-only"
#endif
#if FLT_EVAL_METHOD == 2 || FLT_EVAL_METHOD < 0
#error "expected binary64 arithmetic: compile with -msse2 -mfpmath=sse on 32-bit x86"
#endif

/* What every function is declared as. A shared library: cc -x c -DBICYCLE_API= -shared -fPIC ... */
#ifndef BICYCLE_API
#define BICYCLE_API static inline
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- What there is ------------------------------------------------------- */

/* The eight columns of the benchmark in the order of its file, each in its default definition, then
   their other definitions. */
enum bicycle_column {
$names
    BICYCLE_COLUMNS /* their number */
};

enum {
    BICYCLE_KEYS = 8,      /* columns of the benchmark */
    BICYCLE_MANEUVERS = $maneuvers /* numbered from 1 */
};

/* Correct digits are counted up to this: the exact motion in here is good to 1e-15 of a column's
   largest value. heyoka-bike score counts up to 32. */
#define BICYCLE_MOST_DIGITS 14.0

/* What a column is; a file has the worst of its columns. */
enum bicycle_grade {
$grades
};

/* A column that is judged. */
typedef struct bicycle_data {
    size_t rows;                 /* 0: it is not there */
    const double *time, *values; /* [s], and in your unit; NaN where there is no value */
    ptrdiff_t time_stride, stride; /* from a number to the next: 1 if they are neighbours */
    int digits;                  /* significant decimal digits that were written; 0: binary64 */
    int places;                  /* digits after the point, if all rows have as many; -1 if not */
} bicycle_data;

/* What was found of it. Errors are those that are left when definition, sign, unit and zero are
   taken as they fit, in SI units. */
typedef struct bicycle_result {
    size_t rows;             /* values compared; 0: nothing, and all else here says nothing */
    double digits;           /* scd: -log10 of the largest error over the largest exact value */
    double mescd;            /* -log10 of the largest error / (1 + abs(exact)) */
    double max_error, time_of_max, rms_error;
    int column;              /* the definition, one of enum bicycle_column */
    unsigned long long also; /* bit 1ULL << column: a definition that fits as well */
    int sign;                /* -1: the other way round */
    const char *unit;        /* of your values */
    double factor;           /* SI value = sign * factor * value - offset */
    double offset;           /* what the energies have too much by another zero [J] */
    int grade;               /* one of enum bicycle_grade */
    int never_filled;        /* one number in every row of what varies: not compared */
    int is_contradicted;     /* its sign is not that of its own angle or rate */
    int is_of_its_own;       /* of a definition that is not known here, of a motion that is right */
} bicycle_result;

typedef struct bicycle_check {
    bicycle_data data[BICYCLE_MANEUVERS][BICYCLE_KEYS];
    bicycle_result result[BICYCLE_MANEUVERS][BICYCLE_KEYS];
    int grade;    /* the worst */
    int bad_time; /* 1 + the place among the eight of a column with a time that is not finite */
    int is_whole; /* whether all eight columns of every maneuver that you gave cover its run, with
                     no value missing; else the grade is only about the part that was compared */
    int columns;     /* the number of compared columns in the maneuver with the fewest; 8 is all */
    double coverage; /* the fraction of the run that the column with the least covers, 0 to 1 */
} bicycle_check;

/* ---- The exact motion ---------------------------------------------------- */

/* From the time a to the time b of a maneuver: coefficients of Chebyshev polynomials of
   $states. Those that are left out vanish. */
enum { UB_STATES = 7, UB_TERMS = $terms };

typedef struct ub_piece {
    double a, b, c[UB_STATES][UB_TERMS];
} ub_piece;

typedef struct ub_unit {
    const char *name;
    double factor;
} ub_unit;

typedef struct ub_column {
    const char *key, *definition;
    int of;       /* the column of the benchmark that it is a definition of */
    int angle_of; /* the definition of the angle that it is the derivative of; -1: none */
} ub_column;

typedef struct ub_maneuver {
    const ub_piece *pieces;
    int count;
    double end;
    double reach;                  /* so far, a little beyond the end, the last piece is continued */
    double varies;                 /* root mean square of the potential energy around its median */
    double scale[BICYCLE_COLUMNS]; /* largest absolute values */
} ub_maneuver;

$data
$columns
/* The rest, to the exact time, of the decimal of at most nine places whose binary64 is t: 0.07 means
   7/100. A time that is no such decimal means itself. */
BICYCLE_API double ub_rest(double t)
{
    double tens = 1, high = (double)(float)t, low = t - high;
    for (; tens <= 1e9; tens *= 10) {
        double k = floor(t * tens + 0.5);
        if (k / tens == t)
            return ((k - high * tens) - low * tens) / tens;
    }
    return 0;
}

BICYCLE_API void ub_state(const ub_maneuver *m, double t, double y[UB_STATES])
{
    int low = 0, high = m->count, i, k;
    double x, b1, b2, next;
    const ub_piece *p;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (t >= m->pieces[middle].a)
            low = middle;
        else
            high = middle;
    }
    p = &m->pieces[low];
    x = (((t - p->a) - (p->b - t)) + 2 * ub_rest(t)) / (p->b - p->a);
    for (i = 0; i < UB_STATES; i++) { /* Clenshaw's rule */
        b1 = b2 = 0;
        for (k = UB_TERMS - 1; k > 0; k--) {
            next = p->c[i][k] + (2 * x * b1 - b2);
            b2 = b1;
            b1 = next;
        }
        y[i] = p->c[i][0] + (x * b1 - b2);
    }
}

/* All columns of a maneuver (1, 2, ...) at the time t [s]; NaN for a time outside the run. */
BICYCLE_API void bicycle_evaluate_all(int maneuver, double t, double values[BICYCLE_COLUMNS])
{
    double y[UB_STATES];
    int i, is_known = 1 <= maneuver && maneuver <= BICYCLE_MANEUVERS;
    /* Steps that are summed may end late. */
    if (is_known && t >= 0 && t <= ub_maneuvers[maneuver - 1].reach) {
        ub_state(&ub_maneuvers[maneuver - 1], t, y);
        ub_columns(y, values);
    } else
        for (i = 0; i < BICYCLE_COLUMNS; i++)
            values[i] = NAN;
}

/* One of them; NaN for a maneuver or column that is not known, too. */
BICYCLE_API double bicycle_evaluate(int maneuver, int column, double t)
{
    double values[BICYCLE_COLUMNS];
    bicycle_evaluate_all(maneuver, t, values);
    return 0 <= column && column < BICYCLE_COLUMNS ? values[column] : NAN;
}

/* Names of a column, such as "roll_angle" and "lean". */
BICYCLE_API const char *bicycle_key(int column) { return ub_names[column].key; }
BICYCLE_API const char *bicycle_definition(int column) { return ub_names[column].definition; }

/* What a grade means, such as "right". */
BICYCLE_API const char *bicycle_word(int grade) { return ub_words[grade]; }

/* ---- What the columns mean --------------------------------------------------------------------
   As heyoka-bike score has it (scoring/definitions.py): the likelihood of a candidate is
   typical^-3 in each maneuver, where typical is the root mean square of its error without the
   largest hundredth of the rows; the default, and what belongs to the definition of the angle, is
   five times as likely before; odds below 20 to 1 are left open. The first row tells the unit and
   the sign of a motion that is wrong. */

enum { UB_SAMPLE = 4001, UB_FEW_ROWS = 10, UB_LEFT_OUT = 100, UB_WAYS = 2 * UB_UNITS };
#define UB_VALUES 3.0                  /* an error curve counts as so many */
#define UB_CLAIMED 2.995732273553991  /* log 20 */
#define UB_SELDOM 6.907755278982137   /* log 1000 */
#define UB_AGAINST_NONE 4.605170185988092 /* log 100 */
#define UB_EXPECTED 1.6094379124341003 /* log 5 */
#define UB_CLEARLY 10.0
#define UB_HALF 0.5
#define UB_NEAR 0.02
#define UB_FAR_ZERO 0.1
#define UB_KNOWN 1e-15    /* of the scale: what binary64 resolves */
#define UB_LARGEST 1e150  /* no program means more */

typedef struct ub_sample {
    int count, is_from_start;
    double scale, written, known; /* half a written digit, and what binary64 resolves */
    double time[UB_SAMPLE], value[UB_SAMPLE], exact[UB_SAMPLE], error[UB_SAMPLE];
} ub_sample;

/* How a column is taken. */
typedef struct ub_taken {
    int is_there, column, sign, unit;
    double offset;
    unsigned long long also;
} ub_taken;

BICYCLE_API double ub_time(const bicycle_data *d, size_t i)
{
    return d->time[(ptrdiff_t)i * d->time_stride];
}

BICYCLE_API double ub_value(const bicycle_data *d, size_t i)
{
    double x = d->values[(ptrdiff_t)i * d->stride];
    return fabs(x) <= UB_LARGEST ? x : NAN;
}

BICYCLE_API int ub_is_within(int m, double t)
{
    return t >= 0 && t <= ub_maneuvers[m].reach;
}

BICYCLE_API size_t ub_rows_within(const bicycle_data *d, int m)
{
    size_t i, found = 0;
    for (i = 0; i < d->rows; i++)
        found += ub_is_within(m, ub_time(d, i)) ? 1 : 0;
    return found;
}

/* The k-th smallest of x, with the smaller ones before it: Hoare's FIND. */
BICYCLE_API double ub_select(double *x, int n, int k)
{
    int low = 0, high = n - 1;
    while (low < high) {
        double pivot = x[k], swap;
        int i = low, j = high;
        while (i <= j) {
            while (x[i] < pivot)
                i++;
            while (pivot < x[j])
                j--;
            if (i <= j) {
                swap = x[i];
                x[i++] = x[j];
                x[j--] = swap;
            }
        }
        if (j < k)
            low = i;
        if (k < i)
            high = j;
    }
    return x[k];
}

BICYCLE_API double ub_median(double *x, int n)
{
    double low = ub_select(x, n, (n - 1) / 2);
    return (low + ub_select(x, n, n / 2)) / 2;
}

BICYCLE_API double ub_rms(const double *x, int n)
{
    double largest = 0, sum = 0;
    int i;
    for (i = 0; i < n; i++)
        largest = fmax(largest, fabs(x[i]));
    if (largest == 0 || n == 0)
        return 0;
    for (i = 0; i < n; i++)
        sum += (x[i] / largest) * (x[i] / largest);
    return largest * sqrt(sum / n);
}

/* Distance of neighbouring numbers of so many bits at x, which is not negative. */
BICYCLE_API double ub_binary(double x, int bits)
{
    int exponent;
    if (x < DBL_MIN)
        return 0;
    frexp(x, &exponent);
    return ldexp(1, exponent - bits);
}

/* Distance of neighbouring written numbers at x; bits of a column in binary. */
BICYCLE_API double ub_spacing(const bicycle_data *d, int bits, double x)
{
    double exponent, size = fabs(x);
    if (d->places >= 0)
        return pow(10, -d->places);
    if (size < DBL_MIN)
        return 0;
    if (d->digits > 0 && d->digits < 17) {
        exponent = floor(log10(size));
        exponent += pow(10, exponent + 1) <= size;
        return pow(10, exponent - d->digits + 1);
    }
    return ub_binary(size, bits);
}

/* 24 if all values are single precision numbers, and not only integers; else 53. */
BICYCLE_API int ub_bits(const bicycle_data *d)
{
    size_t i;
    int has_fraction = 0;
    for (i = 0; i < d->rows; i++) {
        double x = ub_value(d, i);
        if (x == x && (fabs(x) > FLT_MAX || (double)(float)x != x))
            return 53;
        has_fraction |= x == x && x != floor(x);
    }
    return has_fraction ? 24 : 53;
}

/* At most UB_SAMPLE of the rows within the run, evenly spread, without those that have no value. */
BICYCLE_API int ub_take(const bicycle_check *c, int m, int key, ub_sample *s)
{
    const bicycle_data *d = &c->data[m][key];
    size_t rows = d->rows ? ub_rows_within(d, m) : 0, i, row = 0, next = 0;
    int taken = 0, bits;
    s->count = s->is_from_start = 0;
    if (c->result[m][key].never_filled)
        return 0;
    for (i = 0; i < d->rows; i++) {
        double t = ub_time(d, i), x = ub_value(d, i);
        if (!ub_is_within(m, t) || row++ != next)
            continue;
        if (x == x) {
            if (taken == 0)
                s->is_from_start = t == 0;
            s->time[s->count] = t;
            s->value[s->count++] = x;
        }
        taken++;
        next = rows <= UB_SAMPLE ? row : (size_t)(taken * ((double)(rows - 1) / (UB_SAMPLE - 1)));
        if (taken == UB_SAMPLE - 1)
            next = rows - 1;
    }
    if (!s->count)
        return 0;
    s->scale = ub_maneuvers[m].scale[key];
    s->known = s->scale > 0 ? UB_KNOWN * s->scale : DBL_MIN;
    bits = ub_bits(d);
    for (i = 0; i < (size_t)s->count; i++)
        s->error[i] = ub_spacing(d, bits, s->value[i]);
    s->written = ub_median(s->error, s->count) / 2;
    return s->count;
}

BICYCLE_API void ub_expect(ub_sample *s, int m, int column)
{
    int i;
    for (i = 0; i < s->count; i++)
        s->exact[i] = bicycle_evaluate(m + 1, column, s->time[i]);
}

BICYCLE_API double ub_factor(int key, const ub_taken *u)
{
    return ub_units[key][u->unit].factor;
}

BICYCLE_API double ub_smallest(const ub_sample *s, double factor)
{
    return fmax(s->written * factor, s->known);
}

BICYCLE_API void ub_compare(ub_sample *s, double factor, double offset)
{
    int i;
    for (i = 0; i < s->count; i++)
        s->error[i] = factor * s->value[i] - offset - s->exact[i];
}

/* The typical error of what `ub_compare` found, which it puts into another order. */
BICYCLE_API double ub_typical(ub_sample *s, double smallest)
{
    int i, kept = s->count - s->count / UB_LEFT_OUT;
    for (i = 0; i < s->count; i++)
        s->error[i] = fabs(s->error[i]);
    if (kept < s->count)
        ub_select(s->error, s->count, kept);
    return fmax(ub_rms(s->error, kept), smallest);
}

/* Of a column as it is taken, in one maneuver; 0 without it. */
BICYCLE_API double ub_typical_of(const bicycle_check *c, int m, int key, const ub_taken *u,
                                 ub_sample *s)
{
    double factor = ub_factor(key, u);
    if (!ub_take(c, m, key, s))
        return 0;
    ub_expect(s, m, u->column);
    ub_compare(s, u->sign * factor, u->offset);
    return ub_typical(s, ub_smallest(s, factor));
}

BICYCLE_API int ub_is_energy(int key)
{
    return BICYCLE_POTENTIAL_ENERGY <= key && key <= BICYCLE_MECHANICAL_ENERGY;
}

BICYCLE_API int ub_units_of(int key)
{
    int n = 0;
    while (n < UB_UNITS && ub_units[key][n].name)
        n++;
    return n;
}

/* How likely each definition is, in each way: a unit and a sign; as natural logarithms. */
typedef struct ub_odds {
    int signs, ways;
    double likely[UB_WAYS][BICYCLE_COLUMNS], before[BICYCLE_COLUMNS];
} ub_odds;

/* Unit and sign of a way. */
BICYCLE_API void ub_go(ub_taken *u, const ub_odds *o, int way)
{
    u->unit = way / o->signs;
    u->sign = way % o->signs ? -1 : 1;
}

/* Weighs all candidates; 0 if the column is in no maneuver. */
BICYCLE_API int ub_weigh(const bicycle_check *c, int key, const ub_taken found[BICYCLE_KEYS],
                         ub_odds *o, ub_sample *s)
{
    int m, i, way, is_there = 0;
    o->signs = ub_is_energy(key) ? 1 : 2;
    o->ways = ub_units_of(key) * o->signs;
    for (i = 0; i < BICYCLE_COLUMNS; i++) {
        int angle = ub_names[i].angle_of;
        int belongs = angle >= 0 && found[ub_names[angle].of].is_there;
        belongs = belongs && found[ub_names[angle].of].column == angle;
        o->before[i] = i == key || belongs ? UB_EXPECTED : 0;
        for (way = 0; way < UB_WAYS; way++)
            o->likely[way][i] = ub_names[i].of == key ? o->before[i] : -INFINITY;
    }
    for (m = 0; m < BICYCLE_MANEUVERS; m++) {
        if (!ub_take(c, m, key, s))
            continue;
        is_there = 1;
        for (i = 0; i < BICYCLE_COLUMNS; i++) {
            if (ub_names[i].of != key)
                continue;
            ub_expect(s, m, i);
            for (way = 0; way < o->ways; way++) {
                double factor = ub_units[key][way / o->signs].factor, first = 0, smallest;
                smallest = ub_smallest(s, factor);
                ub_compare(s, way % o->signs ? -factor : factor, 0);
                if (s->is_from_start) /* where no integrator has made an error yet */
                    first = fmin(log(fmax(fabs(s->error[0]) / smallest, 1)), UB_SELDOM);
                o->likely[way][i] -= UB_VALUES * log(ub_typical(s, smallest)) + first;
            }
        }
    }
    return is_there;
}

/* The likeliest definition in a way; of equals the first, the default. */
BICYCLE_API int ub_likeliest(const ub_odds *o, int key, int way)
{
    int i, found = key;
    for (i = 0; i < BICYCLE_COLUMNS; i++)
        if (o->likely[way][i] > o->likely[way][found])
            found = i;
    return found;
}

/* Whether there are rows enough to tell anything, or the few of them fit to the last digit; and
   whether the typical error is below half the size of the column itself, as no noise is that is
   scaled down to nothing. */
BICYCLE_API int ub_is_shown(const bicycle_check *c, int key, const ub_taken *u, int *is_near,
                            ub_sample *s)
{
    double sizes = 0, errors = 0, limit = UB_NEAR;
    int m, i, count = 0, has_rows = 0, meets_floor = 1;
    *is_near = 1;
    for (m = 0; m < BICYCLE_MANEUVERS; m++) {
        double typical = ub_typical_of(c, m, key, u, s), low = INFINITY, high = -INFINITY, size;
        if (!s->count)
            continue;
        count++;
        errors += log(typical);
        has_rows |= s->count >= UB_FEW_ROWS;
        meets_floor = meets_floor && typical <= UB_CLEARLY * (s->written + s->known);
        ub_expect(s, m, key);
        for (i = 0; i < s->count; i++) {
            low = fmin(low, s->exact[i]);
            high = fmax(high, s->exact[i]);
        }
        if (high - low >= UB_HALF * s->scale)
            limit = UB_HALF;
        size = ub_rms(s->exact, s->count);
        *is_near = *is_near && size > 0;
        sizes += log(fmax(size, DBL_MIN));
    }
    *is_near = *is_near && errors < sizes + count * log(limit);
    return has_rows || meets_floor;
}

/* The likelihood of one number in the place of the column. */
BICYCLE_API double ub_of_a_constant(const bicycle_check *c, int key, const ub_taken *u,
                                    ub_sample *s)
{
    double found = 0, factor = ub_factor(key, u);
    int m, i;
    for (m = 0; m < BICYCLE_MANEUVERS; m++) {
        double mean = 0, varies;
        if (!ub_take(c, m, key, s))
            continue;
        for (i = 0; i < s->count; i++)
            mean += s->value[i] / s->count;
        for (i = 0; i < s->count; i++)
            s->error[i] = s->value[i] - mean;
        varies = factor * ub_rms(s->error, s->count);
        found -= UB_VALUES * log(fmax(varies, ub_smallest(s, factor)));
    }
    return found;
}

/* Whether the first value of a column is the given one in every maneuver, in a unit and sign. */
BICYCLE_API int ub_begins(const bicycle_check *c, int key, double factor, ub_sample *s)
{
    int m, has_start = 0;
    for (m = 0; m < BICYCLE_MANEUVERS; m++) {
        double given;
        if (!ub_take(c, m, key, s) || !s->is_from_start)
            continue;
        given = bicycle_evaluate(m + 1, key, s->time[0]);
        if (fabs(given) <= UB_TOLERANCE * s->scale)
            continue;
        has_start = 1;
        if (!(fabs(factor * s->value[0] - given) <= UB_TOLERANCE * fabs(given)))
            return 0;
    }
    return has_start;
}

/* The way of each column whose first row is the given value in one way alone; -1 of the others. */
BICYCLE_API void ub_ways_at_start(const bicycle_check *c, int starts[BICYCLE_KEYS], ub_sample *s)
{
    int key, way;
    for (key = 0; key < BICYCLE_KEYS; key++) {
        int signs = ub_is_energy(key) ? 1 : 2, fitting = 0;
        starts[key] = -1;
        for (way = 0; way < ub_units_of(key) * signs; way++) {
            double factor = ub_units[key][way / signs].factor;
            if (!ub_begins(c, key, way % signs ? -factor : factor, s))
                continue;
            starts[key] = fitting++ ? -1 : way;
        }
    }
}

/* The way that the first row tells: an angle has the sign of its rate. */
BICYCLE_API int ub_told_way(int key, const int starts[BICYCLE_KEYS])
{
    int i;
    if (starts[key] >= 0)
        return starts[key];
    for (i = 0; i < BICYCLE_KEYS; i++)
        if (ub_names[i].angle_of == key)
            return starts[i] >= 0 ? starts[i] % 2 : 0;
    return 0;
}

/* Whether a unit is that of a column whose first row tells it, or the angle's of such a rate. */
BICYCLE_API int ub_is_used(const char *unit, const int starts[BICYCLE_KEYS])
{
    int i, k;
    for (i = 0; i < BICYCLE_KEYS; i++) {
        const char *used, *per_second = " s-1";
        if (starts[i] < 0)
            continue;
        used = ub_units[i][starts[i] / (ub_is_energy(i) ? 1 : 2)].name;
        for (k = 0; unit[k] && unit[k] == used[k];)
            k++;
        if (unit[k])
            continue;
        for (used += k; *used && *used == *per_second; used++)
            per_second++;
        if (!*used)
            return 1;
    }
    return 0;
}

/* Unit and sign, then the definition under them. */
BICYCLE_API void ub_choose(const bicycle_check *c, int key, const int starts[BICYCLE_KEYS],
                           ub_taken found[BICYCLE_KEYS], ub_sample *s)
{
    ub_odds o;
    ub_taken best, *u = &found[key];
    int i, way = 0, at, is_near;
    int told = ub_told_way(key, starts);
    double likeliest;
    if (!ub_weigh(c, key, found, &o, s))
        return;
    u->is_there = 1;
    u->column = key;
    u->sign = 1;
    for (i = 0; i < o.ways; i++)
        if (o.likely[i][ub_likeliest(&o, key, i)] > o.likely[way][ub_likeliest(&o, key, way)])
            way = i;
    best = *u;
    best.column = ub_likeliest(&o, key, way);
    likeliest = o.likely[way][best.column];
    ub_go(&best, &o, way);
    ub_go(u, &o, told);
    if (!ub_is_shown(c, key, &best, &is_near, s))
        return;
    if (!is_near) { /* of a wrong motion, but in the units of other columns */
        way = told;
        for (i = told % o.signs; i < o.ways; i += o.signs)
            if (ub_is_used(ub_units[key][i / o.signs].name, starts) &&
                o.likely[i][ub_likeliest(&o, key, i)] > o.likely[way][ub_likeliest(&o, key, way)])
                way = i;
    }
    if (o.likely[way][ub_likeliest(&o, key, way)] - o.likely[told][ub_likeliest(&o, key, told)] <
        UB_CLAIMED)
        way = told;
    ub_go(u, &o, way);
    at = ub_likeliest(&o, key, way);
    if (ub_of_a_constant(c, key, u, s) - likeliest > UB_CLAIMED)
        return; /* One number is nearest to whichever varies the least, and means none of them. */
    u->column = at;
    for (i = 0; i < BICYCLE_COLUMNS; i++) {
        double less = o.likely[way][at] - o.likely[way][i];
        /* What is claimed is shown by the values alone. */
        less -= fmax(o.before[at] - o.before[i], 0);
        if (ub_names[i].of == key && i != at && less < UB_CLAIMED)
            u->also |= 1ULL << i;
    }
}

/* To what errors of the motion in a column are proportional, of what `ub_take` found. */
BICYCLE_API double ub_moves(const bicycle_check *c, int m, int key, ub_sample *s)
{
    const bicycle_data *kinetic = &c->data[m][BICYCLE_KINETIC_ENERGY];
    double middle;
    int i;
    if (!kinetic->rows || c->result[m][BICYCLE_KINETIC_ENERGY].never_filled)
        return s->scale;
    if (ub_is_energy(key))
        return ub_maneuvers[m].varies;
    ub_expect(s, m, key);
    for (i = 0; i < s->count; i++)
        s->error[i] = s->exact[i];
    middle = ub_median(s->error, s->count);
    for (i = 0; i < s->count; i++)
        s->error[i] = s->exact[i] - middle;
    return ub_rms(s->error, s->count);
}

/* What a maneuver is off by for sure, in scales or in parts of what each column varies by: the
   largest typical error of a column of one meaning; 1 where too little tells. */
BICYCLE_API double ub_accuracy(const bicycle_check *c, int m, const ub_taken found[BICYCLE_KEYS],
                               int is_with_zeroed, int is_by_moves, ub_sample *s)
{
    double largest = 0, typical, size;
    int key, i, count = 0, has_lateral = 0;
    for (key = 0; key < BICYCLE_KEYS; key++) {
        int is_zeroed = key == BICYCLE_POTENTIAL_ENERGY || key == BICYCLE_MECHANICAL_ENERGY;
        int definitions = 0;
        for (i = 0; i < BICYCLE_COLUMNS; i++)
            definitions += ub_names[i].of == key;
        if (definitions > 1 || (is_zeroed && !is_with_zeroed) || !found[key].is_there)
            continue;
        typical = ub_typical_of(c, m, key, &found[key], s);
        if (!s->count)
            continue;
        size = is_by_moves ? ub_moves(c, m, key, s) : s->scale;
        if (!(size > 0))
            continue;
        largest = fmax(largest, typical / size);
        count++;
        has_lateral |= !ub_is_energy(key);
    }
    return count > 1 && has_lateral ? largest : 1;
}

/* Takes the errors of the kinetic energy from those of a sample; 0 if it is not in all its rows. */
BICYCLE_API int ub_without_kinetic(const bicycle_check *c, int m, int unit, ub_sample *s)
{
    const bicycle_data *d = &c->data[m][BICYCLE_KINETIC_ENERGY];
    double factor = ub_units[BICYCLE_KINETIC_ENERGY][unit].factor, x;
    size_t row = 0;
    int i;
    if (c->result[m][BICYCLE_KINETIC_ENERGY].never_filled)
        return 0;
    for (i = 0; i < s->count; i++) {
        while (row < d->rows && ub_time(d, row) != s->time[i])
            row++;
        x = row < d->rows ? ub_value(d, row) : NAN;
        if (x != x)
            return 0;
        s->error[i] -= factor * x - bicycle_evaluate(m + 1, BICYCLE_KINETIC_ENERGY, s->time[i]);
    }
    return 1;
}

/* The energies with a zero elsewhere that explains them, if there is one in this unit. */
BICYCLE_API int ub_move_zero(const bicycle_check *c, int leader, int unit,
                             ub_taken found[BICYCLE_KEYS], ub_sample *s)
{
    static const int zeroed[2] = {BICYCLE_POTENTIAL_ENERGY, BICYCLE_MECHANICAL_ENERGY};
    ub_taken moved[2];
    double offset = 0, least = INFINITY, off_by = 0, scale = 0;
    int m, i, k, has_rows = 0, meets_floor = 1, shows_height = 1;
    for (k = 0; k < 2; k++) {
        moved[k] = found[zeroed[k]];
        moved[k].unit = unit;
    }
    for (m = 0; m < BICYCLE_MANEUVERS; m++) {
        double middle, first;
        if (!ub_take(c, m, leader, s))
            continue;
        ub_expect(s, m, leader);
        ub_compare(s, ub_units[leader][unit].factor, 0);
        if (leader != BICYCLE_POTENTIAL_ENERGY)
            shows_height = shows_height && ub_without_kinetic(c, m, unit, s);
        first = s->error[0];
        middle = ub_median(s->error, s->count);
        for (i = 0; i < s->count; i++)
            s->error[i] = fabs(s->error[i] - middle);
        middle = ub_median(s->error, s->count);
        if (middle < least) {
            least = middle;
            offset = first;
        }
        scale = fmax(scale, s->scale);
        has_rows |= s->count >= UB_FEW_ROWS;
    }
    for (m = 0; m < BICYCLE_MANEUVERS; m++) {
        int is_there = 0;
        for (k = 0; k < BICYCLE_KEYS; k++)
            is_there |= found[k].is_there && ub_take(c, m, k, s) > 0;
        if (is_there)
            off_by = fmax(off_by, ub_accuracy(c, m, found, 0, 0, s));
    }
    if (fabs(offset) / scale < fmin(UB_CLEARLY * off_by, UB_FAR_ZERO))
        return 0;
    if (!shows_height && off_by >= UB_TOLERANCE)
        return 0;
    for (k = 0; k < 2; k++) {
        moved[k].offset = offset;
        if (!moved[k].is_there)
            continue;
        for (m = 0; m < BICYCLE_MANEUVERS; m++) {
            double after = ub_typical_of(c, m, zeroed[k], &moved[k], s), floors;
            if (!s->count)
                continue;
            floors = s->written + s->known;
            if (zeroed[k] == leader) {
                meets_floor = meets_floor && after <= UB_CLEARLY * floors;
                if (after > UB_HALF * ub_maneuvers[m].varies + floors)
                    return 0;
            }
            if (ub_typical_of(c, m, zeroed[k], &found[zeroed[k]], s) < UB_CLEARLY * after)
                return 0;
        }
    }
    if (!has_rows && !meets_floor)
        return 0;
    for (k = 0; k < 2; k++)
        if (moved[k].is_there)
            found[zeroed[k]] = moved[k];
    return 1;
}

BICYCLE_API void ub_find_zero(const bicycle_check *c, ub_taken found[BICYCLE_KEYS], ub_sample *s)
{
    int leader = BICYCLE_POTENTIAL_ENERGY, unit, known, m, k;
    double offset, rest = 0, least = INFINITY;
    if (!found[leader].is_there)
        leader = BICYCLE_MECHANICAL_ENERGY;
    if (!found[leader].is_there)
        return;
    known = found[leader].unit;
    if (!ub_move_zero(c, leader, known, found, s)) {
        /* The kinetic energy tells the unit; without it, another zero hides it. */
        if (found[BICYCLE_KINETIC_ENERGY].is_there || leader != BICYCLE_POTENTIAL_ENERGY)
            return;
        for (unit = 0; unit < ub_units_of(leader); unit++)
            if (unit != known && ub_move_zero(c, leader, unit, found, s))
                break;
        if (unit == ub_units_of(leader))
            return;
    }
    /* To all digits: errors of the motion begin at nothing, those of rounding are nothing on
       average. */
    offset = found[leader].offset;
    if (offset == 0)
        return;
    for (m = 0; m < BICYCLE_MANEUVERS; m++) {
        double low = INFINITY, high = -INFINITY, mean = 0, middle, last, at, factor;
        int i;
        factor = ub_factor(leader, &found[leader]);
        if (!ub_take(c, m, leader, s))
            continue;
        last = fmax(s->written * factor, ldexp(s->scale, -52));
        ub_expect(s, m, leader);
        ub_compare(s, factor, offset);
        for (i = 0; i < s->count; i++) {
            low = fmin(low, s->error[i]);
            high = fmax(high, s->error[i]);
            mean += s->error[i] / s->count;
        }
        at = high - low <= 4 * last ? mean : s->error[0];
        for (i = 0; i < s->count; i++)
            s->error[i] = fabs(s->error[i] - at);
        middle = ub_median(s->error, s->count);
        if (middle < least) {
            least = middle;
            rest = at;
        }
    }
    for (k = 0; k < BICYCLE_KEYS; k++)
        if (found[k].is_there && found[k].offset == offset)
            found[k].offset += rest;
}

/* ---- What was never filled in -------------------------------------------- */

/* Whether no definition of a column is one number, as far as the digits written show. */
BICYCLE_API int ub_should_vary(const bicycle_check *c, int m, int key, double number, ub_sample *s)
{
    const bicycle_data *d = &c->data[m][key];
    int i, k, bits = ub_bits(d);
    if (!ub_take(c, m, key, s))
        return 0;
    for (k = 0; k < BICYCLE_COLUMNS; k++) {
        double low = INFINITY, high = -INFINITY, step = UB_KNOWN * ub_maneuvers[m].scale[k];
        if (ub_names[k].of != key)
            continue;
        ub_expect(s, m, k);
        for (i = 0; i < s->count; i++) {
            low = fmin(low, s->exact[i]);
            high = fmax(high, s->exact[i]);
            step = fmax(step, ub_spacing(d, bits, s->exact[i]));
        }
        if ((number == 0 ? fmax(fabs(low), fabs(high)) : high - low) <= 4 * step)
            return 0;
    }
    return 1;
}

/* Marks the columns of a maneuver that hold one number in every row where the quantity varies. */
BICYCLE_API void ub_mark_unfilled(bicycle_check *c, int m, ub_sample *s)
{
    double low, high, number[BICYCLE_KEYS];
    int key, is_one[BICYCLE_KEYS] = {0}, is_found[BICYCLE_KEYS] = {0};
    int lateral = 0, others = 0, is_straight = 1;
    for (key = 0; key < BICYCLE_KEYS; key++) {
        const bicycle_data *d = &c->data[m][key];
        int is_lateral = ub_is_energy(key) || key == BICYCLE_FORWARD_SPEED ? 0 : 1, has_gap = 0;
        size_t i, rows = 0;
        low = INFINITY;
        high = -INFINITY;
        for (i = 0; i < d->rows; i++) {
            double x = ub_value(d, i);
            if (!ub_is_within(m, ub_time(d, i)))
                continue;
            rows++;
            has_gap |= x != x;
            low = fmin(low, x);
            high = fmax(high, x);
        }
        number[key] = low;
        is_one[key] = rows >= UB_FEW_ROWS && !has_gap && low == high;
        if (!rows)
            continue;
        lateral += is_lateral;
        others += !is_lateral;
        if (is_lateral ? low != 0 || high != 0 || has_gap
                       : !(high - low <= 1e-9 * fmax(fabs(low), fabs(high))) || high == 0)
            is_straight = 0;
    }
    if (is_straight && lateral && others)
        return;
    for (key = 0; key < BICYCLE_KEYS; key++) {
        int angle = key == BICYCLE_ROLL_RATE    ? BICYCLE_ROLL_ANGLE
                    : key == BICYCLE_STEER_RATE ? BICYCLE_STEER_ANGLE
                                                : -1;
        if (!is_one[key])
            continue;
        if (number[key] != 0 ? !ub_is_energy(key)
                             : angle >= 0 && is_one[angle] && number[angle] != 0)
            continue;
        is_found[key] = ub_should_vary(c, m, key, number[key], s);
    }
    if (is_found[BICYCLE_POTENTIAL_ENERGY] && is_found[BICYCLE_KINETIC_ENERGY] &&
        is_one[BICYCLE_MECHANICAL_ENERGY] &&
        number[BICYCLE_MECHANICAL_ENERGY] ==
            number[BICYCLE_POTENTIAL_ENERGY] + number[BICYCLE_KINETIC_ENERGY])
        is_found[BICYCLE_MECHANICAL_ENERGY] = 1;
    for (key = 0; key < BICYCLE_KEYS; key++)
        c->result[m][key].never_filled = is_found[key];
}

/* ---- How far the columns are from the exact motion ----------------------- */

BICYCLE_API double ub_digits(double error, double scale)
{
    if (error == 0)
        return BICYCLE_MOST_DIGITS;
    return scale > 0 ? fmin(BICYCLE_MOST_DIGITS, -log10(error / scale)) : 0;
}

BICYCLE_API int ub_are_multiples(const bicycle_data *d, double of)
{
    size_t i;
    for (i = 0; i < d->rows; i++) {
        double quotient = fabs(ub_value(d, i) / of), rest = fabs(quotient - floor(quotient + 0.5));
        if (quotient == quotient && rest > 8 * DBL_EPSILON * quotient)
            return 0;
    }
    return 1;
}

/* The power of ten of which all values are multiples: their digits after it are none. */
BICYCLE_API double ub_in_common(const bicycle_data *d)
{
    double low = INFINITY, high = -INFINITY, largest, unit = 1;
    size_t i;
    int places;
    for (i = 0; i < d->rows; i++) {
        low = fmin(low, ub_value(d, i));
        high = fmax(high, ub_value(d, i));
    }
    largest = fmax(fabs(low), fabs(high));
    for (places = 0; places < 13 && low < high; places++, unit /= 10)
        if (largest / unit < 1e13 && ub_are_multiples(d, unit))
            return unit;
    return 0;
}

BICYCLE_API int ub_grade(double error, double unexplained, double resolution, double scale)
{
    double found = ub_digits(error, scale), at_most = ub_digits(unexplained, scale);
    if (at_most < BICYCLE_CLOSE_DIGITS)
        return BICYCLE_WRONG;
    if (fmin(found, ub_digits(resolution, scale)) >= BICYCLE_RIGHT_DIGITS)
        return BICYCLE_RIGHT;
    if (at_most >= BICYCLE_RIGHT_DIGITS || found < BICYCLE_CLOSE_DIGITS)
        return BICYCLE_UNTOLD;
    return BICYCLE_CLOSE;
}

BICYCLE_API void ub_measure(bicycle_check *c, int m, int key, const ub_taken *u)
{
    const bicycle_data *d = &c->data[m][key];
    bicycle_result *r = &c->result[m][key];
    double scale = ub_maneuvers[m].scale[u->column], factor = ub_factor(key, u), sum = 0;
    double unexplained = 0, resolution = 0, mixed = 0, largest = 0, common = ub_in_common(d);
    size_t i;
    int bits = ub_bits(d), is_decimal = d->places >= 0 || (d->digits > 0 && d->digits < 17);
    r->column = u->column;
    r->also = u->also;
    r->sign = u->sign;
    r->unit = ub_units[key][u->unit].name;
    r->factor = factor;
    r->offset = u->offset;
    for (i = 0; i < d->rows; i++)
        if (ub_is_within(m, ub_time(d, i)))
            largest = fmax(largest, fabs(ub_value(d, i)));
    for (i = 0; i < d->rows; i++) {
        double t = ub_time(d, i), x = ub_value(d, i), exact, error, half;
        if (!ub_is_within(m, t) || x != x)
            continue;
        exact = bicycle_evaluate(m + 1, u->column, t);
        error = fabs(u->sign * factor * x - u->offset - exact);
        half = ub_spacing(d, bits, is_decimal ? x : largest);
        if (is_decimal) /* a text may have more places than the number that it was written from */
            half = fmax(half, ub_binary(fabs(x), 53));
        half = (half < common / 2 ? common : half) / 2 * factor;
        unexplained = fmax(unexplained, error - half);
        resolution = fmax(resolution, half);
        mixed = fmax(mixed, error / (1 + fabs(exact)));
        sum += error * error;
        if (!r->rows++ || error > r->max_error) {
            r->max_error = error;
            r->time_of_max = t;
        }
    }
    if (!r->rows)
        return;
    r->rms_error = sqrt(sum / (double)r->rows);
    r->digits = ub_digits(r->max_error, scale);
    r->mescd = ub_digits(mixed, 1);
    r->grade = ub_grade(r->max_error, unexplained, resolution, scale);
}

/* An angle and its rate have one sign, if both are near enough to show it. */
BICYCLE_API void ub_contradict(bicycle_check *c, int angle, int rate, ub_sample *s)
{
    int keys[2], signs[2] = {0, 0}, k, m, i;
    keys[0] = angle;
    keys[1] = rate;
    for (k = 0; k < 2; k++)
        for (m = 0; m < BICYCLE_MANEUVERS; m++) {
            const bicycle_result *r = &c->result[m][keys[k]];
            double far;
            if (!r->rows || !ub_take(c, m, keys[k], s))
                continue;
            signs[k] = r->sign;
            ub_expect(s, m, r->column);
            ub_compare(s, r->sign * r->factor, r->offset);
            for (i = 0; i < s->count; i++) {
                s->error[i] = fabs(s->error[i]);
                s->exact[i] = fabs(s->exact[i]);
            }
            far = ub_median(s->error, s->count);
            if (far >= ub_median(s->exact, s->count))
                return;
        }
    if (signs[0] * signs[1] < 0)
        for (k = 0; k < 2; k++)
            for (m = 0; m < BICYCLE_MANEUVERS; m++)
                if (c->result[m][keys[k]].rows) {
                    c->result[m][keys[k]].grade = BICYCLE_WRONG;
                    c->result[m][keys[k]].is_contradicted = 1;
                }
}

/* Whether a column is of none of the definitions: the odds are those of heyoka-bike score. */
BICYCLE_API int ub_is_of_its_own(const bicycle_check *c, int key,
                                 const ub_taken found[BICYCLE_KEYS], ub_sample *s)
{
    const ub_taken *u = &found[key];
    double odds = UB_AGAINST_NONE, factor = ub_factor(key, u);
    int m, i, k, definitions = 0;
    for (k = 0; k < BICYCLE_COLUMNS; k++)
        definitions += ub_names[k].of == key;
    for (m = 0; m < BICYCLE_MANEUVERS && definitions > 1; m++) {
        double off_by, allowed, error, apart = INFINITY;
        /* A motion that is wrong itself tells nothing. */
        if (!ub_take(c, m, key, s) || ub_accuracy(c, m, found, 1, 0, s) >= UB_TOLERANCE)
            continue;
        off_by = ub_accuracy(c, m, found, 1, 1, s);
        ub_take(c, m, key, s);
        allowed = fmax(UB_CLEARLY * off_by * ub_moves(c, m, key, s), 4 * ub_smallest(s, factor));
        ub_expect(s, m, u->column);
        ub_compare(s, u->sign * factor, u->offset);
        for (i = 0; i < s->count; i++)
            s->error[i] = fabs(s->error[i]);
        /* A few bad rows are no other meaning. */
        error = fmax(ub_select(s->error, s->count, (int)(0.9 * (s->count - 1))), allowed);
        for (k = 0; k < BICYCLE_COLUMNS; k++) {
            if (ub_names[k].of != key || k == u->column)
                continue;
            for (i = 0; i < s->count; i++)
                s->error[i] = bicycle_evaluate(m + 1, k, s->time[i]) - s->exact[i];
            apart = fmin(apart, ub_rms(s->error, s->count));
        }
        if (error > allowed)
            odds -= fmin(UB_VALUES * log(error / allowed), UB_SELDOM);
        else if (apart > error)
            odds += UB_VALUES * log(apart / error);
    }
    return definitions > 1 && odds < UB_CLAIMED;
}

/* Marks the columns that are of definitions of their own. */
BICYCLE_API void ub_mark_own(bicycle_check *c, const ub_taken found[BICYCLE_KEYS], ub_sample *s)
{
    int m, key;
    for (key = 0; key < BICYCLE_KEYS; key++)
        if (found[key].is_there && ub_is_of_its_own(c, key, found, s))
            for (m = 0; m < BICYCLE_MANEUVERS; m++)
                c->result[m][key].is_of_its_own = c->result[m][key].rows > 0;
}

/* Whether all times of a column are finite. */
BICYCLE_API int ub_has_times(const bicycle_data *d)
{
    size_t i;
    for (i = 0; i < d->rows; i++)
        if (!(fabs(ub_time(d, i)) <= DBL_MAX))
            return 0;
    return 1;
}

/* The fraction of the run that the values of a column cover. Two values cover the time between them
   if they are at most UB_MOST_APART apart. missing becomes 1 if a row has no value. */
BICYCLE_API double ub_coverage(const bicycle_check *c, int m, int key, int *missing)
{
    const bicycle_data *d = &c->data[m][key];
    double last = NAN, covered = 0;
    size_t i;
    for (i = 0; i < d->rows; i++) {
        double t = ub_time(d, i), x = ub_value(d, i);
        if (!ub_is_within(m, t))
            continue;
        if (x != x) {
            *missing = 1;
            continue;
        }
        if (t - last <= UB_MOST_APART * (1 + 1e-10))
            covered += t - last;
        last = t;
    }
    return fmin(1, covered / ub_maneuvers[m].end);
}

/* The number of compared columns of a maneuver. */
BICYCLE_API int ub_count_columns(const bicycle_check *c, int m)
{
    int key, count = 0;
    for (key = 0; key < BICYCLE_KEYS; key++)
        count += c->result[m][key].rows > 0;
    return count;
}

/* Whether at least one column of a maneuver was given. */
BICYCLE_API int ub_has_columns(const bicycle_check *c, int m)
{
    int key;
    for (key = 0; key < BICYCLE_KEYS; key++)
        if (c->data[m][key].rows)
            return 1;
    return 0;
}

/* ---- To be called -------------------------------------------------------- */

/* Empties a check; nothing is allocated. */
BICYCLE_API void bicycle_begin(bicycle_check *c)
{
    static bicycle_check nothing; /* of zeros */
    *c = nothing;
}

/* Gives it a column: maneuver from 1, one of the first eight of enum bicycle_column, and arrays that
   stay until they are judged. Times [s] ascend; those outside of the run are left out. */
BICYCLE_API void bicycle_give(bicycle_check *c, int maneuver, int column, size_t rows,
                              const double *time, ptrdiff_t time_stride, const double *values,
                              ptrdiff_t stride)
{
    bicycle_data *d;
    if (maneuver < 1 || maneuver > BICYCLE_MANEUVERS || column < 0 || column >= BICYCLE_KEYS)
        return;
    d = &c->data[maneuver - 1][column];
    d->rows = rows;
    d->time = time;
    d->values = values;
    d->time_stride = time_stride;
    d->stride = stride;
    d->digits = 0;
    d->places = -1;
}

/* Judges all that was given, with one choice of definitions for all maneuvers; the worst grade. */
BICYCLE_API int bicycle_judge(bicycle_check *c)
{
    ub_sample s;
    ub_taken found[BICYCLE_KEYS] = {{0, 0, 0, 0, 0, 0}};
    static bicycle_result nothing; /* of zeros */
    int starts[BICYCLE_KEYS];
    int m, key, count = 0, left_out = 0, unit = -1, missing = 0;
    c->grade = BICYCLE_UNKNOWN;
    c->columns = BICYCLE_KEYS;
    c->coverage = 1;
    c->bad_time = 0;
    for (m = 0; m < BICYCLE_MANEUVERS; m++)
        for (key = 0; key < BICYCLE_KEYS; key++)
            if (!ub_has_times(&c->data[m][key]))
                c->bad_time = 1 + key;
    for (m = 0; m < BICYCLE_MANEUVERS; m++) {
        for (key = 0; key < BICYCLE_KEYS; key++)
            c->result[m][key] = nothing;
        ub_mark_unfilled(c, m, &s);
        for (key = 0; key < BICYCLE_KEYS; key++)
            if (c->data[m][key].rows && ub_rows_within(&c->data[m][key], m)) {
                count++;
                left_out += c->result[m][key].never_filled;
            }
    }
    /* What has nothing else stays as it is. */
    for (m = 0; m < BICYCLE_MANEUVERS && count == left_out; m++)
        for (key = 0; key < BICYCLE_KEYS; key++)
            c->result[m][key].never_filled = 0;
    ub_ways_at_start(c, starts, &s);
    for (key = 0; key < BICYCLE_KEYS; key++)
        ub_choose(c, key, starts, found, &s);
    for (key = 0; key < 3; key++) { /* one unit of all energies, that of the surest */
        static const int order[3] = {BICYCLE_KINETIC_ENERGY, BICYCLE_MECHANICAL_ENERGY,
                                     BICYCLE_POTENTIAL_ENERGY};
        if (found[order[key]].is_there && unit < 0)
            unit = found[order[key]].unit;
        found[order[key]].unit = unit < 0 ? 0 : unit;
    }
    ub_find_zero(c, found, &s);
    for (m = 0; m < BICYCLE_MANEUVERS; m++)
        for (key = 0; key < BICYCLE_KEYS; key++)
            if (found[key].is_there && !c->result[m][key].never_filled)
                ub_measure(c, m, key, &found[key]);
    ub_contradict(c, BICYCLE_ROLL_ANGLE, BICYCLE_ROLL_RATE, &s);
    ub_contradict(c, BICYCLE_STEER_ANGLE, BICYCLE_STEER_RATE, &s);
    ub_mark_own(c, found, &s);
    for (m = 0; m < BICYCLE_MANEUVERS; m++) {
        if (ub_has_columns(c, m) && ub_count_columns(c, m) < c->columns)
            c->columns = ub_count_columns(c, m);
        for (key = 0; key < BICYCLE_KEYS; key++)
            if (c->data[m][key].rows && !c->result[m][key].never_filled) {
                if (c->result[m][key].grade > c->grade)
                    c->grade = c->result[m][key].grade;
                c->coverage = fmin(c->coverage, ub_coverage(c, m, key, &missing));
            }
    }
    if (c->bad_time)
        c->grade = BICYCLE_WRONG;
    if (c->bad_time || c->grade == BICYCLE_UNKNOWN) {
        c->columns = 0;
        c->coverage = 0;
    }
    c->is_whole = c->columns == BICYCLE_KEYS && c->coverage >= 0.99 && !missing;
    return c->grade;
}

/* Whether all eight columns of every maneuver that you gave are right over the whole run. To accept
   fewer columns or a part of the run, test for instance
   grade == BICYCLE_RIGHT && columns >= 5 && coverage >= 0.3. */
BICYCLE_API int bicycle_is_right(const bicycle_check *c)
{
    return c->grade == BICYCLE_RIGHT && c->is_whole;
}

/* The column with the fewest correct digits: its maneuver from 1 and its place among the eight; 0 if
   nothing was compared. */
BICYCLE_API int bicycle_worst(const bicycle_check *c, int *maneuver, int *column)
{
    int m, key, found = 0;
    double digits = INFINITY;
    for (m = 0; m < BICYCLE_MANEUVERS; m++)
        for (key = 0; key < BICYCLE_KEYS; key++)
            if (c->result[m][key].rows && c->result[m][key].digits < digits) {
                digits = c->result[m][key].digits;
                *maneuver = m + 1;
                *column = key;
                found = 1;
            }
    return found;
}

BICYCLE_API size_t ub_put(char *text, size_t size, size_t at, const char *more)
{
    for (; *more && at + 1 < size; more++)
        text[at++] = *more;
    if (size)
        text[at] = 0;
    return at;
}

/* A whole number that is not negative. */
BICYCLE_API size_t ub_put_number(char *text, size_t size, size_t at, int number)
{
    char digits[24];
    size_t i = sizeof digits - 1;
    digits[i] = 0;
    do
        digits[--i] = (char)('0' + number % 10);
    while (number /= 10);
    return ub_put(text, size, at, digits + i);
}

/* Names of the columns that are marked, with commas between them; how many there are. */
BICYCLE_API int ub_put_marked(char *text, size_t size, size_t *at, const int marked[BICYCLE_KEYS])
{
    int key, count = 0;
    for (key = 0; key < BICYCLE_KEYS; key++)
        if (marked[key]) {
            *at = ub_put(text, size, *at, count++ ? ", " : "");
            *at = ub_put(text, size, *at, bicycle_key(key));
        }
    return count;
}

/* Appends that the verdict is about a part, and the number of columns if some are missing. */
BICYCLE_API size_t ub_put_part(const bicycle_check *c, char *text, size_t size, size_t at)
{
    int m, fewest = -1, differ = 0;
    at = ub_put(text, size, at, UB_IN_PART);
    if (c->columns >= BICYCLE_KEYS)
        return at;
    for (m = 0; m < BICYCLE_MANEUVERS; m++)
        if (ub_has_columns(c, m)) {
            if (fewest < 0 && ub_count_columns(c, m) == c->columns)
                fewest = m;
            differ |= ub_count_columns(c, m) != c->columns;
        }
    at = ub_put(text, size, at, " (");
    at = ub_put_number(text, size, at, c->columns);
    at = ub_put(text, size, at, " " UB_OF_ALL " ");
    at = ub_put_number(text, size, at, BICYCLE_KEYS);
    at = ub_put(text, size, at, " " UB_COLUMNS);
    if (differ) {
        at = ub_put(text, size, at, " in " UB_MANEUVER " ");
        at = ub_put_number(text, size, at, fewest + 1);
    }
    return ub_put(text, size, at, ")");
}

/* The verdict as one line for a test's log, at most size - 1 letters and a zero. */
BICYCLE_API const char *bicycle_line(const bicycle_check *c, char *text, size_t size)
{
    int maneuver = 0, column = 0, n, m, key;
    int own[BICYCLE_KEYS] = {0}, odd[BICYCLE_KEYS] = {0}, has_own = 0, has_odd = 0;
    int others = BICYCLE_UNKNOWN;
    size_t at = 0;
    double digits;
    if (c->bad_time) {
        at = ub_put(text, size, at, UB_BAD_TIME " (");
        at = ub_put(text, size, at, bicycle_key(c->bad_time - 1));
        ub_put(text, size, at, ")");
        return text;
    }
    if (!bicycle_worst(c, &maneuver, &column)) {
        ub_put(text, size, 0, UB_NOTHING);
        return text;
    }
    for (m = 0; m < BICYCLE_MANEUVERS; m++)
        for (key = 0; key < BICYCLE_KEYS; key++) {
            own[key] |= c->result[m][key].is_of_its_own;
            odd[key] |= c->result[m][key].is_contradicted;
        }
    for (m = 0; m < BICYCLE_MANEUVERS; m++)
        for (key = 0; key < BICYCLE_KEYS; key++) {
            has_own |= own[key];
            has_odd |= odd[key];
            if (!own[key] && c->result[m][key].grade > others)
                others = c->result[m][key].grade;
        }
    /* First goes what may be said of a file whose motion is right. */
    if (has_own && others < c->grade && c->grade >= BICYCLE_CLOSE) {
        n = ub_put_marked(text, size, &at, own);
        at = ub_put(text, size, at, n > 1 ? UB_OWN_DEFINITIONS : UB_OWN_DEFINITION);
    }
    at = ub_put(text, size, at, ub_words[c->grade]);
    if (c->grade != BICYCLE_WRONG && !c->is_whole)
        at = ub_put_part(c, text, size, at);
    if (has_odd) {
        at = ub_put(text, size, at, UB_SIGNS_OF);
        ub_put_marked(text, size, &at, odd);
        at = ub_put(text, size, at, UB_CONTRADICT);
    }
    at = ub_put(text, size, at, has_odd ? ", " : "; ");
    digits = c->result[maneuver - 1][column].digits;
    n = (int)floor(10 * digits + 0.5);
    if (n <= 0)
        at = ub_put(text, size, at, UB_NO_DIGIT " (");
    else {
        /* Do not round up to the limit of a better grade. */
        if ((digits < BICYCLE_CLOSE_DIGITS && n >= 10 * BICYCLE_CLOSE_DIGITS) ||
            (digits < BICYCLE_RIGHT_DIGITS && n >= 10 * BICYCLE_RIGHT_DIGITS))
            n = (int)floor(10 * digits);
        at = ub_put(text, size, at, UB_WORST " ");
        at = ub_put_number(text, size, at, n / 10);
        at = ub_put(text, size, at, ".");
        at = ub_put_number(text, size, at, n % 10);
        at = ub_put(text, size, at, " " UB_CORRECT_DIGITS " (");
    }
    at = ub_put(text, size, at, ub_names[column].key);
    at = ub_put(text, size, at, " in " UB_MANEUVER " ");
    at = ub_put_number(text, size, at, maneuver);
    ub_put(text, size, at, ")");
    return text;
}

/* A whole table in one call: the number at [row * row_stride + column * column_stride], with the
   time in column 0, then eight columns for each of some maneuvers from the first one (1, 2, ...) on.
   digits has 8 numbers for each, NaN where nothing could be compared; text the line. Returns the
   grade, but BICYCLE_CLOSE instead of BICYCLE_RIGHT if a column or a part of the run is missing. */
BICYCLE_API int bicycle_check_table(size_t rows, const double *table, ptrdiff_t row_stride,
                                    ptrdiff_t column_stride, int first, int maneuvers,
                                    double *digits, char *text, size_t size)
{
    bicycle_check c;
    int m, k;
    bicycle_begin(&c);
    for (m = 0; m < maneuvers; m++)
        for (k = 0; k < BICYCLE_KEYS; k++)
            bicycle_give(&c, first + m, k, rows, table, row_stride,
                         table + (1 + BICYCLE_KEYS * m + k) * column_stride, row_stride);
    bicycle_judge(&c);
    for (m = 0; m < maneuvers; m++)
        for (k = 0; k < BICYCLE_KEYS; k++) {
            int i = first + m - 1;
            int is_known = 0 <= i && i < BICYCLE_MANEUVERS && c.result[i][k].rows;
            digits[BICYCLE_KEYS * m + k] = is_known ? c.result[i][k].digits : NAN;
        }
    bicycle_line(&c, text, size);
    return c.grade == BICYCLE_RIGHT && !c.is_whole ? BICYCLE_CLOSE : c.grade;
}

#ifdef __cplusplus
}
#endif

#endif
