/* The header for the page: columns, results and texts at addresses that JavaScript reads. */
#include "uncontrolled_bicycle.h"

#define EXPORT(name) __attribute__((export_name(#name))) name

static bicycle_check check;
static char text[400];
static double values[BICYCLE_COLUMNS];

/* Of the header that this was made from, without its comment. */
static const char source[] = SOURCE;

extern unsigned char __heap_base;

/* Room for so many doubles, from the same address on at each call. */
double *EXPORT(room)(size_t doubles)
{
    size_t start = ((size_t)&__heap_base + 15) & ~(size_t)15, end = start + 8 * doubles;
    size_t has = __builtin_wasm_memory_size(0) << 16;
    if (end > has && __builtin_wasm_memory_grow(0, (end - has + 65535) >> 16) == (size_t)-1)
        return NULL;
    return (double *)start;
}

void EXPORT(begin)(void) { bicycle_begin(&check); }

/* A column of a table of rows, as it was written. */
void EXPORT(give)(int maneuver, int column, size_t rows, const double *time, const double *first,
                  int stride, int digits, int places)
{
    bicycle_give(&check, maneuver, column, rows, time, stride, first, stride);
    check.data[maneuver - 1][column].digits = digits;
    check.data[maneuver - 1][column].places = places;
}

int EXPORT(judge)(void) { return bicycle_judge(&check); }
int EXPORT(is_whole)(void) { return check.is_whole; }
int EXPORT(is_right)(void) { return bicycle_is_right(&check); }
const char *EXPORT(line)(void) { return bicycle_line(&check, text, sizeof text); }
/* What was found of a column, in the order of bicycle_result, but for its unit. */
double EXPORT(number)(int maneuver, int column, int which)
{
    const bicycle_result *r = &check.result[maneuver - 1][column];
    const double all[] = {(double)r->rows, r->digits, r->mescd, r->max_error, r->time_of_max,
                          r->rms_error, r->column, r->sign, r->factor, r->offset, r->grade,
                          r->never_filled};
    return all[which];
}
const char *EXPORT(unit)(int maneuver, int column) { return check.result[maneuver - 1][column].unit; }
int EXPORT(fits)(int maneuver, int column, int other)
{
    return (int)(check.result[maneuver - 1][column].also >> other & 1);
}
int EXPORT(count_columns)(void) { return BICYCLE_COLUMNS; }
int EXPORT(maneuvers)(void) { return BICYCLE_MANEUVERS; }
int EXPORT(of)(int column) { return ub_names[column].of; }
double EXPORT(scale)(int maneuver, int column) { return ub_maneuvers[maneuver - 1].scale[column]; }
double EXPORT(end)(int maneuver) { return ub_maneuvers[maneuver - 1].end; }
const char *EXPORT(key)(int column) { return bicycle_key(column); }
const char *EXPORT(definition)(int column) { return bicycle_definition(column); }
const char *EXPORT(word)(int grade) { return bicycle_word(grade); }
const char *EXPORT(made_from)(void) { return source; }

double EXPORT(exact)(int maneuver, int column, double t)
{
    bicycle_evaluate_all(maneuver, t, values);
    return values[column];
}
