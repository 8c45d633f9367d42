// The rows of two texts and an HDF5 file: the benchmark's eight columns of the exact motion, correctly rounded.
#pragma once
#include <iterator>
#include "error.hpp"

const std::array<std::string, 8> COLUMNS = {"roll_angle",     "roll_rate",         "forward_speed", "potential_energy",
                                            "kinetic_energy", "mechanical_energy", "steer_angle",   "steer_rate"};

inline std::vector<Interval> columns(const Bicycle& k, const std::vector<Interval>& x) {
    const Motion<Interval> m(k, x);
    Interval potential, kinetic2;
    auto add = [&](const Interval& mass, const Vector<Interval>& place, const Vector<Interval>& velocity,
                   const Vector<Interval>& omega, const Vector<Interval>& momentum) {
        potential += mass * k.g * dot(m.down, m.rim_R - place);
        kinetic2 += mass * dot(velocity, velocity) + dot(omega, momentum);
    };
    add(k.mR, {0, 0, 0}, m.v_R, {x[3], -x[5], x[4]}, m.L_R);
    add(k.mB, k.b, m.v_B, m.omega, m.L_B);
    add(k.mH, m.fork, m.v_H, m.omega_F, m.L_H);
    add(k.mF, m.front_hub, m.v_F, m.omega_F + (m.spin_F - dot(m.omega_F, m.f2)) * m.f2, m.L_F);
    const Interval kinetic = kinetic2 / 2;
    return {x[0], m.roll_rate, x[5] * k.rR, potential, kinetic, potential + kinetic, x[2], m.steer_rate};
}

// Whether d is the binary64 nearest to all of x.
inline bool rounds_to(const Interval& x, double d) { return x.nearest(-1) == d && x.nearest(1) == d; }

struct Text {
    std::string name;
    bool is_binary64;
    std::vector<std::vector<std::string>> words;

    Text(const std::string& folder, const std::string& file, bool binary64) : name(file), is_binary64(binary64) {
        std::istringstream all(text_of(folder + "/" + file));
        for (std::string line; std::getline(all, line);) {
            std::istringstream each(line);
            words.emplace_back(std::istream_iterator<std::string>(each), std::istream_iterator<std::string>());
        }
    }
    // Whether a word is what all of x rounds to, to binary64 or to 50 digits; a time is exact.
    void check(std::size_t row, std::size_t column, const Interval& x) const {
        const std::string& word = words[row][column];
        const Interval found = Interval::decimal(word);
        const std::size_t e = word.find('e'), point = word.find('.');
        bool good = (found - x).size() < 0x1p-280;
        if (column > 0 && is_binary64) {
            good = rounds_to(found, found.nearest(1)) && rounds_to(x, found.nearest(1));
        } else if (column > 0 && word != "0") {
            // d.ddd...e+xx with 49 decimals: within half a unit of the last.
            good = e != std::string::npos && point < e && e - point == 50;
            const long last = good ? std::stol(word.substr(e + 1)) - 50 : 0;
            good = good && (found - x).size() <= Interval::decimal("5e" + std::to_string(last)).below();
        }
        expect(good, name + ", line " + std::to_string(row + 1) + ", column " + std::to_string(column + 1) + ": "
                         + word + " is not what the exact value rounds to");
    }
};

// A group of uncontrolled-bicycle.h5: of each column the nearest binary64, and that to what is left.
struct Table {
    std::vector<std::vector<double>> hi, lo;

    Table(hid_t group, std::size_t rows) {
        std::vector<hsize_t> shape(1);
        for (const std::string& column : COLUMNS) {
            hi.push_back(array<double>(group, column, H5T_NATIVE_DOUBLE, shape));
            lo.push_back(array<double>(group, column + "_lo", H5T_NATIVE_DOUBLE, shape));
            expect(hi.back().size() == rows && lo.back().size() == rows, column + " has another number of rows");
        }
    }
    void check(std::size_t row, std::size_t column, const Interval& x) const {
        const double near = hi[column][row];
        expect(rounds_to(x, near) && rounds_to(x - Interval::exactly(near), lo[column][row]),
               "uncontrolled-bicycle.h5, " + COLUMNS[column] + ", row " + std::to_string(row) + ": not what the exact value rounds to");
    }
};

// The rows of maneuver `number` of `count` that are before `until`; returns how many values they have.
inline std::size_t check_rows(const std::vector<Text>& texts, hid_t group, const Bicycle& k, const Candidate& run,
                              const Claim& claim, std::size_t number, std::size_t count, double until) {
    const auto& given = claim.at_start;
    const Interval &spacing = given.at("spacing"), steps = given.at("duration") / spacing;
    const std::size_t rows = std::lround(steps.middle().below()) + 1;
    const Table table(group, rows);
    std::size_t values = 0;
    for (const Text& text : texts)
        expect(text.words.size() == rows, text.name + ": expected " + std::to_string(rows) + " rows");
    const auto at_start = start(k, claim, run.piece(0)[1][0], claim.interval[1]);
    for (std::size_t row = 0; row < rows && (spacing * long(row)).below() < until; ++row) {
        const Interval t = spacing * long(row);
        std::vector<Interval> found = columns(k, row ? run.around(t, claim.interval) : at_start);
        if (row == 0) {  // Without rounding: some are zero.
            found[0] = given.at("roll"), found[1] = given.at("roll_rate"), found[2] = given.at("speed");
            found[6] = given.at("steer"), found[7] = given.at("steer_rate");
        }
        for (const Text& text : texts) {
            expect(text.words[row].size() == 1 + 8 * count, text.name + ": a row of another length");
            text.check(row, 0, t);
            for (std::size_t j = 0; j < 8; ++j) text.check(row, 1 + 8 * number + j, found[j]);
        }
        for (std::size_t j = 0; j < 8; ++j) table.check(row, j, found[j]);
        values += 8 * (texts.size() + 2);
    }
    return values;
}
