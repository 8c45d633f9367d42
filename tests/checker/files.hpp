// What is read: certificate.json, candidate.h5 and texts of rows.
#pragma once
#include <cstring>
#include <fstream>
#include <hdf5.h>
#include <map>
#include <sstream>
#include "interval.hpp"

// A file that is not there or not of its kind; the message is one line.
struct Unreadable : std::runtime_error {
    using std::runtime_error::runtime_error;
};
inline void readable(bool good, const std::string& message) {
    if (!good) throw Unreadable(message);
}

inline std::string text_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream all;
    readable(file && all << file.rdbuf(), path + " cannot be read");
    return all.str();
}

// A rational plus a rational multiple of pi: "51/50", "1/10*pi", "1/2+1/10*pi".
inline Interval exact_number(const std::string& text) {
    const std::size_t star = text.find("*pi"), plus = text.find('+');
    if (star != std::string::npos) {
        const Interval rest = plus == std::string::npos ? Interval() : exact_number(text.substr(0, plus));
        const std::size_t from = plus == std::string::npos ? 0 : plus + 1;
        expect(star + 3 == text.size(), "found \"" + text + "\", expected a fraction or a multiple of pi");
        return rest + exact_number(text.substr(from, star - from)) * Interval::pi();
    }
    mpq_t q;
    mpq_init(q);
    const bool good = mpq_set_str(q, text.c_str(), 10) == 0 && mpz_sgn(mpq_denref(q)) != 0;
    const Interval r = good ? Interval::of(q) : Interval();
    mpq_clear(q);
    expect(good, "found \"" + text + "\", expected a fraction or a multiple of pi");
    return r;
}

// A JSON value; numbers and words stay text.
struct Json {
    std::string text;
    std::vector<Json> list;
    std::map<std::string, Json> items;

    const Json& at(const std::string& key) const {
        const auto found = items.find(key);
        expect(found != items.end(), "expected \"" + key + "\"");
        return found->second;
    }
    static Json read(const std::string& text) {
        const char* p = text.c_str();
        Json r = value(p, 0);
        readable(!next(p, ',') && p == text.c_str() + text.size(), "not JSON");
        return r;
    }

private:
    // Whether the next character that is no blank is c; if so it is taken.
    static bool next(const char*& p, char c) {
        while (*p && std::strchr(" \t\r\n", *p)) ++p;
        return *p == c && c && ++p;
    }
    static std::string word(const char*& p) {
        std::string r;
        for (; *p && *p != '"'; ++p) r += *p == '\\' && p[1] ? *++p : *p;
        readable(next(p, '"'), "not JSON");
        return r;
    }
    static Json value(const char*& p, int depth) {
        Json r;
        readable(depth < 20, "not JSON of this kind");
        if (next(p, '{')) {
            while (next(p, '"')) {
                const std::string key = word(p);
                readable(next(p, ':'), "not JSON");
                expect(r.items.emplace(key, value(p, depth + 1)).second, "\"" + key + "\" is there twice");
                if (!next(p, ',')) break;
            }
            readable(next(p, '}'), "not JSON");
        } else if (next(p, '[')) {
            if (next(p, ']')) return r;
            do r.list.push_back(value(p, depth + 1));
            while (next(p, ','));
            readable(next(p, ']'), "not JSON");
        } else if (next(p, '"')) {
            r.text = word(p);
        } else {
            while (*p && std::strchr("+-.0123456789eEtrufalsn", *p)) r.text += *p++;
            readable(!r.text.empty(), "not JSON");
        }
        return r;
    }
};

// An open HDF5 file or group; closed when the program ends.
class Hdf5 {
public:
    static Hdf5 open(const std::string& path) {
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
        return Hdf5(good(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), path + " as an HDF5 file"));
    }
    Hdf5 group(const std::string& name) const { return Hdf5(good(H5Gopen2(id, name.c_str(), H5P_DEFAULT), name)); }
    std::size_t groups() const {
        H5G_info_t info;
        good(H5Gget_info(id, &info), "groups");
        return info.nlinks;
    }
    std::string attribute(const std::string& name) const {
        const hid_t a = good(H5Aopen(id, name.c_str(), H5P_DEFAULT), name), type = H5Aget_type(a);
        readable(H5Tis_variable_str(type) > 0, name + ": expected text");
        char* text = nullptr;
        good(H5Aread(a, type, &text), name);
        return text ? text : "";
    }
    long integer(const std::string& name) const {
        long n = 0;
        good(H5Aread(good(H5Aopen(id, name.c_str(), H5P_DEFAULT), name), H5T_NATIVE_LONG, &n), name);
        return n;
    }
    template <class V>
    std::vector<V> array(const std::string& name, hid_t as, std::vector<hsize_t>& shape) const {
        const hid_t d = good(H5Dopen2(id, name.c_str(), H5P_DEFAULT), name), space = H5Dget_space(d);
        readable(H5Sget_simple_extent_ndims(space) == int(shape.size()), name + " has another shape");
        H5Sget_simple_extent_dims(space, shape.data(), nullptr);
        std::vector<V> r(H5Sget_simple_extent_npoints(space));
        readable(!r.empty(), name + " is empty");
        good(H5Dread(d, as, H5S_ALL, H5S_ALL, H5P_DEFAULT, r.data()), name);
        return r;
    }

private:
    hid_t id;
    explicit Hdf5(hid_t h) : id(h) {}
    template <class H>
    static H good(H h, const std::string& what) {
        readable(h >= 0, "cannot read " + what);
        return h;
    }
};

// A run of candidate.h5: on the piece from breaks[i] to breaks[i + 1] a state is sum_k c[k] s^k, 0 <= s <= 1.
struct Candidate {
    std::vector<double> breaks;
    std::size_t pieces = 0, states = 0;

    explicit Candidate(const Hdf5& group) : grid(group.integer("grid")) {
        std::vector<hsize_t> one(1), shape(4);
        breaks = group.array<double>("breaks", H5T_NATIVE_DOUBLE, one);
        data = group.array<unsigned char>("coefficients", H5T_NATIVE_UCHAR, shape);
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
    // The exact motion at t, when it is not farther than `radii`.
    std::vector<Interval> around(const Interval& t, const std::vector<double>& radii) const {
        std::size_t i = 0;
        while (i + 1 < pieces && breaks[i + 1] <= t.below()) ++i;
        const Interval a = Interval::exactly(breaks[i]), s = (t - a) / (Interval::exactly(breaks[i + 1]) - a);
        std::vector<Interval> r;
        for (const auto& row : piece(i)) {
            Interval sum;
            for (std::size_t k = row.size(); k-- > 0;) sum = sum * s + row[k];
            r.push_back(sum + Interval::around_zero(radii[r.size()]));
        }
        return r;
    }

private:
    std::size_t powers = 0, width = 0;
    long grid;
    std::vector<unsigned char> data;
};
