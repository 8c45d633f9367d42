// The rows of two texts and an HDF5 file: the benchmark's eight columns of the exact motion, correctly rounded. If a
// dataset marks a value as undecided, the value must only be near the exact one.
#pragma once
#include <algorithm>
#include <set>
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

// True if d is the binary64 nearest to every number in x.
inline bool rounds_to(const Interval& x, double d) { return x.nearest(-1) == d && x.nearest(1) == d; }

// The text of a number in a dataset, or nothing if it is undecided. A time is written without rounding, other numbers
// as the nearest binary64 with 17 digits, or with 50 digits and an exponent.
enum class Form { time, binary64, digits50 };
inline std::string text_of(const Interval& x, Form form) {
    if (x.size() == 0) return "0";
    if (form == Form::binary64)
        return rounds_to(x, x.nearest(1)) ? Interval::exactly(x.nearest(1)).written("%.17RNg") : "";
    std::string r = x.written(form == Form::time ? "%.50RNf" : "%.49RNe");
    const std::size_t last = r.find_last_not_of('0'), exponent = r.find('e') + 2;
    if (form == Form::time) return r.substr(0, last + (last != r.npos && r[last] != '.'));
    return !r.empty() && r[exponent] == '0' ? r.erase(exponent, 1) : r;
}

// The largest error of an undecided number: a unit of its last digit; or nothing if the number is decided. A number
// with fewer than 50 digits, or a zero with an exponent (0e-62), is undecided.
inline std::string unit_of(const std::string& word, Form form) {
    const std::size_t e = word.find('e'), digits = std::count_if(word.begin(), word.begin() + std::min(e, word.size()), ::isdigit);
    const bool is_zero = word[0] == '0' && e == 1, is_short = word[0] != '0' && form == Form::digits50 && digits < 50;
    const bool is_decided = e == word.npos || (!is_zero && !is_short);
    return is_decided ? "" : "1e" + std::to_string(std::atol(word.c_str() + e + 1) - long(digits) + 1);
}

struct Text {
    std::string name;
    Form form;
    std::vector<std::vector<std::string>> words;

    Text(const std::string& folder, const std::string& file, Form form) : name(file), form(form) {
        std::istringstream all(text_of(folder + "/" + file));
        for (std::string line; std::getline(all, line);) {
            std::istringstream each(line + " ");
            words.emplace_back();
            for (std::string word; std::getline(each, word, ' ');) words.back().push_back(word);
        }
    }
    // Check a number; return true if it is marked as undecided.
    bool check(std::size_t row, std::size_t column, const Interval& x) const {
        const std::string &word = words[row][column], right = text_of(x, column ? form : Form::time);
        const std::string unit = column ? unit_of(word, form) : "";
        const auto is_near = [&] {
            return (x - Interval::decimal(word)).is_within(Interval::decimal(unit) * Interval::between(-1, 1));
        };
        expect(unit.empty() ? !right.empty() && word == right : is_near(),
               name + ", line " + std::to_string(row + 1) + ", column " + std::to_string(column + 1) + ": " + word
                   + " is not what the exact value rounds to");
        return !unit.empty();
    }
};

// A group of uncontrolled-bicycle.h5. For each column it has the nearest binary64 (hi), the binary64 nearest to the
// remainder (lo), and a bound; for the times it has hi and lo.
struct Table {
    std::vector<double> time, time_lo;
    std::vector<std::vector<double>> hi, lo, bound;
    std::vector<std::set<long>> undecided;  // undecided rows of each column

    Table(hid_t group, const Claim& claim) {
        const Interval steps = claim.at_start.at("duration") / claim.at_start.at("spacing");
        const std::size_t rows = std::lround(steps.middle().below()) + 1;
        expect(same(claim.input.at("duration"), claim.input.at("spacing"), rows - 1), "the last row is not the end");
        std::vector<hsize_t> shape(1);
        time = array<double>(group, "time", H5T_NATIVE_DOUBLE, shape);
        time_lo = array<double>(group, "time_lo", H5T_NATIVE_DOUBLE, shape);
        expect(time.size() == rows && time_lo.size() == rows, "time has another number of rows");
        for (const std::string& column : COLUMNS) {
            for (const auto& [tag, to] : {std::pair("", &hi), std::pair("_lo", &lo), std::pair("_bound", &bound)}) {
                to->push_back(array<double>(group, column + tag, H5T_NATIVE_DOUBLE, shape));
                expect(to->back().size() == rows, column + tag + " has another number of rows");
            }
            const std::string numbers = column + "_undecided";
            undecided.emplace_back();
            if (H5Lexists(group, numbers.c_str(), H5P_DEFAULT) > 0)
                for (const long row : array<long>(group, numbers, H5T_NATIVE_LONG, shape)) undecided.back().insert(row);
        }
    }
    void check_time(std::size_t row, const Interval& t) const {
        const Interval left = t - Interval::exactly(time[row]), rest = left - Interval::exactly(time_lo[row]);
        // 1/100 is not a binary number, so at whole seconds the computed remainder is an interval around zero.
        expect(rounds_to(t, time[row]) && (rounds_to(left, time_lo[row]) || rest.size() <= 0x1p-280),
               "uncontrolled-bicycle.h5, time, row " + std::to_string(row) + ": is not that of the row");
    }
    void check(std::size_t row, std::size_t column, const Interval& x) const {
        const double near = hi[column][row], most = bound[column][row];
        const Interval left = x - Interval::exactly(near);
        const std::string place = "uncontrolled-bicycle.h5, " + COLUMNS[column] + ", row " + std::to_string(row);
        expect(undecided[column].count(long(row)) || (rounds_to(x, near) && rounds_to(left, lo[column][row])),
               place + ": not what the exact value rounds to");
        const double apart = (left - Interval::exactly(lo[column][row])).size();
        expect(apart <= most + 0x1p-280 && std::isfinite(most), place + ": the bound is " + shown(most));
    }
};

// Check the rows of maneuver `number` of `count` that are before `until`; return the number of checked values.
inline std::size_t check_rows(const std::vector<Text>& texts, const Table& table, const Bicycle& k, const Candidate& run,
                              const Claim& claim, const Column& at_start, std::size_t number, std::size_t count,
                              double until) {
    const auto& given = claim.at_start;
    const Interval& spacing = given.at("spacing");
    const std::size_t rows = table.time.size();
    std::size_t values = 0, undecided = 0;
    for (const Text& text : texts)
        expect(text.words.size() == rows, text.name + ": expected " + std::to_string(rows) + " rows");
    for (std::size_t row = 0; row < rows && (spacing * long(row)).below() < until; ++row) {
        const Interval t = spacing * long(row);
        std::vector<Interval> found = columns(k, row ? run.around(t, claim.interval) : at_start);
        if (row == 0) {  // The first row is exact: some values are zero.
            found[0] = given.at("roll"), found[1] = given.at("roll_rate"), found[2] = given.at("speed");
            found[6] = given.at("steer"), found[7] = given.at("steer_rate");
        }
        for (const Text& text : texts) {
            expect(text.words[row].size() == 1 + 8 * count, text.name + ": a row of another length");
            text.check(row, 0, t);
            for (std::size_t j = 0; j < 8; ++j)
                undecided += text.check(row, 1 + 8 * number + j, found[j]) && text.form == Form::digits50;
        }
        table.check_time(row, t);
        for (std::size_t j = 0; j < 8; ++j) table.check(row, j, found[j]), undecided += table.undecided[j].count(long(row));
        expect(undecided <= claim.ambiguous, "more is not decided than the certificate counts");
        values += 8 * (texts.size() + 2);
    }
    return values;
}
