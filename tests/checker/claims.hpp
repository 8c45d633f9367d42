// What a set says of itself: the problem, and how far each run is from the exact motion.
#pragma once
#include <array>
#include "files.hpp"

constexpr std::size_t SIZE = 7;
const std::array<std::string, SIZE> STATES = {"roll", "pitch", "steer", "w1", "w3", "spin", "yaw"};
using Radii = std::vector<double>;

// Numbers by name, all of them and no other; `what` has them.
inline std::map<std::string, Interval> numbers(const Json& of, const std::string& names, const std::string& what) {
    std::map<std::string, Interval> r;
    std::istringstream each(names);
    for (std::string name; each >> name;) r.emplace(name, exact_number(of.at(name).text));
    for (const auto& [name, item] : of.items)
        expect(r.count(name) || name == "name", what + ": \"" + name + "\" is not known");
    return r;
}

inline std::map<std::string, Interval> parameters(const Json& bicycle) {
    return numbers(bicycle.at("parameters"),
                   "w c lam g rR mR IRxx IRyy xB zB mB IBxx IByy IBzz IBxz xH zH mH IHxx IHyy IHzz IHxz "
                   "rF mF IFxx IFyy",
                   "parameters");
}

struct Claim {
    std::string name, pieces;
    Json input;
    std::map<std::string, Interval> at_start;
    Radii interval, end;  // by state variable, rounded down

    Claim(const Json& given, const Json& entry) : name(given.at("name").text), input(given) {
        at_start = numbers(given, "speed roll_rate roll steer steer_rate duration spacing", "inputs");
        expect(entry.at("maneuver").text == name, "found \"" + entry.at("maneuver").text + "\", expected " + name);
        pieces = entry.at("steps").text;
        const Json& bounds = entry.at("state_bounds");
        expect(bounds.items.size() == SIZE, "expected bounds of 7 state variables");
        // A bound of all variables is one of each.
        auto lowest = [](const Json& one, const Json& all) {
            return std::min(Interval::decimal(one.text).below(), Interval::decimal(all.text).below());
        };
        for (const std::string& state : STATES) {
            interval.push_back(lowest(bounds.at(state).at("interval"), entry.at("bound")));
            end.push_back(lowest(bounds.at(state).at("end"), entry.at("bound_end")));
        }
    }
};

// Whether a run is about the claim's maneuver and covers its time.
inline void check_whole(const Candidate& run, const Hdf5& group, const Claim& claim) {
    for (const auto& [key, item] : claim.input.items)
        expect(group.attribute(key) == item.text,
               "candidate.h5 has " + key + " " + group.attribute(key) + ", expected " + item.text);
    const Json states = Json::read(group.attribute("states"));
    expect(states.list.size() == SIZE && run.states == SIZE, "expected 7 state variables");
    for (std::size_t i = 0; i < SIZE; ++i)
        expect(states.list[i].text == STATES[i], "found state " + states.list[i].text + ", expected " + STATES[i]);
    expect(std::to_string(run.pieces) == claim.pieces && run.breaks.size() == run.pieces + 1,
           "found " + std::to_string(run.pieces) + " pieces and " + std::to_string(run.breaks.size())
               + " breaks, expected " + claim.pieces + " and one more");
    const Interval rest = Interval::exactly(run.breaks.back()) - claim.at_start.at("duration");
    expect(run.breaks[0] == 0 && rest.below() >= 0, "the pieces do not cover its time");
    for (std::size_t i = 0; i < run.pieces; ++i) expect(run.breaks[i] < run.breaks[i + 1], "the breaks do not increase");
}
