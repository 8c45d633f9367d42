// Propagation of an error: linear differential equations with proved solutions, and Lohner's frame.
#pragma once
#include <algorithm>
#include <numeric>
#include "model.hpp"

using Radii = std::vector<double>;
using Column = std::vector<Interval>;
using Models = std::vector<std::vector<Model>>;

// Solutions of w' = A w + b on 0 <= u <= 1. There is a column for each unit initial value with b = 0, and a last one
// for zero initial values with b. w[i][j] are polynomials, and off[i][j] bounds their distance from the exact solution.
struct Flow {
    Models w;
    std::vector<Radii> off;

    // The last column has the working order, the others have `order`.
    Flow(const Models& A, const std::vector<Model>& b, std::size_t order)
        : w(b.size(), std::vector<Model>(b.size() + 1)), off(b.size(), Radii(b.size() + 1)) {
        const std::size_t n = b.size();
        Radii weights(n, 1.0);
        const double growth = most_growth(A, weights);
        for (std::size_t j = 0; j <= n; ++j) {
            const Working now(Working::bits, j < n ? order : Working::order);
            for (std::size_t i = 0; i < n; ++i) w[i][j].c.push_back(i == j ? 1 : 0);
            for (std::size_t k = 0; k + 1 < Working::order; ++k)
                for (std::size_t i = 0; i < n; ++i) {
                    Interval sum = j == n && k < b[i].c.size() ? b[i].c[k] : Interval();
                    for (std::size_t l = 0; l < n; ++l)
                        for (std::size_t m = 0; m <= k && m < A[i][l].c.size(); ++m)
                            sum.add_product(A[i][l].c[m], w[l][j].c[k - m]);
                    w[i][j].c.push_back((sum / long(k + 1)).middle());
                }
            // Gronwall's bound: the norm of the defect w' - A w - b times the largest growth by A.
            double defect = 0;
            for (std::size_t i = 0; i < n; ++i) {
                Model d = w[i][j].slope();
                if (j == n) d += -b[i];
                for (std::size_t l = 0; l < n; ++l) d += -(A[i][l] * w[l][j]);
                defect = std::max(defect, d.size() / weights[i]);
            }
            for (std::size_t i = 0; i < n; ++i) off[i][j] = weights[i] * growth * defect;
        }
    }

private:
    // exp of the logarithmic norm of A, but at least 1, in the maximum norm with weights near Perron's vector.
    static double most_growth(const Models& A, Radii& weights) {
        const std::size_t n = A.size();
        double norm = 0, shift = 0;  // the shift makes the diagonal nonnegative
        for (std::size_t i = 0; i < n; ++i) shift = std::max(shift, A[i][i].size());
        for (int round = 0; round < 20; ++round) {
            Radii next(n, 0.0);
            norm = 0;
            for (std::size_t i = 0; i < n; ++i) {
                for (std::size_t l = 0; l < n; ++l)
                    next[i] += (i == l ? A[i][l].above() + shift : A[i][l].size()) * weights[l];
                norm = std::max(norm, next[i] / weights[i]);
            }
            if (round == 19 || !(norm > 0)) break;
            for (std::size_t i = 0; i < n; ++i) weights[i] = next[i] / norm + 0.01 * weights[i];
        }
        norm -= shift;
        if (!(norm < 100)) throw Refusal("the errors may grow too fast over a span");
        return exp(Interval::exactly(std::max(norm, 0.0))).size();
    }
};

// The set of possible errors is centre + sum_j axes[j] box_j with abs(box) <= radii.
class Frame {
public:
    explicit Frame(const Column& start) : axes(start.size(), Column(start.size())) {
        for (std::size_t i = 0; i < start.size(); ++i) {
            centre.push_back(start[i].middle()), radii.push_back(start[i].radius());
            axes[i][i] = 1;
        }
    }
    Radii bound() const {
        Radii r;
        for (std::size_t i = 0; i < radii.size(); ++i) {
            r.push_back(centre[i].size());
            for (std::size_t j = 0; j < radii.size(); ++j) r[i] += axes[j][i].size() * radii[j];
        }
        return r;
    }
    // Carry the set to the end of a span; return a bound that is valid during the span.
    Radii carry(const Flow& flow) {
        const std::size_t n = radii.size();
        const Radii start = bound();
        Radii most(n), added(n);
        Column end(n);
        std::vector<Column> moved(n, Column(n));
        for (std::size_t i = 0; i < n; ++i) {
            auto times = [&](const Column& v) {
                Model sum;
                for (std::size_t l = 0; l < n; ++l) sum += flow.w[i][l] * Model(v[l]);
                return sum;
            };
            const Model middle = times(centre) + flow.w[i][n];
            added[i] = flow.off[i][n];
            for (std::size_t l = 0; l < n; ++l) added[i] += flow.off[i][l] * start[l];
            most[i] = middle.size() + added[i];
            for (std::size_t j = 0; j < n; ++j) {
                const Model along = times(axes[j]);
                most[i] += along.size() * radii[j];
                moved[j][i] = along.at_end();
            }
            end[i] = middle.at_end();
        }
        put(end, moved, added);
        return most;
    }
    void move(const Column& by) {
        Column sum;
        for (std::size_t i = 0; i < by.size(); ++i) sum.push_back(centre[i] + by[i]);
        put(sum, std::vector<Column>(axes), Radii(by.size(), 0.0));
    }

private:
    Column centre;
    std::vector<Column> axes;
    Radii radii;

    static Interval dot(const Column& a, const Column& b) {
        Interval sum;
        for (std::size_t i = 0; i < a.size(); ++i) sum.add_product(a[i], b[i]);
        return sum;
    }
    // Enclose the set middle + sum_j moved[j] box_j + [-added, added] in nearly orthonormal axes, the longest first.
    // With the new axes Q and Q^T Q = 1 + R, Q^-1 v = (1 + R)^-1 Q^T v.
    void put(const Column& middle, const std::vector<Column>& moved, Radii added) {
        const std::size_t n = radii.size();
        Radii length(n, 0.0), across(n, 0.0);
        for (std::size_t i = 0; i < n; ++i) {
            centre[i] = middle[i].middle(), added[i] += middle[i].radius();
            for (const Interval& x : moved[i]) length[i] = std::max(length[i], x.size() * radii[i]);
        }
        std::vector<std::size_t> order(n);
        std::iota(order.begin(), order.end(), 0);
        std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return length[a] > length[b]; });
        axes.clear();
        for (std::size_t j : order) {
            Column v;
            for (const Interval& x : moved[j]) v.push_back(x.middle());
            for (int twice = 0; twice < 2; ++twice)
                for (const Column& axis : axes) {
                    const Interval part = dot(axis, v).middle();
                    for (std::size_t i = 0; i < n; ++i) v[i] = (v[i] - part * axis[i]).middle();
                }
            const Interval scale = inverse_root(dot(v, v));
            for (Interval& x : v) x = (x * scale).middle();
            axes.push_back(v);
        }
        double skew = 0, largest = 0;
        for (std::size_t j = 0; j < n; ++j) {
            double row = 0;
            for (std::size_t l = 0; l < n; ++l) {
                row += (dot(axes[j], axes[l]) - (j == l ? 1 : 0)).size();
                across[j] += dot(axes[j], moved[l]).size() * radii[l] + axes[j][l].size() * added[l];
            }
            skew = std::max(skew, row), largest = std::max(largest, across[j]);
        }
        if (!(skew <= 0.5)) throw Refusal("the axes that carry the error are not orthogonal");
        for (std::size_t j = 0; j < n; ++j) radii[j] = across[j] + 2 * skew * largest;
    }
};
