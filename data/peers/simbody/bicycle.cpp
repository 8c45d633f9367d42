// The uncontrolled bicycle in Simbody, by what it has built in: each wheel hangs on a massless frame
// that follows its point of contact (place and yaw), and on another that leans; SpeedCoupler makes
// it roll. The front wheel closes a loop with the fork. Axes: x forward, y left, z up.
//
// Reads lines "name value" (parameters, speed, roll_rate, rate, accuracy, integrator, interpolate), writes
// the eight columns `rate` times a second, as an error message the processor time [s] and the steps.

#include <Simbody.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include <cstdio>
#include <ctime>
#include <iostream>
#include <map>
#include <memory>

using namespace SimTK;

// Along or across its heading, how fast a contact point runs ahead of its wheel: zero. Arguments
// are the rates of place along x and y, those of rotation on the axle, and the yaw.
class Ahead : public Function {
public:
    Ahead(double radius, int spins, bool across) : radius(radius), spins(spins), across(across) {}
    double calcValue(const Vector& x) const override {
        double sum = 0;
        for (int i = 0; i < 2 + spins; ++i) sum += factor(i, x) * x[i];
        return sum;
    }
    double calcDerivative(const Array_<int>& by, const Vector& x) const override {
        const int yaw = 2 + spins;
        if (by.size() == 1 && by[0] < yaw) return factor(by[0], x);
        if (by.size() == 1) return turned(0, x) * x[0] + turned(1, x) * x[1];
        throw std::logic_error("Simbody asks for no second derivative");
    }
    int getArgumentSize() const override { return 3 + spins; }
    int getMaxDerivativeOrder() const override { return 2; }

private:
    double factor(int i, const Vector& x) const {
        const double c = std::cos(x[2 + spins]), s = std::sin(x[2 + spins]);
        if (i > 1) return across ? 0 : -radius;
        return across ? (i ? c : -s) : (i ? s : c);
    }
    double turned(int i, const Vector& x) const {  // derivative of a factor by the yaw
        const double c = std::cos(x[2 + spins]), s = std::sin(x[2 + spins]);
        return across ? (i ? -s : -c) : (i ? c : -s);
    }
    double radius;
    int spins;
    bool across;
};

static Rotation along(const Vec3& axis) { return Rotation(UnitVec3(axis), ZAxis); }  // for a Pin

int main() {
    std::map<std::string, std::string> given;
    for (std::string name, value; std::cin >> name >> value;) given[name] = value;
    const auto p = [&](const std::string& name) { return std::stod(given.at(name)); };

    MultibodySystem system;
    SimbodyMatterSubsystem matter(system);
    GeneralForceSubsystem forces(system);
    Force::Gravity gravity(forces, matter, -ZAxis, p("g"));

    // Mass, centre and tensor about the body's origin; z up changes the sign of the products.
    const auto body = [&](const std::string& b, const Vec3& centre) {
        const auto or_else = [&](const std::string& name, double value) {
            return given.count(name) ? p(name) : value;
        };
        const double xx = p("I" + b + "xx");
        Inertia central(xx, p("I" + b + "yy"), or_else("I" + b + "zz", xx), 0,
                        -or_else("I" + b + "xz", 0), 0);
        return Body::Rigid(
            MassProperties(p("m" + b), centre, central.shiftFromMassCenter(centre, p("m" + b))));
    };
    const Vec3 axle(0, 1, 0), steer(std::sin(p("lam")), 0, -std::cos(p("lam")));
    const Vec3 foot(p("w") + p("c"), 0, -p("rR"));  // steer axis on the floor, from the rear hub
    const Vec3 front = Vec3(p("w"), 0, p("rF") - p("rR")) - foot;

    const auto on_floor = [&](double x) {  // place and yaw, then lean
        return MobilizedBody::Planar(matter.Ground(), Vec3(x, 0, 0), Body::Massless(), Vec3(0));
    };
    const auto leaning = [&](MobilizedBody& parent) {
        return MobilizedBody::Pin(parent, along(Vec3(1, 0, 0)), Body::Massless(),
                                  along(Vec3(1, 0, 0)));
    };
    const auto hinged = [&](MobilizedBody& parent, const Vec3& place, const Vec3& axis,
                            const Body& what) {
        return MobilizedBody::Pin(parent, Transform(along(axis), place), what, along(axis));
    };
    auto rear_place = on_floor(0), front_place = on_floor(p("w"));
    auto rear_lean = leaning(rear_place), front_lean = leaning(front_place);
    auto frame = hinged(rear_lean, Vec3(0, 0, p("rR")), axle,
                        body("B", Vec3(p("xB"), 0, -p("zB") - p("rR"))));
    auto rear = hinged(frame, Vec3(0), axle, body("R", Vec3(0)));
    auto fork = hinged(frame, foot, steer, body("H", Vec3(p("xH"), 0, -p("zH") - p("rR")) - foot));
    const Vec3 up(0, 0, p("rF"));
    auto wheel = hinged(front_lean, up, axle, body("F", Vec3(0)));

    Constraint::Ball(fork, front, front_lean, up);
    Constraint::ConstantAngle(fork, XAxis, front_lean, YAxis, Pi / 2);
    Constraint::ConstantAngle(fork, ZAxis, front_lean, YAxis, Pi / 2);
    const auto rolls = [&](MobilizedBody& place, double radius, std::vector<MobilizedBody*> spins) {
        Array_<MobilizedBodyIndex> bodies(2, place.getMobilizedBodyIndex());
        Array_<MobilizerUIndex> rates{MobilizerUIndex(1), MobilizerUIndex(2)};
        for (auto* body : spins) {
            bodies.push_back(body->getMobilizedBodyIndex());
            rates.push_back(MobilizerUIndex(0));
        }
        const Array_<MobilizedBodyIndex> yawing(1, place.getMobilizedBodyIndex());
        const Array_<MobilizerQIndex> yaw(1, MobilizerQIndex(0));
        for (bool across : {false, true})
            Constraint::SpeedCoupler(matter, new Ahead(radius, int(spins.size()), across), bodies,
                                     rates, yawing, yaw);
    };
    rolls(rear_place, p("rR"), {&frame, &rear});
    rolls(front_place, p("rF"), {&wheel});

    State state = system.realizeTopology();
    const double v = p("speed");
    for (auto* place : {&rear_place, &front_place}) place->setU(state, Vec3(0, v, 0));
    for (auto* lean : {&rear_lean, &front_lean}) lean->setRate(state, p("roll_rate"));
    rear.setRate(state, v / p("rR"));
    wheel.setRate(state, v / p("rF"));

    std::unique_ptr<Integrator> integrator;
    const std::string method = given["integrator"];
    if (method == "CPodes") integrator.reset(new CPodesIntegrator(system, CPodes::BDF));
    else if (method == "RungeKutta3") integrator.reset(new RungeKutta3Integrator(system));
    else if (method == "RungeKuttaFeldberg") integrator.reset(new RungeKuttaFeldbergIntegrator(system));
    else if (method == "Verlet") integrator.reset(new VerletIntegrator(system));
    else integrator.reset(new RungeKuttaMersonIntegrator(system));
    if (given.count("accuracy")) integrator->setAccuracy(p("accuracy"));
    if (given.count("constraints")) integrator->setConstraintTolerance(p("constraints"));
    integrator->setAllowInterpolation(given["interpolate"] != "no");
    integrator->setProjectInterpolatedStates(true);
    TimeStepper stepper(system, *integrator);
    stepper.initialize(state);

    // An integrator from outside: the accelerations of Simbody, its constraints not projected upon.
    struct Outside {
        MultibodySystem& system;
        State state;
        int calls = 0;
    } outside{system, stepper.getState()};
    const int size = outside.state.getNY();
    const auto rates = [](double, const double y[], double found[], void* given) {
        auto& [system, state, calls] = *static_cast<Outside*>(given);
        for (int i = 0; i < state.getNY(); ++i) state.updY()[i] = y[i];
        system.realize(state, Stage::Acceleration);
        for (int i = 0; i < state.getNY(); ++i) found[i] = state.getYDot()[i];
        ++calls;
        return int(GSL_SUCCESS);
    };
    gsl_odeiv2_system equations = {rates, nullptr, std::size_t(size), &outside};
    const double tolerance = given.count("accuracy") ? p("accuracy") : 1e-3;
    auto* driver = gsl_odeiv2_driver_alloc_y_new(&equations, gsl_odeiv2_step_rk8pd, 1e-6, tolerance,
                                                 tolerance);
    std::vector<double> y(size);
    for (int i = 0; i < size; ++i) y[i] = outside.state.getY()[i];
    double t = 0;
    double cpu = 0;
    for (int row = 0; row <= 1000; ++row) {
        const auto begin = std::clock();
        if (method != "rk8pd") {
            if (row) stepper.stepTo(row / p("rate"));
        } else if (gsl_odeiv2_driver_apply(driver, &t, row / p("rate"), y.data()) == GSL_SUCCESS) {
            for (int i = 0; i < size; ++i) outside.state.updY()[i] = y[i];
        } else {
            return std::fprintf(stderr, "stops at %g s\n", t);
        }
        cpu += double(std::clock() - begin) / CLOCKS_PER_SEC;
        const State& s = method == "rk8pd" ? outside.state : stepper.getState();
        system.realize(s, Stage::Velocity);
        const double potential = system.calcPotentialEnergy(s), kinetic = system.calcKineticEnergy(s);
        std::printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", rear_lean.getAngle(s),
                    rear_lean.getRate(s), p("rR") * rear.getRate(s), potential, kinetic,
                    potential + kinetic, fork.getAngle(s), fork.getRate(s));
    }
    if (method == "rk8pd") std::fprintf(stderr, "%g calls %d\n", cpu, outside.calls);
    else std::fprintf(stderr, "%g steps %d\n", cpu, integrator->getNumStepsTaken());
    gsl_odeiv2_driver_free(driver);
}
