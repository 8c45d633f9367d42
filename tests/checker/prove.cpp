// check FOLDER [--any-inputs] [--until SECONDS], with options in any order: check the claims of a dataset.
// Exit codes: 0 accepted, 3 refused, 1 unreadable.
#include <sys/resource.h>
#include "rows.hpp"

static hid_t opened(const std::string& path) { return good(H5Fopen(regular(path).c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), path); }
static hid_t group(hid_t file, std::size_t number) { return member(file, "maneuver_" + std::to_string(number)); }

static void check(const std::string& folder, bool any, double until) {
    const Json certificate = json(text_of(folder + "/certificate.json"));
    const hid_t file = opened(folder + "/candidate.h5"), published = opened(folder + "/uncontrolled-bicycle.h5");
    const Json parameters = below(certificate, "/inputs/bicycle/parameters");
    const Bicycle k(numbers(parameters, BICYCLE, any));
    for (const auto& [key, text] : json(attribute(file, "parameters")))
        expect(at(parameters, key.substr(1)) == text, "candidate.h5 has another " + key.substr(1));
    std::vector<Claim> claims;
    std::vector<Candidate> runs;
    std::vector<Table> tables;
    std::string known = ABOUT;
    for (std::size_t i = 0;; ++i) {
        const Json given = below(certificate, "/inputs/maneuvers/" + std::to_string(i));
        const Json entry = below(certificate, "/maneuvers/" + std::to_string(i));
        const bool is_end = given.empty() && entry.empty();
        expect(i > 0 || !is_end, "there is no maneuver");
        expect(any || is_end == (i == MANEUVERS.size()), "found fewer or more maneuvers than the benchmark's");
        if (is_end) break;
        claims.emplace_back(given, entry, MANEUVERS[any ? 0 : i], any);
        runs.emplace_back(group(file, i + 1));
        check_whole(runs.back(), group(file, i + 1), claims.back());
        tables.emplace_back(group(published, i + 1), claims.back());
        known += " maneuver_" + std::to_string(i + 1);
    }
    expect_only(file, known);
    const std::vector<Text> texts = {{folder, "uncontrolled-bicycle-50digits.txt", Form::digits50},
                                     {folder, "uncontrolled-bicycle.txt", Form::binary64}};
    std::size_t values = 0;
    for (std::size_t i = 0; i < claims.size(); ++i) try {
        const Column at_start = start(k, claims[i]);
        const Radii worst = prove(k, runs[i], claims[i], at_start, until);
        std::cout << claims[i].name << ": largest error proved (claimed):";
        for (std::size_t j = 0; j < SIZE; ++j)
            std::cout << " " << STATES[j] << " " << shown(worst[j]) << " (" << shown(claims[i].interval[j]) << ")";
        std::cout << std::endl;
        values += check_rows(texts, tables[i], k, runs[i], claims[i], at_start, i, claims.size(), until);
    } catch (const Refusal& e) {
        throw Refusal(claims[i].name + ": " + e.what());
    }
    std::cout << values << " values of the rows are correctly rounded\naccepted: " << folder
              << (any ? ", for inputs that may be others than the benchmark's" : "")
              << (until < 1e300 ? ", pieces and rows that begin before that time only" : "") << std::endl;
}

// Ends the program at once. At a normal exit HDF5 closes its open objects, which may crash with a damaged file.
static int ended(const std::string& message, int code) {
    std::cout.flush(), std::cerr << message << std::flush;
    std::_Exit(code);
}

int main(int argc, char** argv) {
    std::fesetround(FE_UPWARD);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const Working high(BITS, ORDER);
    // Compressed data may unpack to a thousand times its size. Beyond this limit the program reports a lack of memory.
    const rlimit most = {rlim_t(1) << 31, rlim_t(1) << 31};
    setrlimit(RLIMIT_AS, &most);
    const char* folder = nullptr;
    bool any = false, is_usage = false;
    double until = 1e300;
    for (int i = 1; i < argc; ++i)
        if (!std::strcmp(argv[i], "--any-inputs")) any = true;
        else if (!std::strcmp(argv[i], "--until") && i + 1 < argc) until = std::atof(argv[++i]), is_usage |= !(until > 0);
        else if (folder || argv[i][0] == '-') is_usage = true;
        else folder = argv[i];
    if (is_usage || !folder) return ended("usage: check FOLDER [--any-inputs] [--until SECONDS]\n", 1);
    try {
        check(folder, any, until);
        return ended("", 0);
    } catch (const Refusal& e) {
        return ended(std::string("refused: ") + e.what() + "\n", 3);
    } catch (const std::bad_alloc&) {
        return ended(std::string(folder) + ": needs more memory than a set does\n", 1);
    } catch (const std::exception& e) {
        return ended(std::string(folder) + ": " + e.what() + "\n", 1);
    }
}
