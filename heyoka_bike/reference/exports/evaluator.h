$about
#ifndef UNCONTROLLED_BICYCLE_H
#define UNCONTROLLED_BICYCLE_H

enum bicycle_column {
$names
    BICYCLE_COLUMNS /* their number */
};

#ifdef __cplusplus
extern "C" {
#endif

/* A column of a maneuver (1, 2, ...) at the time t [s] in plain binary64, good to its roundoff.
   NaN for a time outside the run, and for a maneuver or column that is not in this file. */
double bicycle_evaluate(int maneuver, int column, double t);

/* The same in double-double arithmetic: the value is pair[0] + pair[1], to at least 25 digits of
   the column's scale, at the time t + t_lo exactly. No binary64 is 7/100: t = 0.07 with t_lo = 0 means
   the binary64, and t_lo = -6.661338147750939e-18 makes it 7/100 to 32 digits. */
void bicycle_evaluate_pair(int maneuver, int column, double t, double t_lo, double pair[2]);

#ifdef __cplusplus
}
#endif

#endif
