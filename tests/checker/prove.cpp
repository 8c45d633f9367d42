// check FOLDER [--until SECONDS]: whether what a set claims is so. Exit 0 accepted, 3 refused, 1 unreadable.
#include "rows.hpp"

static hid_t opened(const std::string& folder, const std::string& name) {
    return good(H5Fopen((folder + "/" + name).c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), name);
}
static hid_t group(hid_t file, std::size_t number) {
    return good(H5Gopen2(file, ("maneuver_" + std::to_string(number)).c_str(), H5P_DEFAULT), "a group for each maneuver");
}

static void check(const std::string& folder, double until) {
    const Json certificate = json(text_of(folder + "/certificate.json"));
    const hid_t file = opened(folder, "candidate.h5"), published = opened(folder, "uncontrolled-bicycle.h5");
    const Json parameters = below(certificate, "/inputs/bicycle/parameters");
    const Bicycle k(numbers(parameters, PARAMETERS));
    for (const auto& [key, text] : json(attribute(file, "parameters")))
        expect(at(parameters, key.substr(1)) == text, "candidate.h5 has another " + key.substr(1));
    std::vector<Claim> claims;
    std::vector<Candidate> runs;
    H5G_info_t info;
    for (good(H5Gget_info(file, &info), "groups"); claims.size() < info.nlinks;) {
        const std::string number = "maneuvers/" + std::to_string(claims.size());
        claims.emplace_back(below(certificate, "/inputs/" + number), below(certificate, "/" + number));
        const hid_t at = group(file, claims.size());
        runs.emplace_back(at);
        check_whole(runs.back(), at, claims.back());
    }
    for (const char* place : {"/inputs/maneuvers/", "/maneuvers/"})
        expect(below(certificate, place + std::to_string(claims.size())).empty(), "candidate.h5 has fewer maneuvers");
    expect(!claims.empty(), "there is no maneuver");
    const std::vector<Text> texts = {{folder, "uncontrolled-bicycle-50digits.txt", false},
                                     {folder, "uncontrolled-bicycle.txt", true}};
    std::size_t values = 0;
    for (std::size_t i = 0; i < claims.size(); ++i) try {
        const Radii worst = prove(k, runs[i], claims[i], until);
        std::cout << claims[i].name << ": largest error proved (claimed):";
        for (std::size_t j = 0; j < SIZE; ++j)
            std::cout << " " << STATES[j] << " " << shown(worst[j]) << " (" << shown(claims[i].interval[j]) << ")";
        std::cout << std::endl;
        values += check_rows(texts, group(published, i + 1), k, runs[i], claims[i], i, claims.size(), until);
    } catch (const Refusal& e) {
        throw Refusal(claims[i].name + ": " + e.what());
    }
    std::cout << values << " values of the rows are correctly rounded\naccepted: " << folder
              << (until < 1e300 ? ", pieces and rows that begin before that time only" : "") << std::endl;
}

int main(int argc, char** argv) {
    std::fesetround(FE_UPWARD);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const Working high(BITS, ORDER);
    const bool cut = argc == 4 && !std::strcmp(argv[2], "--until") && std::atof(argv[3]) > 0;
    if (argc != 2 && !cut) return std::cerr << "usage: check FOLDER [--until SECONDS]\n", 1;
    try {
        check(argv[1], cut ? std::atof(argv[3]) : 1e300);
    } catch (const Refusal& e) {
        return std::cerr << "refused: " << e.what() << "\n", 3;
    } catch (const std::exception& e) {
        return std::cerr << argv[1] << ": " << e.what() << "\n", 1;
    }
}
