// One arm of a unit that holds exported files: its sizes and functions. The unit defines the list; one_file.cpp solves.
#pragma once

#include <stdint.h>

struct Exported {
    int joints, columns, parameters;
    long (*ik_batch)(const double* T, long m, double* q, uint8_t* flags, const double* q_ref, const double* values);
    int (*ik)(const double* T, double* q, uint8_t* flags, const double* q_ref, const double* values);
    void (*fk)(const double* q, double* T);
    void (*jacobian)(const double* q, double* J);
};

#define EXPORTED(arm) {arm::joints, arm::columns, arm::parameters, arm::ik_batch, arm::ik, arm::fk, arm::jacobian}

extern const Exported exported[];
