// The claims of a dataset: the problem, and the distance of each run from the exact motion.
#pragma once
#include <array>
#include "files.hpp"

constexpr std::size_t SIZE = 7;
const std::array<std::string, SIZE> STATES = {"roll", "pitch", "steer", "w1", "w3", "spin", "yaw"};
using Radii = std::vector<double>;

// The benchmark: Table 1 of Meijaard, Papadopoulos, Ruina and Schwab (2007), doi:10.1098/rspa.2007.1857, and
// the maneuvers of the IFToMM library's problem "Uncontrolled bicycle", with the rows that are published.
const std::string BICYCLE = "w 1.02 c 0.08 lam 1/10*pi g 9.81 rR 0.3 mR 2 IRxx 0.0603 IRyy 0.12 xB 0.3 zB -0.9 mB 85 "
                            "IBxx 9.2 IByy 11 IBzz 2.8 IBxz 2.4 xH 0.9 zH -0.7 mH 4 IHxx 0.05892 IHyy 0.06 "
                            "IHzz 0.00708 IHxz -0.00756 rF 0.35 mF 3 IFxx 0.1405 IFyy 0.28";
const std::string REST = " roll 0 steer 0 steer_rate 0 duration 10 spacing 0.01";
const std::vector<std::string> MANEUVERS = {"speed 4 roll_rate 0.05" + REST, "speed 4.6 roll_rate 0.5" + REST,
                                            "speed 8 roll_rate 0.05" + REST};

// Names of the attributes of candidate.h5, and of the attributes and datasets of a run in it.
const std::string ABOUT = "id title summary Conventions keywords source references history product_version "
                          "creator_name creator_type license comment bicycle parameters";
const std::string ABOUT_RUN = "name speed roll_rate roll steer steer_rate duration spacing states form grid "
                              "taylor_order precision precision_bits breaks coefficients";

// True if two numbers are proved to be equal. Fractions of at most 39 characters are equal if they differ by less than
// 2^-280.
inline bool same(const std::string& a, const std::string& b, long times = 1) {
    const bool is_short = a.size() < 40 && b.size() < 40 && (a + b).find_first_of("+p") == a.npos;
    return a == b || (is_short && (exact_number(a) - exact_number(b) * times).size() < 0x1p-280);
}

// Numbers by name: exactly the expected names. The values must be those of the benchmark unless `any` is set.
inline std::map<std::string, Interval> numbers(const Json& given, const std::string& expected, bool any) {
    std::map<std::string, Interval> r;
    std::istringstream each(expected);
    for (std::string name, value; each >> name >> value;) {
        const std::string& text = at(given, name);
        expect(any || same(text, value), name + " is " + text + ", that of the benchmark " + value);
        r.emplace(name, exact_number(text));
    }
    for (const auto& [name, text] : given) expect(r.count(name) || name == "name", "\"" + name + "\" is not known");
    return r;
}

struct Claim {
    std::string name, pieces;
    Json input;
    std::map<std::string, Interval> at_start;
    Radii interval, end;  // bounds by state variable, rounded down
    std::size_t ambiguous;  // count of undecided numbers in all columns

    Claim(const Json& given, const Json& entry, const std::string& expected, bool any)
        : name(at(given, "name")), pieces(at(entry, "steps")), input(given), at_start(numbers(given, expected, any)) {
        ambiguous = std::size_t(std::atol(at(entry, "ambiguous").c_str()));
        expect(at(entry, "maneuver") == name, "found " + at(entry, "maneuver") + ", expected " + name);
        expect(below(entry, "state_bounds").size() == 2 * SIZE, name + ": expected bounds of 7 state variables");
        // A common bound also applies to each variable.
        auto lowest = [&](const std::string& one, const std::string& all) {
            return std::min(Interval::decimal(at(entry, one)).below(), Interval::decimal(at(entry, all)).below());
        };
        for (const std::string& state : STATES) {
            interval.push_back(lowest("state_bounds/" + state + "/interval", "bound"));
            end.push_back(lowest("state_bounds/" + state + "/end", "bound_end"));
        }
    }
};

// Check that a run belongs to the claim's maneuver and covers its time.
inline void check_whole(const Candidate& run, hid_t group, const Claim& claim) {
    expect_only(group, ABOUT_RUN);
    for (const auto& [key, text] : claim.input)
        expect(attribute(group, key) == text, "candidate.h5 has " + key + " " + attribute(group, key) + ", expected " + text);
    const std::string states = R"(["roll", "pitch", "steer", "w1", "w3", "spin", "yaw"])";
    expect(attribute(group, "states") == states && run.states == SIZE, "the state variables are not " + states);
    expect(std::to_string(run.pieces) == claim.pieces && run.breaks.size() == run.pieces + 1,
           "found " + std::to_string(run.pieces) + " pieces, expected " + claim.pieces + " and one break more");
    const Interval rest = Interval::exactly(run.breaks.back()) - claim.at_start.at("duration");
    expect(std::isfinite(run.breaks.back()), "the last break is not a time");
    expect(run.breaks[0] == 0 && rest.below() >= 0, "the pieces do not cover its time");
    for (std::size_t i = 0; i < run.pieces; ++i) expect(run.breaks[i] < run.breaks[i + 1], "the breaks do not increase");
}
