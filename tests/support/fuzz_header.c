/* The input that libFuzzer passes to the header of export --checker: columns of correct motions with
   any change, and any number anywhere. Sanitizers check the memory and the arithmetic. This file
   checks the conditions that must be true for every input.

   clang -g -O1 -fsanitize=fuzzer,address,undefined,float-cast-overflow -fno-sanitize-recover=all */

#include "uncontrolled_bicycle.h"
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 400, LONGEST = 200 };

static const uint8_t *given;
static size_t left;

static unsigned byte(void) { return left ? (left--, *given++) : 0; }

static double any_number(void)
{
    double found = 0;
    size_t n = left < sizeof found ? left : sizeof found;
    memcpy(&found, given, n);
    given += n;
    left -= n;
    return found;
}

static void hold(int is_so, const char *what)
{
    if (!is_so) {
        fprintf(stderr, "does not hold: %s\n", what);
        abort();
    }
}

/* Make some numbers wrong in one of several ways. */
static void bend(double *x, size_t n)
{
    size_t i, from = n ? byte() * n / 256 : 0;
    double by = any_number();
    switch (byte() % 8) {
    case 0:
        for (i = 0; i < n; i++)
            x[i] *= by;
        break;
    case 1:
        for (i = 0; i < n; i++)
            x[i] += by;
        break;
    case 2:
        for (i = from; i < n; i++)
            x[i] = by;
        break;
    case 3:
        if (from < n)
            x[from] = by;
        break;
    case 4:
        for (i = 0; i < n; i++)
            x[i] = (double)(float)(fabs(x[i]) < 1e30 ? x[i] : 0);
        break;
    case 5:
        for (i = from; i < n; i++)
            x[i] = any_number();
        break;
    case 6:
        for (i = 0; i < n; i++)
            x[i] = -x[i];
        break;
    default:
        break;
    }
}

static void judge(bicycle_check *c, char *text, size_t size)
{
    int m, k, grade, maneuver = 0, column = 0;
    memset(text, '#', LONGEST);
    grade = bicycle_judge(c);
    hold(grade == c->grade && grade >= 0 && bicycle_word(grade), "the grade is one of them");
    hold(!bicycle_is_right(c) || (grade == BICYCLE_RIGHT && c->is_whole && !c->bad_time && c->columns == 8),
         "what is right is whole, with finite times");
    for (m = 0; m < BICYCLE_MANEUVERS; m++)
        for (k = 0; k < BICYCLE_KEYS; k++) {
            const bicycle_result *r = &c->result[m][k];
            if (!r->rows)
                continue;
            hold(r->rows <= c->data[m][k].rows, "no more rows are compared than there are");
            hold(r->digits <= BICYCLE_MOST_DIGITS && r->mescd <= BICYCLE_MOST_DIGITS,
                 "digits are numbers, and not too many");
            hold(r->max_error >= 0 && r->rms_error >= 0, "errors are numbers");
            hold(r->column >= 0 && r->column < BICYCLE_COLUMNS && r->unit != NULL, "it is taken");
            hold(r->grade > BICYCLE_UNKNOWN && r->grade <= grade, "none is worse than the file");
            hold(r->grade != BICYCLE_RIGHT || r->digits >= 6, "what is right has six digits");
        }
    hold(!bicycle_worst(c, &maneuver, &column) || (maneuver >= 1 && column < BICYCLE_KEYS),
         "the worst is one of them");
    hold(bicycle_line(c, text, size) == text, "the line is where it was asked for");
    hold(!size || memchr(text, 0, size), "the line ends");
    hold(text[size] == '#', "no letter is beyond its room");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static double table[MOST * 25], other[MOST];
    static bicycle_check c, again;
    static char text[LONGEST + 1], same[LONGEST + 1];
    double digits[24];
    unsigned many, i;
    size_t rows, row, room;
    int first, maneuvers, is_down;
    given = data;
    left = size;
    /* Mostly few rows: more rows take longer, and find little more. */
    rows = 1 + byte() % 40;
    rows *= byte() % 16 ? 1 : 10;
    room = byte() % LONGEST;
    first = (int)(byte() % 6) - 1;
    maneuvers = 1 + (int)(byte() % 3);
    is_down = byte() & 1;
    for (row = 0; row < rows; row++) {
        double t = 10.0 * (double)row / (double)(rows > 1 ? rows - 1 : 1);
        int at;
        table[25 * row] = t;
        for (at = 0; at < 24; at++)
            table[25 * row + 1 + at] = bicycle_evaluate(1 + at / 8, at % 8, t);
    }
    for (many = byte() % 8; many; many--) {
        unsigned column = byte() % 25;
        for (row = 0; row < rows; row++)
            other[row] = table[25 * row + column];
        bend(other, rows);
        for (row = 0; row < rows; row++)
            table[25 * row + column] = other[row];
    }
    bicycle_begin(&c);
    for (many = 1 + byte() % 24, i = 0; i < many; i++) {
        unsigned which = byte(), how = byte();
        ptrdiff_t stride = is_down ? -25 : 25;
        const double *start = table + (is_down ? 25 * (rows - 1) : 0);
        int m = (int)(which % 5), k = (int)(which / 5 % 10) - 1;
        bicycle_give(&c, m, k, how & 1 ? rows : rows / 2, start, how & 2 ? stride : 25 * (rows < 2),
                     start + 1 + (which + how) % 24, stride);
        if (m >= 1 && m <= BICYCLE_MANEUVERS && k >= 0 && k < BICYCLE_KEYS && how & 4) {
            c.data[m - 1][k].digits = (int)(how >> 3);
            c.data[m - 1][k].places = (int)(byte() % 40) - 1;
        }
    }
    again = c;
    judge(&c, text, room);
    judge(&again, same, room);
    hold(!strncmp(text, same, room), "the same is said of the same");
    hold(bicycle_check_table(rows, table, 25, 1, first, maneuvers, digits, text, room) >= 0,
         "a table has a grade");
    return 0;
}
