// check FOLDER [--until SECONDS]: whether what a set claims is so. Exit 0 accepted, 3 refused, 1 unreadable.
#include <cmath>
#include <cstring>
#include "error.hpp"
#include "rows.hpp"

// The rows of maneuver `number` before `until`, in the texts; returns how many values they have.
static std::size_t check_rows(const std::vector<Rows>& texts, const Bicycle& k, const Candidate& run, const Claim& claim,
                              std::size_t number, std::size_t maneuvers, double until) {
    const Interval spacing = claim.at_start.at("spacing"), duration = claim.at_start.at("duration");
    const Interval steps = duration / spacing;
    const long last = std::lround(steps.middle().below());
    expect((steps - last).holds_zero(), "its time is no multiple of the spacing");
    for (const Rows& text : texts) text.check_shape(last + 1, 1 + 8 * maneuvers);
    std::size_t count = 0;
    for (long row = 0; row <= last; ++row) {
        const Interval t = spacing * row;
        if (!(t.below() < until)) break;
        std::vector<Interval> found;
        if (row == 0) {
            const auto& given = claim.at_start;
            found = columns(k, start(k, claim, run.piece(0)[1][0], claim.interval[1]));
            found[0] = given.at("roll"), found[1] = given.at("roll_rate"), found[2] = given.at("speed");
            found[6] = given.at("steer"), found[7] = given.at("steer_rate");
        } else {
            found = columns(k, run.around(t, claim.interval));
        }
        for (const Rows& text : texts) {
            text.check_time(row, t);
            for (std::size_t j = 0; j < 8; ++j) text.check(row, 1 + 8 * number + j, found[j]), ++count;
        }
    }
    return count;
}

static void check(const std::string& folder, double until) {
    const Json certificate = Json::read(text_of(folder + "/certificate.json"));
    const Hdf5 file = Hdf5::open(folder + "/candidate.h5");
    const Json& inputs = certificate.at("inputs");
    const Bicycle k(parameters(inputs.at("bicycle")));
    const auto stated = Json::read(file.attribute("parameters")).items;
    for (const auto& [key, item] : inputs.at("bicycle").at("parameters").items)
        expect(stated.count(key) && stated.at(key).text == item.text, "candidate.h5 has another " + key);
    const auto &given = inputs.at("maneuvers").list, &claimed = certificate.at("maneuvers").list;
    expect(given.size() == claimed.size() && given.size() == file.groups() && !given.empty(),
           "certificate.json and candidate.h5 do not have the same maneuvers");
    std::vector<Claim> claims;
    std::vector<Candidate> runs;
    for (std::size_t i = 0; i < given.size(); ++i) {
        claims.emplace_back(given[i], claimed[i]);
        const Hdf5 group = file.group("maneuver_" + std::to_string(i + 1));
        runs.emplace_back(group);
        check_whole(runs[i], group, claims[i]);
    }
    const std::vector<Rows> texts = {{folder, "uncontrolled-bicycle-50digits.txt", false},
                                     {folder, "uncontrolled-bicycle.txt", true}};
    std::size_t values = 0;
    for (std::size_t i = 0; i < claims.size(); ++i) try {
        const Radii worst = prove(k, runs[i], claims[i], until);
        values += check_rows(texts, k, runs[i], claims[i], i, claims.size(), until);
        std::cout << claims[i].name << ": largest error proved (claimed):";
        for (std::size_t j = 0; j < SIZE; ++j)
            std::cout << " " << STATES[j] << " " << shown(worst[j]) << " (" << shown(claims[i].interval[j]) << ")";
        std::cout << std::endl;
    } catch (const Refusal& e) {
        throw Refusal(claims[i].name + ": " + e.what());
    }
    std::cout << values << " values of the two texts are correctly rounded\naccepted: " << folder
              << (until < 1e300 ? ", pieces and rows that begin before that time only" : "") << std::endl;
}

int main(int argc, char** argv) {
    std::fesetround(FE_UPWARD);
    const Working high(BITS, ORDER);
    const bool cut = argc == 4 && !std::strcmp(argv[2], "--until") && std::atof(argv[3]) > 0;
    if (argc != 2 && !cut) return std::cerr << "usage: check FOLDER [--until SECONDS]\n", 1;
    try {
        check(argv[1], cut ? std::atof(argv[3]) : 1e300);
    } catch (const Refusal& e) {
        return std::cerr << "refused: " << e.what() << "\n", 3;
    } catch (const Unreadable& e) {
        return std::cerr << argv[1] << ": " << e.what() << "\n", 1;
    }
}
