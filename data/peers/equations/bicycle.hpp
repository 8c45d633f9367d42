// The uncontrolled bicycle for integrators in C++: equations that whipple.py writes, start and rows.
//
// Reads lines "name value" (parameters, speed, roll_rate and the settings of the program); the eight
// columns are written `rate` times a second, as an error message the processor time [s] and the
// calls of the equations.

#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "equations.inc"

// Place of the rear contact (x, y), yaw, roll, pitch, rear wheel, steer, front wheel; their rates.
using State = std::array<double, 16>;

class Bicycle {
  public:
    std::map<std::string, std::string> said;

    Bicycle() {
        std::map<std::string, double> table;
        for (std::string name, value; std::cin >> name >> value; said[name] = value)
            table[name] = std::strtod(value.c_str(), nullptr);
        parameters(table, p);
        rate = table["rate"];
        start = {0, 0, 0, 0, table["lam"], 0, 0, 0, table["speed"], 0, 0, table["roll_rate"], 0,
                 -table["speed"] / table["rR"], 0, -table["speed"] / table["rF"]};
    }

    double number(const char* name) const { return std::stod(said.at(name)); }

    // Rates of the state: the accelerations by elimination with the largest pivots.
    void slope(const double* y, double* rates) {
        ++calls;
        double found[72];
        motion(y, p, found);
        double a[8][9];
        for (int i = 0; i < 8; ++i) {
            for (int j = 0; j < 8; ++j) a[i][j] = found[8 * i + j];
            a[i][8] = found[64 + i];
        }
        for (int k = 0; k < 8; ++k) {
            int pivot = k;
            for (int i = k + 1; i < 8; ++i)
                if (std::abs(a[i][k]) > std::abs(a[pivot][k])) pivot = i;
            for (int j = k; j < 9; ++j) std::swap(a[k][j], a[pivot][j]);
            for (int i = k + 1; i < 8; ++i)
                for (int j = 8; j >= k; --j) a[i][j] -= a[i][k] / a[k][k] * a[k][j];
        }
        for (int k = 7; k >= 0; --k) {
            rates[k] = y[8 + k];
            rates[8 + k] = a[k][8];
            for (int j = k + 1; j < 8; ++j) rates[8 + k] -= a[k][j] * rates[8 + j];
            rates[8 + k] /= a[k][k];
        }
    }

    // Writes the rows and the time since `begin`; the speed is that of the rear contact along x.
    void write(const std::vector<State>& rows, std::clock_t begin) const {
        const double cpu = double(std::clock() - begin) / CLOCKS_PER_SEC;
        for (const State& y : rows) {
            double e[2];
            energies(y.data(), p, e);
            std::printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", y[3], y[11], y[8],
                        e[0], e[1], e[0] + e[1], y[6], y[14]);
        }
        std::fprintf(stderr, "%g calls %ld\n", cpu, calls);
    }

    State start;
    double rate;

  private:
    double p[32];
    long calls = 0;
};
