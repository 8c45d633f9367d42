// The uncontrolled bicycle by the GNU Scientific Library: SymBRiM's equations, a driver that steps
// from row to row. Settings: tolerance (of absolute errors), relative, method.

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include "bicycle.hpp"

static int slope(double, const double y[], double rates[], void* bicycle) {
    static_cast<Bicycle*>(bicycle)->slope(y, rates);
    return GSL_SUCCESS;
}

int main() {
    Bicycle bicycle;
    const std::map<std::string, const gsl_odeiv2_step_type*> methods = {
        {"rk4", gsl_odeiv2_step_rk4},     {"rkf45", gsl_odeiv2_step_rkf45},
        {"rkck", gsl_odeiv2_step_rkck},   {"rk8pd", gsl_odeiv2_step_rk8pd},
        {"msadams", gsl_odeiv2_step_msadams}};
    const double tolerance = bicycle.number("tolerance");
    gsl_odeiv2_system system = {slope, nullptr, 16, &bicycle};
    gsl_odeiv2_driver* driver = gsl_odeiv2_driver_alloc_y_new(
        &system, methods.at(bicycle.said["method"]), 1e-6, tolerance,
        tolerance * bicycle.number("relative"));

    const std::clock_t begin = std::clock();
    State y = bicycle.start;
    double t = 0;
    std::vector<State> rows = {y};
    for (int i = 1; i <= 1000; ++i) {
        const int status = gsl_odeiv2_driver_apply(driver, &t, i / bicycle.rate, y.data());
        if (status != GSL_SUCCESS) {
            std::fprintf(stderr, "stops at %g s: %s\n", t, gsl_strerror(status));
            return 1;
        }
        rows.push_back(y);
    }
    bicycle.write(rows, begin);
    gsl_odeiv2_driver_free(driver);
}
