// The uncontrolled bicycle in the Open Dynamics Engine: four bodies, three hinges, and a contact at
// the lowest point of each wheel, with friction. Axes: x forward, y left, z up.
//
// Reads lines "name value" (parameters, speed, roll_rate, rate, step, erp, cfm, gyroscopic), writes the
// eight columns `rate` times a second, and the processor time of the simulation [s] as an error message.

#include <ode/ode.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <map>
#include <string>

struct Vector {
    double x, y, z;
};
static Vector from(const dReal* a) { return {a[0], a[1], a[2]}; }
static double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Vector axis(dBodyID body, double x, double y, double z) {
    dVector3 found;
    dBodyVectorToWorld(body, x, y, z, found);
    return from(found);
}

int main() {
    std::map<std::string, double> p;
    double number;
    for (std::string name; std::cin >> name >> number;) p[name] = number;

    dInitODE();
    dWorldID world = dWorldCreate();
    dWorldSetGravity(world, 0, 0, -p["g"]);
    if (p.count("erp")) dWorldSetERP(world, p["erp"]);
    if (p.count("cfm")) dWorldSetCFM(world, p["cfm"]);

    const std::map<std::string, Vector> centres = {{"B", {p["xB"], 0, -p["zB"]}},
                                                   {"H", {p["xH"], 0, -p["zH"]}},
                                                   {"R", {0, 0, p["rR"]}},
                                                   {"F", {p["w"], 0, p["rF"]}}};
    std::map<std::string, dBodyID> bodies;
    for (const auto& [b, at] : centres) {
        dMass mass;  // z up changes the sign of the products
        const double xx = p["I" + b + "xx"], zz = p.count("I" + b + "zz") ? p["I" + b + "zz"] : xx;
        dMassSetParameters(&mass, p["m" + b], 0, 0, 0, xx, p["I" + b + "yy"], zz, 0,
                           -p["I" + b + "xz"], 0);
        dBodyID body = bodies[b] = dBodyCreate(world);
        dBodySetMass(body, &mass);
        dBodySetPosition(body, at.x, at.y, at.z);
        dBodySetGyroscopicMode(body, p.count("gyroscopic") ? int(p["gyroscopic"]) : 1);
        // The whole bicycle turns about the line of the contact points.
        dBodySetLinearVel(body, p["speed"], -p["roll_rate"] * at.z, 0);
        const double spin = p.count("r" + b) ? p["speed"] / p["r" + b] : 0;
        dBodySetAngularVel(body, p["roll_rate"], spin, 0);
    }
    const auto hinge = [&](const char* one, const char* other, Vector at, Vector along) {
        dJointID joint = dJointCreateHinge(world, nullptr);
        dJointAttach(joint, bodies[other], bodies[one]);
        dJointSetHingeAnchor(joint, at.x, at.y, at.z);
        dJointSetHingeAxis(joint, along.x, along.y, along.z);
        return joint;
    };
    hinge("B", "R", centres.at("R"), {0, 1, 0});
    hinge("H", "F", centres.at("F"), {0, 1, 0});
    dJointID steer = hinge("B", "H", {p["w"] + p["c"], 0, 0},
                           {std::sin(p["lam"]), 0, -std::cos(p["lam"])});

    dJointGroupID contacts = dJointGroupCreate(0);
    const auto touch = [&](const std::string& wheel) {
        // The lowest point of the rim: down, less its part along the axle.
        const Vector hub = from(dBodyGetPosition(bodies[wheel]));
        const Vector axle = axis(bodies[wheel], 0, 1, 0);
        const double r = p["r" + wheel], length = std::sqrt(1 - axle.z * axle.z);
        dContact contact = {};
        contact.surface.mode = dContactApprox1;
        contact.surface.mu = dInfinity;
        contact.geom.pos[0] = hub.x + r * axle.z * axle.x / length;
        contact.geom.pos[1] = hub.y + r * axle.z * axle.y / length;
        contact.geom.pos[2] = hub.z - r * length;
        contact.geom.normal[2] = 1;
        contact.geom.depth = -contact.geom.pos[2];
        dJointAttach(dJointCreateContact(world, contacts, &contact), bodies[wheel], nullptr);
    };
    const int each = int(std::lround(1 / p["rate"] / p["step"]));
    double cpu = 0;
    for (int row = 0; row <= 1000; ++row) {
        const auto begin = std::clock();
        for (int i = 0; row && i < each; ++i) {
            touch("R");
            touch("F");
            dWorldStep(world, p["step"]);
            dJointGroupEmpty(contacts);
        }
        cpu += double(std::clock() - begin) / CLOCKS_PER_SEC;
        double potential = 0, kinetic = 0;
        for (const auto& [b, body] : bodies) {
            dMass mass;
            dBodyGetMass(body, &mass);
            const Vector v = from(dBodyGetLinearVel(body)), w = from(dBodyGetAngularVel(body));
            dVector3 own;
            dBodyVectorFromWorld(body, w.x, w.y, w.z, own);
            double turning = 0;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) turning += own[i] * mass.I[4 * i + j] * own[j];
            potential += mass.mass * p["g"] * dBodyGetPosition(body)[2];
            kinetic += (mass.mass * dot(v, v) + turning) / 2;
        }
        const Vector ahead = axis(bodies["B"], 1, 0, 0), left = axis(bodies["B"], 0, 1, 0);
        const Vector spin = from(dBodyGetAngularVel(bodies["B"]));
        const Vector hub = from(dBodyGetLinearVel(bodies["R"]));
        std::printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", std::asin(left.z),
                    dot(spin, ahead), dot(hub, ahead), potential, kinetic, potential + kinetic,
                    dJointGetHingeAngle(steer), dJointGetHingeAngleRate(steer));
    }
    std::fprintf(stderr, "%g\n", cpu);
    dCloseODE();
}
