/* c_interface ARM.json: prints what the C interface says of an arm and of its pose at zero. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <urdf_ik.h>

int main(int argc, char** argv) {
    char error[1024];
    urdf_ik_arm* arm = urdf_ik_load(argc > 1 ? argv[1] : "", error, sizeof error);
    if (!arm) return fprintf(stderr, "%s\n", error), 1;
    const int n = urdf_ik_joints(arm), columns = urdf_ik_columns(arm);
    double T[16], lower, upper;
    double* q = calloc((size_t)(n * columns), sizeof *q);
    double* nearest = calloc((size_t)n, sizeof *nearest);
    double* zero = calloc((size_t)n, sizeof *zero);
    uint8_t* flags = calloc((size_t)columns, 1);
    urdf_ik_fk(arm, zero, 1, T);
    printf("%s %s %s %d %d\n", urdf_ik_version(), urdf_ik_base(arm), urdf_ik_tip(arm), n, columns);
    if (urdf_ik_solve(arm, T, 1, q, flags, zero, NULL) >= 0) return 1;
    const int column = urdf_ik_nearest(arm, q, flags, zero, nearest, 0, NULL);
    for (int c = 0; c < columns; ++c) {
        if (flags[c] & URDF_IK_VALID) printf("%s%s\n", urdf_ik_branch_name(arm, c), c == column ? " *" : "");
    }
    for (int k = 0; k < n; ++k) {
        urdf_ik_limits(arm, k, &lower, &upper);
        printf("%s %.17g %.17g %.6f\n", urdf_ik_joint_name(arm, k), lower, upper, nearest[k]);
    }
    T[15] = 2.0;
    printf("%ld\n", urdf_ik_solve(arm, T, 1, q, flags, NULL, NULL));
    free(q), free(nearest), free(zero), free(flags);
    urdf_ik_free(arm);
    return 0;
}
