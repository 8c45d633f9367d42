// The rows of the two texts: the benchmark's eight columns of the exact motion, correctly rounded.
#pragma once
#include "bicycle.hpp"
#include "claims.hpp"

// roll angle, roll rate, forward speed, potential, kinetic and mechanical energy, steer angle, steer rate.
inline std::vector<Interval> columns(const Bicycle& k, const std::vector<Interval>& x) {
    const Motion<Interval> m(k, x);
    Interval potential, kinetic2;
    auto add = [&](const Interval& mass, const Vector<Interval>& place, const Vector<Interval>& velocity,
                   const Vector<Interval>& omega, const Vector<Interval>& momentum) {
        potential += mass * k.g * dot(m.down, m.rim_R - place);
        kinetic2 += mass * dot(velocity, velocity) + dot(omega, momentum);
    };
    const Interval relative = m.spin_F - dot(m.omega_F, m.f2);
    add(k.mR, {0, 0, 0}, m.v_R, {x[3], -x[5], x[4]}, m.L_R);
    add(k.mB, k.b, m.v_B, m.omega, m.L_B);
    add(k.mH, m.fork, m.v_H, m.omega_F, m.L_H);
    add(k.mF, m.front_hub, m.v_F, m.omega_F + relative * m.f2, m.L_F);
    const Interval kinetic = kinetic2 / 2;
    return {x[0], m.roll_rate, x[5] * k.rR, potential, kinetic, potential + kinetic, x[2], m.steer_rate};
}

// A text of rows, its words.
class Rows {
public:
    Rows(const std::string& folder, const std::string& file, bool binary64) : name(file), is_binary64(binary64) {
        std::istringstream all(text_of(folder + "/" + file));
        for (std::string line, word; std::getline(all, line);) {
            std::istringstream each(line);
            words.emplace_back();
            while (each >> word) words.back().push_back(word);
        }
    }
    void check_shape(std::size_t rows, std::size_t columns) const {
        expect(words.size() == rows, name + ": found " + std::to_string(words.size()) + " rows, expected " + std::to_string(rows));
        for (const auto& line : words) expect(line.size() == columns, name + ": expected " + std::to_string(columns) + " columns");
    }
    void check_time(std::size_t row, const Interval& t) const {
        expect((Interval::decimal(words[row][0]) - t).size() < 0x1p-280, at(row, 0) + "is not its time");
    }
    // Whether a word is what all of x rounds to: to binary64, or to 50 digits.
    void check(std::size_t row, std::size_t column, const Interval& x) const {
        const std::string& word = words[row][column];
        const Interval found = Interval::decimal(word);
        if (is_binary64) {
            const double nearest = found.nearest(-1);
            expect(nearest == found.nearest(1) && nearest == x.nearest(-1) && nearest == x.nearest(1),
                   at(row, column) + word + " is not the nearest");
            return;
        }
        // d.ddd...e+xx with 49 decimals: within half a unit of the last. Zero stands for zero.
        const std::size_t e = word.find('e'), point = word.find('.');
        const double half = e == std::string::npos ? 0 : Interval::decimal("5e" + std::to_string(std::stol(word.substr(e + 1)) - 50)).below();
        expect(word == "0" || (point < e && e - point == 50), at(row, column) + "expected 50 digits");
        expect((found - x).size() <= half, at(row, column) + "is not within half a unit of the last digit");
    }

private:
    std::string name;
    bool is_binary64;
    std::vector<std::vector<std::string>> words;
    std::string at(std::size_t row, std::size_t column) const {
        return name + ", line " + std::to_string(row + 1) + ", column " + std::to_string(column + 1) + ": ";
    }
};
