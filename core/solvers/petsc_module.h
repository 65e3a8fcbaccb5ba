// Plain C interface of the module for distributed linear systems. The module is loaded only when a
// run has several MPI processes.
#pragma once

#include <cstdint>

extern "C" {

// Table of the module's functions. They return an error message for the user, or null on success;
// the message is valid until the next call. All functions except serve() are called in process 0.
struct BattenDistributed {
  int rank, size;
  // Executes the requests of process 0 until it calls end(). Called in all other processes.
  void (*serve)();
  // Factors the symmetric matrix whose lower triangle is given in compressed columns without gaps.
  // `id` identifies the factor.
  const char* (*factorize)(int id, int n, const int* outer, const int* inner, const double* values);
  // Solves with factor `id`: b (n×k, stored by columns) is overwritten by x.
  const char* (*solve)(int id, double* b, int k);
  void (*release)(int id);
  void (*end)();
};

// Initialises MPI and PETSc and fills in the table. Entry point that is looked up by name in the
// module.
const char* batten_distributed(BattenDistributed* module);
}
