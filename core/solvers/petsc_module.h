// What the module of distributed systems offers, as plain C: it is loaded when a run has several
// processes. Internal.
#pragma once

#include <cstdint>

extern "C" {

// Functions return a message for a person, or null where all went well; it lives until the next call.
// All but serve() are called in process 0.
struct BattenDistributed {
  int rank, size;
  // Does what process 0 asks for, until it ends. In all other processes.
  void (*serve)();
  // Factors a lower triangle in compressed columns, without gaps, as number `id`.
  const char* (*factorize)(int id, int n, const int* outer, const int* inner, const double* values);
  // b, n×k by columns, becomes x.
  const char* (*solve)(int id, double* b, int k);
  void (*release)(int id);
  void (*end)();
};

// Joins the other processes and fills in the rest. The name under which the module has it.
const char* batten_distributed(BattenDistributed* module);
}
