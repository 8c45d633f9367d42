// The uncontrolled bicycle by Boost.odeint: SymBRiM's equations; rows by the dense output of the
// method, or, for one that has none (Fehlberg), by steps that end there. Settings: tolerance, method.

#include <boost/numeric/odeint.hpp>

#include "bicycle.hpp"

using namespace boost::numeric::odeint;

int main() {
    Bicycle bicycle;
    const auto slope = [&](const State& y, State& rates, double) {
        bicycle.slope(y.data(), rates.data());
    };
    std::vector<double> times;
    for (int i = 0; i <= 1000; ++i) times.push_back(i / bicycle.rate);
    std::vector<State> rows;
    const auto keep = [&](const State& y, double) { rows.push_back(y); };

    const std::clock_t begin = std::clock();
    State y = bicycle.start;
    const auto run = [&](auto stepper) {
        integrate_times(stepper, slope, y, times.begin(), times.end(), 1e-3, keep);
    };
    const std::string method = bicycle.said["method"];
    const double tolerance = bicycle.number("tolerance");
    if (method == "dopri5")
        run(make_dense_output(tolerance, tolerance, runge_kutta_dopri5<State>()));
    else if (method == "fehlberg78")
        run(make_controlled(tolerance, tolerance, runge_kutta_fehlberg78<State>()));
    else if (method == "bulirsch_stoer")
        run(bulirsch_stoer<State>(tolerance, tolerance));
    else if (method == "bulirsch_stoer_dense_out")
        run(bulirsch_stoer_dense_out<State>(tolerance, tolerance));
    else
        return std::fprintf(stderr, "no method %s\n", method.c_str());
    bicycle.write(rows, begin);
}
