// See urdf_ik.h.
#include <cstring>
#include <new>

#include "library/urdf_ik.h"
#include "library/urdf_ik.hpp"

struct urdf_ik_arm {
    urdf_ik::Arm arm;
};

// The handle of an arm that was read, or a null pointer and the error.
static urdf_ik_arm* handle(urdf_ik::Arm arm, const std::string& problem, char* error, size_t size) {
    urdf_ik_arm* made = arm ? new (std::nothrow) urdf_ik_arm{std::move(arm)} : nullptr;
    if (!made && error && size > 0) {
        const size_t length = problem.size() < size - 1 ? problem.size() : size - 1;
        std::memcpy(error, problem.data(), length);
        error[length] = '\0';
    }
    return made;
}

const char* urdf_ik_version(void) { return URDF_IK_VERSION; }

urdf_ik_arm* urdf_ik_load(const char* file, char* error, size_t size) {
    std::string problem;
    urdf_ik::Arm arm = urdf_ik::Arm::load(file, &problem);
    return handle(std::move(arm), problem, error, size);
}
urdf_ik_arm* urdf_ik_parse(const char* text, size_t length, char* error, size_t size) {
    std::string problem;
    urdf_ik::Arm arm = urdf_ik::Arm::parse({text, length}, &problem);
    return handle(std::move(arm), problem, error, size);
}
void urdf_ik_free(urdf_ik_arm* arm) { delete arm; }

int urdf_ik_joints(const urdf_ik_arm* arm) { return arm->arm.joints(); }
int urdf_ik_columns(const urdf_ik_arm* arm) { return arm->arm.columns(); }
int urdf_ik_parameters(const urdf_ik_arm* arm) { return arm->arm.parameters(); }
const char* urdf_ik_name(const urdf_ik_arm* arm) { return arm->arm.name().c_str(); }
const char* urdf_ik_base(const urdf_ik_arm* arm) { return arm->arm.base().c_str(); }
const char* urdf_ik_tip(const urdf_ik_arm* arm) { return arm->arm.tip().c_str(); }
const char* urdf_ik_family(const urdf_ik_arm* arm) { return arm->arm.family().c_str(); }
const char* urdf_ik_joint_name(const urdf_ik_arm* arm, int joint) { return arm->arm.joint(joint).name.c_str(); }
const char* urdf_ik_branch_name(const urdf_ik_arm* arm, int column) { return arm->arm.branch_name(column).c_str(); }
void urdf_ik_limits(const urdf_ik_arm* arm, int joint, double* lower, double* upper) {
    *lower = arm->arm.joint(joint).lower, *upper = arm->arm.joint(joint).upper;
}
void urdf_ik_parameter(const urdf_ik_arm* arm, int parameter, double* lower, double* upper, double* default_value) {
    const urdf_ik::Arm::Parameter& held = arm->arm.parameter(parameter);
    *lower = held.lower, *upper = held.upper, *default_value = held.default_value;
}
int urdf_ik_compiled_from(const urdf_ik_arm* arm, const char* urdf, size_t length) {
    return arm->arm.compiled_from({urdf, length});
}

long urdf_ik_solve(const urdf_ik_arm* arm, const double* T, long m, double* q, uint8_t* flags, const double* q_ref,
                   const double* values) {
    return arm->arm.ik(T, m, q, flags, q_ref, values);
}
void urdf_ik_fk(const urdf_ik_arm* arm, const double* q, long m, double* T) { arm->arm.fk(q, m, T); }
void urdf_ik_jacobian(const urdf_ik_arm* arm, const double* q, long m, double* J) { arm->arm.jacobian(q, m, J); }
void urdf_ik_redundancy_of(const urdf_ik_arm* arm, const double* q, const double* T, double* values) {
    arm->arm.redundancy_of(q, T, values);
}
int urdf_ik_nearest(const urdf_ik_arm* arm, const double* q, const uint8_t* flags, const double* q_ref, double* nearest, int inside,
                    const double* weights) {
    return arm->arm.nearest(q, flags, q_ref, nearest, inside != 0, weights);
}
long urdf_ik_turns(const urdf_ik_arm* arm, const double* q, double* images, long most) { return arm->arm.turns(q, images, most); }
