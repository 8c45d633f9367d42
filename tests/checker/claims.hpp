// What a set says of itself: the problem, and how far each run is from the exact motion.
#pragma once
#include <array>
#include "files.hpp"

constexpr std::size_t SIZE = 7;
const std::array<std::string, SIZE> STATES = {"roll", "pitch", "steer", "w1", "w3", "spin", "yaw"};
const std::string PARAMETERS = "w c lam g rR mR IRxx IRyy xB zB mB IBxx IByy IBzz IBxz xH zH mH IHxx IHyy IHzz IHxz "
                               "rF mF IFxx IFyy";
const std::string START = "speed roll_rate roll steer steer_rate duration spacing";
using Radii = std::vector<double>;

// Numbers by name: all of them, and no other.
inline std::map<std::string, Interval> numbers(const Json& given, const std::string& names) {
    std::map<std::string, Interval> r;
    std::istringstream each(names);
    for (std::string name; each >> name;) r.emplace(name, exact_number(at(given, name)));
    for (const auto& [name, text] : given) expect(r.count(name) || name == "name", "\"" + name + "\" is not known");
    return r;
}

struct Claim {
    std::string name, pieces;
    Json input;
    std::map<std::string, Interval> at_start;
    Radii interval, end;  // by state variable, rounded down

    Claim(const Json& given, const Json& entry)
        : name(at(given, "name")), pieces(at(entry, "steps")), input(given), at_start(numbers(given, START)) {
        expect(at(entry, "maneuver") == name, "found " + at(entry, "maneuver") + ", expected " + name);
        expect(below(entry, "state_bounds").size() == 2 * SIZE, name + ": expected bounds of 7 state variables");
        // A bound of all variables is one of each.
        auto lowest = [&](const std::string& one, const std::string& all) {
            return std::min(Interval::decimal(at(entry, one)).below(), Interval::decimal(at(entry, all)).below());
        };
        for (const std::string& state : STATES) {
            interval.push_back(lowest("state_bounds/" + state + "/interval", "bound"));
            end.push_back(lowest("state_bounds/" + state + "/end", "bound_end"));
        }
    }
};

// Whether a run is about the claim's maneuver and covers its time.
inline void check_whole(const Candidate& run, hid_t group, const Claim& claim) {
    for (const auto& [key, text] : claim.input)
        expect(attribute(group, key) == text, "candidate.h5 has " + key + " " + attribute(group, key) + ", expected " + text);
    const Json states = json(attribute(group, "states"));
    for (std::size_t i = 0; i < SIZE; ++i)
        expect(at(states, "/" + std::to_string(i)) == STATES[i], "the state variables are others");
    expect(states.size() == SIZE && run.states == SIZE, "expected 7 state variables");
    expect(std::to_string(run.pieces) == claim.pieces && run.breaks.size() == run.pieces + 1,
           "found " + std::to_string(run.pieces) + " pieces, expected " + claim.pieces + " and one break more");
    const Interval rest = Interval::exactly(run.breaks.back()) - claim.at_start.at("duration");
    expect(run.breaks[0] == 0 && rest.below() >= 0, "the pieces do not cover its time");
    for (std::size_t i = 0; i < run.pieces; ++i) expect(run.breaks[i] < run.breaks[i + 1], "the breaks do not increase");
}
