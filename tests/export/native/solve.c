/* Solves by the C interface: solve_c ARM.json REPEATS < poses > answers.
   in:  m, whether values are given; T (m, 16), values (m, parameters); out: q (m, columns, joints), flags (m, columns)
   stderr: the least processor time of a batch [s], then the names of the branches, a line each. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <urdf_ik.h>

int main(int argc, char** argv) {
    char error[1024];
    if (argc < 3) return 2;
    urdf_ik_arm* arm = urdf_ik_load(argv[1], error, sizeof error);
    if (!arm) return fprintf(stderr, "%s\n", error), 1;
    int64_t header[2];
    if (fread(header, 8, 2, stdin) != 2) return 1;
    const size_t m = (size_t)header[0], n = (size_t)urdf_ik_joints(arm), columns = (size_t)urdf_ik_columns(arm);
    const size_t p = header[1] ? (size_t)urdf_ik_parameters(arm) : 0;
    double* T = malloc(128 * m + 8);
    double* values = malloc(8 * m * p + 8);
    double* q = calloc(m * columns * n + 1, 8);
    uint8_t* flags = calloc(m * columns + 1, 1);
    if (!T || !values || !q || !flags || fread(T, 128, m, stdin) != m || fread(values, 8, m * p, stdin) != m * p) return 1;
    double least = 1e9;
    for (int k = 0; k < atoi(argv[2]); ++k) {
        const clock_t start = clock();
        if (urdf_ik_solve(arm, T, (long)m, q, flags, NULL, p ? values : NULL) >= 0) return 1;
        const double took = (double)(clock() - start) / CLOCKS_PER_SEC;
        if (took < least) least = took;
    }
    fwrite(q, 8, m * columns * n, stdout), fwrite(flags, 1, m * columns, stdout);
    fprintf(stderr, "%.9f\n", least);
    for (int c = 0; c < (int)columns; ++c) fprintf(stderr, "%s\n", urdf_ik_branch_name(arm, c));
    free(T), free(values), free(q), free(flags);
    urdf_ik_free(arm);
    return 0;
}
