/* urdf-ik for C: see urdf_ik.hpp, whose functions these are. Lengths are m, angles rad, poses 4x4 row by row. */
#ifndef URDF_IK_H
#define URDF_IK_H

#include <stddef.h>
#include <stdint.h>

#define URDF_IK_VERSION "0.1.0"

/* A shared library shows these names and no others. */
#define URDF_IK_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

/* An arm; immutable, safe from any number of threads at once. */
typedef struct urdf_ik_arm urdf_ik_arm;

/* Bits of a column's flags, and of the flags of a pose's first column. */
enum { URDF_IK_VALID = 1, URDF_IK_SINGULAR = 30, URDF_IK_STATUS = 96 };
/* The status of a pose's solutions: flags[0] & URDF_IK_STATUS. */
enum { URDF_IK_COMPLETE = 0, URDF_IK_INCOMPLETE = 32, URDF_IK_CLUSTERED = 64, URDF_IK_CONTINUUM = 96 };

/* URDF_IK_VERSION of the library that is linked. */
URDF_IK_API const char* urdf_ik_version(void);

/* The arm of a file, or of the `length` characters of a text. NULL: there is none, and `error`, if it is not NULL, holds why, at most
   `size` bytes with the zero at the end. urdf_ik_free frees the arm; it takes NULL, too. */
URDF_IK_API urdf_ik_arm* urdf_ik_load(const char* file, char* error, size_t size);
URDF_IK_API urdf_ik_arm* urdf_ik_parse(const char* text, size_t length, char* error, size_t size);
URDF_IK_API void urdf_ik_free(urdf_ik_arm* arm);

URDF_IK_API int urdf_ik_joints(const urdf_ik_arm* arm);
URDF_IK_API int urdf_ik_columns(const urdf_ik_arm* arm);
URDF_IK_API int urdf_ik_parameters(const urdf_ik_arm* arm);
/* These stay valid as long as the arm. */
URDF_IK_API const char* urdf_ik_name(const urdf_ik_arm* arm);
URDF_IK_API const char* urdf_ik_base(const urdf_ik_arm* arm);
URDF_IK_API const char* urdf_ik_tip(const urdf_ik_arm* arm);
URDF_IK_API const char* urdf_ik_family(const urdf_ik_arm* arm);
URDF_IK_API const char* urdf_ik_joint_name(const urdf_ik_arm* arm, int joint);
URDF_IK_API const char* urdf_ik_branch_name(const urdf_ik_arm* arm, int column);
URDF_IK_API void urdf_ik_limits(const urdf_ik_arm* arm, int joint, double* lower, double* upper);
URDF_IK_API void urdf_ik_parameter(const urdf_ik_arm* arm, int parameter, double* lower, double* upper, double* default_value);
/* 1: the arm was compiled from this text of a URDF; 0: from another one. */
URDF_IK_API int urdf_ik_compiled_from(const urdf_ik_arm* arm, const char* urdf, size_t length);

/* All solutions of m poses T (m, 16): q (m, columns, joints), flags (m, columns). q_ref (joints) and values (m, parameters) may be
   NULL. The index of the first T that is no pose, or -1. */
URDF_IK_API long urdf_ik_solve(const urdf_ik_arm* arm, const double* T, long m, double* q, uint8_t* flags, const double* q_ref,
                   const double* values);
URDF_IK_API void urdf_ik_fk(const urdf_ik_arm* arm, const double* q, long m, double* T);
URDF_IK_API void urdf_ik_jacobian(const urdf_ik_arm* arm, const double* q, long m, double* J);
URDF_IK_API void urdf_ik_redundancy_of(const urdf_ik_arm* arm, const double* q, const double* T, double* values);
/* The column nearest to q_ref, or -1; inside: 1: among images inside the limits, 0: on the circle. weights may be NULL. */
URDF_IK_API int urdf_ik_nearest(const urdf_ik_arm* arm, const double* q, const uint8_t* flags, const double* q_ref, double* nearest, int inside,
                    const double* weights);
URDF_IK_API long urdf_ik_turns(const urdf_ik_arm* arm, const double* q, double* images, long most);

#ifdef __cplusplus
}
#endif

#endif
