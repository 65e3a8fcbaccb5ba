// Entry of the module in which a program may keep what needs OpenCASCADE. What the program has too,
// such as the list of unfinished files, is the program's: its symbols come first.
#include "batten/io/lines/cad_plugin.h"

extern "C" const batten::CadPlugin* batten_cad() { return &batten::linked_cad_plugin(); }
