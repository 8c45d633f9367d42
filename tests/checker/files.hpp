// The input files: certificate.json, candidate.h5 and texts of rows.
#pragma once
#include <fstream>
#include <hdf5.h>
#include <map>
#include <set>
#include <sstream>
#include <sys/stat.h>
#include "interval.hpp"

// Raised if a file is missing or has the wrong form; the message is one line.
inline void readable(bool good, const std::string& message) {
    if (!good) throw std::runtime_error(message);
}

// Only regular files are opened: reading a pipe would wait for a writer, and a device may never end.
inline const std::string& regular(const std::string& path) {
    struct stat found;
    readable(stat(path.c_str(), &found) == 0, path + " cannot be read");
    readable(S_ISREG(found.st_mode), path + " is not a regular file");
    return path;
}

inline std::string text_of(const std::string& path) {
    std::ostringstream all;
    readable(bool(all << std::ifstream(regular(path)).rdbuf()), path + " cannot be read");
    return all.str();
}

// A rational plus a rational multiple of pi: "51/50", "1/10*pi", "1/2+1/10*pi".
inline Interval exact_number(const std::string& text) {
    const std::size_t plus = text.find('+'), star = text.find("*pi"), slash = text.find('/'), none = text.npos;
    if (plus != none) return exact_number(text.substr(0, plus)) + exact_number(text.substr(plus + 1));
    if (star != none && star + 3 == text.size()) return exact_number(text.substr(0, star)) * Interval::pi();
    if (slash == none) return Interval::decimal(text);
    return Interval::decimal(text.substr(0, slash)) / Interval::decimal(text.substr(slash + 1));
}

// The words and numbers of a JSON text by their path, such as "/maneuvers/0/bound". Ambiguous text is refused:
// duplicate keys, keys with a slash, and escapes, which no dataset needs.
using Json = std::map<std::string, std::string>;
inline void read_json(const char*& p, const std::string& place, Json& into) {
    readable(place.size() < 500, "not JSON of this kind");
    auto next = [&p](char c) { return p += std::strspn(p, " \t\r\n"), *p == c && ++p; };
    auto need = [&next](char c) { readable(next(c), "not JSON"); };
    auto word = [&p](const char* until) {
        const std::size_t length = std::strcspn(p, until);
        return p += length, std::string(p - length, length);
    };
    auto quoted = [&] {
        const std::string r = word("\"\\");
        expect(*p != '\\', place + ": an escape in JSON, which is not read");
        return need('"'), r;
    };
    if (const char end = next('{') ? '}' : next('[') ? ']' : 0) {
        std::set<std::string> keys;
        for (int i = 0; !next(end); ++i) {
            std::string key = std::to_string(i);
            if (i > 0) need(',');
            if (end == '}') need('"'), key = quoted(), need(':');
            expect(keys.insert(key).second, place + "/" + key + " is there twice");
            expect(key.find('/') == key.npos, place + "/" + key + ": a key with a slash");
            read_json(p, place + "/" + key, into);
        }
    } else {
        into[place] = next('"') ? quoted() : word(" \t\r\n,:[]{}\"");
    }
}
inline Json json(const std::string& text) {
    Json r;
    const char* p = text.c_str();
    read_json(p, "", r);
    readable(p + std::strspn(p, " \t\r\n") == text.c_str() + text.size(), "not JSON of one value");
    return r;
}
// The part of the document below a path.
inline Json below(const Json& all, const std::string& place) {
    Json r;
    for (const auto& [key, text] : all)
        if (key.rfind(place + "/", 0) == 0) r[key.substr(place.size() + 1)] = text;
    return r;
}
inline const std::string& at(const Json& j, const std::string& place) {
    expect(j.count(place), "expected \"" + place + "\"");
    return j.at(place);
}

// Size limit of an HDF5 dataset [bytes]; the largest published one has 2 million.
constexpr std::size_t MOST_BYTES = 500'000'000;

// HDF5 files and groups; they are closed when the program ends.
template <class H>
H good(H h, const std::string& what) {
    readable(h >= 0, "cannot read " + what);
    return h;
}
// Opens an object of a group. Links are refused, because they may lead to other files.
inline hid_t member(hid_t group, const std::string& name) {
    H5L_info_t link;
    expect(H5Lget_info(group, name.c_str(), &link, H5P_DEFAULT) >= 0, "there is no " + name);
    expect(link.type == H5L_TYPE_HARD, name + " is a link, expected numbers stored in the file");
    return good(H5Oopen(group, name.c_str(), H5P_DEFAULT), name);
}
// Check that a group has no unknown attribute, dataset or group.
inline void expect_only(hid_t group, const std::string& known) {
    std::vector<std::string> found;
    const auto note = [](hid_t, const char* name, const auto*, void* to) -> herr_t {
        return static_cast<std::vector<std::string>*>(to)->emplace_back(name), 0;
    };
    good(H5Aiterate2(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, note, &found), "attributes");
    good(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, note, &found), "a group");
    for (const std::string& name : found) {
        const bool is_known = (" " + known + " ").find(" " + name + " ") != known.npos;
        expect(is_known && name.find(' ') == name.npos, "found " + name + ", and nothing proves it");
    }
}
// Check that the stored data have exactly the expected type and number of axes, because HDF5 would convert them
// silently.
inline void expect_stored(hid_t found, hid_t type, hid_t space, int axes, const std::string& name) {
    const bool same = H5Tequal(found, type) > 0 && H5Sget_simple_extent_ndims(space) == axes;
    expect(same, name + " is of another type or shape");
}
template <class V>
V scalar(hid_t of, const std::string& name, hid_t type) {
    const hid_t a = good(H5Aopen(of, name.c_str(), H5P_DEFAULT), name);
    expect_stored(H5Aget_type(a), type, H5Aget_space(a), 0, name);
    V r{};
    return good(H5Aread(a, type, &r), name), r;
}
inline std::string attribute(hid_t of, const std::string& name) {
    const hid_t text = H5Tcopy(H5T_C_S1);
    H5Tset_size(text, H5T_VARIABLE), H5Tset_cset(text, H5T_CSET_UTF8);
    const char* r = scalar<const char*>(of, name, text);
    return r ? r : "";
}
template <class V>
std::vector<V> array(hid_t of, const std::string& name, hid_t type, std::vector<hsize_t>& shape) {
    const hid_t d = member(of, name), space = good(H5Dget_space(d), name), made = good(H5Dget_create_plist(d), name);
    expect(H5Pget_layout(made) != H5D_VIRTUAL && H5Pget_external_count(made) == 0, name + " is kept in another file");
    expect_stored(H5Dget_type(d), type, space, int(shape.size()), name);
    H5Sget_simple_extent_dims(space, shape.data(), nullptr);
    const hssize_t entries = H5Sget_simple_extent_npoints(space);
    readable(entries >= 0 && std::size_t(entries) < MOST_BYTES / sizeof(V), name + " is too large");
    std::vector<V> r(entries);
    readable(!r.empty(), name + " is empty");
    good(H5Dread(d, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, r.data()), name);
    return r;
}

// A run of candidate.h5. On the segment from breaks[i] to breaks[i + 1] a state is sum_k c[k] s^k with 0 <= s <= 1.
struct Candidate {
    std::vector<double> breaks;
    std::size_t pieces = 0, states = 0;

    explicit Candidate(hid_t group) {
        std::vector<hsize_t> one(1), shape(4);
        grid = scalar<long>(group, "grid", H5T_NATIVE_LONG);
        breaks = array<double>(group, "breaks", H5T_NATIVE_DOUBLE, one);
        data = array<unsigned char>(group, "coefficients", H5T_NATIVE_UCHAR, shape);
        pieces = shape[0], states = shape[1], powers = shape[2], width = shape[3];
    }
    std::vector<std::vector<Interval>> piece(std::size_t number) const {
        std::vector<std::vector<Interval>> r(states);
        mpz_t n, wrap;
        mpz_inits(n, wrap, nullptr);
        mpz_setbit(wrap, 8 * width);
        for (std::size_t k = 0; k < states * powers; ++k) {
            const unsigned char* bytes = &data[(number * states * powers + k) * width];
            mpz_import(n, width, -1, 1, -1, 0, bytes);
            if (bytes[width - 1] & 0x80) mpz_sub(n, n, wrap);
            r[k / powers].push_back(Interval::of(n).scaled_by_power_of_two(-grid));
        }
        mpz_clears(n, wrap, nullptr);
        return r;
    }
    // An enclosure of the exact motion at t, if it is within `radii` of the candidate; t is not after the end.
    std::vector<Interval> around(const Interval& t, const std::vector<double>& radii) const {
        std::size_t i = 0;
        while (i + 1 < pieces && breaks[i + 1] <= t.below()) ++i;
        const Interval a = Interval::exactly(breaks[i]), s = (t - a) / (Interval::exactly(breaks[i + 1]) - a);
        expect(i + 1 == pieces || s.above() <= 1, "a row at a break between pieces");
        std::vector<Interval> r;
        for (const auto& row : piece(i)) {
            Interval sum;
            for (std::size_t k = row.size(); k-- > 0;) sum = sum * s.not_above_1() + row[k];
            r.push_back(sum + Interval::around_zero(radii[r.size()]));
        }
        return r;
    }

private:
    std::size_t powers = 0, width = 0;
    long grid = 0;
    std::vector<unsigned char> data;
};
