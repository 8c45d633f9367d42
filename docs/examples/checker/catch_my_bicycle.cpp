// A test case of Catch2 (2 or 3) for each maneuver; CMakeLists.txt builds it where Catch2 is installed.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp> // link Catch2::Catch2WithMain
#else
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#endif

#include "uncontrolled_bicycle.h"

#include <vector>

// YOUR CODE GOES HERE: see test_my_bicycle.cpp.
static void my_bicycle(int maneuver, double t, double columns[8])
{
    for (int i = 0; i < 8; ++i)
        columns[i] = bicycle_evaluate(maneuver, i, t) * (1 + 1e-9 * t);
}

TEST_CASE("six correct digits in every column")
{
    const int maneuver = GENERATE(1, 2, 3);
    std::vector<double> time(1001), rows(8 * 1001);
    for (int i = 0; i <= 1000; ++i) {
        time[i] = i / 100.0;
        my_bicycle(maneuver, time[i], &rows[8 * i]);
    }
    static bicycle_check check;
    bicycle_begin(&check);
    for (int i = 0; i < 8; ++i)
        bicycle_give(&check, maneuver, i, time.size(), time.data(), 1, rows.data() + i, 8);
    bicycle_judge(&check);

    char line[120];
    INFO(bicycle_line(&check, line, sizeof line));
    for (int i = 0; i < 8; ++i) {
        const bicycle_result &found = check.result[maneuver - 1][i];
        INFO(bicycle_definition(found.column));
        CHECK(found.digits >= 6);
    }
    CHECK(bicycle_is_right(&check));
}
