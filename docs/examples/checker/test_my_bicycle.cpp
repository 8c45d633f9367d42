// A test with plain asserts: every column of every maneuver has six correct digits.
#include "uncontrolled_bicycle.h"

#undef NDEBUG
#include <cassert>
#include <cstdio>
#include <vector>

// YOUR CODE GOES HERE: roll angle, roll rate, forward speed, potential, kinetic and mechanical energy,
// steer angle and steer rate at the time t. This stand-in is nearly exact.
static void my_bicycle(int maneuver, double t, double columns[8])
{
    for (int i = 0; i < 8; ++i)
        columns[i] = bicycle_evaluate(maneuver, i, t) * (1 + 1e-9 * t);
}

int main()
{
    std::vector<double> time, rows[3];
    for (int i = 0; i <= 1000; ++i)
        time.push_back(i / 100.0);
    for (int maneuver = 1; maneuver <= 3; ++maneuver)
        for (double t : time) {
            double columns[8];
            my_bicycle(maneuver, t, columns);
            rows[maneuver - 1].insert(rows[maneuver - 1].end(), columns, columns + 8);
        }

    static bicycle_check check;
    bicycle_begin(&check);
    for (int maneuver = 1; maneuver <= 3; ++maneuver)
        for (int i = 0; i < 8; ++i)
            bicycle_give(&check, maneuver, i, time.size(), time.data(), 1,
                         rows[maneuver - 1].data() + i, 8);
    bicycle_judge(&check);

    char line[120];
    std::printf("%s\n", bicycle_line(&check, line, sizeof line));
    const bicycle_result &roll = check.result[1][BICYCLE_ROLL_ANGLE]; // of maneuver 2
    std::printf("maneuver 2, roll angle: %.1f digits, %s, sign %d, %s\n", roll.digits,
                bicycle_definition(roll.column), roll.sign, roll.unit);
    std::fflush(stdout);
    assert(bicycle_is_right(&check));
    assert(roll.digits >= 6);
    return 0;
}
