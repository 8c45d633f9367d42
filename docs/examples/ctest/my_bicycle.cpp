// Writes results.txt, 1001 rows of 25 columns: time, then 8 columns for each of 3 maneuvers.
#include "uncontrolled_bicycle.h"

#include <cstdio>

// YOUR CODE GOES HERE. Integrate the maneuver and give roll angle, roll rate, forward speed,
// potential, kinetic and mechanical energy, steer angle and steer rate at the time t. This stand-in
// looks them up in the reference.
static void my_bicycle(int maneuver, double t, double columns[8])
{
    for (int i = 0; i < BICYCLE_COLUMNS; ++i)
        columns[i] = bicycle_evaluate(maneuver, i, t);
}

int main(int argc, char **argv)
{
    std::FILE *file = argc == 2 ? std::fopen(argv[1], "w") : nullptr;
    if (!file) {
        std::fprintf(stderr, "expected the name of a file to write\n");
        return 1;
    }
    for (int row = 0; row <= 1000; ++row) {
        double t = row / 100.0, columns[8];
        std::fprintf(file, "%.17g", t);
        for (int maneuver = 1; maneuver <= 3; ++maneuver) {
            my_bicycle(maneuver, t, columns);
            for (double value : columns)
                std::fprintf(file, " %.17g", value);
        }
        std::fprintf(file, "\n");
    }
    return std::fclose(file) ? 1 : 0;
}
